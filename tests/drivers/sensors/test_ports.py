"""Lines from a serial line, a TCP server and datagrams; ports that are lost and found again."""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from fleet.drivers.gpsd.receiver import WATCH
from fleet.drivers.nmea import encode
from fleet.drivers.seam import Sensor
from fleet.drivers.sensors import port as ports
from fleet.drivers.sensors.config import SensorConfig
from fleet.drivers.sensors.kinds import made
from fleet.drivers.sensors.lines import LONGEST, Splitter
from fleet.drivers.sensors.port import endpoint
from fleet.drivers.sensors.silence import Silence
from fleet.errors import ConfigError

from .rig import Pty, Server, free_port, said, until

AIVDM = b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C\r\n"
TPV = b'{"class":"TPV","mode":3,"time":"2025-11-28T12:00:00.000Z","lat":44.38,"lon":8.93,"epx":3.0,"epy":4.0}\n'
S = 1_000_000_000


@contextmanager
def listening(**config: object) -> Iterator[Sensor]:
    sensor = made("b1", SensorConfig(**config), time.time_ns)  # type: ignore[arg-type]
    sensor.open()
    try:
        yield sensor
    finally:
        sensor.close()


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ports, "AGAIN_S", 0.02)


def fix() -> bytes:
    return encode.gga(time.time_ns(), 44.38, 8.93, 2, 0.8)


def test_a_receiver_on_a_serial_line_is_heard_and_its_plug_may_be_pulled() -> None:
    line = Pty()
    with listening(kind="nmea", endpoint=f"serial:{line.device}:38400", silent_s=0.2) as sensor:
        until(lambda: sensor.lines.port.opened > 0)  # type: ignore[attr-defined]
        before = time.time_ns()
        line.write(fix())
        heard = said(sensor, lambda it: it.fix_ns > 0)
        assert heard.lat_deg == pytest.approx(44.38)
        assert before <= heard.fix_ns <= time.time_ns()
        line.close()
        assert said(sensor, lambda it: it.trouble not in ("", "no fix", "silent")).fix_ns == 0


def test_a_serial_line_that_is_not_there_is_trouble_and_found_later() -> None:
    with listening(kind="nmea", endpoint="serial:/dev/no-such-line:4800") as sensor:
        assert "No such file" in said(sensor, lambda it: it.trouble != "").trouble


def test_one_datagram_holds_whole_sentences_of_receiver_compass_and_other_vessels() -> None:
    port = free_port(socket.SOCK_DGRAM)
    with listening(kind="nmea", endpoint=f"udp:127.0.0.1:{port}") as sensor:
        until(lambda: sensor.lines.port.opened > 0)  # type: ignore[attr-defined]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as talker:
            talker.connect(("127.0.0.1", port))
            talker.send(encode.hdt(1.0) + AIVDM + fix().strip())  # the last one without a line end
        heard = said(sensor, lambda it: it.heading_ns > 0)
        assert heard.heading_rad == pytest.approx(1.0, abs=1e-4)
        assert [one.name for one in heard.sightings] == ["mmsi-477553000"]
        assert said(sensor, lambda it: it.fix_ns > 0).position_error_m == pytest.approx(0.64)
        assert sensor.counts["accepted"] == 3  # type: ignore[attr-defined]


def test_a_tcp_server_that_goes_away_is_asked_again_and_half_a_sentence_is_forgotten() -> None:
    with Server() as server, listening(kind="nmea", endpoint=f"tcp:127.0.0.1:{server.port}") as sensor:
        server.accept().sendall(encode.hdt(1.0) + b"$HEHDT,5")
        assert said(sensor, lambda it: it.heading_ns > 0).heading_rad == pytest.approx(1.0, abs=1e-4)
        assert server.client is not None
        server.client.close()
        assert said(sensor, lambda it: it.trouble != "").trouble == "the other end has closed"
        server.accept().sendall(encode.hdt(2.0))
        assert said(sensor, lambda it: it.heading_ns > 0).heading_rad == pytest.approx(2.0, abs=1e-4)
        assert said(sensor, lambda it: it.trouble == "").trouble == ""


def test_nobody_at_the_other_end_is_trouble_in_words() -> None:
    with listening(kind="ais", endpoint=f"tcp:127.0.0.1:{free_port()}") as sensor:
        assert said(sensor, lambda it: it.trouble != "").trouble == "Connection refused"


def test_gpsd_is_asked_to_report_and_is_heard() -> None:
    with Server() as server, listening(kind="gpsd", endpoint=f"tcp:127.0.0.1:{server.port}") as sensor:
        client = server.accept()
        assert client.recv(len(WATCH)) == WATCH
        client.sendall(b'{"class":"VERSION","release":"3.22"}\n' + TPV)
        assert said(sensor, lambda it: it.fix_ns > 0).lat_deg == 44.38


def test_an_ais_receiver_gives_traffic_and_its_silence_is_no_trouble() -> None:
    port = free_port(socket.SOCK_DGRAM)
    with listening(kind="ais", endpoint=f"udp:127.0.0.1:{port}", silent_s=0.01) as sensor:
        assert sensor.gives == {"traffic"}
        until(lambda: sensor.lines.port.opened > 0)  # type: ignore[attr-defined]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as talker:
            talker.sendto(fix() + AIVDM, ("127.0.0.1", port))
        heard = said(sensor, lambda it: it.sightings != ())
        assert (heard.fix_ns, heard.trouble) == (0, "")
        assert sensor.read(time.time_ns() + 10 * S).trouble == ""


def test_a_sensor_that_has_given_headings_and_stops_is_told_by_what_is_missing() -> None:
    silence = Silence((), 3.0)
    assert silence.trouble(1, 0, "", {}) == ""
    assert silence.trouble(4 * S, 4 * S, "", {"fix": "no fix"}) == "nothing in it can be used"
    silence.gave("heading", 5 * S, 5 * S)
    assert silence.trouble(6 * S, 6 * S, "", {}) == ""
    why = {"heading": "magnetic, variation not known"}
    assert silence.trouble(9 * S, 9 * S, "", why) == "no heading: magnetic, variation not known"
    assert silence.trouble(19 * S, 9 * S, "", {}) == "silent"
    assert silence.trouble(19 * S, 9 * S, "Connection refused", {}) == "Connection refused"
    named = Silence(("fix", "heading"), 3.0)
    named.trouble(1, 0, "", {})
    named.gave("heading", 5 * S, 5 * S)
    named.gave("fix", 5 * S, 4 * S)
    assert named.trouble(6 * S, 6 * S, "", {"fix": "void"}) == "no fix: void"


def test_lines_may_come_in_any_pieces_and_endless_ones_are_dropped() -> None:
    splitter = Splitter()
    whole = b"$A*00\r\n$B*00\n\n$C*00\r\n"
    for size in (1, 2, 3, 5, 100):
        found = [line for i in range(0, len(whole), size) for line in splitter.feed(whole[i : i + size])]
        assert found == [b"$A*00", b"$B*00", b"$C*00"]
    assert splitter.feed(b"x" * (LONGEST + 1)) == []
    assert splitter.feed(b"x" * LONGEST + b"\n$D*00\n") == [b"$D*00"]
    assert splitter.too_long == 1


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("", "expected serial:DEVICE:BAUD"),
        ("udp:10110", "expected serial"),
        ("udp:127.0.0.1:0", "expected serial"),
        ("udp:127.0.0.1:70000", "expected serial"),
        ("serial:/dev/ttyUSB0:fast", "expected serial"),
        ("ftp:127.0.0.1:21", "expected serial"),
        ("udp:0.0.0.0:10110", "anybody on the network could tell this boat where it is"),
    ],
)
def test_an_endpoint_that_is_none_is_refused_in_words(text: str, wrong: str) -> None:
    with pytest.raises(ConfigError, match=wrong):
        endpoint(text, "gnss")


def test_listening_beyond_loopback_must_be_meant() -> None:
    assert endpoint("udp:0.0.0.0:10110", "gnss", insecure=True).beyond_loopback
    assert not endpoint("udp:[::1]:10110", "gnss").beyond_loopback


def test_options_that_do_not_fit_are_refused_with_their_sensor() -> None:
    for options, wrong in (({"hdop_mots": 3}, "hdop_mots"), ({"variation_deg": "2 E"}, "variation_deg")):
        with pytest.raises(ConfigError, match=rf"driver.sensors, nmea: options: .*{wrong}"):
            made("b1", SensorConfig(kind="nmea", endpoint="udp:127.0.0.1:10110", options=options), time.time_ns)


def test_a_flood_takes_only_so_much_of_a_tick_and_what_is_too_much_is_counted() -> None:
    sensor = made("b1", SensorConfig(kind="nmea", endpoint="udp:127.0.0.1:10110"), time.time_ns)
    lines = sensor.lines  # type: ignore[attr-defined]
    for _ in range(6000):
        lines._take(encode.hdt(1.0), 1)
    assert len(lines.take()) == 400
    assert lines.counts["dropped"] == 2000
    assert math.isfinite(sensor.read(2).heading_rad)
