"""What an operator may tune, as MAVLink parameters: names, limits, what a value means."""

from __future__ import annotations

import math
from typing import Literal

from msgspec import Struct

from fleet.gcs.chart import PATTERNS


class Parameter(Struct, frozen=True):
    """One of them."""

    name: str  # at most 16 characters
    kind: Literal["formation", "draft", "boat", "read-only"]
    least: float
    most: float
    meaning: str
    change: str = ""  # what it is for `fleet set`
    field: str = ""  # of the draft
    whole: bool = False


PARAMETERS: tuple[Parameter, ...] = (
    Parameter("FLT_SPACING", "formation", -200, 200, "from slot to slot, + ahead [m]", "spacing", "spacing_m"),
    Parameter("FLT_LATERAL", "formation", -200, 200, "from slot to slot abeam [m]", "lateral", "lateral_m"),
    Parameter("FLT_CRUISE", "formation", 0.05, 20, "speed of the formation [m/s]", "speed", "cruise_mps"),
    Parameter("FLT_PATTERN", "formation", 0, 4, ", ".join(PATTERNS), "pattern", "pattern", whole=True),
    Parameter("FLT_SLOT", "formation", -100, 100, "place of this boat in the formation", "slots"),
    Parameter("FLT_GAIN", "draft", 0.01, 2, "k_u: how hard places are corrected [1/m]", field="gain_per_m"),
    Parameter("FLT_RADIUS", "draft", 3, 50, "safety radius R between boats [m]", field="radius_m"),
    Parameter("FLT_ALONE", "boat", 0, 1, "1: what is uploaded to this boat is for it alone", whole=True),
    Parameter("FLT_CONTROL", "boat", 0, 1, "1: this bridge holds control of the fleet; set 1 to take it", whole=True),
    Parameter("ARMING_CHECK", "read-only", 1, 1, "1: all of them, always", whole=True),
    Parameter("MAV_SYSID", "read-only", 1, 250, "of this boat; given by fleet gcs --sysid", whole=True),
)
NUMBERS = {parameter.name: number for number, parameter in enumerate(PARAMETERS)}


def wrong(parameter: Parameter, value: float) -> str:
    """Why a value is not taken; '' when it may be."""
    name, low, high = parameter.name, parameter.least, parameter.most
    if parameter.kind == "read-only":
        return f"{name} cannot be set: {parameter.meaning}"
    if not (math.isfinite(value) and low <= value <= high):
        return f"{name} {value:g}: expected {low:g} to {high:g}"
    if parameter.whole and value != round(value):
        return f"{name} {value:g}: expected a whole number"
    return ""


def worded(parameter: Parameter, value: float, boat: str) -> float | str:
    """The value as `fleet set` has it."""
    if parameter.name == "FLT_PATTERN":
        return PATTERNS[int(value)]
    return f"{boat}={value!r}" if parameter.name == "FLT_SLOT" else value
