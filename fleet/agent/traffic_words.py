"""Keeping clear of foreign vessels in words."""

from __future__ import annotations

import math

from fleet.avoidance.foreign.types import NEVER_S, Action, Advice, Contact, Kind, Reason, Role

MEETS: dict[float, str] = {
    float(Kind.NONE): "no risk of collision",
    float(Kind.STATIC): "not under way",
    float(Kind.OVERTAKING): "overtaken by us",
    float(Kind.OVERTAKEN): "overtaking us",
    float(Kind.HEAD_ON): "head-on",
    float(Kind.CROSSING_GIVE_WAY): "crossing from starboard",
    float(Kind.CROSSING_STAND_ON): "crossing from port",
}
ROLES: dict[float, str] = {float(Role.NONE): "", float(Role.GIVE_WAY): "gives way", float(Role.STAND_ON): "stands on"}


def meeting(contact: Contact) -> str:
    """`crossing from starboard, gives way, 120 m off, in 34 s`."""
    words = [MEETS.get(contact.kind, "?"), ROLES.get(contact.role, ""), f"{contact.distance:.0f} m off"]
    if contact.entry < NEVER_S:
        words.append(f"in {contact.entry:.0f} s")
    return ", ".join(word for word in words if word)


def sentence(advice: Advice, name: str) -> str:
    """`gives way to ferry, crossing from starboard`."""
    if advice.reason == Reason.ORDER:
        return f"keeps clear of {name} as its leader says"
    meets = MEETS.get(advice.kind, "?")
    if advice.role == Role.STAND_ON:
        return f"keeps clear of {name}, {meets}, which has not given way"
    why = {
        float(Reason.HELD_FAILS): "changes its course for",
        float(Reason.BANK): "changes its course at the fence for",
        float(Reason.NEW_TARGET): "gives way also to",
        float(Reason.NO_ORDER): "without an order keeps clear of",
    }
    return f"{why.get(advice.reason, 'gives way to')} {name}" + (f", {meets}" if advice.kind else "")


def action(decided: Action) -> str:
    """`60 deg to starboard at half speed`."""
    turn = round(abs(math.degrees(decided.a)))
    side = "starboard" if decided.a > 0.0 else "port"
    course = f"{turn} deg to {side}" if turn else ""
    if decided.factor <= 0.0:
        speed = "stops"
    elif decided.factor < 1.0:
        speed = f"at {decided.factor:.0%} of its speed"
    else:
        speed = "as fast as it can" if decided.factor > 1.0 else ""
    return " ".join(word for word in (course, speed) if word) or "holds its course"
