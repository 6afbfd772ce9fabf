"""What is shown of a boat: as an object for programs, and as words in a row for people."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fleet.operator import BoatView

HEADS = ("boat", "mode", "abscissa", "speed", "along-path", "cross-track", "nearest", "", "age")
UNITS = ("", "", "m", "m/s", "m", "m", "", "m", "s")
RIGHT = (2, 3, 4, 5, 7, 8)
WIDTHS = (4, 8, 8, 5, 10, 11, 7, 6, 5)  # at least, so that the picture does not jump
SIGNS = "along-path: + behind its place; cross-track: + to starboard of the path"
OLD_S = 0.7  # without a state for so long a boat is out of the formation (DESIGN.md, the trouble table)
LOST = "lost"


def facts(view: BoatView, clock_rate: float = 1.0) -> dict[str, Any]:
    """One boat as an object; null where nothing is known.

    Args:
        view: the boat as it was heard
        clock_rate: how much faster than the wall's the boats' clocks run
    """
    age_s = view.age_s() * clock_rate
    return {
        "boat": view.name,
        "alive": view.alive,
        "age_s": round(age_s, 3) if math.isfinite(age_s) else None,
        **_of_state(view),
        **_of_status(view),
    }


def _of_state(view: BoatView) -> dict[str, Any]:
    from fleet.agent.modes import in_words, mode_word

    state = view.state
    if state is None:  # a boat that does not know where it is has no state to publish, but says its mode and why
        status = view.status
        return {"mode": status.mode if status else None, "reasons": list(status.reasons) if status else []}
    return {
        "mode": mode_word(state.mode),
        "reasons": list(in_words(state.reasons)),
        "lap": state.lap,
        "s_m": state.s_m,
        "speed_mps": state.sog_mps,
        "along_path_error_m": state.along_path_m,
        "cross_track_error_m": state.cross_track_m,
        "nearest": state.nearest or None,
        "nearest_m": state.nearest_m if state.nearest else None,
        "lat_deg": state.lat_deg,
        "lon_deg": state.lon_deg,
        "course_deg": math.degrees(state.cog_rad) % 360.0,
        "heading_deg": math.degrees(state.heading_rad) % 360.0,
        "mission_id": state.mission_id or None,
        "formation_in_force": str(state.in_force),
        "formation_held": str(state.held),
        "controller": state.control.operator or None,
        "stops": list(state.stops),
        "simulated": state.simulated,
    }


def _of_status(view: BoatView) -> dict[str, Any]:
    status = view.status
    if status is None:
        return {}
    return {
        "mission": status.mission_title or None,
        "spacing_m": status.spacing_m if status.mission_id else None,
        "cruise_mps": status.cruise_mps if status.mission_id else None,
        "pattern": (status.pattern or None) if status.mission_id else None,
        "lateral_m": status.lateral_m if status.mission_id else None,
        "slot": status.slot if status.mission_id else None,
        "battery_percent": status.battery_percent,
        "peers": status.peers,
        "ticks": status.ticks,
        "ticks_late": status.ticks_late,
        "worst_late_ms": status.worst_late_ms,
        "messages_lost": status.messages_lost,
        "messages_refused": status.messages_refused,
        "requests_refused": status.requests_refused,
        "recording": status.recording,
        "driver": status.driver,
        "hull": status.hull,
        "version": status.version,
        "security": status.security,
        "roster": status.roster or None,
    }


def mode_shown(fact: dict[str, Any]) -> str:
    """The mode, or why there is none to rely on: a boat that fell silent is not still following."""
    if not fact["alive"]:
        return LOST
    return str(fact["mode"] or "unheard")


def cells(fact: dict[str, Any]) -> list[str]:
    """The row of a boat, without its reasons."""
    sails = bool(fact.get("mission_id"))
    lap = f" L{fact['lap'] + 1}" if fact.get("lap") else ""
    return [
        fact["boat"],
        mode_shown(fact),
        (_figure(fact.get("s_m"), ".1f") + lap) if sails else "-",
        _figure(fact.get("speed_mps"), ".2f"),
        _figure(fact.get("along_path_error_m"), "+.2f") if sails else "-",
        _figure(fact.get("cross_track_error_m"), "+.2f") if sails else "-",
        fact.get("nearest") or "-",
        _figure(fact.get("nearest_m"), ".1f"),
        _figure(fact["age_s"], ".1f"),
    ]


def why(fact: dict[str, Any]) -> str:
    """The boat's reasons in one line."""
    reasons = list(fact["reasons"])
    if fact.get("recording"):
        reasons.append(f"recording: {fact['recording']}")
    if fact.get("security"):
        reasons.append(fact["security"])
    return "; ".join(dict.fromkeys(reasons))


def _figure(value: float | None, form: str) -> str:
    if value is None or not math.isfinite(value):
        return "-"
    text = format(value, form)
    return text.replace("-", "+", 1) if text.startswith("-") and not text.strip("-0.") else text
