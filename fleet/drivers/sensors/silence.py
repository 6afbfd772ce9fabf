"""Does a sensor give what it ought to? In words, when it does not. Pure."""

from __future__ import annotations

from collections.abc import Mapping

from fleet.drivers.sensors.config import NAVIGATION

OLD_NS = 500_000_000  # what the fusion does not use any more
WHAT = {"fix": "no fix", "heading": "no heading", "yaw-rate": "no yaw rate"}


class Silence:
    """What a sensor ought to give is what its configuration says is used of it, else what it has given before."""

    def __init__(self, use: tuple[str, ...], silent_s: float) -> None:
        self._named = frozenset(use) & NAVIGATION
        self._for_traffic = use == ("traffic",)
        self._silent_ns = int(silent_s * 1e9)
        self._given: dict[str, int] = {}
        self._began_ns = 0

    def gave(self, what: str, now_ns: int, stamp_ns: int) -> None:
        """It gave something; what is too old to be used is nothing."""
        if now_ns - stamp_ns < OLD_NS:
            self._given[what] = now_ns

    def trouble(self, now_ns: int, heard_ns: int, port: str, why: Mapping[str, str]) -> str:
        """What is wrong; '' when nothing is.

        Args:
            now_ns: the agent's time
            heard_ns: when anything at all came from it last; 0: never
            port: why its port is not open
            why: by what it ought to give, why there is none, as far as it says
        """
        self._began_ns = self._began_ns or now_ns
        if port:
            return port
        if self._for_traffic:
            return ""  # no vessels, no words
        if now_ns - max(heard_ns, self._began_ns) > self._silent_ns:
            return "silent"
        ought = self._named or frozenset(self._given) or frozenset({"fix"})
        missing = [
            f"{WHAT[what]}: {why[what]}" if why.get(what) else WHAT[what]
            for what in WHAT
            if what in ought and now_ns - self._given.get(what, self._began_ns) > self._silent_ns
        ]
        if not self._given and not self._named and missing:
            return "nothing in it can be used"
        return ", ".join(missing)
