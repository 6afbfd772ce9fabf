"""What boats decided, read from events and tracks worked by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from fleet.analysis.decisions import Decision, decisions
from fleet.analysis.series import Said, Series, Track
from fleet.recording.topics import Event

T = np.arange(0.0, 100.05, 0.1)


def track(x: float, y: float, psi_deg: float, length_m: float = 2.4) -> Track:
    """1 m/s from a place on a course."""
    psi = math.radians(psi_deg)
    return Track(t=T, x=x + math.cos(psi) * T, y=y + math.sin(psi) * T, psi=np.full_like(T, psi),
                 speed=np.ones_like(T), length_m=length_m)  # fmt: skip


def said(u_d: np.ndarray) -> Said:
    zeros = np.zeros_like(T)
    return Said(t=T, speed=zeros, u_d=u_d, e_s=zeros, y_e=zeros, mode=("follow",) * len(T),
                avoiding=zeros > 0.0, reasons=((),) * len(T))  # fmt: skip


def event(at_s: float, boat: str, kind: str, text: str, **more: object) -> Event:
    return Event(stamp_ns=round(at_s * 1e9), boat=boat, kind=kind, text=text, **more)  # type: ignore[arg-type]


def only(*events: Event, traffic: dict[str, Track] | None = None) -> list[Decision]:
    """b1 sails north from the datum, b10 meets it bow to bow, 2 m to port of its line."""
    own = track(0.0, 0.0, 0.0)
    turned = np.where(T < 20.0, 0.0, np.radians(30.0)) + np.where(T < 40.0, 0.0, np.radians(-50.0))
    series = Series(
        folder=Path("run"),
        start_ns=0,
        tracks={"b1": Track(t=T, x=own.x, y=own.y, psi=turned, speed=own.speed, length_m=2.4),
                "b10": track(60.0, -2.0, 180.0)},
        said={"b1": said(np.where(T < 25.0, 1.0, 0.5))},
        events=list(events),
        traffic=traffic or {},
    )  # fmt: skip
    return decisions(series)


def test_a_boat_that_keeps_clear_of_another_decides_until_it_is_clear() -> None:
    found = only(
        event(10.0, "b1", "avoid", "keeping clear of b10, leaving it to port"), event(50.0, "b1", "avoid", "clear")
    )
    assert len(found) == 1
    one = found[0]
    assert (one.boat, one.other) == ("b1", "b10")
    assert (one.at_s, one.until_s) == (pytest.approx(10.0), pytest.approx(50.0))
    assert (one.why, one.what) == ("keeping clear of b10", "leaves it to port")
    assert one.met == "40 m off, ahead, on the opposite course"
    assert one.turned_deg == pytest.approx((-20.0, 30.0))
    assert one.asked_mps == (0.5, 1.0)
    assert one.nearest_m == pytest.approx(2.0)
    assert one.nearest_s == pytest.approx(30.0)


def test_the_distance_is_the_least_while_the_decision_is_in_force_and_not_of_the_run() -> None:
    found = only(event(40.0, "b1", "avoid", "keeping clear of b10"), event(50.0, "b1", "avoid", "clear"))
    assert found[0].nearest_m == pytest.approx(math.hypot(20.0, 2.0))
    assert found[0].nearest_s == pytest.approx(40.0)


def test_a_decision_that_nothing_ends_is_in_force_to_the_end() -> None:
    assert only(event(10.0, "b1", "avoid", "keeping clear of b10"))[0].until_s is None


def test_another_boats_event_ends_nothing() -> None:
    found = only(event(10.0, "b1", "avoid", "keeping clear of b10"), event(20.0, "b10", "avoid", "clear"))
    assert found[0].until_s is None


def test_a_vessel_has_its_class_of_encounter_and_the_distance_between_hulls() -> None:
    ferry = Track(t=T, x=np.full_like(T, 50.0), y=100.0 - 5.0 * T, psi=np.full_like(T, -math.pi / 2.0),
                  speed=np.full_like(T, 5.0), length_m=40.0)  # fmt: skip
    found = only(
        event(2.0, "b1", "traffic", "ferry: crossing from starboard, gives way, 102 m off, in 34 s"),
        event(3.0, "b1", "avoid", "gives way to ferry, crossing from starboard: 60 deg to starboard"),
        event(12.0, "b1", "avoid", "past and clear of other vessels, back to the path"),
        traffic={"ferry": ferry},
    )  # fmt: skip
    one = found[0]
    assert one.other == "ferry"
    assert one.why == "gives way to ferry, crossing from starboard"
    assert one.what == "60 deg to starboard"
    assert one.met == "crossing from starboard, gives way; 97 m off, 61 deg to starboard, courses 90 deg apart"
    assert one.until_s == pytest.approx(12.0)
    assert one.nearest_m is not None
    assert one.nearest_m < 50.0


def test_a_mode_with_a_reason_is_a_decision_and_one_without_is_none() -> None:
    found = only(
        event(0.0, "b1", "mode", "standby -> follow"),
        event(10.0, "b1", "mode", "follow -> avoid: keeping clear"),
        event(20.0, "b1", "mode", "avoid -> follow"),
        event(30.0, "b1", "mode", "follow -> hold: own link is down"),
        event(60.0, "b1", "mode", "hold -> follow"),
    )
    assert [(one.what, one.why) for one in found] == [("hold", "own link is down")]
    assert (found[0].at_s, found[0].until_s) == (pytest.approx(30.0), pytest.approx(60.0))


def test_named_reasons_of_an_event_are_told() -> None:
    found = only(event(10.0, "b1", "avoid", "keeping clear of b10", reasons=["ahead"], other="b10"))
    assert found[0].why == "keeping clear of b10, ahead"
