"""AIS sentences to sightings: what vessels say, what they leave out, and what is passed over."""

from __future__ import annotations

import math

import pytest
from pyais.encode import encode_dict

from fleet.drivers.ais.decoder import Listener
from fleet.drivers.ais.mmsi import FIRST, LAST, mmsis
from fleet.drivers.ais.options import AisOptions
from fleet.drivers.nmea.codec import KNOT_MPS, framed
from fleet.drivers.seam import Sighting

S = 1_000_000_000
REPORT = {
    "type": 1,
    "mmsi": 247000001,
    "lat": 44.4,
    "lon": 8.9,
    "speed": 10.0,
    "course": 90.0,
    "heading": 511,
    "accuracy": 1,
    "second": 10,
}


def sentences(**fields: object) -> list[bytes]:
    values = {**REPORT, **fields}
    return [one.encode() for one in encode_dict(values, talker_id="AI", sentence_type="VDM", seq_id=3)]


def heard(*lines: bytes, options: AisOptions | None = None) -> tuple[Sighting, ...]:
    listener = Listener(options or AisOptions())
    for i, line in enumerate(lines):
        listener.take(line, (i + 1) * 100)
    return listener.heard()


def why(*lines: bytes) -> str:
    listener = Listener(AisOptions())
    for line in lines:
        listener.take(line, 1)
    assert listener.heard() == ()
    return max(listener.counts, key=lambda key: key not in ("accepted", "waiting"))


def test_a_report_from_the_standard_literature_is_read() -> None:
    (one,) = heard(b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C")
    assert one.name == "mmsi-477553000"
    assert (one.lat_deg, one.lon_deg) == (pytest.approx(47.582833, abs=1e-6), pytest.approx(-122.345833, abs=1e-6))


@pytest.mark.parametrize("kind", [1, 2, 3])
def test_a_class_a_report_is_a_sighting_with_a_velocity_over_ground(kind: int) -> None:
    (one,) = heard(*sentences(type=kind))
    assert (one.source, one.name, one.stamp_ns) == ("ais", "mmsi-247000001", 100)
    assert (one.lat_deg, one.lon_deg) == (pytest.approx(44.4, abs=1e-6), pytest.approx(8.9, abs=1e-6))
    assert one.v_north_mps == pytest.approx(0.0, abs=1e-6)
    assert one.v_east_mps == pytest.approx(10.0 * KNOT_MPS)
    assert one.position_error_m == 4.0
    assert one.length_m == 100.0  # a ship that has not told it yet is a long one


def test_without_the_accuracy_bit_the_error_is_larger() -> None:
    assert heard(*sentences(accuracy=0))[0].position_error_m == 10.0


def test_a_class_b_report_has_no_length_until_it_is_told() -> None:
    listener = Listener(AisOptions())
    for line in sentences(type=18):
        listener.take(line, 1)
    assert math.isnan(listener.heard()[0].length_m)
    for line in sentences(type=24, partno=1, to_bow=8, to_stern=4, to_port=2, to_starboard=2):
        listener.take(line, 2)
    for line in sentences(type=24, partno=0, shipname="ANNA"):
        listener.take(line, 2)
    for line in sentences(type=18, lat=44.41):
        listener.take(line, 3)
    assert listener.heard()[0].length_m == 12.0


def test_one_that_tells_its_size_is_where_its_middle_is_not_where_its_antenna_is() -> None:
    static = sentences(type=5, to_bow=150, to_stern=50, to_port=10, to_starboard=20)
    assert len(static) == 2
    (one,) = heard(*static, *sentences(heading=0))
    assert one.length_m == 200.0
    assert (one.lat_deg - 44.4) * 111_195.0 == pytest.approx(50.0, abs=0.2)
    assert (one.lon_deg - 8.9) * 111_195.0 * math.cos(math.radians(44.4)) == pytest.approx(5.0, abs=0.2)
    (east,) = heard(*static, *sentences())  # without a compass its bow is where it goes
    assert (east.lon_deg - 8.9) * 111_195.0 * math.cos(math.radians(44.4)) == pytest.approx(50.0, abs=0.2)
    (moored,) = heard(*static, *sentences(speed=0.0))  # and without either nobody knows
    assert moored.lat_deg == pytest.approx(44.4, abs=1e-6)
    assert moored.position_error_m == pytest.approx(math.hypot(4.0, 50.0))


def test_an_extended_class_b_report_tells_place_and_size_at_once() -> None:
    (one,) = heard(*sentences(type=19, to_bow=6, to_stern=6, to_port=2, to_starboard=2))
    assert one.length_m == 12.0


@pytest.mark.parametrize(("fields", "velocity"), [({"speed": 102.3}, None), ({"course": 360.0}, None),
                                                  ({"course": 360.0, "speed": 0.1}, 0.0)])  # fmt: skip
def test_speed_or_course_not_available_is_no_velocity(fields: dict[str, object], velocity: float | None) -> None:
    one = heard(*sentences(**fields))[0]
    if velocity is None:
        assert math.isnan(one.v_north_mps + one.v_east_mps)
    else:
        assert (one.v_north_mps, one.v_east_mps) == (velocity, velocity)


def test_a_position_that_is_not_available_is_none() -> None:
    assert why(*sentences(lat=91.0, lon=181.0)) == "no position"
    assert why(*sentences(lat=0.0, lon=0.0)) == "position 0, 0"


def test_boats_of_the_fleet_and_the_own_transponder_are_passed_over() -> None:
    assert why(*sentences(mmsi=FIRST + 5)) == "of the fleet"
    listener = Listener(AisOptions(ignore_mmsi=(247000001,)))
    listener.take(sentences()[0], 1)
    assert listener.heard() == ()
    own = encode_dict(REPORT, talker_id="AI", sentence_type="VDO")[0].encode()
    assert why(own) == "own vessel"


def test_fragments_may_come_in_any_order_and_too_late_they_are_none() -> None:
    first, second = sentences(type=5, to_bow=10, to_stern=10)
    listener = Listener(AisOptions())
    listener.take(second, 1)
    listener.take(first, 2)
    assert listener.counts == {"waiting": 1, "accepted": 1}
    listener.take(first, 3)
    listener.take(second, 3 + 5 * S)
    assert listener.counts == {"waiting": 3, "accepted": 1, "messages abandoned": 1}


def test_fragments_of_two_messages_are_not_mixed() -> None:
    ones = sentences(type=5, to_bow=10, to_stern=10)
    others = [o.encode() for o in encode_dict({**REPORT, "type": 5, "mmsi": 247000002}, "AI", "VDM", seq_id=4)]
    listener = Listener(AisOptions())
    for line in (ones[0], others[0], others[1], ones[1]):
        listener.take(line, 1)
    assert listener.counts == {"waiting": 2, "accepted": 2}


def test_a_message_heard_twice_counts_once_and_the_next_one_again() -> None:
    line = sentences()[0]
    listener = Listener(AisOptions())
    for stamp_ns in (0, S, 4 * S):
        listener.take(line, stamp_ns)
    assert len(listener.heard()) == 2
    assert listener.counts["heard twice"] == 1


def test_a_tag_block_is_passed_over() -> None:
    assert len(heard(b"\\s:station,c:1764331200*00\\" + sentences()[0])) == 1


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"!AIVDM,1,1,,A,13HOI:0P0000VOHLCnHQKwvL05Ip,0*24", "checksum"),
        (framed("AIVDM,1,1,,A,13HOI:0P00,0", "!").strip(), "cut short"),
        (framed("AIVDM,1,1,,A,xyz\x7f,0", "!").strip(), "characters"),
        (framed("AIVDM,1,1,,A,~~~,0", "!").strip(), "not six-bit ASCII"),
        (framed("AIVDM,1,1,,A,4020soh,0", "!").strip(), "not used"),
        (framed("AIVDM,2,3,1,A,4020soh,0", "!").strip(), "fragment number"),
        (framed("AIVDM,1,1,,A,13HOI:0P0000VOHLCnHQKwvL05Ip", "!").strip(), "not six fields"),
        (b"$GPGGA", "no sentence"),
    ],
)
def test_what_cannot_be_read_says_why(line: bytes, reason: str) -> None:
    assert why(line) == reason


def test_every_boat_has_an_mmsi_of_a_country_that_does_not_exist() -> None:
    found = mmsis([f"b{i}" for i in range(200)], {"b7": 235000000})
    assert len(set(found.values())) == 200
    assert found["b7"] == 235000000
    assert all(FIRST <= mmsi <= LAST for boat, mmsi in found.items() if boat != "b7")
    assert mmsis(["b3"], {})["b3"] == found["b3"]
