"""A real agent process that also notes, at every tick, when it came, how late, and the CPU of its thread.

`python -m bench.agent_process RESOLVED ...` takes what `python -m fleet.agent` takes. Everything is the agent's own;
only the clock and `tick` are looked at. On its end it writes `bench.msgpack` into the boat's folder.
"""

from __future__ import annotations

import sys
import threading
import time
from array import array

import msgspec

from fleet.agent import process
from fleet.agent.agent import Agent
from fleet.agent.clock import SystemClock
from fleet.agent.config import AgentConfig
from fleet.agent.journal import set_up

NOTES = "bench.msgpack"
COUNT_EVERY = 10  # ticks between two looks at the message counters


class Notes(msgspec.Struct, array_like=True):
    """What one agent noted."""

    boat: str
    at_ns: list[int]  # monotonic time of each tick
    late_ns: list[int]  # its lateness
    spent_ns: list[int]  # CPU of the loop's thread until then
    counted: list[tuple[int, int, int]]  # (monotonic time, messages heard, messages lost)
    first_tick_cpu_ns: int  # of the whole process, imports and all, when the first tick was over
    first_tick_ns: int  # wall time since the process began


class WatchedClock(SystemClock):
    """Knows which deadline was slept for."""

    deadline_ns = 0

    def sleep_until(self, at_ns: int, wake: threading.Event) -> None:
        """Wait, and remember for what."""
        WatchedClock.deadline_ns = at_ns
        super().sleep_until(at_ns, wake)


class Watch:
    """Stands around one agent's tick."""

    def __init__(self, agent: Agent) -> None:
        self._agent, self._tick = agent, agent.tick
        self.at, self.late, self.spent = array("q"), array("q"), array("q")
        self.counted: list[tuple[int, int, int]] = []
        self.first_cpu_ns = self.first_ns = 0
        agent.tick = self.tick  # type: ignore[method-assign]

    def tick(self, now_ns: int) -> None:
        """Note, then tick."""
        self.spent.append(time.thread_time_ns())
        self.at.append(time.monotonic_ns())
        self.late.append(now_ns - WatchedClock.deadline_ns)
        self._tick(now_ns)
        if not self.first_cpu_ns:
            self.first_cpu_ns = time.process_time_ns()
        if len(self.at) % COUNT_EVERY == 0:
            others = self._agent.picture.others.values()
            heard, lost = sum(other.heard for other in others), sum(other.lost for other in others)
            self.counted.append((time.monotonic_ns(), heard, lost))

    def notes(self) -> Notes:
        """Everything noted."""
        return Notes(
            self._agent.boat,
            list(self.at),
            list(self.late),
            list(self.spent),
            self.counted,
            self.first_cpu_ns,
            self.at[0] if self.at else 0,
        )


def main() -> None:
    """As `fleet.agent.__main__`, watched."""
    config = msgspec.json.decode(sys.argv[1], type=AgentConfig)
    stop = threading.Event()
    process.end_on_signals(stop)
    set_up(config.boat)
    process.end_with_parent(stop)
    process.SystemClock = WatchedClock  # type: ignore[misc]
    watches: list[Watch] = []
    try:
        process.run_agent(config, stop, lambda agent: watches.append(Watch(agent)))
    finally:
        for watch in watches:
            (config.folder() / NOTES).write_bytes(msgspec.msgpack.encode(watch.notes()))


if __name__ == "__main__":
    main()
