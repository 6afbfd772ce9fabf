"""What the kernel knows of a process: CPU of every thread, memory."""

from __future__ import annotations

import os
from pathlib import Path

from msgspec import Struct

TICK_NS = 1_000_000_000 // os.sysconf("SC_CLK_TCK")


class Threads(Struct, frozen=True):
    """CPU of a process since it began, by kind of thread [ns]."""

    loop: int  # the main thread: the control loop
    zenoh: int
    others: int  # recorder, store, parent

    def since(self, before: Threads) -> Threads:
        """What was spent between two looks."""
        return Threads(self.loop - before.loop, self.zenoh - before.zenoh, self.others - before.others)

    @property
    def all(self) -> int:
        """All threads."""
        return self.loop + self.zenoh + self.others


def _thread_ns(task: Path) -> int:
    try:
        return int((task / "schedstat").read_text().split()[0])
    except (OSError, IndexError):
        fields = (task / "stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) * TICK_NS


ZENOH = ("rx-", "tx-", "net-", "app-", "acc-", "tokio", "zenoh", "async")


def threads(pid: int) -> Threads:
    """CPU of its threads now; those that end in the meantime are left out."""
    spent = {"loop": 0, "zenoh": 0, "others": 0}
    for task in Path(f"/proc/{pid}/task").iterdir():
        try:
            name = (task / "comm").read_text().strip()
            kind = "loop" if task.name == str(pid) else ("zenoh" if name.startswith(ZENOH) else "others")
            spent[kind] += _thread_ns(task)
        except OSError:
            continue
    return Threads(**spent)


def thread_names(pid: int) -> list[str]:
    """Names of its threads."""
    return sorted((task / "comm").read_text().strip() for task in Path(f"/proc/{pid}/task").iterdir())


def memory_mib(pid: int) -> tuple[float, float]:
    """(resident, proportional share) [MiB]."""
    found = {}
    for text in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
        key, _, rest = text.partition(":")
        if key in ("Rss", "Pss"):
            found[key] = int(rest.split()[0]) / 1024.0
    return found["Rss"], found["Pss"]


def machine_ns() -> int:
    """CPU that all processes of this machine have used [ns]: no idle, no waiting, no time stolen by other machines."""
    fields = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0].split()
    user, nice, system, _, _, irq, softirq = map(int, fields[1:8])
    return (user + nice + system + irq + softirq) * TICK_NS
