"""Time: handed in everywhere, so that a simulation may run it faster, or in lock-step."""

from __future__ import annotations

import threading
import time
from typing import Annotated, Protocol

from msgspec import Meta, Struct

TIME_ERROR = 5  # of adjtimex(2): the clock is not synchronised
UNDISCIPLINED_NS = 10_000_000_000


class Clock(Protocol):
    """The time that a process lives by."""

    def now_ns(self) -> int:
        """UTC as this station has it [ns]."""

    def sleep_until(self, at_ns: int, wake: threading.Event) -> None:
        """Wait for that time, or until `wake` is set."""


class ClockSpec(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A clock that all processes of one machine share: `warp` times faster, equal to `utc_ns` at `monotonic_ns`."""

    warp: Annotated[float, Meta(gt=0.0, le=1000.0)] = 1.0
    utc_ns: int = 0
    monotonic_ns: int = 0


class SystemClock:
    """The machine's clock; steps of its wall time do not move deadlines."""

    def __init__(self, spec: ClockSpec | None = None) -> None:
        if spec is None or spec.utc_ns == 0:
            self._utc, self._monotonic, self._warp = time.time_ns(), time.monotonic_ns(), 1.0
        else:
            self._utc, self._monotonic, self._warp = spec.utc_ns, spec.monotonic_ns, spec.warp

    def now_ns(self) -> int:
        """UTC as this station has it [ns]."""
        passed = time.monotonic_ns() - self._monotonic
        return self._utc + (passed if self._warp == 1.0 else int(passed * self._warp))

    def error_ns(self) -> int:
        """How wrong this clock may be: the kernel's bound, and what its wall time was moved since the start."""
        return kernel_error_ns() + abs(time.time_ns() - self.now_ns())

    def sleep_until(self, at_ns: int, wake: threading.Event) -> None:
        """Wait for that time, or until `wake` is set."""
        left = (at_ns - self.now_ns()) * 1e-9 / self._warp
        if left > 0.0:
            wake.wait(left) if left > 0.5 else time.sleep(left)


def kernel_error_ns() -> int:
    """The bound that NTP, PTP or GNSS keep on the machine's clock; 10 s when nothing disciplines it."""
    import ctypes

    words = (ctypes.c_long * 64)()  # struct timex: modes, offset, freq, maxerror, esterror, status, ...
    try:
        state = ctypes.CDLL(None, use_errno=True).adjtimex(ctypes.byref(words))
    except (OSError, AttributeError):
        return UNDISCIPLINED_NS
    if state < 0 or state == TIME_ERROR:
        return UNDISCIPLINED_NS
    return int(words[3]) * 1000


def warped(warp: float) -> ClockSpec:
    """A clock that starts now and runs `warp` times faster."""
    return ClockSpec(warp=warp, utc_ns=time.time_ns(), monotonic_ns=time.monotonic_ns())
