"""`fleet sim --case` for a case with foreign vessels."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from fleet.cli import say
from fleet.errors import UsageError

if TYPE_CHECKING:
    from fleet.sim.sweep.family import Family


def sail_ship_case(
    family: Family, name: str, which: tuple[int, int, int], *, json: bool, picture: bool, record: bool, runs: str | None
) -> int:
    """Sail it, tell about it, keep its trace and picture; the exit code."""
    import json as json_

    import numpy as np

    from fleet.recording.runs import new_run
    from fleet.sim.sweep import ships_alone
    from fleet.sim.sweep.store import write_text

    one = ships_alone.sail_ship_case(family, *which)
    told = ships_alone.told(family, which[0], which[1], one)
    written: list[tuple[str, Path]] = []
    if picture or record:
        folder = new_run(runs, f"case-{family.name}-{name.replace('/', '-')}").folder
        write_text(folder / "case.json", json_.dumps(say.finite(told), indent=1, ensure_ascii=False) + "\n")
        written.append(("case", folder))
        if record:
            np.savez_compressed(folder / "trace.npz", **ships_alone.trace(one))
            written.append(("trace", folder / "trace.npz"))
        if picture:
            written += _draw(one, told, folder)
    if json:
        say.out_json({**told, **{what: str(where) for what, where in written if what != "case"}})
    else:
        _print(told, written)
    return 1 if told["failed"] else 0


def _draw(one: Any, told: dict[str, Any], folder: Path) -> list[tuple[str, Path]]:
    try:
        from fleet.sim.sweep.ships_pictures import tracks

        figure = tracks(one.case, one.voyage, ": ".join([told["case"], "; ".join(told["why"]) or "nothing failed"]))
    except UsageError as error:
        say.hint(str(error))
        return []
    figure.savefig(folder / "picture.png", dpi=130)
    return [("picture", folder / "picture.png")]


def _print(told: dict[str, Any], written: list[tuple[str, Path]]) -> None:
    say.out(say.paint(told["case"], "bold"))
    boats = say.count(len(told["boats"]), "boat")
    say.out(f"{boats} at {told['cruise_mps']:.2f} m/s, first risk: {told['kind']}, sailed for {told['ended_s']:.1f} s")
    for line in say.aligned(
        [
            (f"vessel {one['vessel']}", f"{one['length_m']:.0f} m", f"{one['speed_mps']:.1f} m/s",
             f"course {one['course_deg']:.0f} deg", one["sensor"])
            for one in told["vessels"]
        ],
        indent="  ",
    ):  # fmt: skip
        say.out(line)
    say.out(
        f"least distance to a domain's core {told['domain']:.2f} of the clearance, hulls {told['hulls_m']:.1f} m apart"
    )
    say.out(f"delay {told['delay_median_s']:.1f} s")
    say.out()
    rows = [("at s", "boat", "what", "vessel", "range m", "why")]
    for act in told["acts"]:
        what = f"{act['alteration_deg']:+.0f} deg, {act['speed_factor']:g} of the speed" if act["acting"] else "resumes"
        vessel = "-" if act["vessel"] is None else str(act["vessel"])
        away = "-" if act["range_m"] is None else f"{act['range_m']:.0f}"
        rows.append((f"{act['t_s']:.1f}", str(act["boat"]), what, vessel, away, act["reason"]))
    for line in say.aligned(rows, right=(0, 1, 3, 4), indent="  "):
        say.out(line)
    say.out()
    if told["failed"]:
        say.out(say.paint(f"FAILED: {'; '.join(told['why'])}", "red"))
    else:
        say.out(say.paint("passed: no contact, 0.8 of every domain kept", "green"))
    for line in say.aligned([(what, str(where)) for what, where in written]):
        say.out(line)
