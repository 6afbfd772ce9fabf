"""`fleet sim --case`: one case of a sweep, sailed alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from fleet.cli import say
from fleet.errors import UsageError

if TYPE_CHECKING:
    from fleet.sim.sweep.family import Family

EXPECTED = "expected FAMILY:SEED/CASE, or FAMILY:SEED/POINT/CASE where the family has a grid"


def sail_case(
    text: str, boats: int | None, method: str | None, *, json: bool, picture: bool, record: bool, runs: str | None
) -> int:
    """Sail it, tell about it, keep its trace and picture; the exit code."""
    import json as json_

    import numpy as np

    from fleet.recording.runs import new_run
    from fleet.sim.sweep.family import read_case
    from fleet.sim.sweep.store import write_text

    family, name = _family(text, boats, method)
    case = (_with_vessels if family.foreign else _of_boats)(family, *read_case(family, name))
    told = case.told
    written: list[tuple[str, Path]] = []
    if picture or record:
        folder = new_run(runs, f"case-{family.name}-{name.replace('/', '-')}").folder
        write_text(folder / "case.json", json_.dumps(say.finite(told), indent=1, ensure_ascii=False) + "\n")
        written.append(("case", folder))
        if record:
            np.savez_compressed(folder / "trace.npz", **case.trace)
            written.append(("trace", folder / "trace.npz"))
        if picture:
            written += _draw(case, folder / "picture.png")
    if json:
        say.out_json({**told, **{what: str(where) for what, where in written if what != "case"}})
    else:
        _print(case, written)
    return 1 if told["failed"] else 0


class Case(Struct, frozen=True, kw_only=True):
    """A case that was sailed alone."""

    told: dict[str, Any]
    trace: dict[str, Any]
    """Arrays by name."""
    figure: Callable[[str], Any]
    """Of a title."""
    lines: Callable[[dict[str, Any]], list[str]]
    """What a person wants to know."""
    passed: str
    """Words for a case that did not fail."""


def _of_boats(family: Family, seed: int, point: int, case: int) -> Case:
    """A case among boats of the fleet."""
    from msgspec import structs

    from fleet.sim.sweep import alone

    def figure(title: str) -> Any:
        from fleet.sim.sweep.pictures import tracks

        return tracks(results, title)

    results = alone.sail_case(family, seed, point, case)
    return Case(
        told=alone.told(family, seed, point, results),
        trace=structs.asdict(results.traces[0]),
        figure=figure,
        lines=_lines,
        passed="no collision, no standstill",
    )


def _with_vessels(family: Family, seed: int, point: int, case: int) -> Case:
    """A case with foreign vessels."""
    from fleet.cli.case_ships import lines
    from fleet.sim.sweep import ships_alone

    def figure(title: str) -> Any:
        from fleet.sim.sweep.ships_pictures import tracks

        return tracks(one.case, one.voyage, title)

    one = ships_alone.sail_ship_case(family, seed, point, case)
    return Case(
        told=ships_alone.told(family, seed, point, one),
        trace=ships_alone.trace(one),
        figure=figure,
        lines=lines,
        passed="no contact, 0.8 of every domain kept",
    )


def _family(text: str, boats: int | None, method: str | None) -> tuple[Family, str]:
    """The family of FAMILY:CASE, and the case's name."""
    from fleet.sim.sweep.family import load, loads
    from fleet.sim.sweep.store import find, is_sweep

    where, colon, name = text.rpartition(":")
    if not colon or not where or not name:
        raise UsageError(f"--case {text}: {EXPECTED}")
    if not is_sweep(where):
        return load(where, boats=boats, method=method), name
    if boats is not None or method is not None:
        raise UsageError("--boats and --method say what a sweep's folder says: expected neither with it")
    return loads(find(where).sweep.text), name


def _draw(case: Case, path: Path) -> list[tuple[str, Path]]:
    try:
        figure = case.figure(": ".join([case.told["case"], "; ".join(case.told["why"]) or "nothing failed"]))
    except UsageError as error:
        say.hint(str(error))
        return []
    figure.savefig(path, dpi=130)
    return [("picture", path)]


def _print(case: Case, written: list[tuple[str, Path]]) -> None:
    say.out(say.paint(case.told["case"], "bold"))
    for line in case.lines(case.told):
        say.out(line)
    say.out()
    if case.told["failed"]:
        say.out(say.paint(f"FAILED: {'; '.join(case.told['why'])}", "red"))
    else:
        say.out(say.paint(f"passed: {case.passed}", "green"))
    for line in say.aligned([(what, str(where)) for what, where in written]):
        say.out(line)


def _lines(told: dict[str, Any]) -> list[str]:
    lines = [f"method {told['method']}, R = {told['radius_m']:g} m, sailed for {told['ended_s']:.1f} s"]
    near = told["closest"]
    if near is not None:
        first, second = near["boats"]
        apart = f"least separation {near['distance_m']:.2f} m, boats {first} and {second} at {near['at_s']:.1f} s"
        lines.append(f"{apart}; {told['inside_s']:.1f} s within R")
    heads = ("boat", "nominal s", "arrived s", "delay s", "switches", "cross-track rms m", "formation rms m", "")
    rows: list[tuple[str, ...]] = [heads]
    for one in told["boats"]:
        figures = [_shown(one[key]) for key in ("nominal_s", "arrived_s", "delay_s")]
        errors = [f"{one[key]:.2f}" for key in ("cross_track_rms_m", "formation_rms_m")]
        rows.append((str(one["boat"]), *figures, str(one["switches"]), *errors, "made no way" if one["stood"] else ""))
    return [*lines, "", *say.aligned(rows, right=range(7), indent="  ")]


def _shown(value: float) -> str:
    return f"{value:.1f}" if abs(value) < 1e12 else "-"
