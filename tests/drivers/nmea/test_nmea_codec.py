"""NMEA 0183 sentences by hand, beside pynmea2, and the ways in which they say nothing."""

from __future__ import annotations

import math

import pynmea2
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.drivers.nmea import encode
from fleet.drivers.nmea.codec import KNOT_MPS, Gga, Gst, Heading, Rmc, Rot, Unusable, Vtg, checksum, decode, framed

NOON_NS = 1_764_331_200_000_000_000  # 2025-11-28 12:00:00 UTC
lats = st.floats(-89.9, 89.9).filter(lambda lat: abs(lat) > 1e-6)
lons = st.floats(-179.9, 179.9)


def why(body: str) -> str:
    with pytest.raises(Unusable) as info:
        decode(framed(body).strip())
    return str(info.value)


def test_the_checksum_of_a_sentence_in_every_manual() -> None:
    gga = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47"
    assert checksum(gga[1:-3]) == 0x47
    said = decode(gga)
    assert isinstance(said, Gga)
    assert (said.time_s, said.quality, said.hdop) == (45319.0, 1, 0.9)
    assert (said.lat_deg, said.lon_deg) == (pytest.approx(48.0 + 7.038 / 60.0), pytest.approx(11.0 + 31.0 / 60.0))


def test_speed_and_course_become_a_velocity_over_ground() -> None:
    said = decode(framed("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,090.0,230394,003.1,W").strip())
    assert isinstance(said, Rmc)
    assert (said.v_north_mps, said.v_east_mps) == (pytest.approx(0.0, abs=1e-9), pytest.approx(22.4 * KNOT_MPS))
    vtg = decode(framed("GPVTG,180.0,T,,M,,N,7.2,K,A").strip())
    assert vtg == Vtg(pytest.approx(-2.0), pytest.approx(0.0, abs=1e-9))


def test_a_turn_to_starboard_is_positive_and_in_degrees_a_minute() -> None:
    assert decode(framed("TIROT,60.0,A").strip()) == Rot(pytest.approx(math.radians(1.0)))
    assert decode(framed("TIROT,-60.0,A").strip()) == Rot(pytest.approx(-math.radians(1.0)))


@pytest.mark.parametrize("talker", ["GP", "GN", "HE", "II", "GA", "BD"])
def test_who_says_it_does_not_matter(talker: str) -> None:
    said = decode(framed(f"{talker}HDT,350.0,T").strip())
    assert said == Heading(pytest.approx(-math.radians(10.0)), False, pytest.approx(math.nan, nan_ok=True))


def test_a_magnetic_heading_says_so_and_brings_its_variation_where_it_has_one() -> None:
    hdg = decode(framed("HCHDG,98.0,1.0,E,2.5,W").strip())
    assert isinstance(hdg, Heading)
    assert hdg.magnetic
    assert math.degrees(hdg.heading_rad) == pytest.approx(99.0)
    assert math.degrees(hdg.variation_rad) == pytest.approx(-2.5)
    bare = decode(framed("HCHDM,98.0,M").strip())
    assert isinstance(bare, Heading)
    assert bare.magnetic
    assert math.isnan(bare.variation_rad)


def test_the_receivers_own_error_is_per_axis() -> None:
    gst = decode(framed("GNGST,120000.00,1.0,,,,0.3,0.4,0.9").strip())
    assert gst == Gst(43200.0, pytest.approx(0.5 / math.sqrt(2.0)))


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("GPRMC,123519,V,4807.038,N,01131.000,E,022.4,084.4,230394,,", "void"),
        ("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,,,N", "void"),
        ("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,,,E", "void"),
        ("GPRMC,123519,A,,,,,022.4,084.4,230394,,,A", "no position"),
        ("GPRMC,123519,A,0000.000,N,00000.000,E,0.0,0.0,230394,,,A", "position 0, 0"),
        ("GPRMC,,A,4807.038,N,01131.000,E,022.4,084.4,230394,,,A", "no time"),
        ("GPRMC,123519,A,4807.038,N,01131.000,E,122.4,084.4,230394,,,A", "implausible"),
        ("GPRMC,123519,A,4807.038,N,01131.000,E,1e1,084.4,230394,,,A", "not a number"),
        ("GPRMC,123519,A,4807.038,N,01131.000,E,nan,084.4,230394,,,A", "not a number"),
        ("GPGGA,123519,4807.038,N,01131.000,E,0,08,0.9,,,,,,", "no fix"),
        ("GPGGA,123519,4807.038,N,01131.000,E,,08,0.9,,,,,,", "no fix"),
        ("GPGGA,123519,4807.038,N,01131.000,E,6,08,0.9,,,,,,", "not a measured fix"),
        ("GPGGA,123519,4807.038,N,01131.000,E,8,08,0.9,,,,,,", "not a measured fix"),
        ("GPGGA,123519,4867.038,N,01131.000,E,1,08,0.9,,,,,,", "not a position"),
        ("GPGGA,123519,9100.000,N,01131.000,E,1,08,0.9,,,,,,", "not a position"),
        ("GPGGA,123519,4807.038,E,01131.000,N,1,08,0.9,,,,,,", "not a position"),
        ("GPGGA,253519,4807.038,N,01131.000,E,1,08,0.9,,,,,,", "not a time"),
        ("GPVTG,,T,,M,,N,,K,N", "void"),
        ("HEHDT,,T", "no heading"),
        ("HEHDT,361.0,T", "implausible"),
        ("HETHS,12.0,V", "void"),
        ("TIROT,,A", "no rate"),
        ("TIROT,3.0,V", "void"),
        ("GPGSV,3,1,11,03,03,111,00", "not used"),
        ("PGRME,15.0,M,45.0,M,25.0,M", "not used"),
    ],
)
def test_what_says_nothing_says_why(body: str, reason: str) -> None:
    assert why(body) == reason


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"GPRMC", "no sentence"),
        (b"$GPRMC,123519", "no checksum"),
        (b"$HEHDT,123.4,T*2C", "checksum"),
        (b"$HEHDT,123.4,T*+B", "checksum"),
        (b"$" + b"x" * 300, "too long"),
        (b"\xff\xfe$", "no sentence"),
    ],
)
def test_what_is_no_sentence_is_none(line: bytes, reason: str) -> None:
    with pytest.raises(Unusable, match=f"^{reason}$"):
        decode(line)


def test_empty_fields_are_not_available_and_never_zero() -> None:
    rmc = decode(framed("GPRMC,123519,A,4807.038,N,01131.000,E,,,230394,,,A").strip())
    assert isinstance(rmc, Rmc)
    assert math.isnan(rmc.v_north_mps)
    assert math.isnan(rmc.v_east_mps)
    gga = decode(framed("GPGGA,123519,4807.038,N,01131.000,E,1,,,,,,,,").strip())
    assert isinstance(gga, Gga)
    assert math.isnan(gga.hdop)


def test_a_boat_at_rest_has_a_speed_without_a_course() -> None:
    rmc = decode(framed("GPRMC,123519,A,4807.038,N,01131.000,E,0.02,,230394,,,A").strip())
    assert isinstance(rmc, Rmc)
    assert (rmc.v_north_mps, rmc.v_east_mps) == (0.0, 0.0)


@given(lats, lons, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_what_we_say_we_hear_and_pynmea2_hears_it_too(lat: float, lon: float, vn: float, ve: float) -> None:
    line = encode.rmc(NOON_NS, lat, lon, vn, ve).strip()
    ours, theirs = decode(line), pynmea2.parse(line.decode(), check=True)
    assert isinstance(ours, Rmc)
    assert (ours.lat_deg, ours.lon_deg) == (pytest.approx(lat, abs=1e-8), pytest.approx(lon, abs=1e-8))
    assert (theirs.latitude, theirs.longitude) == (pytest.approx(lat, abs=1e-8), pytest.approx(lon, abs=1e-8))
    assert (ours.v_north_mps, ours.v_east_mps) == (pytest.approx(vn, abs=1e-3), pytest.approx(ve, abs=1e-3))
    assert theirs.spd_over_grnd * KNOT_MPS == pytest.approx(math.hypot(vn, ve), abs=1e-3)
    gga = encode.gga(NOON_NS, lat, lon, 4, 0.7).strip()
    fix, theirs = decode(gga), pynmea2.parse(gga.decode(), check=True)
    assert isinstance(fix, Gga)
    assert (fix.time_s, fix.quality, fix.hdop) == (43200.0, 4, 0.7)
    assert (theirs.latitude, int(theirs.gps_qual)) == (pytest.approx(lat, abs=1e-8), 4)


@given(st.floats(-math.pi, math.pi), st.floats(-0.5, 0.5))
def test_heading_and_rate_of_turn_go_round(psi: float, r: float) -> None:
    heading, rate = decode(encode.hdt(psi).strip()), decode(encode.rot(r).strip())
    assert isinstance(heading, Heading)
    assert math.remainder(heading.heading_rad - psi, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-4)
    assert rate == Rot(pytest.approx(r, abs=1e-6))


def test_without_values_our_own_sentences_say_so() -> None:
    nan = math.nan
    assert why(encode.rmc(NOON_NS, nan, nan, nan, nan)[1:-5].decode()) == "void"
    assert why(encode.gga(NOON_NS, nan, nan, 1, 1.0)[1:-5].decode()) == "no fix"
    assert why(encode.hdt(nan)[1:-5].decode()) == "no heading"
    assert why(encode.rot(nan)[1:-5].decode()) == "void"
    assert pynmea2.parse("$GPRMC,123519,V,,,,,,,230394,,*33").latitude == 0.0  # why pynmea2 does not read for us


@given(st.binary(max_size=120))
def test_whatever_bytes_come_nothing_but_a_reason_is_made_of_them(noise: bytes) -> None:
    with pytest.raises(Unusable):
        decode(b"$" + noise + b"*zz")
