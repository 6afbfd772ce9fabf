"""The fleet as AIS targets: what pyais reads of it, and what is refused."""

from __future__ import annotations

import math
import time

import pyais
import pytest
from msgspec.structs import replace

from fleet.cli.main import main
from fleet.drivers.ais.decoder import Listener
from fleet.drivers.ais.options import AisOptions
from fleet.operator.targets import Targets
from fleet.operator.view import BoatView
from tests.wire.samples import STATE


def views(**changes: float) -> dict[str, BoatView]:
    now = time.monotonic()
    return {name: BoatView(name, replace(STATE, boat=name, **changes), None, now) for name in ("b1", "b2")}


def read(lines: list[bytes]) -> list[object]:
    return [pyais.decode(line) for line in lines]


def test_a_boat_is_a_class_b_target_with_name_and_size() -> None:
    lines = Targets(given={"b2": 235000001}).due(views(), 0.0)
    said = [one for one in read(lines) if one.mmsi == 235000001]  # type: ignore[attr-defined]
    name, size, place = said
    assert name.shipname == "SIM B2"  # type: ignore[attr-defined]
    assert size.to_bow + size.to_stern == 2  # type: ignore[attr-defined]
    assert (place.msg_type, place.lat, place.lon) == (18, 44.38, 8.93)  # type: ignore[attr-defined]
    assert place.speed * 0.514444 == pytest.approx(1.01, abs=0.03)  # type: ignore[attr-defined]
    assert place.course == pytest.approx(math.degrees(0.1), abs=0.06)  # type: ignore[attr-defined]
    assert (place.heading, place.accuracy, place.second) == (6, True, 24)  # type: ignore[attr-defined]


def test_places_are_told_every_two_seconds_and_names_now_and_then() -> None:
    targets, kinds = Targets(), []
    for k in range(320):
        kinds += [one.msg_type for one in read(targets.due(views(), 0.1 * k))]  # type: ignore[attr-defined]
    assert kinds.count(18) == 2 * 16
    assert kinds.count(24) == 2 * 2 * 2


def test_a_boat_that_is_not_heard_any_more_is_no_target() -> None:
    old = {name: BoatView(name, view.state, None, time.monotonic() - 11.0) for name, view in views().items()}
    assert Targets().due(old, 0.0) == []
    assert Targets().due({"b1": BoatView("b1")}, 0.0) == []


def test_a_boat_that_knows_little_says_so() -> None:
    *_, place = read(Targets().due(views(position_error_m=9.0, sog_mps=0.0), 0.0))
    assert (place.accuracy, place.speed, place.course) == (False, 0.0, 360.0)  # type: ignore[attr-defined]


def test_a_fleets_own_targets_that_come_back_are_not_foreign_vessels() -> None:
    listener = Listener(AisOptions())
    for line in Targets().due(views(), 0.0):
        listener.take(line.strip(), 1)
    assert listener.heard() == ()
    assert listener.counts == {"of the fleet": 6}


@pytest.mark.parametrize(
    ("argv", "wrong"),
    [
        (["--udp", "8.8.8.8:10110"], "not an address of a local network"),
        (["--udp", "10.0.0.255:10110"], "or --lan where it is meant"),
        (["--udp", "10110"], "expected HOST:PORT"),
        (["--udp", "127.0.0.1:0"], "expected HOST:PORT"),
        (["--mmsi", "b1=x"], "expected BOAT=MMSI"),
        (["--interval", "0"], "expected more than 0"),
    ],
)
def test_what_cannot_be_meant_is_refused(argv: list[str], wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "ais", *argv]) == 2
    assert wrong in capsys.readouterr().err
