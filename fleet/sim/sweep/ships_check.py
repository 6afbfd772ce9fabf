"""What cannot work in a family with foreign vessels that has the right shape."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import structs

from fleet.mission.misfit import CRUISE_MARGIN_MPS
from fleet.mission.problem import Problem
from fleet.sim.sweep.distributions import Spread, support
from fleet.sim.sweep.fits import gap_for, shown
from fleet.sim.sweep.model import Environment, Imazu, Radio, Spec, Trouble, Tuned, Vessels
from fleet.sim.sweep.ships import MOST_VESSELS

NOT_HERE = "not with foreign vessels; expected none"


def ships_problems(spec: Spec) -> Iterator[Problem]:
    """Everything that is wrong with such a family beside single numbers."""
    layout = spec.layout
    assert isinstance(layout, Vessels | Imazu)
    yield from _unused(spec)
    crossing = isinstance(layout, Vessels) and layout.crossing_deg is not None
    if crossing and spec.formation is not None:
        yield Problem(("formation",), "boats that cross each other are none; expected layout.crossing_deg or formation")
    if crossing and spec.boats == 1:
        yield Problem(("layout", "crossing_deg"), "there is one boat; expected boats of at least 2")
    if spec.boats > 1 and spec.formation is None and not crossing:
        yield Problem(("formation",), f"missing, {spec.boats} boats that meet vessels need spacing_m and cruise_mps")
    if spec.boats == 1 and spec.formation is not None:
        yield Problem(("formation",), "one boat is none; expected boats of at least 2")
    yield from _cruise(spec, layout)
    if isinstance(layout, Vessels):
        yield from _vessels(layout)


def _unused(spec: Spec) -> Iterator[Problem]:
    """Tables and keys that other families have, and that would do nothing here."""
    if spec.trouble != Trouble():
        yield Problem(("trouble",), NOT_HERE)
    if spec.timeline:
        yield Problem(("timeline",), NOT_HERE)
    for table, kinds, used in (
        ("environment", Environment, ("current_mps", "current_toward_deg")),
        ("radio", Radio, ("delay_s", "loss")),
        ("keeping_clear", Tuned, ("radius_m",)),
    ):
        given, default = getattr(spec, table), kinds()
        for field in structs.fields(kinds):
            value = getattr(given, field.name)
            if field.name not in used and value != getattr(default, field.name):
                shown_value = shown(value) if isinstance(value, float | Spread) else value
                yield Problem((table, field.encode_name), NOT_HERE, shown_value)
    if spec.hulls:
        yield Problem(("hulls",), NOT_HERE)
    if spec.measure_from_s != 0.0:
        yield Problem(("measure_from_s",), NOT_HERE, spec.measure_from_s)


def _cruise(spec: Spec, layout: Vessels | Imazu) -> Iterator[Problem]:
    """Speeds that boats cannot sail."""
    low, high = spec.limits.speed_min_mps, spec.limits.speed_max_mps
    where, value, room = ("layout", "cruise_mps"), layout.cruise_mps, 0.0
    if spec.formation is not None:
        where, value, room = ("formation", "cruise_mps"), spec.formation.cruise_mps, CRUISE_MARGIN_MPS
    least, most = support(value)
    if least < low + room - 1e-9 or most > high - room + 1e-9:
        comes = f"{least:g} to {most:g} m/s can come; " if isinstance(value, Spread) else ""
        yield Problem(where, f"{comes}expected {low + room:g} to {high - room:g} m/s, as boats can sail", shown(value))
    if spec.formation is not None:
        least, need = support(spec.formation.spacing_m)[0], gap_for(spec.keeping_clear.radius_m, 0.0)
        if least < need - 1e-9:
            wrong = f"boats can come to be {least:g} m apart; at least {need:.1f} m"
            yield Problem(("formation", "spacing_m"), wrong, shown(spec.formation.spacing_m))


def _vessels(layout: Vessels) -> Iterator[Problem]:
    """Vessels in numbers that there are not, and bends and banks where they cannot be."""
    least, most = support(layout.vessels)
    if least < 1.0 or most >= MOST_VESSELS + 1.0:
        yield Problem(("layout", "vessels"), f"expected 1 to {MOST_VESSELS}", shown(layout.vessels))
    bends = support(layout.bend_deg) != (0.0, 0.0)
    if bends and layout.bend_before_s >= support(layout.meet_s)[0]:
        yield Problem(("layout", "bend_before_s"), "before the start; expected less than meet_s", layout.bend_before_s)
    if bends and layout.crossing_deg is not None:
        yield Problem(("layout", "bend_deg"), "boats that cross each other sail straight on", shown(layout.bend_deg))
    if bends and layout.bank_m is not None:
        yield Problem(("layout", "bank_m"), "the path bends; a bank lies beside a straight one", layout.bank_m)
