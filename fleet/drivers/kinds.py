"""Drivers by name: those of `fleet`, and those of other packages (entry points `fleet.drivers`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from fleet.drivers.seam import Driver
from fleet.errors import ConfigError
from fleet.plugins import Kinds

BUILT_IN = ("can", "mavlink", "simulated")
Factory = Callable[[str, Mapping[str, Any], Callable[[], int]], Driver]
"""(boat, `[driver.options]`, the agent's clock [ns]) -> driver, not yet open; ConfigError for wrong options."""

OTHERS: Kinds[Factory] = Kinds("fleet.drivers", {})


def wrong_kind(kind: str) -> str:
    """Why there is no such driver; '' when there is."""
    if kind in BUILT_IN or kind in OTHERS:
        return ""
    known = ", ".join(BUILT_IN)
    return OTHERS.why(kind) or f"expected one of {known}, or a driver that an installed package adds"


def made_by_others(kind: str, boat: str, options: Mapping[str, Any], now_ns: Callable[[], int]) -> Driver:
    """The driver of another package; ConfigError where it cannot be made."""
    try:
        return OTHERS[kind](boat, options, now_ns)
    except (TypeError, ValueError, KeyError, OSError) as error:
        raise ConfigError(f"driver.kind {kind!r}: {type(error).__name__}: {error}") from error
