"""Scenarios of boats that meet foreign vessels, drawn by hashes of (seed, case, vessel, purpose)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from fleet.sim.batch.draws import more, uniform
from fleet.sim.batch.ships import Ship, ShipCase

SPACING_M = 10.0
BANK_M = 15.0
NEAR_EQUAL_MPS = 0.35  # relative speeds below it are left out
MEET_S = 120.0
STOPPED_MEET_S = 240.0  # long enough for the slowest boat to begin outside the domain of a vessel of 100 m
IMAZU_MEET_S = 180.0
LONG_M = 1.0e4
SENSORS = ("exact", "ais", "positions", "mixed")
SLOW_AHEAD = 0.5  # of our speed: the ship ahead on our course in Imazu's cases

IMAZU: tuple[tuple[float, ...], ...] = (
    (180,), (-90,), (0,), (45,),
    (180, -90), (-10, -45), (0, -45), (180, 90), (-30, -90), (-90, 15), (90, -30),
    (180, -45, -10), (180, 10, 45), (-10, -45, -90), (0, -45, -90), (45, 90, -90), (0, 10, -45), (-135, -15, -30),
    (15, -15, -135), (0, -15, -90), (-15, 15, -90), (0, -45, -90),
)  # fmt: skip
"""Imazu's 22 cases: courses of the vessels [deg] for an own course of 0; all meet in one point. Case 8 from port."""


class _Draws:
    """Numbers for one vessel of one scenario."""

    def __init__(self, seed: int, case: int, ship: int) -> None:
        self.h = more(more(more(0, seed), case), 1_000 + ship)
        self.k = 0

    def __call__(self, low: float, high: float) -> float:
        self.k += 1
        return low + (high - low) * uniform(more(self.h, self.k))


def c0(length: float) -> float:
    """Clearance without uncertainty [m]."""
    return 1.2 + 0.1 * length + min(max(0.4 * length, 6.0), 30.0)


def sensor_of(word: str, draw: _Draws) -> str:
    """Mixed: half AIS, half positions."""
    share = draw(0.0, 1.0)
    return ("ais" if share < 0.5 else "positions") if word == "mixed" else word


def meeting(
    draw: _Draws, cruise: float, sensor: str, meet_s: float, lengths: tuple[float, float], speeds: tuple[float, float],
    misses: float = 1.2, course: Callable[[_Draws], float] = lambda draw: draw(-math.pi, math.pi),
) -> Ship:  # fmt: skip
    """A vessel that would pass a boat on its path north by `misses` times +-C0, after `meet_s`."""
    while True:
        length, U, chi = draw(*lengths), draw(*speeds), course(draw)
        vx, vy = U * math.cos(chi), U * math.sin(chi)
        wx, wy = cruise - vx, -vy
        w = math.hypot(wx, wy)
        miss = draw(-misses, misses) * c0(length)
        if w < NEAR_EQUAL_MPS:
            continue
        x = cruise * meet_s - miss * wy / w - vx * meet_s
        y = miss * wx / w - vy * meet_s
        return Ship(x=x, y=y, chi=chi, U=U, length=length, sensor=sensor_of(sensor, draw))


def two(seed: int, count: int, sensor: str = "mixed", first: int = 0) -> Iterator[ShipCase]:
    """One boat, one vessel of 5 to 60 m at 0 to 8 m/s from anywhere."""
    for case in range(first, first + count):
        own = _Draws(seed, case, 99)
        cruise = own(0.5, 1.5)
        ship = meeting(_Draws(seed, case, 0), cruise, sensor, MEET_S, (5.0, 60.0), (0.0, 8.0))
        yield _one(f"two, {sensor}", seed, case, cruise, (ship,))


def several(seed: int, count: int, sensor: str = "mixed", first: int = 0) -> Iterator[ShipCase]:
    """One boat, two to four vessels."""
    for case in range(first, first + count):
        own = _Draws(seed, case, 99)
        cruise, many = own(0.5, 1.5), 2 + int(own(0.0, 3.0))
        ships = tuple(
            meeting(draw, cruise, sensor, draw(80.0, 160.0), (5.0, 60.0), (0.0, 8.0))
            for draw in (_Draws(seed, case, k) for k in range(many))
        )
        yield _one(f"several, {sensor}", seed, case, cruise, ships, meet_s=160.0)


def imazu(seed: int, factor: float = 1.0, sensor: str = "exact", repeat: int = 1) -> Iterator[ShipCase]:
    """Imazu's cases at 1 m/s, vessels of 20 m at `factor` times that; one ahead on our course at half our speed."""
    for case in range(len(IMAZU) * repeat):
        ships = []
        for k, degrees in enumerate(IMAZU[case % len(IMAZU)]):
            U = SLOW_AHEAD if degrees == 0 else factor
            chi = math.radians(degrees)
            x, y = IMAZU_MEET_S * (1.0 - U * math.cos(chi)), -IMAZU_MEET_S * U * math.sin(chi)
            word = sensor_of(sensor, _Draws(seed, case, k))
            ships.append(Ship(x=x, y=y, chi=chi, U=U, length=20.0, sensor=word))
        yield _one(f"imazu x{factor:g}, {sensor}", seed, case, 1.0, tuple(ships), meet_s=IMAZU_MEET_S)


def sudden(seed: int, count: int, sensor: str = "mixed", first: int = 0) -> Iterator[ShipCase]:
    """As `two`, and 10 to 60 s before the meeting the vessel turns by 30 to 90 deg, to either side."""
    for each in two(seed, count, sensor, first):
        draw = _Draws(seed, each.case, 50)
        before, turn, rate = draw(10.0, 60.0), math.radians(draw(30.0, 90.0)), draw(0.03, 0.1)
        sign = 1.0 if draw(0.0, 1.0) < 0.5 else -1.0
        ship = each.ships[0]
        turning = Ship(
            x=ship.x, y=ship.y, chi=ship.chi, U=ship.U, length=ship.length, sensor=ship.sensor,
            turns_s=each.meet_s - before, turn=sign * turn, rate=rate,
        )  # fmt: skip
        yield _one(f"sudden, {sensor}", seed, each.case, each.cruise, (turning,))


def stopped(seed: int, count: int, sensor: str = "mixed", first: int = 0) -> Iterator[ShipCase]:
    """One vessel of 5 to 100 m that lies still."""
    for case in range(first, first + count):
        cruise = _Draws(seed, case, 99)(0.5, 1.5)
        ship = meeting(_Draws(seed, case, 0), cruise, sensor, STOPPED_MEET_S, (5.0, 100.0), (0.0, 0.0))
        yield _one(f"stopped, {sensor}", seed, case, cruise, (ship,), meet_s=STOPPED_MEET_S)


def channel(
    seed: int, count: int, bank_m: float = BANK_M, longest: float = 60.0, sensor: str = "mixed", first: int = 0
) -> Iterator[ShipCase]:
    """Traffic along a channel, courses within 20 deg of ours or opposite; a bank to starboard, none if not finite."""

    def course(draw: _Draws) -> float:
        opposite = draw(0.0, 1.0) < 0.6
        return math.radians(draw(-20.0, 20.0)) + (math.pi if opposite else 0.0)

    for case in range(first, first + count):
        cruise = _Draws(seed, case, 99)(0.5, 1.5)
        ship = meeting(_Draws(seed, case, 0), cruise, sensor, MEET_S, (5.0, longest), (0.0, 8.0), course=course)
        edges = ((-LONG_M, bank_m, LONG_M, bank_m),) if math.isfinite(bank_m) else ()
        yield _one(f"channel, bank {bank_m:g} m, L to {longest:g}", seed, case, cruise, (ship,), edges=edges)


def formation(
    seed: int, count: int, boats: int = 3, abreast: bool = False, sensor: str = "ais", first: int = 0
) -> Iterator[ShipCase]:
    """A formation, 10 m apart in column or abreast, meets one vessel of 10 to 100 m. The leader is the aftermost."""
    for case in range(first, first + count):
        cruise = _Draws(seed, case, 99)(0.5, 1.5)
        ship = meeting(_Draws(seed, case, 0), cruise, sensor, MEET_S, (10.0, 100.0), (0.0, 8.0))
        paths = tuple(
            (0.0, SPACING_M * i, 0.0) if abreast else (SPACING_M * i, 0.0, SPACING_M * i) for i in range(boats)
        )
        word = f"formation, {boats} {'abreast' if abreast else 'in column'}, {sensor}"
        yield ShipCase(
            suite=word, seed=seed, case=case, cruise=cruise, paths=paths, ships=(ship,), meet_s=MEET_S, limit_s=400.0
        )


def _one(
    suite: str,
    seed: int,
    case: int,
    cruise: float,
    ships: tuple[Ship, ...],
    meet_s: float = MEET_S,
    edges: tuple[tuple[float, float, float, float], ...] = (),
) -> ShipCase:
    """A scenario of one boat that sails north."""
    return ShipCase(
        suite=suite,
        seed=seed,
        case=case,
        cruise=cruise,
        paths=((0.0, 0.0, 0.0),),
        ships=ships,
        meet_s=meet_s,
        limit_s=3.0 * meet_s + 60.0,
        edges=edges,
    )
