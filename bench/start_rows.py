"""What it costs to begin: `fleet --help` against an empty Typer program, an agent up to its first tick."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import msgspec

from bench.agent_process import NOTES, Notes
from bench.procs import memory_mib
from bench.table import Row, Table
from fleet.agent.config import AgentConfig, DriverConfig
from fleet.wire.link import LinkConfig

GROUP = "start, CPU of the process"
ROOT = Path(__file__).resolve().parent.parent
EMPTY = """import typer
app = typer.Typer()
@app.command()
def one() -> None:
    "Nothing."
@app.command()
def two() -> None:
    "Nothing."
app()
"""


def _cpu_ms(argv: list[str]) -> float:
    child = subprocess.Popen(argv, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise RuntimeError(f"{' '.join(argv)} ended with {child.returncode}")
    return (usage.ru_utime + usage.ru_stime) * 1e3


def help_rows(table: Table, quick: bool) -> None:
    """`fleet --help`, interleaved with the empty program."""
    fleet = Path(sys.executable).with_name("fleet")
    if not fleet.exists() or not (ROOT / "fleet" / "cli" / "main.py").exists():
        table.say("fleet --help: there is no fleet/cli/main.py yet")
        return
    with tempfile.TemporaryDirectory() as place:
        empty = Path(place) / "empty.py"
        empty.write_text(EMPTY, encoding="utf-8")
        for argv in ([str(fleet), "--help"], [sys.executable, str(empty), "--help"]):
            _cpu_ms(argv)  # compiles what is new
        mine, bare = [], []
        for _ in range(5 if quick else 15):
            mine.append(_cpu_ms([str(fleet), "--help"]))
            bare.append(_cpu_ms([sys.executable, str(empty), "--help"]))
    quotient = statistics.median(mine) / statistics.median(bare)
    table.add(
        Row(
            group=GROUP,
            name="fleet --help",
            value=statistics.median(mine),
            unit="ms",
            ratio=quotient,
            over="empty Typer program",
            aim=1.2,
            aim_is_ratio=True,
        )
    )


def agent_rows(table: Table, quick: bool) -> None:
    """Imports up to the first tick of one agent that finds neither hub nor world, and its memory."""
    spent: list[float] = []
    bare: list[float] = []
    memory: list[float] = []
    for _ in range(2 if quick else 5):
        cpu, resident = _one_agent()
        spent.append(cpu)
        memory.append(resident)
        bare.append(_cpu_ms([sys.executable, "-c", "pass"]))
    mine, python = statistics.median(spent), statistics.median(bare)
    table.add(
        Row(
            group=GROUP,
            name="agent: imports to first tick, no hub",
            value=mine,
            unit="ms",
            ratio=mine / python,
            over="python -c pass",
            aim=150.0,
        )
    )
    table.add(
        Row(
            group=GROUP,
            name="agent: resident memory, recording, no hub",
            value=statistics.median(memory),
            unit="MiB",
            aim=45.0,
        )
    )


def _one_agent() -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as place:
        config = AgentConfig(
            boat="alone",
            link=LinkConfig(topology="hub", connect=("tcp/127.0.0.1:9",)),
            driver=DriverConfig(world="127.0.0.1:9"),
            state_dir=place,
            record=str(Path(place) / "alone.mcap"),
        )
        argv = [sys.executable, "-m", "bench.agent_process", msgspec.json.encode(config).decode()]
        child = subprocess.Popen(argv, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
        time.sleep(1.5)
        resident, _ = memory_mib(child.pid)
        child.terminate()
        child.wait(10)
        notes = msgspec.msgpack.decode((Path(place) / NOTES).read_bytes(), type=Notes)
    return notes.first_tick_cpu_ns * 1e-6, resident
