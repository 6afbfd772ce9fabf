"""The sensor on real links: TCP and a serial line, a scanner that goes and comes, a laser that is off at the end."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import time
import tty
from collections.abc import Callable, Iterator

import pytest

from fleet.drivers.lidar.driver import Lidar
from fleet.drivers.seam import Observed
from fleet.drivers.sensors.config import SensorConfig
from fleet.errors import ConfigError
from fleet.sensing.scan import Scan
from fleet.sim.scanner.responder import Responder

PATIENCE_S = 15.0


def config(endpoint: str, **options: object) -> SensorConfig:
    return SensorConfig(kind="lidar", name="bow", endpoint=endpoint, silent_s=0.5, options=options)


class Served:
    """A scanner at the other end of a stream, in a thread."""

    def __init__(self, read: Callable[[], bytes], write: Callable[[bytes], object]) -> None:
        self.scanner = Responder()
        self.heard = b""
        self._read, self._write = read, write
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        turned_s = 0.0
        with contextlib.suppress(OSError):
            while not self._stop.is_set():
                now_s = time.monotonic()
                chunk = self._read()
                self.heard += chunk
                answer = self.scanner.hear(chunk, round(now_s * 1e3))
                if now_s - turned_s > 0.05:
                    turned_s = now_s
                    answer += self.scanner.turned(round(now_s * 1e3), [4321] * 1081)
                self._write(answer)

    def close(self) -> None:
        self._stop.set()
        self._thread.join(PATIENCE_S)


class TcpScanner:
    """A scanner with a TCP port, that can be switched off and on."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        self._client: socket.socket | None = None
        self.served: Served | None = None

    def accept(self) -> Served:
        self._server.settimeout(PATIENCE_S)
        client, _ = self._server.accept()
        client.settimeout(0.005)

        def read() -> bytes:
            try:
                chunk = client.recv(4096)
            except TimeoutError:
                return b""
            if not chunk:
                raise OSError("gone")
            return chunk

        self._client, self.served = client, Served(read, client.sendall)
        return self.served

    def cut(self) -> None:
        if self._client is not None:
            self._client.close()
        if self.served is not None:
            self.served.close()

    def close(self) -> None:
        self.cut()
        self._server.close()


@pytest.fixture
def scanner() -> Iterator[TcpScanner]:
    one = TcpScanner()
    yield one
    one.close()


def until(lidar: Lidar, found: Callable[[Observed], object]) -> Observed:
    deadline = time.monotonic() + PATIENCE_S
    while True:
        said = lidar.read(time.time_ns())
        if found(said):
            return said
        assert time.monotonic() < deadline, "never"
        time.sleep(0.005)


def scans(said: Observed) -> tuple[Scan, ...]:
    return said.scans


def test_scans_come_over_tcp_and_the_laser_is_off_at_the_end(scanner: TcpScanner) -> None:
    lidar = Lidar(config(f"tcp:127.0.0.1:{scanner.port}"), time.time_ns)
    lidar.open()
    served = scanner.accept()
    scan = until(lidar, scans).scans[-1]
    assert (scan.beams, scan.scanner) == (1081, "bow")
    assert abs(time.time_ns() - scan.stamp_ns) < 1e9
    assert served.scanner.laser
    lidar.close()
    assert served.heard.endswith(b"QT\n")
    assert not served.scanner.laser


def test_a_scanner_that_is_not_there_is_trouble_after_its_time_and_is_found_when_it_comes(scanner: TcpScanner) -> None:
    port = scanner.port
    scanner.close()
    lidar = Lidar(config(f"tcp:127.0.0.1:{port}"), time.time_ns)
    lidar.open()
    assert lidar.read(time.time_ns()).trouble == ""  # it has half a second
    said = until(lidar, lambda said: said.trouble)
    assert said.trouble == f"tcp:127.0.0.1:{port}: Connection refused"
    lidar.close()


def test_a_scanner_that_is_switched_off_and_on_is_connected_again(scanner: TcpScanner) -> None:
    lidar = Lidar(config(f"tcp:127.0.0.1:{scanner.port}"), time.time_ns)
    lidar.open()
    scanner.accept()
    until(lidar, scans)
    scanner.cut()
    said = until(lidar, lambda said: said.trouble)
    assert said.trouble == f"tcp:127.0.0.1:{scanner.port}: the other end has closed"
    scanner.accept()
    assert until(lidar, scans).trouble == ""
    assert lidar.connected == 2
    lidar.close()


def test_scans_that_nobody_fetches_are_dropped_the_oldest_first(scanner: TcpScanner) -> None:
    lidar = Lidar(config(f"tcp:127.0.0.1:{scanner.port}"), time.time_ns)
    lidar.open()
    scanner.accept()
    until(lidar, scans)
    deadline = time.monotonic() + PATIENCE_S
    while lidar.session is None or lidar.session.counts.scans < 15:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert len(lidar.read(time.time_ns()).scans) <= 8
    lidar.close()


def test_scans_come_over_a_serial_line() -> None:
    pytest.importorskip("serial")
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    os.set_blocking(ours, False)

    def read() -> bytes:
        time.sleep(0.005)
        try:
            return os.read(ours, 4096)
        except BlockingIOError:
            return b""

    def write(said: bytes) -> None:
        while said:
            with contextlib.suppress(BlockingIOError):
                said = said[os.write(ours, said) :]

    served = Served(read, write)
    lidar = Lidar(config(f"serial:{os.ttyname(theirs)}:115200", from_deg=-45.0, to_deg=45.0), time.time_ns)
    lidar.open()
    assert until(lidar, scans).scans[-1].beams == 361
    lidar.close()
    assert not served.scanner.laser
    served.close()
    os.close(ours)
    os.close(theirs)


def test_a_serial_line_that_does_not_exist_is_trouble_in_words() -> None:
    pytest.importorskip("serial")
    lidar = Lidar(config("serial:/dev/ttyNONE9"), time.time_ns)
    lidar.open()
    assert "No such file or directory" in until(lidar, lambda said: said.trouble).trouble
    lidar.close()


@pytest.mark.parametrize(
    ("endpoint", "options", "why"),
    [
        ("", {}, "driver.sensors, bow: endpoint: missing; expected where the scanner is"),
        ("udp:1.2.3.4:5", {}, "driver.sensors, bow: endpoint 'udp:1.2.3.4:5': expected tcp:HOST"),
        ("tcp:1.2.3.4:0", {}, "driver.sensors, bow: endpoint 'tcp:1.2.3.4:0': expected"),
        ("tcp:1.2.3.4", {"rate_hz": 0.0}, "rate_hz"),
        ("tcp:1.2.3.4", {"comand": "MD"}, "comand"),
        ("tcp:1.2.3.4", {"from_deg": 90.0, "to_deg": 10.0}, "options.from_deg = 90: expected less than to_deg = 10"),
        ("tcp:1.2.3.4", {"command": "XX"}, "command"),
    ],
)
def test_wrong_configurations_are_refused_with_the_value_and_what_was_expected(
    endpoint: str, options: dict[str, object], why: str
) -> None:
    with pytest.raises(ConfigError, match=r"driver\.sensors, bow") as refused:
        Lidar(config(endpoint, **options), time.time_ns)
    assert why in str(refused.value)
