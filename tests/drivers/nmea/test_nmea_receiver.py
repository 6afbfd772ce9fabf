"""Sentences of one line to fixes: epochs, what is refused, and why, and how old it all is."""

from __future__ import annotations

import math

import pytest

from fleet.drivers.nmea import encode
from fleet.drivers.nmea.codec import framed
from fleet.drivers.nmea.receiver import NmeaOptions, Receiver
from fleet.drivers.seam import Observed

MS = 1_000_000
NOON_NS = 1_764_331_200_000_000_000
LAT, LON = 44.38, 8.93


class Line:
    """A receiver, and a clock that is not UTC."""

    def __init__(self, options: NmeaOptions | None = None, delay_s: float = 0.0) -> None:
        self.receiver = Receiver(options or NmeaOptions(), delay_s)
        self.ns = 5_000 * MS
        self.utc_ns = NOON_NS

    def hear(self, *sentences: bytes) -> None:
        for one in sentences:
            self.receiver.take(one.strip(), self.ns)
            self.ns += 5 * MS

    def epoch(self, north_m: float = 0.0, *, hdop: float = 1.0, quality: int = 1, rmc: bool = True) -> Observed:
        """Both sentences of the next tenth of a second, and what came of them."""
        lat = LAT + north_m / 111_195.0
        self.hear(encode.gga(self.utc_ns, lat, LON, quality, hdop))
        if rmc:
            self.hear(encode.rmc(self.utc_ns, lat, LON, 1.0, 0.5))
        said = self.receiver.observed(self.ns)
        self.utc_ns += 100 * MS
        self.ns += (90 if rmc else 95) * MS
        return said

    def well(self, epochs: int = 3) -> None:
        for _ in range(epochs):
            self.epoch()


def test_two_sentences_of_one_moment_are_one_fix_that_is_as_old_as_the_first() -> None:
    line = Line()
    line.well()
    began = line.ns
    said = line.epoch(2.0)
    assert said.fix_ns == began
    assert said.lat_deg == pytest.approx(LAT + 2.0 / 111_195.0)
    assert (said.v_north_mps, said.v_east_mps) == (pytest.approx(1.0, abs=1e-3), pytest.approx(0.5, abs=1e-3))
    assert (said.position_error_m, said.velocity_error_mps) == (1.5, 0.1)
    assert line.receiver.observed(line.ns).fix_ns == 0  # once


def test_the_delay_of_a_receiver_that_is_known_makes_the_fix_older() -> None:
    line = Line(delay_s=0.12)
    line.well()
    began = line.ns
    assert line.epoch().fix_ns == began - 120 * MS


@pytest.mark.parametrize(("quality", "hdop", "sigma"), [(1, 1.0, 1.5), (2, 2.0, 1.6), (4, 0.5, 0.01), (5, 1.0, 0.3)])
def test_quality_and_hdop_give_the_error(quality: int, hdop: float, sigma: float) -> None:
    line = Line()
    line.well()
    assert line.epoch(hdop=hdop, quality=quality).position_error_m == pytest.approx(sigma)


def test_the_receivers_own_word_on_its_error_goes_over_that() -> None:
    line = Line()
    line.well()
    line.hear(framed("GNGST,120000.00,1.0,,,,0.3,0.3,0.9"))
    assert line.epoch().position_error_m == pytest.approx(0.3)


def test_a_receiver_that_says_only_where_it_is_is_heard_too() -> None:
    line = Line()
    said = [line.epoch(rmc=False) for _ in range(4)][-1]
    assert said.fix_ns > 0
    assert math.isnan(said.v_north_mps)


def test_speed_and_course_may_come_in_a_sentence_of_their_own() -> None:
    line = Line()
    for _ in range(4):
        line.hear(encode.gga(line.utc_ns, LAT, LON, 1, 1.0), framed("GPVTG,90.0,T,,M,,N,3.6,K,A"))
        said = line.receiver.observed(line.ns)
        line.utc_ns, line.ns = line.utc_ns + 100 * MS, line.ns + 90 * MS
    assert said.v_east_mps == pytest.approx(1.0, abs=1e-3)


def test_a_void_sentence_spoils_the_moment_whatever_the_other_one_says() -> None:
    line = Line()
    line.well()
    for void_first in (False, True, False):
        sentences = [encode.gga(line.utc_ns, LAT, LON, 1, 1.0), encode.rmc(line.utc_ns, math.nan, 0.0, 0.0, 0.0)]
        line.hear(*(reversed(sentences) if void_first else sentences))
        assert line.receiver.observed(line.ns + 200 * MS).fix_ns == 0
        line.utc_ns, line.ns = line.utc_ns + 1000 * MS, line.ns + 990 * MS
    assert line.receiver.why_no_fix == "void"


def test_sentences_of_one_moment_that_disagree_are_no_fix() -> None:
    line = Line()
    line.well()
    line.hear(encode.gga(line.utc_ns, LAT, LON, 1, 1.0), encode.rmc(line.utc_ns, LAT + 0.001, LON, 1.0, 0.0))
    assert line.receiver.observed(line.ns).fix_ns == 0
    assert line.receiver.counts["no fix: its sentences disagree"] == 1


def test_a_poor_geometry_is_no_fix() -> None:
    line = Line()
    line.well()
    assert line.epoch(hdop=4.1).fix_ns == 0
    assert line.receiver.why_no_fix == "HDOP too high"


def test_a_jump_is_refused_until_five_fixes_agree_on_it() -> None:
    line = Line()
    line.well()
    jumped = [line.epoch(100.0).fix_ns > 0 for _ in range(6)]
    assert jumped == [False, False, False, False, True, True]


def test_a_single_wild_fix_leaves_nothing_behind() -> None:
    line = Line()
    line.well()
    assert line.epoch(500.0).fix_ns == 0
    assert line.epoch(0.5).fix_ns > 0


def test_time_that_stands_still_or_goes_back_gives_no_fix() -> None:
    line = Line()
    line.well()
    line.utc_ns -= 100 * MS
    frozen = line.utc_ns
    for _ in range(10):
        line.utc_ns = frozen
        assert line.epoch().fix_ns == 0
    assert line.receiver.why_no_fix == "time stands still"
    line.utc_ns = frozen - 2_000 * MS
    assert line.epoch().fix_ns == 0
    assert line.receiver.counts["time goes back"] == 2


def test_a_receiver_whose_time_was_wrong_is_believed_after_a_second() -> None:
    line = Line()
    line.well()
    line.utc_ns -= 18_000 * MS  # leap seconds, learned late
    heard = [line.epoch().fix_ns > 0 for _ in range(8)]
    assert heard[:4] == [False] * 4
    assert heard[-1]


def test_what_waited_somewhere_is_as_old_as_its_time_says() -> None:
    line = Line()
    line.well()
    began = line.ns
    line.ns += 3_000 * MS  # a gateway holds everything back, then hands it on at once
    assert line.epoch().fix_ns == pytest.approx(began, abs=5 * MS)
    assert line.receiver.counts["late"] == 1


def test_midnight_is_a_moment_as_any_other() -> None:
    line = Line()
    line.utc_ns = NOON_NS + 43_200_000 * MS - 300 * MS
    assert [line.epoch().fix_ns > 0 for _ in range(8)][2:] == [True] * 6
    assert line.receiver.counts["late"] == 0


def test_heading_and_rate_of_turn_have_their_own_time() -> None:
    line = Line(NmeaOptions(heading_offset_deg=-90.0, heading_error_deg=1.0))
    line.hear(encode.hdt(0.0), encode.rot(0.1))
    said = line.receiver.observed(line.ns)
    assert (said.heading_ns, said.yaw_rate_ns) == (5_000 * MS, 5_005 * MS)
    assert (said.heading_rad, said.heading_error_rad) == (pytest.approx(-math.pi / 2), pytest.approx(math.radians(1)))
    assert said.yaw_rate_radps == pytest.approx(0.1, abs=1e-6)


def test_a_magnetic_heading_needs_the_variation() -> None:
    line = Line()
    line.hear(framed("HCHDM,98.0,M"))
    assert line.receiver.observed(line.ns).heading_ns == 0
    assert line.receiver.why_no_heading == "magnetic, variation not known"
    line = Line(NmeaOptions(variation_deg=2.5))
    line.hear(framed("HCHDM,98.0,M"))
    assert math.degrees(line.receiver.observed(line.ns).heading_rad) == pytest.approx(100.5)


def test_every_sentence_is_counted_by_what_came_of_it() -> None:
    line = Line()
    line.well(2)
    line.hear(b"$GPGSV,1,1,00*79", b"$HEHDT,1.0,T*00", b"rubbish", framed("GPRMC,120000,V,,,,,,,,,,N"))
    counts = line.receiver.counts
    assert (counts["accepted"], counts["not used"], counts["checksum"], counts["no sentence"], counts["void"]) == (
        4, 1, 1, 1, 1,
    )  # fmt: skip


def test_what_came_late_once_and_stays_late_is_late_for_hours() -> None:
    line = Line()
    line.well()
    line.ns += 2_000 * MS
    for _ in range(6000):  # ten minutes
        line.hear(encode.gga(line.utc_ns, LAT, LON, 1, 1.0))
        line.utc_ns, line.ns = line.utc_ns + 100 * MS, line.ns + 95 * MS
    assert line.receiver.counts["late"] == 6000
    line.hear(encode.hdt(1.0))  # on the same line, and as late
    assert line.ns - line.receiver.observed(line.ns).heading_ns > 1_800 * MS
