"""The control loop: absolute deadlines, late ticks skipped and counted, the driver neutral whichever way it ends."""

from __future__ import annotations

import gc
import logging
import threading
from collections.abc import Callable

from fleet.agent.agent import Agent
from fleet.agent.clock import Clock
from fleet.wire.radio import number_of

log = logging.getLogger("fleet.agent")
LATENESS_KEPT = 4096
ANSWER_TICKS = 2  # after the stop is asked for, to tell the others


def run(
    agent: Agent,
    clock: Clock,
    stop: threading.Event,
    *,
    slots: int = 4,
    after_tick: Callable[[int], None] = lambda now_ns: None,
) -> list[float]:
    """Tick until `stop` is set; returns how late the last ticks were [ms].

    Args:
        agent: the boat
        clock: the time it lives by
        stop: ends the loop
        slots: publication times in one period; boats take them by their number in the roster, so that messages meet
            in the router and wake a receiver once
        after_tick: called after every whole tick with its time; a watchdog is fed here
    """
    period_ns = int(agent.period_s * 1e9)
    lateness: list[float] = []
    gc.collect()
    gc.freeze()
    by_name = number_of(agent.boat)  # a fleet in standby does not wake all at once
    phase_ns = 0
    deadline_ns = _next(clock.now_ns(), period_ns, phase_ns)
    try:
        while not stop.is_set():
            clock.sleep_until(deadline_ns, stop)
            now_ns = clock.now_ns()
            late_ns = now_ns - deadline_ns
            agent.tick(now_ns)
            after_tick(now_ns)
            if len(lateness) < LATENESS_KEPT:
                lateness.append(late_ns * 1e-6)
            sailing = agent.orders.sailing
            phase_ns = (sailing.number if sailing is not None else by_name) % slots * period_ns // slots
            deadline_ns = _next(deadline_ns, period_ns, phase_ns)
            now_ns = clock.now_ns()
            if now_ns > deadline_ns + period_ns:
                missed = (now_ns - deadline_ns) // period_ns
                agent.reporter.late(missed, late_ns * 1e-6)
                deadline_ns = _next(now_ns, period_ns, phase_ns)
            elif late_ns > 0:
                agent.reporter.late(0, late_ns * 1e-6)
    finally:
        agent.driver.neutral()
    return lateness


def _next(after_ns: int, period_ns: int, phase_ns: int) -> int:
    """The next deadline of the common grid."""
    return (after_ns - phase_ns) // period_ns * period_ns + period_ns + phase_ns
