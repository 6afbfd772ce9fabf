"""What came of meeting foreign vessels, one scenario and a suite of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from msgspec import Struct


class Outcome(Struct, frozen=True, kw_only=True):
    """One scenario, judged."""

    case: int
    kind: int  # Kind of the first vessel at risk, 0 none
    risk: bool  # straight on, some domain would have been entered
    contact: bool  # hulls touched
    hull_m: float  # least distance of hulls
    inside: bool  # it began within 1.2 C0 of a core: nothing of the domain is asked of it
    dom: float  # least distance to a core, as a share of C0; inf without a vessel
    side: float  # 1 every head-on and crossing vessel from starboard was left to port, 0 not, NaN none to judge
    stand_on_port: bool  # rule 17 c: as the stand-on boat it turned to port for a vessel to port
    first_range_m: float  # at the first action, NaN none
    lead_s: float  # from the first action to the entry it prevents, NaN none
    early: float  # 1 the first action was in time for its role, 0 not, NaN none
    substantial: float  # 1 the track shows it: 25 deg or 30 % of the speed within 15 s, 0 not, NaN none
    first: int  # 0 none, 1 starboard, -1 port, 2 only speed
    decisions: int  # alterations begun or changed, of all boats that decide
    reversals: int
    retriggers: int
    delay_s: float  # of the first boat
    deviation_m: float
    closest_m: float  # of two boats, inf for one
    alone: int  # followers' decisions of their own
    bank_m: float  # least distance to an edge, inf without
    complete: bool
    ended_s: float

    @property
    def rule_right(self) -> float:
        """1 what the rules ask is done: side, in time, to be seen, no closed turn to port; 0 not; NaN none asked."""
        asked = [each for each in (self.side, self.early, self.substantial) if not math.isnan(each)]
        return float(all(asked) and not self.stand_on_port) if asked else math.nan


class Summary(Struct, kw_only=True):
    """A suite."""

    suite: str
    outcomes: list[Outcome]
    cpu_s: float = 0.0

    def share(self, condition: Iterable[bool]) -> float:
        """Per cent of the scenarios."""
        return 100.0 * sum(condition) / max(len(self.outcomes), 1)

    def figures(self) -> dict[str, Any]:
        """The row of a table."""
        o = self.outcomes
        outside = [each for each in o if not each.inside]
        risk = [each for each in outside if each.risk]
        acted = [each for each in o if each.first != 0]
        sides = [each.side for each in o if not math.isnan(each.side)]
        timely = [each.early for each in o if not math.isnan(each.early)]
        plain = [each.substantial for each in o if not math.isnan(each.substantial)]
        right = [each.rule_right for each in o if not math.isnan(each.rule_right)]
        return {
            "suite": self.suite,
            "n": len(o),
            "at_risk": len(risk),
            "contact": sum(each.contact for each in o),
            "began inside": len(o) - len(outside),
            "dom<1 %": _share([each.dom < 1.0 for each in outside]),
            "dom<0.8 %": _share([each.dom < 0.8 for each in outside]),
            "dom 5/50 %": _percentiles([each.dom for each in risk], (5, 50)),
            "side ok %": _share(sides),
            "judged": len(sides),
            "stand-on port %": _share([each.stand_on_port for each in o]),
            "range 5/50/95 m": _percentiles([each.first_range_m for each in acted], (5, 50, 95)),
            "lead 5/50/95 s": _percentiles([each.lead_s for each in acted], (5, 50, 95)),
            "in time %": _share(timely),
            "substantial %": _share(plain),
            "rules right %": _share(right),
            "decisions": float(np.mean([each.decisions for each in acted])) if acted else 0.0,
            "reversal %": _share([each.reversals > 0 for each in o]),
            "re-trigger %": _share([each.retriggers > 0 for each in o]),
            "delay 50/95 s": _percentiles([each.delay_s for each in o], (50, 95)),
            "deviation 95 m": _percentiles([each.deviation_m for each in o], (95,)),
            "starboard/port/speed": tuple(sum(each.first == k for each in o) for k in (1, -1, 2)),
            "closest boats m": min((each.closest_m for each in o), default=math.inf),
            "boats < 6 m %": _share([each.closest_m < 6.0 for each in o]),
            "decided alone %": _share([each.alone > 0 for each in o]),
            "bank m": min((each.bank_m for each in o), default=math.inf),
            "unfinished": sum(not each.complete for each in o),
            "failed": [each.case for each in o if each.contact or (each.dom < 0.8 and not each.inside)],
            "cpu s a run": self.cpu_s / max(len(o), 1),
        }


def _share(values: Sequence[float] | Sequence[bool]) -> float:
    """Mean as per cent, NaN of nothing."""
    return 100.0 * float(np.mean([float(v) for v in values])) if values else math.nan


def _percentiles(values: Sequence[float], which: tuple[int, ...]) -> tuple[float, ...]:
    """Rounded to two places; NaN of nothing."""
    known = [v for v in values if math.isfinite(v)]
    return tuple(round(float(np.percentile(known, q)), 2) if known else math.nan for q in which)
