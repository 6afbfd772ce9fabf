"""The service manager is told what is true, and the watchdog is fed by whole ticks alone."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from fleet.agent.config import AgentConfig, DriverConfig
from fleet.agent.notify import Notifier
from fleet.sim.processes import free_port
from fleet.wire.zenoh_bus import LinkConfig, ZenohBus

S = 1_000_000_000
PERIOD_S = 0.6


class Manager:
    """The other end: a socket with a name in the file system, or an abstract one."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind("\0" + name[1:] if name.startswith("@") else name)

    def heard(self, within_s: float = 0.0) -> dict[str, str] | None:
        """The next message, or None when none comes within that time."""
        self._socket.settimeout(within_s or 1e-9)
        try:
            lines = self._socket.recv(4096).decode().split("\n")
        except (TimeoutError, BlockingIOError):
            return None
        return dict(line.split("=", 1) for line in lines)

    def until(self, key: str, within_s: float = 30.0) -> dict[str, str]:
        """The first message with that key."""
        deadline = time.monotonic() + within_s
        while time.monotonic() < deadline:
            message = self.heard(0.5)
            if message is not None and key in message:
                return message
        raise AssertionError(f"no {key} within {within_s:g} s")

    def silent_for(self, seconds: float) -> bool:
        """Whether nothing comes for so long, after what was under way."""
        deadline = time.monotonic() + 10.0
        while time.monotonic() < deadline:
            if self.heard(seconds) is None:
                return True
        return False

    def close(self) -> None:
        self._socket.close()


@pytest.fixture(params=["path", "abstract"])
def manager(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Manager]:
    one = Manager(str(tmp_path / "notify") if request.param == "path" else f"@fleet-test-{os.getpid()}")
    yield one
    one.close()


# -- by hand -----------------------------------------------------------------------------------------------------------
def test_ready_comes_with_the_first_whole_tick_in_reach_and_food_three_times_in_a_period(manager: Manager) -> None:
    notifier = Notifier({"NOTIFY_SOCKET": manager.name, "WATCHDOG_USEC": "3000000"})
    notifier.whole_tick(False, "standby", 10 * S)
    assert manager.heard(1.0) == {"WATCHDOG": "1", "STATUS": "standby"}, "fed, but not ready"
    notifier.whole_tick(True, "standby", 10 * S + S // 10)
    assert manager.heard(1.0) == {"READY": "1", "STATUS": "standby"}
    fed = []
    for tick in range(2, 60):
        notifier.whole_tick(True, "standby", 10 * S + tick * S // 10)
        if (message := manager.heard()) is not None:
            fed.append(tick)
            assert "READY" not in message
    assert fed == [10, 20, 30, 40, 50]


def test_a_boat_out_of_reach_is_ready_after_ten_seconds(manager: Manager) -> None:
    notifier = Notifier({"NOTIFY_SOCKET": manager.name})
    told = []
    for second in range(1, 14):
        notifier.whole_tick(False, "standby: no link", second * S)
        if (message := manager.heard()) is not None and "READY" in message:
            told.append(second)
    assert told == [11]


def test_a_new_text_is_told_at_most_once_a_second_on_one_line(manager: Manager) -> None:
    notifier = Notifier({"NOTIFY_SOCKET": manager.name})
    notifier.whole_tick(True, "standby", 10 * S)
    assert manager.heard(1.0) is not None
    notifier.whole_tick(True, "follow\nWATCHDOG=1", 10 * S + S // 2)
    assert manager.heard() is None
    notifier.whole_tick(True, "follow\nWATCHDOG=1", 11 * S)
    assert manager.heard(1.0) == {"STATUS": "follow WATCHDOG=1"}


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"NOTIFY_SOCKET": ""},
        {"NOTIFY_SOCKET": "vsock:2:1234", "WATCHDOG_USEC": "1000"},
        {"NOTIFY_SOCKET": "/nowhere/at/all", "WATCHDOG_USEC": "much", "WATCHDOG_PID": "?"},
    ],
)
def test_without_a_manager_that_can_be_reached_nothing_happens(given: dict[str, str]) -> None:
    notifier = Notifier(given)
    notifier.whole_tick(True, "standby", S)
    notifier.ends()
    assert not notifier.send("READY=1")


def test_what_did_not_go_out_is_told_again(tmp_path: Path) -> None:
    name = str(tmp_path / "later")
    notifier = Notifier({"NOTIFY_SOCKET": name, "WATCHDOG_USEC": "3000000"})
    notifier.whole_tick(True, "standby", 10 * S)
    manager = Manager(name)
    notifier.whole_tick(True, "standby", 10 * S + S // 10)
    assert manager.heard(1.0) == {"READY": "1", "WATCHDOG": "1", "STATUS": "standby"}
    manager.close()


def test_the_watchdog_of_another_process_is_not_fed(manager: Manager) -> None:
    notifier = Notifier({"NOTIFY_SOCKET": manager.name, "WATCHDOG_USEC": "3000000", "WATCHDOG_PID": "1"})
    notifier.whole_tick(True, "standby", S)
    assert manager.heard(1.0) == {"READY": "1", "STATUS": "standby"}


# -- a real agent ------------------------------------------------------------------------------------------------------
DRIVER = """
import time
from pathlib import Path
from fleet.drivers.seam import Reading


class Hanging:
    simulated = False

    def __init__(self, hang, now_ns):
        self._hang, self._now_ns = Path(hang), now_ns

    def open(self): ...
    def neutral(self): ...
    def close(self): ...

    def read(self):
        while self._hang.exists():
            time.sleep(0.02)
        return Reading(self._now_ns(), 44.0, 8.0, 0.0, 0.0, 0.0, 0.0)

    def write(self, surge_mps, yaw_rate_radps):
        return ""


def hanging(boat, options, now_ns):
    return Hanging(options["hang"], now_ns)
"""


@pytest.fixture
def agent(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[bytes], Manager, Path, str]]:
    """A real agent with a driver of another package that hangs while a file is there."""
    plug, hang = tmp_path / "plug", tmp_path / "hang"
    info = plug / "hangs-1.0.dist-info"
    info.mkdir(parents=True)
    (plug / "hangs.py").write_text(DRIVER)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: hangs\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[fleet.drivers]\nhanging = hangs:hanging\n")
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config = AgentConfig(
        boat="b1",
        link=LinkConfig(topology="routed", listen=(endpoint,)),
        driver=DriverConfig(kind="hanging", options={"hang": str(hang)}),
        state_dir=str(tmp_path / "state"),
        record="none",
    )
    manager = Manager(str(tmp_path / "notify"))
    environment = {
        **os.environ,
        "PYTHONPATH": f"{plug}:{os.environ.get('PYTHONPATH', '')}",
        "NOTIFY_SOCKET": manager.name,
        "WATCHDOG_USEC": str(int(PERIOD_S * 1e6)),
    }
    argv = [sys.executable, "-m", "fleet.agent", msgspec.json.encode(config).decode()]
    child = subprocess.Popen(argv, env=environment, stderr=subprocess.DEVNULL)
    yield child, manager, hang, endpoint
    child.kill()
    child.wait()
    manager.close()


@pytest.mark.sails
def test_a_frozen_agent_and_a_hanging_loop_starve_the_watchdog_though_other_threads_live(
    agent: tuple[subprocess.Popen[bytes], Manager, Path, str],
) -> None:
    child, manager, hang, endpoint = agent
    ready = manager.until("READY")
    assert ready["STATUS"].startswith("standby: no mission")
    for _ in range(4):
        manager.until("WATCHDOG", PERIOD_S)

    child.send_signal(signal.SIGSTOP)
    assert manager.silent_for(2.0 * PERIOD_S), "frozen"
    child.send_signal(signal.SIGCONT)
    manager.until("WATCHDOG", 5.0)

    hang.touch()
    assert manager.silent_for(2.0 * PERIOD_S), "the loop hangs in its driver"
    other = ZenohBus("demo", "b2", LinkConfig(topology="hub", connect=(endpoint,)), time.time_ns)
    try:
        deadline = time.monotonic() + 10.0
        while not other.open() or "b1" not in other.alive():
            assert time.monotonic() < deadline, "its other threads do not answer"
            time.sleep(0.02)
    finally:
        other.close()
    assert manager.heard() is None
    hang.unlink()
    manager.until("WATCHDOG", 5.0)

    child.send_signal(signal.SIGTERM)
    assert manager.until("STOPPING")["STATUS"] == "ends"
    assert child.wait(10) == 0
