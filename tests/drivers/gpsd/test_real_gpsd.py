"""The real gpsd between our own sentences and our own reader: it believes the first, the second understands it."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator

import pytest
from msgspec import Struct

from fleet.drivers.ais.codec import position_report, static_report
from fleet.drivers.nmea import encode
from fleet.drivers.seam import Sensor
from fleet.drivers.sensors.config import SensorConfig
from fleet.drivers.sensors.kinds import made
from tests.drivers.sensors.rig import free_port, said, until

GPSD = shutil.which("gpsd", path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin")
pytestmark = pytest.mark.skipif(GPSD is None, reason="gpsd is not installed: apt-get install gpsd")
LAT, LON = 44.38, 8.93


class Running(Struct):
    """A gpsd, and the lines of its two receivers."""

    port: int
    gnss: socket.socket
    ais: socket.socket


def _talker(port: int) -> socket.socket:
    talker = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    talker.connect(("127.0.0.1", port))
    return talker


@pytest.fixture(scope="module")
def gpsd() -> Iterator[Running]:
    port, gnss, ais = free_port(), free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_DGRAM)
    devices = [f"udp://127.0.0.1:{gnss}", f"udp://127.0.0.1:{ais}"]
    child = subprocess.Popen([str(GPSD), "-N", "-n", "-b", "-S", str(port), *devices], stderr=subprocess.DEVNULL)

    def answers() -> bool:
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    running = Running(port, _talker(gnss), _talker(ais))
    try:
        until(answers)
        yield running
    finally:
        running.gnss.close()
        running.ais.close()
        child.terminate()
        child.wait(10)


def epoch(running: Running, k: int) -> None:
    """The next fix of a boat that goes north-east."""
    stamp_ns = time.time_ns()
    lat, lon = LAT + 1e-6 * k, LON + 1e-6 * k
    for line in (encode.gga(stamp_ns, lat, lon, 2, 1.0), encode.rmc(stamp_ns, lat, lon, 1.0, 0.5)):
        try:
            running.gnss.send(line)
        except ConnectionRefusedError:  # gpsd has not opened that device yet
            time.sleep(0.05)


def test_a_fix_goes_through_gpsd_and_comes_out_as_it_went_in(gpsd: Running) -> None:
    sensor: Sensor = made("b1", SensorConfig(kind="gpsd", endpoint=f"tcp:127.0.0.1:{gpsd.port}"), time.time_ns)
    sensor.open()
    k = 0

    def talk() -> None:
        nonlocal k
        k += 1
        epoch(gpsd, k)
        time.sleep(0.02)  # the pace of the receiver that is played here

    try:
        heard = said(sensor, lambda it: it.fix_ns > 0 and it.v_east_mps > 0.0, talk)
    finally:
        sensor.close()
    assert heard.lat_deg == pytest.approx(LAT, abs=1e-6 * k + 1e-8)
    assert heard.lat_deg - LAT == pytest.approx(heard.lon_deg - LON, abs=1e-8)
    assert (heard.v_north_mps, heard.v_east_mps) == (pytest.approx(1.0, abs=0.01), pytest.approx(0.5, abs=0.01))
    assert heard.position_error_m == pytest.approx(4.75 / 2.45)  # gpsd 3.22: 4.75 m (95 %) at HDOP 1 with corrections


def test_gpsd_reads_our_ais_targets(gpsd: Running) -> None:
    with socket.create_connection(("127.0.0.1", gpsd.port), timeout=10.0) as client:
        client.sendall(b'?WATCH={"enable":true,"json":true,"scaled":true};\n')
        client.settimeout(0.1)
        reports: dict[int, dict[str, object]] = {}
        text = b""

        def heard() -> bool:
            nonlocal text
            lines = static_report(200000001, "SIM B1", 2.4, 1.1)
            lines += position_report(200000001, LAT, LON, 1.0, 0.5, 0.4, accurate=True, second=3)
            try:
                for line in lines:
                    gpsd.ais.send(line)
                text += client.recv(65536)
            except (ConnectionRefusedError, TimeoutError):
                return False
            *whole, text = text.split(b"\r\n")
            for one in map(json.loads, whole):
                if one["class"] == "AIS":
                    reports[one["type"]] = one
            return {18, 24} <= reports.keys()

        until(heard)
    assert (reports[18]["mmsi"], reports[18]["lat"], reports[18]["lon"]) == (200000001, LAT, LON)
    assert (reports[18]["speed"], reports[18]["course"], reports[18]["heading"]) == (2.2, 26.6, 23)
    assert reports[24]["shipname"] == "SIM B1"
