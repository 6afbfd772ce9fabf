"""`step` and the codec: CPU of one call, in units of the calibration loop."""

from __future__ import annotations

import statistics
import time
from itertools import cycle

from msgspec import structs

from bench.scenes import boat_state, column, due, in_a_crowd
from bench.table import Row, Table
from bench.timing import CALIBRATION, Timed, calibration, timed
from fleet.wire.codec import decode_state, encode

PEERS = (1, 4, 10, 50)
STEP_AIM_US = {10: 60.0, 50: 100.0}
DECIDE_AIM_US = 1000.0
ALL_RULES_AIM_US = 2000.0


def step_rows(table: Table, quick: bool) -> None:
    """One boat's `step`; the aims are stated for the reference machine and scale with the calibration loop."""
    repetitions = 9 if quick else 25
    for method in ("scoring", "circle"):
        for peers in PEERS:
            scene = column(method, peers)
            assert scene.tick()[1].avoiding == 0.0
            t = timed(scene.tick, repetitions)
            aim = STEP_AIM_US.get(peers)
            table.add(_row(f"{method}, {peers} peers, nobody in conflict", t, aim, "50 near" if peers == 50 else ""))
    for peers in PEERS:
        free = due(column("scoring", peers))
        assert free.tick()[0].keep.countdown > free.dt
        t = timed(free.tick, repetitions)
        table.add(_row(f"scoring, {peers} peers, deciding, course free", t, DECIDE_AIM_US if peers <= 10 else None))
    for peers in PEERS:
        searching = due(column("scoring", peers, conflict=True))
        assert searching.tick()[1].avoiding == 1.0
        t = timed(searching.tick, repetitions)
        table.add(_row(f"scoring, {peers} peers, deciding, searching", t, DECIDE_AIM_US if peers <= 10 else None))
    crowd = due(in_a_crowd(10))
    assert crowd.tick()[1].avoiding == 1.0
    t = timed(crowd.tick, repetitions)
    note = "all ten in conflict, margins for GNSS"
    table.add(_row("scoring, 10 peers, deciding with all rules", t, ALL_RULES_AIM_US, note))
    _rested_row(table, quick)
    blocked = column("circle", 10, conflict=True)
    near = structs.replace(blocked.peers[-1], x=blocked.nav.x + 9.0)  # within 2 R: the circle acts
    blocked.peers[-1] = near
    t = timed(blocked.tick, repetitions)
    note = "avoiding" if blocked.tick()[1].avoiding else "not avoiding"
    table.add(_row("circle, 10 peers, one head-on", t, DECIDE_AIM_US, note))


def _rested_row(table: Table, quick: bool) -> None:
    """The same tick once after a sleep, as in an agent: caches hold something else by then."""
    scene = column("scoring", 10)
    spent, units = [], []
    for _ in range(10 if quick else 30):
        for work, kept in ((scene.tick, spent), (calibration, units)):
            time.sleep(0.1)
            began = time.thread_time_ns()
            work()
            kept.append((time.thread_time_ns() - began) * 1e-3)
    tick, unit = statistics.median(spent), statistics.median(units)
    note = "what a warm loop does not show; it has no aim of its own"
    row = _row("scoring, 10 peers, once after 0.1 s of sleep", Timed(tick, unit, tick / unit), None, note)
    table.add(structs.replace(row, over="calibration, slept"))


def _row(name: str, t: Timed, aim: float | None, note: str = "", group: str = "step of one boat, CPU") -> Row:
    return Row(
        group=group,
        name=name,
        value=t.us,
        unit="us",
        ratio=t.ratio,
        over=CALIBRATION,
        aim=aim,
        scale=t.scale,
        note=note,
    )


def codec_rows(table: Table, quick: bool) -> None:
    """BoatState out and in."""
    repetitions = 9 if quick else 25
    state = boat_state()
    payload = encode(state)
    group = f"codec of BoatState ({len(payload)} bytes), CPU"
    table.add(_row("encode", timed(lambda: encode(state), repetitions), None, group=group))
    heard = cycle([encode(boat_state(seq=k)) for k in range(1000)])  # each is new, as on the air: no cache helps
    table.add(_row("decode and check", timed(lambda: decode_state(next(heard), "b7"), repetitions), None, group=group))
