"""`fleet sim --case`: one case of a sweep, sailed alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from fleet.cli import say
from fleet.errors import UsageError

if TYPE_CHECKING:
    from fleet.sim.batch import Results
    from fleet.sim.sweep.family import Family

EXPECTED = "expected FAMILY:SEED/CASE, or FAMILY:SEED/POINT/CASE where the family has a grid"


def sail_case(
    text: str, boats: int | None, method: str | None, *, json: bool, picture: bool, record: bool, runs: str | None
) -> int:
    """Sail it, tell about it, keep its trace and picture; the exit code."""
    import json as json_

    from fleet.recording.runs import new_run
    from fleet.sim.sweep import alone
    from fleet.sim.sweep.family import read_case
    from fleet.sim.sweep.store import write_text

    family, name = _family(text, boats, method)
    seed, point, case = read_case(family, name)
    if family.foreign:
        from fleet.cli.case_ships import sail_ship_case

        return sail_ship_case(family, name, (seed, point, case), json=json, picture=picture, record=record, runs=runs)
    results = alone.sail_case(family, seed, point, case)
    told = alone.told(family, seed, point, results)
    written: list[tuple[str, Path]] = []
    if picture or record:
        folder = new_run(runs, f"case-{family.name}-{name.replace('/', '-')}").folder
        write_text(folder / "case.json", json_.dumps(say.finite(told), indent=1, ensure_ascii=False) + "\n")
        written.append(("case", folder))
        if record:
            written.append(("trace", _keep(results, folder / "trace.npz")))
        if picture:
            written += _draw(results, told, folder)
    if json:
        say.out_json({**told, **{what: str(where) for what, where in written if what != "case"}})
    else:
        _print(told, written)
    return 1 if told["failed"] else 0


def _family(text: str, boats: int | None, method: str | None) -> tuple[Family, str]:
    """The family of FAMILY:CASE, and the case's name."""
    from fleet.sim.sweep.family import load, loads
    from fleet.sim.sweep.store import find, is_sweep

    where, colon, name = text.rpartition(":")
    if not colon or not where or not name:
        raise UsageError(f"--case {text}: {EXPECTED}")
    overrides = [f"keeping_clear.method={method}"] if method is not None else []
    if not is_sweep(where):
        return load(where, overrides, boats=boats), name
    if boats is not None or method is not None:
        raise UsageError("--boats and --method say what a sweep's folder says: expected neither with it")
    return loads(find(where).sweep.text), name


def _keep(results: Results, path: Path) -> Path:
    """The trace as arrays (tick, boat)."""
    import msgspec
    import numpy as np

    np.savez_compressed(path, **msgspec.structs.asdict(results.traces[0]))
    return path


def _draw(results: Results, told: dict[str, Any], folder: Path) -> list[tuple[str, Path]]:
    from fleet.sim.sweep.pictures import tracks

    try:
        figure = tracks(results, ": ".join([told["case"], "; ".join(told["why"]) or "nothing failed"]))
    except UsageError as error:
        say.hint(str(error))
        return []
    figure.savefig(folder / "picture.png", dpi=130)
    return [("picture", folder / "picture.png")]


def _print(told: dict[str, Any], written: list[tuple[str, Path]]) -> None:
    say.out(say.paint(told["case"], "bold"))
    say.out(f"method {told['method']}, R = {told['radius_m']:g} m, sailed for {told['ended_s']:.1f} s")
    near = told["closest"]
    if near is not None:
        first, second = near["boats"]
        say.out(f"least separation {near['distance_m']:.2f} m, boats {first} and {second} at {near['at_s']:.1f} s; "
                f"{told['inside_s']:.1f} s within R")  # fmt: skip
    say.out()
    heads = ("boat", "nominal s", "arrived s", "delay s", "switches", "cross-track rms m", "formation rms m", "")
    rows: list[tuple[str, ...]] = [heads]
    for one in told["boats"]:
        figures = [_shown(one[key]) for key in ("nominal_s", "arrived_s", "delay_s")]
        errors = [f"{one[key]:.2f}" for key in ("cross_track_rms_m", "formation_rms_m")]
        rows.append((str(one["boat"]), *figures, str(one["switches"]), *errors, "stood still" if one["stood"] else ""))
    for line in say.aligned(rows, right=range(7), indent="  "):
        say.out(line)
    say.out()
    if told["failed"]:
        say.out(say.paint(f"FAILED: {'; '.join(told['why'])}", "red"))
    else:
        say.out(say.paint("passed: no collision, no standstill", "green"))
    for line in say.aligned([(what, str(where)) for what, where in written]):
        say.out(line)


def _shown(value: float) -> str:
    return f"{value:.1f}" if abs(value) < 1e12 else "-"
