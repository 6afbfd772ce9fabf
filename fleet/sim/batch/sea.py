"""A sea of scenarios, tick by tick: what many on arrays (`lanes`) and one on floats (`lone`) share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec import Struct

from fleet import ops
from fleet.ops import FloatArray
from fleet.sim.batch import tally
from fleet.sim.batch.block import Block, Rules, decide, sail
from fleet.sim.batch.hearing import TICK_S
from fleet.sim.batch.mail import Mail
from fleet.sim.batch.scenarios import IntArray, Scenarios
from fleet.sim.batch.tally import Apart, Tally

SHOWN = tuple(name for name in Tally.__struct_fields__ if name not in ("marks", "ways"))
WATER = ("current_n", "current_e", "wind_n", "wind_e")
TRACED = ("x", "y", "psi", "u", "s", "e", "y_e", "u_d", "r_d", "mode", "avoiding")


class Counted(Struct, frozen=True):
    """What has been counted; arrays are (B, K), those of pairs (B,)."""

    boats: dict[str, FloatArray]  # fields of Tally
    least_sq: FloatArray
    inside: FloatArray


def traced(block: Block[Any]) -> tuple[Any, ...]:
    """What a trace keeps of a block's lanes, in the order of `TRACED`."""
    d, hull = block.decision, block.hull
    assert d is not None
    return (hull.x, hull.y, hull.psi, hull.u, d.s, d.e, d.y_e, d.u_d, d.r_d, d.mode, d.avoiding)


class Sea(ABC):
    """What both kinds share."""

    blocks: list[Block[Any]]
    tallies: list[Tally[Any]]
    pairs: list[Apart[Any]]
    mail: Mail

    def __init__(self, scenarios: Scenarios, rules: Rules) -> None:
        self.scenarios, self.rules = scenarios, rules
        self._formed = rules.formations > 0 or scenarios.winged
        self._ticks = [np.ceil(change.at_s / TICK_S - 1e-6) for change in scenarios.changes]
        self._due = {int(t) for ticks in self._ticks for t in ticks if np.isfinite(t)}
        self.watch: Callable[[int], None] | None = None  # told of every tick when decided, before the hulls move

    def tick(self, now: int) -> None:
        """Orders, messages, decisions, hulls; then everything is counted."""
        if now in self._due:
            self._order(now)
        told = self.mail.deliver(now)
        clean = self.mail.clean
        self.mail.post(
            now,
            [decide(block, held, now, clean, self.rules) for block, held in zip(self.blocks, told, strict=True)],
        )
        errors = self._errors() if self._formed else [None] * len(self.blocks)
        for k, (block, e) in enumerate(zip(self.blocks, errors, strict=True)):
            assert block.decision is not None
            self.tallies[k] = tally.count(self.tallies[k], block.decision, e, float(now))
        if self.watch is not None:
            self.watch(now)
        for block in self.blocks:
            sail(block, self.rules)
        radius_m = self.rules.radius_m
        self.pairs = [tally.part(a, dx, dy, radius_m) for a, (dx, dy) in zip(self.pairs, self._ranges(), strict=True)]

    def check(self) -> None:
        """Every 5 s: who stands still."""
        self.tallies = [
            tally.check(t, block.decision, block.order, block.hull.x, block.hull.y)
            for t, block in zip(self.tallies, self.blocks, strict=True)
            if block.decision is not None
        ]

    def _apart(self) -> list[Apart[Any]]:
        """The pairs at the start."""
        return [Apart(dx, dy, dx * dx + dy * dy, ops.zero(dx)) for dx, dy in self._ranges()]

    @property
    @abstractmethod
    def rows(self) -> IntArray:
        """Numbers of the scenarios that are still sailed."""

    @abstractmethod
    def seen(self) -> FloatArray:
        """What a trace keeps of this tick: (field of `TRACED`, boat, scenario)."""

    @abstractmethod
    def counted(self) -> Counted:
        """What has been counted so far."""

    @abstractmethod
    def keep(self, columns: IntArray) -> None:
        """Go on with some of the scenarios only."""

    @abstractmethod
    def _order(self, now: int) -> None:
        """Put the changes of this tick into force."""

    @abstractmethod
    def _ranges(self) -> list[tuple[Any, Any]]:
        """(dx, dy) of the pairs, from the lower to the higher number [m]."""

    @abstractmethod
    def _errors(self) -> list[Any]:
        """True formation errors, one for each block [m]."""
