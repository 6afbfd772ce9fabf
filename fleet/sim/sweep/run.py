"""A sweep from its first part, or from where it was interrupted, to the last."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable

from msgspec import Struct

from fleet.errors import UsageError
from fleet.sim.sweep.parts import laws_digest, unpack
from fleet.sim.sweep.pool import Engine, Sailed
from fleet.sim.sweep.store import Store


class Progress(Struct):
    """How far a sweep is."""

    cases: int
    total: int
    failures: int
    before: int
    """Cases that were there already."""
    began: float
    """On the monotonic clock [s]."""
    latest: float
    """When the latest part came [s]."""

    @property
    def left_s(self) -> float | None:
        """Estimated time to the end; None before the first part has come [s]."""
        new = self.cases - self.before
        if not new:
            return None
        ends = self.latest + (self.latest - self.began) * (self.total - self.cases) / new
        return max(0.0, ends - time.monotonic())


class Ended(Struct):
    """What this process did about a sweep."""

    lost: list[Sailed]
    """Parts given up."""
    damaged: list[str]
    """Files of parts that could not be read, and were sailed again."""
    boat_ticks: int
    wall_s: float


def sail(store: Store, engine: Engine, look: Callable[[Progress], None] = lambda progress: None) -> Ended:
    """Sail all parts that are not there yet; every one that ends is kept at once.

    Raises:
        UsageError: the laws are not those of the parts that are there, or another process sails this sweep
        RecordingError: a part cannot be written; the others stay
        KeyboardInterrupt: so do they
    """
    sweep = store.sweep
    if sweep.laws != laws_digest() and store.missing()[0]:
        raise UsageError(
            f"{store.folder}: sailed with other laws, {sweep.laws} of fleet {sweep.version}, and these are "
            f"{laws_digest()}: expected the same ones; start a new sweep and compare the two"
        )
    with store.alone():
        missing, damaged = store.missing()
        there = [results for results in store.results(set(sweep.parts) - set(missing)) if results is not None]
        before = sum(len(one.case) for one in there)
        now = time.monotonic()
        progress = Progress(before, sweep.total, sum(len(one.failed) for one in there), before, now, now)
        ended = Ended([], damaged, 0, 0.0)
        look(progress)
        if missing:
            with contextlib.closing(engine(sweep.text, sweep.seed, missing)) as sailing:  # type: ignore[type-var]
                for sailed in sailing:
                    _take(store, sailed, progress, ended)
                    look(progress)
        ended.wall_s = time.monotonic() - progress.began
    return ended


def _take(store: Store, sailed: Sailed, progress: Progress, ended: Ended) -> None:
    """One part more, kept or given up."""
    if sailed.content is None:
        ended.lost.append(sailed)
        return
    results = unpack(sailed.content, str(sailed.part))
    store.keep(sailed.part, sailed.content)
    ended.boat_ticks += results.boat_ticks
    progress.cases += len(results.case)
    progress.failures += len(results.failed)
    progress.latest = time.monotonic()
