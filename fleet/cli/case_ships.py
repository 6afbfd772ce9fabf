"""What `fleet sim --case` tells of a case with foreign vessels."""

from __future__ import annotations

from typing import Any

from fleet.cli import say


def lines(told: dict[str, Any]) -> list[str]:
    """What a person wants to know of the case."""
    boats = say.count(len(told["boats"]), "boat")
    vessels = [
        (f"vessel {one['vessel']}", f"{one['length_m']:.0f} m", f"{one['speed_mps']:.1f} m/s",
         f"course {one['course_deg']:.0f} deg", one["sensor"])
        for one in told["vessels"]
    ]  # fmt: skip
    rows = [("at s", "boat", "what", "vessel", "range m", "why")]
    for act in told["acts"]:
        what = f"{act['alteration_deg']:+.0f} deg, {act['speed_factor']:g} of the speed" if act["acting"] else "resumes"
        vessel = "-" if act["vessel"] is None else str(act["vessel"])
        away = "-" if act["range_m"] is None else f"{act['range_m']:.0f}"
        rows.append((f"{act['t_s']:.1f}", str(act["boat"]), what, vessel, away, act["reason"]))
    return [
        f"{boats} at {told['cruise_mps']:.2f} m/s, first risk: {told['kind']}, sailed for {told['ended_s']:.1f} s",
        *say.aligned(vessels, indent="  "),
        f"least distance to a domain's core {told['domain']:.2f} of the clearance, hulls {told['hulls_m']:.1f} m apart",
        f"delay {told['delay_median_s']:.1f} s",
        "",
        *say.aligned(rows, right=(0, 1, 3, 4), indent="  "),
    ]
