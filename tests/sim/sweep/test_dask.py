"""A sweep on a Dask cluster: a lost worker costs time, and nothing else."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import psutil
import pytest

from fleet.errors import FleetError, UsageError
from fleet.sim.sweep.cluster import dask
from fleet.sim.sweep.pool import local
from fleet.sim.sweep.run import Progress, sail
from fleet.sim.sweep.store import create
from fleet.sim.sweep.table import summary
from tests.sim.sweep.brief import GRID, same_bits, sweep
from tests.sim.sweep.test_run import bare

pytest.importorskip("distributed")


@pytest.mark.sails
def test_one_of_two_workers_killed_on_the_way_nothing_is_lost_or_counted_twice(tmp_path: Path) -> None:
    what = sweep(GRID.replace("[0.0, 0.4]", "[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]"))
    plain, spread = create(tmp_path, what), create(tmp_path, what)
    sail(plain, local(2))
    pids: list[int] = []
    killed: list[int] = []

    def look(progress: Progress) -> None:
        if progress.cases >= 10 and not killed:
            killed.append(pids[0])
            os.kill(pids[0], signal.SIGKILL)

    ended = sail(spread, dask("local:2", pids.append), look)
    assert [one.why for one in ended.lost] == []
    assert len(killed) == 1
    for one, other in zip(plain.results(), spread.results(), strict=True):
        assert same_bits(one, other)
    assert bare(summary(plain, plain.results())) == bare(summary(spread, spread.results()))
    assert not any(psutil.pid_exists(pid) for pid in pids)


@pytest.mark.parametrize("address", ["local", "local:0", "10.0.0.5:8786", "local:two", "tcp://nowhere"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(UsageError, match=f"--dask {address}: expected local:N, or the scheduler"):
        dask(address)


def test_a_scheduler_that_does_not_answer_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fleet.sim.sweep.cluster.CONNECT_S", 0.3)
    what = sweep()
    with pytest.raises(FleetError, match=r"--dask tcp://127.0.0.1:9: no scheduler answers within 0.3 s"):
        list(dask("tcp://127.0.0.1:9")(what.text, what.seed, what.parts))
