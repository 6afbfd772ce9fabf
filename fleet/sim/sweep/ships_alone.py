"""One case with foreign vessels sailed alone: what it did, and why it failed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from msgspec import Struct, structs

from fleet.avoidance.foreign import Kind, Reason
from fleet.sim.batch.ships import Decided, ShipCase, Voyage
from fleet.sim.batch.ships_judge import judge
from fleet.sim.batch.ships_results import Outcome
from fleet.sim.batch.ships_sail import sail
from fleet.sim.sweep.family import Family, case_name
from fleet.sim.sweep.ships_results import ShipResults, figures, gathered, reasons

MOST_DRAWN = 2


class SailedShips(Struct, frozen=True):
    """One case, its truth, and what it is judged to be."""

    case: ShipCase
    voyage: Voyage
    outcome: Outcome
    results: ShipResults


def sail_ship_case(family: Family, seed: int, point: int, case: int) -> SailedShips:
    """One case; the same as in its sweep."""
    (one,) = family.ships(seed, point, [case])
    voyage = sail(one)
    outcome = judge(one, voyage)
    results = gathered(family.name, seed, family.spec(point), [outcome], voyage.x.size, 0.0)
    return SailedShips(one, voyage, outcome, results)


def drawn(family: Family, seed: int, point: int, case: int, why: str) -> Any:
    """The picture of a case for the page of its sweep."""
    from fleet.sim.sweep.ships_pictures import tracks

    one = sail_ship_case(family, seed, point, case)
    label = f", {family.points[point].label}" if family.points[point].label else ""
    told = "; ".join(reasons(one.results)) or why
    return tracks(one.case, one.voyage, f"{case_name(family, seed, point, case)}{label}: {told}")


def chosen_cases(there: Sequence[tuple[int, ShipResults]]) -> list[tuple[int, int, str]]:
    """(point, case, why) of those that are drawn: least domain, and the first ones with a contact or a wrong side."""
    point, worst = min(there, key=lambda one: float(one[1].values["dom"].min()))
    chosen = {(point, int(worst.case[worst.values["dom"].argmin()])): "least of the domain left"}
    for what in ("contact", "wrong side"):
        rows = [
            (number, int(one.case[k]))
            for number, one in there
            for k in range(len(one.case))
            if (one.values["contact"][k] > 0.5 if what == "contact" else one.values["side"][k] == 0.0)
        ]
        for key in [one for one in rows if one not in chosen][:MOST_DRAWN]:
            chosen[key] = what
    return [(number, case, why) for (number, case), why in chosen.items()]


def told(family: Family, seed: int, point: int, one: SailedShips) -> dict[str, Any]:
    """Everything about one case, for `--json` and the table."""
    outcome, case = one.outcome, one.case
    why = reasons(one.results)
    return {
        "case": f"{family.name}:{case_name(family, seed, point, case.case)}",
        "method": one.results.method,
        **figures([one.results]),
        "kind": Kind(outcome.kind).name.lower().replace("_", " "),
        "began_inside": outcome.inside,
        "domain": outcome.dom,
        "hulls_m": outcome.hull_m,
        "ended_s": outcome.ended_s,
        "boats": [{"boat": i + 1, "north_m": x, "east_m": y} for i, (x, y, _) in enumerate(case.paths)],
        "cruise_mps": case.cruise,
        "vessels": [
            {
                "vessel": k + 1,
                "length_m": ship.length,
                "speed_mps": ship.U,
                "course_deg": math.degrees(ship.chi) % 360.0,
                "sensor": ship.sensor,
                "turns_at_s": ship.turns_s if math.isfinite(ship.turns_s) else None,
                "turn_deg": math.degrees(ship.turn),
            }
            for k, ship in enumerate(case.ships)
        ],
        "acts": [_said(decided) for decided in one.voyage.decisions],
        "failed": bool(why),
        "why": why,
    }


def _said(decided: Decided) -> dict[str, Any]:
    """A decision in words and degrees."""
    action = {
        "acting": decided.acting > 0.5,
        "alteration_deg": round(math.degrees(decided.a), 3),
        "speed_factor": decided.factor,
        "vessel": int(decided.target) + 1 if decided.target >= 0.0 else None,
        "range_m": decided.range_m if math.isfinite(decided.range_m) else None,
    }
    reason = Reason(int(decided.reason)).name.lower().replace("_", " ")
    return {"t_s": round(decided.t, 1), "boat": decided.boat + 1, "reason": reason, **action}


def trace(one: SailedShips) -> dict[str, Any]:
    """Arrays of the voyage by name, for a file."""
    kept = structs.asdict(one.voyage)
    return {name: kept[name] for name in ("t", "x", "y", "psi", "u", "ship_x", "ship_y", "ship_chi")}


def glance(summary: dict[str, Any]) -> list[tuple[str, str, str, bool | None]]:
    """The main figures of a sweep: what, value, meaning, good or not."""

    def share(name: str) -> str:
        return "-" if summary[name] is None else f"{100.0 * summary[name]:.1f} %"

    contacts = int(summary["contacts"])
    content: list[tuple[str, str, str, bool | None]] = [
        ("cases", str(summary["cases"]), f"{summary['at_risk']} of them at risk", None),
        ("contacts", str(contacts), "cases in which a boat touched a vessel", contacts == 0),
        ("domain", share("domain_kept"), "of the cases kept it whole", None),
        ("right side", share("side_right"), "of the cases that have one", None),
        ("rules", share("rule_right"), "side, time and size of the action right", None),
        ("delay", f"{summary['delay_p95_s']:.0f} s", "95 % of the cases are below", None),
    ]
    judged = [one for tables in summary["points"] for one in tables["checks"]]
    held = sum(bool(one["ok"]) for one in judged)
    if judged:
        content.insert(0, ("checks", f"{held} of {len(judged)}", "hold, all points together", held == len(judged)))
    return content
