"""Processes that sail parts: killed, they cost time and nothing else."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator

import psutil
import pytest

from fleet.errors import FleetError
from fleet.sim.sweep.family import loads
from fleet.sim.sweep.parts import sail, unpack
from fleet.sim.sweep.pool import local
from tests.sim.sweep.brief import BRIEF, GRID, SEED, same_bits, sweep

SAILING_S = 1.2  # of processor time: a worker that has used so much has long been told its part


@pytest.fixture(autouse=True)
def nobody_left() -> Iterator[None]:
    """No process stays behind."""
    yield
    assert [p for p in psutil.Process().children() if "worker" in " ".join(p.cmdline())] == []


def test_two_processes_sail_every_part_with_the_bits_that_this_one_would() -> None:
    what = sweep(GRID)
    sailed = list(local(2)(what.text, SEED, what.parts))
    assert sorted(one.part for one in sailed) == list(what.parts)
    for one in sailed:
        assert one.content is not None
        assert same_bits(unpack(one.content), sail(loads(GRID), SEED, one.part))


def test_the_part_of_a_killed_process_is_sailed_by_a_new_one() -> None:
    what, pids = sweep(GRID), []
    sailing = local(1, pids.append)(what.text, SEED, what.parts[:2])
    first = next(sailing)
    os.kill(pids[0], signal.SIGKILL)
    (second,) = sailing
    assert [first.part, second.part] == list(what.parts[:2])
    assert second.content is not None
    assert same_bits(unpack(second.content), sail(loads(GRID), SEED, second.part))
    assert len(pids) == 2


def test_a_part_whose_process_dies_three_times_is_given_up_and_the_others_go_on() -> None:
    heavy = GRID.replace("duration_s = 20.0", "duration_s = 4000.0").replace("meet_s = 9.0", "meet_s = 900.0")
    what, pids = sweep(heavy), []
    slow, quick = what.parts[0], type(what.parts[0])(9, 0, 1)  # there is no point 9

    def kill_at_work(pid: int) -> None:
        pids.append(pid)
        if len(pids) <= 3:
            threading.Thread(target=_kill_later, args=(pid,)).start()

    lost, sailed = local(1, kill_at_work)(heavy, SEED, [slow, quick])
    assert (lost.part, lost.content) == (slow, None)
    assert f"process {pids[2]} ended, killed by signal 9" in lost.why
    assert sailed.part == quick
    assert len(pids) == 4


def _kill_later(pid: int) -> None:
    """Kill it when it has worked for a while."""
    process = psutil.Process(pid)
    while process.cpu_times().user < SAILING_S:
        threading.Event().wait(0.05)
    process.kill()


def test_what_a_part_raises_is_its_own_trouble() -> None:
    what = sweep(GRID)
    beyond = type(what.parts[0])(9, 0, 5)
    one, other = local(1)(what.text, SEED, [beyond, what.parts[0]])
    assert (one.part, one.content, one.why) == (beyond, None, "IndexError: tuple index out of range")
    assert other.content is not None


def test_processes_that_never_get_ready_end_the_sweep_with_what_the_last_one_said() -> None:
    with pytest.raises(
        FleetError, match=r"no process that sails can be started: process .* ended, exit code 1: .*boats"
    ):
        list(local(1)(BRIEF.replace("boats = 2", 'boats = "two"'), SEED, sweep().parts))


def test_closed_on_the_way_all_processes_end_at_once() -> None:
    what, pids = sweep(GRID), []
    sailing = local(2, pids.append)(what.text, SEED, what.parts)
    next(sailing)
    sailing.close()
    assert len(pids) == 2
    assert not any(psutil.pid_exists(pid) for pid in pids)
