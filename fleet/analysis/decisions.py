"""What boats decided, why, and what came of it: recorded events, with what the tracks then did."""

from __future__ import annotations

import math
import re

import numpy as np
from msgspec import Struct

from fleet.analysis.separation import Distance, distance
from fleet.analysis.series import Series, Track
from fleet.analysis.traffic import hull_distance
from fleet.recording.topics import Event

DECIDES = ("avoid", "mode", "trouble", "stop")
"""Kinds of events that are decisions of a boat."""
TURN_DEG = 2.0  # a heading that changed by less is said to be kept
CLASS = re.compile(r", \d+ m off.*$")  # what follows the class of an encounter
AVOIDS = re.compile(r"^(\w+ -> avoid|avoid -> follow)\b")
ENDS = re.compile(r"^(clear\b|past and clear\b)")


class Decision(Struct, frozen=True, kw_only=True):
    """One boat decides something."""

    boat: str
    kind: str  # avoid, mode, trouble, stop
    at_s: float
    until_s: float | None  # the next of its kind; None: in force when the run ended
    text: str  # as the boat said it
    what: str  # course, speed, side, or the mode
    why: str  # the encounter, or the reason
    other: str = ""  # boat or vessel concerned
    met: str = ""  # where the other was, and how it sailed
    turned_deg: tuple[float, float] | None = None  # most to port (negative) and to starboard until it ended [deg]
    asked_mps: tuple[float, float] | None = None  # least and highest speed asked for until it ended
    nearest_m: float | None = None  # least distance to the other: of centres, or to a vessel between hulls
    nearest_s: float | None = None


def decisions(series: Series) -> list[Decision]:
    """Decisions of all boats in the order of time; the end of keeping clear ends one and is none itself."""
    names = {*series.tracks, *series.traffic, *series.said}
    apart = _Apart(series)
    met: dict[tuple[str, str], str] = {}
    found = []
    events = sorted(series.events, key=lambda one: one.stamp_ns)
    for k, event in enumerate(events):
        if event.kind == "traffic":
            vessel, _, words = event.text.partition(": ")
            met[event.boat, vessel] = CLASS.sub("", words)
        if event.kind not in DECIDES or _ends(event) or _only_avoids(event) or _goes_on(event):
            continue
        later = (one for one in events[k + 1 :] if one.boat == event.boat and one.kind == event.kind)
        ending = next((one for one in later if one.stamp_ns > event.stamp_ns and not _only_avoids(one)), None)
        until = None if ending is None else series.seconds(ending.stamp_ns)
        found.append(_decision(series, event, until, names, met, apart))
    return found


def _ends(event: Event) -> bool:
    return event.kind == "avoid" and bool(ENDS.match(event.text))


def _only_avoids(event: Event) -> bool:
    """Whether a change of mode says no more than the event about keeping clear does."""
    return event.kind == "mode" and bool(AVOIDS.match(event.text))


def _goes_on(event: Event) -> bool:
    """Whether a change of mode has no reason of its own: launched, or what kept the boat from following is over."""
    return event.kind == "mode" and ": " not in event.text


def _decision(
    series: Series,
    event: Event,
    until_s: float | None,
    names: set[str],
    met: dict[tuple[str, str], str],
    apart: _Apart,
) -> Decision:
    at = series.seconds(event.stamp_ns)
    end = series.end_s if until_s is None else until_s
    why, what = _why_and_what(event)
    other = event.other or _named(why, names - {event.boat})
    seen = [met.get((event.boat, other), ""), _seen(series, event.boat, other, at)]
    nearest = apart.least(event.boat, other, at, end) if event.kind == "avoid" else None
    moved = event.kind == "avoid"
    return Decision(
        boat=event.boat,
        kind=event.kind,
        at_s=at,
        until_s=until_s,
        text=event.text,
        what=what,
        why=", ".join([why, *event.reasons]) if why else ", ".join(event.reasons),
        other=other,
        met="; ".join(filter(None, seen)) if moved else "",
        turned_deg=_turned(series.tracks.get(event.boat), at, end) if moved else None,
        asked_mps=_asked(series, event.boat, at, end) if moved else None,
        nearest_m=None if nearest is None else nearest[0],
        nearest_s=None if nearest is None else nearest[1],
    )


def _why_and_what(event: Event) -> tuple[str, str]:
    head, _, tail = event.text.partition(": ")
    if event.kind == "mode":
        return tail, head.rpartition("-> ")[2] or head
    if event.kind == "avoid" and not tail:
        head, _, tail = event.text.partition(", leaving it")
        return head, f"leaves it{tail}" if tail else ""
    return head, tail


def _named(text: str, names: set[str]) -> str:
    """The longest name that stands in a text as a word."""
    there = [name for name in names if re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", text)]
    return max(there, key=len, default="")


def _seen(series: Series, boat: str, other: str, t: float) -> str:
    """`20 m off, ahead, on the same course`, from tracks; empty where one of them is not known then."""
    own, its = series.tracks.get(boat), series.tracks.get(other, series.traffic.get(other))
    if own is None or its is None or not _known(own, t) or not _known(its, t):
        return ""
    dx, dy = _at(its, "x", t) - _at(own, "x", t), _at(its, "y", t) - _at(own, "y", t)
    psi, psi_other = _at(own, "psi", t), _at(its, "psi", t)
    bearing = _wrapped_deg(math.atan2(dy, dx) - psi)
    across = _wrapped_deg(psi_other - psi)
    words = [f"{math.hypot(dx, dy):.0f} m off", _bearing(bearing)]
    if not math.isnan(across):
        words.append(_course(across))
    return ", ".join(words)


def _bearing(deg: float) -> str:
    side = "starboard" if deg > 0.0 else "port"
    if abs(deg) < 10.0:
        return "ahead"
    return "astern" if abs(deg) > 170.0 else f"{abs(deg):.0f} deg to {side}"


def _course(deg: float) -> str:
    if abs(deg) < 15.0:
        return "on the same course"
    return "on the opposite course" if abs(deg) > 165.0 else f"courses {abs(deg):.0f} deg apart"


def _wrapped_deg(angle: float) -> float:
    return math.degrees(math.remainder(angle, 2.0 * math.pi)) if math.isfinite(angle) else math.nan


def _known(track: Track, t: float) -> bool:
    return len(track.t) > 0 and bool(track.t[0] - 1.0 <= t <= track.t[-1] + 1.0)


def _at(track: Track, name: str, t: float) -> float:
    """A value of a track at a time; a heading as that of the nearest sample."""
    if name == "psi":
        return float(track.psi[int(np.argmin(np.abs(track.t - t)))])
    return float(np.interp(t, track.t, getattr(track, name)))


def _turned(track: Track | None, begin: float, end: float) -> tuple[float, float] | None:
    """Most that the heading went to port and to starboard of what it was at the beginning [deg]."""
    if track is None or not len(track.t):
        return None
    psi = track.psi[(track.t >= begin) & (track.t <= end)]
    psi = psi[np.isfinite(psi)]
    if not len(psi):
        return None
    moved = np.degrees(np.unwrap(psi) - psi[0])
    return float(moved.min()), float(moved.max())


def _asked(series: Series, boat: str, begin: float, end: float) -> tuple[float, float] | None:
    one = series.said.get(boat)
    if one is None:
        return None
    u_d = one.u_d[(one.t >= begin) & (one.t <= end)]
    u_d = u_d[np.isfinite(u_d)]
    return (float(u_d.min()), float(u_d.max())) if len(u_d) else None


class _Apart:
    """Distances of pairs, each computed once."""

    def __init__(self, series: Series) -> None:
        self._series = series
        self._pairs: dict[frozenset[str], Distance | None] = {}

    def least(self, boat: str, other: str, begin: float, end: float) -> tuple[float, float] | None:
        """Least distance in a time, and when [m, s]."""
        own, its = self._series.tracks.get(boat), self._series.tracks.get(other)
        if own is None:
            return None
        if its is None:
            return self._from_vessel(own, other, begin, end)
        pair = frozenset((boat, other))
        if pair not in self._pairs:
            self._pairs[pair] = distance(own, its)
        apart = self._pairs[pair]
        if apart is None:
            return None
        there = np.flatnonzero((apart.least_t >= begin) & (apart.least_t <= end))
        if not len(there):
            return None
        k = there[int(np.argmin(apart.least[there]))]
        return float(apart.least[k]), float(apart.least_t[k])

    def _from_vessel(self, own: Track, other: str, begin: float, end: float) -> tuple[float, float] | None:
        vessel = self._series.traffic.get(other)
        if vessel is None or not len(vessel.t):
            return None
        t = own.t[(own.t >= max(begin, vessel.t[0])) & (own.t <= min(end, vessel.t[-1]))]
        if not len(t):
            return None
        hull = hull_distance(own, vessel, t)
        k = int(np.argmin(hull))
        return float(hull[k]), float(t[k])
