"""The conversation with a scanner, in memory: both sides, with a clock of the test's own."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import replace

from fleet.drivers.lidar.config import LidarOptions
from fleet.drivers.lidar.scip import OK, Model
from fleet.drivers.lidar.session import RUNNING, STALLED_S, Session
from fleet.drivers.lidar.words import HARDWARE
from fleet.sensing.scan import Scan, unpacked
from fleet.sim.scanner.responder import MODEL, Responder
from fleet.sim.scanner.speech import reply_bytes

S = 1_000_000_000
ALL_AT = 7000


class Talk:
    """A session and a scanner whose wires are lists."""

    def __init__(self, options: LidarOptions | None = None, model: Model = MODEL, *, reset: bool = False) -> None:
        self.scanner = Responder(model)
        self.session = Session(options or LidarOptions(), "bow", reset=reset)
        self.now_s = 1000.0
        self.heard: list[bytes] = []
        self.scans: list[Scan] = []
        self.dead = False
        self._pending = self.session.begin(self._ns, self.now_s)

    @property
    def _ns(self) -> int:
        return round(self.now_s * 1e9)

    @property
    def ms(self) -> int:
        return round((self.now_s - 900.0) * 1e3)

    def pass_by(self, seconds: float, ranges: dict[int, int] | None = None) -> None:
        """Time in steps of 10 ms; the scanner turns once in 100 ms."""
        for _ in range(round(seconds * 100)):
            self.now_s += 0.01
            line, self._pending = self._pending, b""
            self.heard += [line] if line else []
            answer = b"" if self.dead or not line else self.scanner.hear(line, self.ms)
            if not self.dead and round(self.now_s * 100) % 10 == 0:
                steps = [(ranges or {}).get(k, ALL_AT) for k in range(self.scanner.model.last + 1)]
                answer += self.scanner.turned(self.ms - 75, steps)
            scans, said = self.session.take(answer, self._ns, self.now_s) if answer else ([], b"")
            self.scans += scans
            self._pending = said + self.session.due(self._ns, self.now_s)


def test_a_scanner_is_stopped_asked_what_it_is_and_how_late_then_told_to_measure() -> None:
    talk = Talk()
    talk.pass_by(1.0)
    assert b"".join(talk.heard).decode().split() == [
        "QT", "VV", "PP", "II", "TM0", "TM1", "TM1", "TM1", "TM1", "TM1", "TM2", "BM", "MD0000108001000",
    ]  # fmt: skip
    assert talk.session.doing == RUNNING
    assert talk.session.version["PROD"] == "simulated scanner"
    assert talk.session.refused == 0
    assert len(talk.scans) >= 7


def test_a_scan_has_the_bearings_the_stamp_and_the_place_of_its_scanner() -> None:
    talk = Talk(LidarOptions(ahead_m=0.8, starboard_m=-0.1, yaw_deg=10.0, range_min_m=0.3))
    talk.pass_by(1.0, {540: 12_345, 180: 5_000, 900: 6_000, 700: 200, 701: 65_533, 702: 0})
    scan = talk.scans[-1]
    ranges = unpacked(scan.ranges)
    assert scan.first_rad == pytest.approx(math.radians(135.0))
    assert scan.increment_rad == pytest.approx(-math.radians(0.25))
    assert (scan.beams, scan.scanner) == (1081, "bow")
    assert (scan.ahead_m, scan.starboard_m, scan.yaw_rad) == (0.8, -0.1, pytest.approx(math.radians(10.0)))
    assert ranges[540] == pytest.approx(12.345)
    assert ranges[180] == pytest.approx(5.0)  # to starboard of the scanner
    assert scan.first_rad + 180 * scan.increment_rad == pytest.approx(math.radians(90.0))
    assert [k for k, one in enumerate(ranges) if math.isnan(one)] == [700, 701, 702]
    assert scan.beam_s == pytest.approx(0.1 / 1440)
    began_s = round(talk.now_s * 10) / 10 - 0.075
    assert scan.stamp_ns * 1e-9 == pytest.approx(began_s, abs=0.0051)  # half of an answer's trip in this test


def test_a_scanner_that_hangs_upside_down_sees_starboard_on_the_other_side() -> None:
    talk = Talk(LidarOptions(inverted=True, yaw_deg=90.0))
    talk.pass_by(1.0)
    scan = talk.scans[-1]
    assert scan.first_rad == pytest.approx(-math.radians(135.0))
    assert scan.increment_rad == pytest.approx(math.radians(0.25))
    assert scan.yaw_rad == pytest.approx(math.radians(90.0))


def test_blind_sectors_are_from_the_bow_and_clockwise() -> None:
    talk = Talk(LidarOptions(blind_deg=((85.0, 95.0), (170.0, -100.0))))
    talk.pass_by(1.0)
    scan = talk.scans[-1]
    bearings = [135.0 - 0.25 * k for k in range(1081)]
    blind = [b for b, one in zip(bearings, unpacked(scan.ranges), strict=True) if math.isnan(one)]
    assert {b for b in blind if b > 0.0} == {b for b in bearings if 85.0 <= b <= 95.0}
    assert {b for b in blind if b < 0.0} == {b for b in bearings if b <= -100.0}


@pytest.mark.parametrize("command", ["MD", "MS", "ME", "GD", "GS", "GE"])
def test_every_command_that_measures_gives_scans(command: str) -> None:
    talk = Talk(LidarOptions(command=command, rate_hz=5.0))  # type: ignore[arg-type]
    talk.pass_by(4.0, {540: 3_000})
    assert 12 <= len(talk.scans) <= 20
    assert unpacked(talk.scans[-1].ranges)[540] == pytest.approx(3.0)
    assert math.isnan(unpacked(talk.scans[-1].ranges)[539]) == command.endswith("S")  # 7 m do not fit two characters


def test_only_the_part_that_is_wanted_is_measured_and_no_more_often() -> None:
    talk = Talk(LidarOptions(from_deg=-45.0, to_deg=90.0, rate_hz=2.5, cluster=2))
    talk.pass_by(3.0)
    assert b"MD0180072002300\n" in talk.heard
    scan = talk.scans[-1]
    assert scan.beams == 271
    assert scan.first_rad == pytest.approx(math.radians(90.0 - 0.125))
    assert scan.increment_rad == pytest.approx(-math.radians(0.5))
    assert 4 <= len(talk.scans) <= 8


def test_a_scanner_that_is_silent_is_asked_three_times_and_given_up() -> None:
    talk = Talk()
    talk.dead = True
    talk.pass_by(2.5)
    assert talk.session.failed == ""
    talk.pass_by(1.0)
    assert talk.session.failed == "does not answer QT"
    assert talk.heard == [b"QT\n"] * 3


def test_a_scanner_that_falls_silent_while_it_measures_is_given_up() -> None:
    talk = Talk()
    talk.pass_by(1.0)
    talk.dead = True
    talk.pass_by(STALLED_S + 0.2)
    assert talk.session.failed == "no scan for 2 s"
    assert not talk.session.hardware


def test_hardware_trouble_is_named_and_the_next_session_resets_the_scanner() -> None:
    talk = Talk()
    talk.pass_by(1.0)
    talk.scanner.fault = "55"
    talk.pass_by(0.3)
    assert talk.session.failed == HARDWARE
    assert talk.session.hardware
    again = Talk(reset=True)
    again.scanner.fault = "55"
    again.pass_by(1.2)
    assert again.heard[:2] == [b"QT\n", b"RS\n"]
    assert again.session.doing == RUNNING


def test_a_laser_that_cannot_be_switched_on_is_named() -> None:
    talk = Talk()
    talk.scanner.fault = "55"
    talk.pass_by(1.0)
    assert talk.session.failed == "laser cannot be switched on"


def test_a_scanner_without_a_clock_to_ask_is_used_all_the_same() -> None:
    talk = Talk()
    ask = talk.scanner.hear
    talk.scanner.hear = lambda line, ms: reply_bytes(line[:-1], "0E") if line[:2] == b"TM" else ask(line, ms)  # type: ignore[method-assign]
    talk.pass_by(1.0)
    assert len(talk.scans) > 5
    assert abs(talk.scans[-1].stamp_ns * 1e-9 - talk.now_s) < 0.2


def test_a_scanner_left_while_its_clock_was_asked_for_is_woken() -> None:
    talk = Talk()
    talk.scanner.hear(b"TM0\n", 0)
    talk.pass_by(1.0)
    assert b"TM2\nQT\n" in talk.heard
    assert len(talk.scans) > 3


def test_a_scanner_that_begins_with_version_1_is_switched_to_version_2() -> None:
    talk = Talk()
    ask = talk.scanner.hear
    old = [True]

    def hear(line: bytes, ms: int) -> bytes:
        if b"SCIP2.0" in line:
            old[0] = False
            line = line.replace(b"SCIP2.0\n", b"")
        return b"QT\nE\n\n" if old[0] else ask(line, ms)

    talk.scanner.hear = hear  # type: ignore[method-assign]
    talk.pass_by(1.0)
    assert len(talk.scans) > 3


def test_a_scanner_that_cannot_measure_what_is_wanted_says_so() -> None:
    talk = Talk(LidarOptions(from_deg=140.0, to_deg=170.0))
    talk.pass_by(1.0)
    assert talk.session.failed == "measures nothing from 140 to 170 degrees"


def test_a_scanner_of_which_nothing_sensible_is_known_is_given_up() -> None:
    talk = Talk(model=replace(MODEL, around=0))
    talk.pass_by(1.0)
    assert talk.session.failed == "does not say what it measures (PP)"


def test_scans_of_a_conversation_before_do_not_confuse_the_new_one() -> None:
    talk = Talk()
    talk.scanner.hear(b"MD0000108001000\n", 0)  # somebody left it measuring
    talk.pass_by(1.0)
    assert talk.session.doing == RUNNING
    assert {unpacked(scan.ranges)[0] for scan in talk.scans} == {7.0}


def test_the_simulated_scanner_refuses_in_the_words_of_the_protocol() -> None:
    scanner = Responder()
    assert scanner.hear(b"GD0000108001\n", 0) == reply_bytes(b"GD0000108001", "10")  # the laser is off
    assert scanner.hear(b"MD0000108101000\n", 0) == reply_bytes(b"MD0000108101000", "04")
    assert scanner.hear(b"MD0010000001000\n", 0) == reply_bytes(b"MD0010000001000", "05")
    assert scanner.hear(b"TM1\n", 0) == reply_bytes(b"TM1", "04")
    assert scanner.hear(b"XX\n", 0) == reply_bytes(b"XX", "0E")
    assert scanner.hear(b"BM\nBM\nQT\n", 0) == b"BM\n00P\n\nBM\n02R\n\nQT\n00P\n\n"
    assert scanner.hear(b"MD0000000201002\n", 0) == reply_bytes(b"MD0000000201002", OK)
    assert scanner.turned(5, [1000] * 1081).startswith(b"MD0000000201001\n99b\n")
    assert scanner.turned(5, [1000] * 1081).startswith(b"MD0000000201000\n99b\n")
    assert scanner.turned(5, [1000] * 1081) == b""
