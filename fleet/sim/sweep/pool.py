"""Processes on this machine that sail parts; one that is killed costs its part some time, and nothing else."""

from __future__ import annotations

import contextlib
import os
import selectors
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import msgspec
from msgspec import Struct

from fleet.errors import FleetError
from fleet.sim.sweep.parts import Part
from fleet.sim.sweep.worker import DONE, HEAD, READY, Work

TRIES = 3
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
END_S = 5.0


class Sailed(Struct, frozen=True):
    """What became of a part."""

    part: Part
    content: bytes | None
    """Its results, packed; None: given up."""
    why: str = ""


class Engine(Protocol):
    """Sails parts, somewhere, in any order; closing the iterator ends all that it started."""

    def __call__(self, text: str, seed: int, parts: Sequence[Part]) -> Iterator[Sailed]: ...


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def local(jobs: int, started: Callable[[int], None] = lambda pid: None) -> Engine:
    """An engine of so many processes; `started` is told the id of each."""

    def engine(text: str, seed: int, parts: Sequence[Part]) -> Iterator[Sailed]:
        with _workers(text, seed, min(jobs, len(parts)), started) as workers:
            yield from workers.sail(parts)

    return engine


class _Worker:
    """One process, and what it is about."""

    def __init__(self, work: Work) -> None:
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  a pipe that nobody reads would fill up
        self.process = subprocess.Popen(
            [sys.executable, "-m", "fleet.sim.sweep.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            env={**os.environ, **ONE_THREAD},
            start_new_session=True,  # Ctrl-C at the terminal reaches the owner alone
        )
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.asked, self.answers = self.process.stdin, self.process.stdout
        os.set_blocking(self.answers.fileno(), False)
        self.part: Part | None = None
        self.ready = False
        self._heard = bytearray()
        self._tell(work)

    def _tell(self, what: Struct) -> None:
        with contextlib.suppress(OSError):  # its end shows as the end of its answers
            self.asked.write(msgspec.json.encode(what) + b"\n")
            self.asked.flush()

    def ask(self, part: Part) -> None:
        """Have it sail a part."""
        self.part = part
        self._tell(part)

    def hear(self) -> list[tuple[int, bytes]] | None:
        """Its whole answers so far; None: it has ended."""
        try:
            more = os.read(self.answers.fileno(), 1 << 20)
        except BlockingIOError:
            return []
        if not more:
            return None
        self._heard += more
        answers = []
        while len(self._heard) >= HEAD.size:
            kind, size = HEAD.unpack_from(self._heard)
            if len(self._heard) < HEAD.size + size:
                break
            answers.append((kind, bytes(self._heard[HEAD.size : HEAD.size + size])))
            del self._heard[: HEAD.size + size]
        return answers

    def end(self) -> str:
        """End it now; how it ended and the last line it wrote."""
        with contextlib.suppress(OSError):
            self.asked.close()
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.answers.close()
        with self._said as said:
            said.seek(0)
            last = said.read().decode(errors="replace").strip().splitlines()[-1:]
        code = self.process.returncode
        how = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
        return ": ".join([f"process {self.process.pid} ended, {how}", *last])


class _Workers:
    """All of them."""

    def __init__(self, work: Work, jobs: int, started: Callable[[int], None]) -> None:
        self._work, self._jobs, self._started = work, jobs, started
        self._selector = selectors.DefaultSelector()
        self.all: list[_Worker] = []
        self._never_ready = 0

    def start(self) -> None:
        """One more."""
        worker = _Worker(self._work)
        self.all.append(worker)
        self._selector.register(worker.answers, selectors.EVENT_READ, worker)
        self._started(worker.process.pid)

    def sail(self, parts: Sequence[Part]) -> Iterator[Sailed]:
        """The parts as they end."""
        left, tries = deque(parts), dict.fromkeys(parts, 0)
        open_parts = len(parts)
        while open_parts:
            while len(self.all) < min(self._jobs, open_parts):
                self.start()
            for worker in self.all:
                if worker.ready and worker.part is None and left:
                    part = left.popleft()
                    tries[part] += 1
                    worker.ask(part)
            for key, _ in self._selector.select():
                for sailed in self._heard(key.data, left, tries):
                    open_parts -= 1
                    yield sailed

    def _heard(self, worker: _Worker, left: deque[Part], tries: dict[Part, int]) -> list[Sailed]:
        """What one of them answered, or that it ended."""
        answers = worker.hear()
        if answers is None:
            return self._lost(worker, left, tries)
        ended = []
        for kind, content in answers:
            if kind == READY:
                worker.ready, self._never_ready = True, 0
                continue
            part, worker.part = worker.part, None
            assert part is not None
            ended.append(Sailed(part, content) if kind == DONE else Sailed(part, None, content.decode()))
        return ended

    def _lost(self, worker: _Worker, left: deque[Part], tries: dict[Part, int]) -> list[Sailed]:
        """A process has ended: its part is first in the queue again, or given up after the third time."""
        self._selector.unregister(worker.answers)
        self.all.remove(worker)
        why = worker.end()
        if not worker.ready:
            self._never_ready += 1
            if self._never_ready >= TRIES:
                raise FleetError(f"no process that sails can be started: {why}")
        if worker.part is None:
            return []
        if tries[worker.part] < TRIES:
            left.appendleft(worker.part)
            return []
        return [Sailed(worker.part, None, f"{why}, for the {TRIES}rd time")]

    def close(self) -> None:
        """End all."""
        for worker in self.all:
            with contextlib.suppress(OSError):
                worker.asked.close()
        for worker in self.all:
            worker.end()
        self._selector.close()


@contextmanager
def _workers(text: str, seed: int, jobs: int, started: Callable[[int], None]) -> Iterator[_Workers]:
    workers = _Workers(Work(text, seed), jobs, started)
    try:
        yield workers
    finally:
        workers.close()
