"""`python -m bench [--quick] [--json FILE] [ROW ...]`: one command, one table."""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path

from bench.batch_rows import batch_rows, lockstep_rows, rules_row
from bench.driver_rows import driver_rows
from bench.fleet_rows import fleet_rows, tick_rows
from bench.gcs_rows import gcs_rows
from bench.link_rows import link_rows
from bench.start_rows import agent_rows, help_rows
from bench.step_rows import codec_rows, step_rows
from bench.table import Table
from bench.timing import REFERENCE_US, calibration, timed

ROWS: dict[str, Callable[[Table, bool], None]] = {
    "step": step_rows,
    "codec": codec_rows,
    "batch": batch_rows,
    "rules": rules_row,
    "lockstep": lockstep_rows,
    "help": help_rows,
    "agent": agent_rows,
    "link": link_rows,
    "gcs": gcs_rows,
    "tick": tick_rows,
    "drivers": driver_rows,
    "fleets": fleet_rows,
}


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((text.partition(":")[2].strip() for text in lines if text.startswith("model name")), "unknown")


def main() -> int:
    """Measure; 1 when an aim is missed."""
    parser = argparse.ArgumentParser(prog="python -m bench", description="Speed and memory, as ratios in one run.")
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"of {', '.join(ROWS)}; all when none is named")
    parser.add_argument("--quick", action="store_true", help="fewer repetitions, shorter fleets")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table as JSON, too")
    options = parser.parse_args()
    unknown = [name for name in options.rows if name not in ROWS]
    if unknown:
        parser.error(f"no such row: {', '.join(unknown)}; expected of {', '.join(ROWS)}")
    unit_us = timed(calibration).us
    facts = {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "system": platform.platform(),
        "calibration_us": unit_us,
        "reference_us": REFERENCE_US,
        "load": os.getloadavg()[0],
    }
    print(f"{facts['processor']}, {facts['cores']} cores, Python {facts['python']}, load {facts['load']:.1f}")
    print(
        f"calibration loop {unit_us:.1f} us of CPU; aims in us hold where it takes {REFERENCE_US:g} us "
        "and grow with it on a slower or busier core"
    )
    began = time.monotonic()
    table = Table()
    for name in options.rows or list(ROWS):
        ROWS[name](table, options.quick)
    missed = [row for row in table.rows if row.missed]
    print(f"\n{len(table.rows)} rows in {time.monotonic() - began:.0f} s, {len(missed)} aims missed")
    for row in missed:
        print(f"  MISSED {row.group}: {row.name}")
    if options.json is not None:
        table.write(options.json, facts)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
