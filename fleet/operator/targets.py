"""The fleet as AIS targets, for plotters: which sentences are due. Time is handed in; nothing is sent from here."""

from __future__ import annotations

import math
from collections.abc import Mapping

from fleet.drivers.ais.codec import position_report, static_report
from fleet.drivers.ais.mmsi import mmsis
from fleet.operator.view import BoatView
from fleet.wire.messages import BoatState

STATIC_S = 30.0  # name and size; a plotter that is switched on later knows them soon
STALE_S = 10.0  # a boat not heard for so long is no target any more, and the plotter marks it as lost
ACCURATE_M = 4.0  # 1 sigma below which the accuracy bit (better than 10 m) is set
BEAM = 0.45  # of the length: a small catamaran's


class Targets:
    """Remembers what was said of which boat when."""

    def __init__(self, interval_s: float = 2.0, given: Mapping[str, int] | None = None) -> None:
        self._interval_s, self._given = interval_s, dict(given or {})
        self._said: dict[str, float] = {}
        self._told: dict[str, float] = {}
        self.mmsis: dict[str, int] = {}

    def due(self, views: Mapping[str, BoatView], now_s: float) -> list[bytes]:
        """The sentences to be sent now.

        Args:
            views: the fleet as it was last heard
            now_s: a time that only grows [s]
        """
        if not self.mmsis.keys() >= views.keys():
            self.mmsis = mmsis({*views, *self.mmsis}, {**self._given, **self.mmsis})
        lines: list[bytes] = []
        for name in sorted(views):
            state = views[name].state
            if state is None or views[name].age_s() > STALE_S:
                continue
            mmsi = self.mmsis[name]
            if now_s - self._told.get(name, -math.inf) >= STATIC_S:
                self._told[name] = now_s
                lines += static_report(mmsi, called(state), state.length_m, BEAM * state.length_m)
            if now_s - self._said.get(name, -math.inf) >= self._interval_s:
                self._said[name] = now_s
                lines += _report(mmsi, state)
        return lines


def called(state: BoatState) -> str:
    """The name that a plotter shows; a simulated boat says so."""
    return f"SIM {state.boat}" if state.simulated else state.boat


def _report(mmsi: int, state: BoatState) -> list[bytes]:
    return position_report(
        mmsi,
        state.lat_deg,
        state.lon_deg,
        state.sog_mps * math.cos(state.cog_rad),
        state.sog_mps * math.sin(state.cog_rad),
        state.heading_rad,
        accurate=state.position_error_m <= ACCURATE_M,
        second=state.stamp_ns // 1_000_000_000,
    )
