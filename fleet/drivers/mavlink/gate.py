"""A value that no boat can have is not believed, unless it is said again and again."""

from __future__ import annotations

import math

NS = 1e-9


class Gate:
    """Lets through what agrees with the value before, or with `agree - 1` refused ones in a row.

    A frame with wrong bytes and a right checksum comes once in 65,536 wrong frames; a boat that was carried elsewhere,
    or whose estimator was set anew, says so in every message.
    """

    def __init__(self, slack: float, per_s: float, agree: int = 5) -> None:
        """Args: slack: how far a value may lie from the one before; per_s: how much farther for each second between."""
        self._slack, self._per_s, self._agree = slack, per_s, agree
        self._last: tuple[float, ...] = ()
        self._last_ns = 0
        self._odd: tuple[float, ...] = ()
        self._odd_ns = self._times = 0

    def passes(self, value: tuple[float, ...], now_ns: int) -> bool:
        """Whether it is believed."""
        if self._near(value, self._last, now_ns - self._last_ns):
            self._last, self._last_ns, self._times = value, now_ns, 0
            return True
        again = self._times > 0 and self._near(value, self._odd, now_ns - self._odd_ns)
        self._times = self._times + 1 if again else 1
        self._odd, self._odd_ns = value, now_ns
        if self._times < self._agree:
            return False
        self._last, self._last_ns, self._times = value, now_ns, 0
        return True

    def _near(self, a: tuple[float, ...], b: tuple[float, ...], apart_ns: int) -> bool:
        return bool(b) and math.dist(a, b) <= self._slack + self._per_s * max(apart_ns, 0) * NS

    def forget(self) -> None:
        """What comes next begins anew."""
        self._last, self._times = (), 0
