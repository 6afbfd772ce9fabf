"""`fleet doctor mavlink` and `fleet drive` against a simulated autopilot in real time."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from fleet.drivers.mavlink import words
from tests.cli.terminal import at_terminal, fleet
from tests.drivers.mavlink.bench import STEP_NS, STEPS, Bench


class Live:
    """A bench whose autopilot and hull live in real time; the tool is the only one who talks to it."""

    def __init__(self) -> None:
        self.bench = Bench()
        self.bench.driver.close()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self.endpoint = f"udp:127.0.0.1:{self.bench.port.number}"
        self.rover = self.bench.rover
        self.turned: Callable[[], None] = lambda: None
        self.most_u = 0.0

    def start(self) -> None:
        self._thread.start()

    def _run(self) -> None:
        began = time.monotonic_ns() - self.bench.now_ns
        while not self._stop.wait(0.02):
            while time.monotonic_ns() - began > self.bench.now_ns + STEPS * STEP_NS:
                self.bench.sail()
                self.most_u = max(self.most_u, self.bench.state.u)
                self.turned()

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5.0)
        self.bench.close()


@pytest.fixture
def live() -> Iterator[Live]:
    one = Live()
    one.start()
    yield one
    one.close()


# -- doctor ------------------------------------------------------------------------------------------------------------
def test_an_autopilot_with_default_parameters_is_not_fit_and_what_to_change_is_printed(live: Live) -> None:
    run = fleet("doctor", "mavlink", live.endpoint)
    assert run.returncode == 1
    assert "navigation: good" in run.stdout
    changes = run.stdout.split("to change")[1].split("\n")[1:]
    assert [line.split() for line in changes if line] == [
        ["MAV_GCS_SYSID", "254"],
        ["FS_GCS_ENABLE", "1"],
        ["FS_ACTION", "6"],
        ["INITIAL_MODE", "4"],
    ]
    assert "not fit yet: 3 parameters to change" in run.stderr


def test_after_the_changes_it_is_fit_and_its_streams_come_as_they_should(live: Live) -> None:
    live.rover.parameters |= {"MAV_GCS_SYSID": 254.0, "FS_GCS_ENABLE": 1.0, "FS_ACTION": 6.0}
    run = fleet("doctor", "mavlink", live.endpoint, "--json")
    assert run.returncode == 0, run.stderr
    told = json.loads(run.stdout)
    assert (told["fit"], told["ardupilot"], told["boat"], told["armed"]) == (True, True, True, False)
    rates = told["rates_hz"]
    assert rates["ATTITUDE"]["now"] == pytest.approx(10.0, abs=1.5)
    assert rates["EKF_STATUS_REPORT"]["now"] == pytest.approx(2.0, abs=0.6)
    assert live.rover.mode == words.MANUAL, "a doctor changes nothing"


def test_where_nobody_answers_the_doctor_says_so() -> None:
    run = fleet("doctor", "mavlink", "udpin:127.0.0.1:0")
    assert (run.returncode, run.stdout) == (1, "")
    assert "no autopilot with sysid 1 at udpin:127.0.0.1:0, after 5 s" in run.stderr


# -- drive -------------------------------------------------------------------------------------------------------------
def driven(live: Live, *argv: str, hold_s: float) -> tuple[int, str]:
    """`fleet drive` of its autopilot; exit code and what was shown."""
    return at_terminal("drive", live.endpoint, *argv, hold_s=hold_s)


def test_a_boat_driven_ahead_and_to_starboard_is_armed_judged_stopped_and_disarmed(live: Live) -> None:
    code, shown = driven(live, "--surge", "0.4", "--yaw-rate", "0.2", "--for", "3", "--arm", hold_s=30.0)
    assert code == 0, shown
    assert "the boat does what it is told" in shown
    assert "surge +0." in shown
    assert live.most_u > 0.2
    assert not live.rover.armed


def test_letting_go_of_the_key_stops_the_boat(live: Live) -> None:
    _, shown = driven(live, "--surge", "0.4", "--for", "20", "--arm", hold_s=4.0)
    assert "let go: stopping" in shown
    assert not live.rover.armed
    assert live.bench.thrust.surge_mps <= 0.1


def test_a_boat_with_crossed_motors_is_found_out(live: Live) -> None:
    live.turned = lambda: live.bench.shift(r=-abs(live.bench.state.r))
    code, shown = driven(live, "--yaw-rate", "0.2", "--for", "3", "--arm", hold_s=30.0)
    assert code == 1
    assert "expected a turn to starboard" in shown


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (("udp:127.0.0.1:14550", "--surge", "3"), "--surge 3: expected -1 to 1 m/s"),
        (("udp:127.0.0.1:14550", "--yaw-rate", "nan"), "--yaw-rate nan: expected -0.5 to 0.5 rad/s"),
        (("udp:127.0.0.1:14550",), "nothing to do: expected --surge, --yaw-rate or both"),
        (("udp:127.0.0.1:14550", "--surge", "0.5", "--for", "60"), "--for 60: expected more than 0 and at most 30 s"),
        (("udp:127.0.0.1:14550", "--surge", "0.5", "--sysid", "0"), "--sysid 0: expected 1 to 255"),
        (("nowhere", "--surge", "0.5"), "driver.mavlink.endpoint 'nowhere': expected udp:HOST:PORT"),
        (("udp:127.0.0.1:14550", "--surge", "0.5"), "there is no terminal to hold it on"),
    ],
)
def test_wrong_input_is_refused_before_anything_moves(argv: tuple[str, ...], message: str) -> None:
    run = fleet("drive", *argv)
    assert run.returncode == 2
    assert message in run.stderr
    assert "Traceback" not in run.stderr
