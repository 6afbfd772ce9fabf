"""Which ground station commands the fleet, of those that talk to one bridge: they never take turns."""

from __future__ import annotations

Peer = tuple[int, tuple[str, int] | None]
"""Where a ground station is: the endpoint, and at one where we listen whoever spoke."""
Station = tuple[Peer, int]
"""A ground station: where it is, and its system id."""
GONE_S = 10.0  # a ground station that said nothing for so long has left
MOST = 32  # ground stations remembered


class Seat:
    """Held by the first that commands, until it falls silent or another takes it by FLT_CONTROL."""

    def __init__(self) -> None:
        self.holder: Station | None = None
        self._heard_s: dict[Station, float] = {}

    def heard(self, station: Station, now_s: float) -> None:
        """A ground station said something."""
        self._heard_s.pop(station, None)
        while len(self._heard_s) >= MOST:
            del self._heard_s[next(iter(self._heard_s))]
        self._heard_s[station] = now_s

    def refusal(self, station: Station, now_s: float) -> str:
        """Why a ground station may not command; '' when it may, and then it has the seat."""
        held = self.holder is not None and now_s - self._heard_s.get(self.holder, -1e9) < GONE_S
        if held and station != self.holder:
            return "another ground station commands; FLT_CONTROL 1 takes over"
        self.holder = station
        return ""

    def take(self, station: Station) -> None:
        """By its operator's word."""
        self.holder = station
