"""Other vessels: where they are, what they do by their script, and what boats receive of them.

Pure: a vessel's motion is a value that `advance` takes and gives back; every random number is a hash of (seed, vessel,
boat, number of the report, purpose).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum

from msgspec import Struct

from fleet import ops
from fleet.drivers.seam import Sighting
from fleet.geo import Plane
from fleet.mission.model import Ais, Change, Lidar, Sensed, Steady, Vessel
from fleet.mission.plan import Plan, Point, metres
from fleet.wire.radio import mix, number_of, uniform

TURN_RADIUS_LENGTHS = 2.5  # of the tightest turn
TURN_RATE_RADPS = 0.15  # never faster
GIVES_WAY_RAD = math.radians(45.0)  # to starboard
LOOKS_AHEAD_S = 120.0
KEEPS_CLEAR = 1.5  # times the distance C0 that boats keep from a vessel of its size
ABAFT_RAD = math.radians(112.5)  # a boat farther aft on its starboard side is none of its business
NEVER_S = 1e12
AHEAD_RAD = math.radians(-11.25)  # nor one more to port

Body = tuple[float, float, float, float]
"""x, y [m], vx, vy [m/s] of a boat."""


class Purpose(IntEnum):
    """What a number is drawn for."""

    PHASE = 200
    LOSS = 201
    NORTH = 210
    EAST = 213
    V_NORTH = 216
    V_EAST = 219
    SIZE = 222


def normal(h: int, purpose: int) -> float:
    """A standard normal number of a hash (Box-Muller)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(h, purpose)))
    return radius * math.cos(2.0 * math.pi * uniform(h, purpose + 1))


class Script(Struct, frozen=True):
    """A vessel as its mission wants it, in metres."""

    name: str
    number: int
    length_m: float
    speed: float
    start: Point
    course: float  # at first [rad]
    points: tuple[Point, ...]  # that it goes to
    changes: tuple[Change, ...]  # in order of time
    gives_way: bool
    sensed: Sensed


class Motion(Struct, frozen=True, gc=False):
    """What a vessel does now."""

    x: float
    y: float
    chi: float  # course [rad]
    speed: float
    course: float  # wanted, giving way apart [rad]
    wanted: float  # speed wanted [m/s]
    leg: int = 0  # next waypoint
    done: int = 0  # changes made
    gives_way: bool = False  # just now

    @property
    def velocity(self) -> Point:
        """Over ground, north and east [m/s]."""
        s, c = ops.sincos(self.chi)
        return self.speed * c, self.speed * s


class Listener(Struct, frozen=True):
    """A boat as far as it receives reports."""

    number: int
    x: float
    y: float
    error_n: float  # by which its own position is wrong [m]
    error_e: float
    knows_itself: bool  # it has a position
    plane: Plane


def scripts(plan: Plan) -> tuple[Script, ...]:
    """The vessels of a mission."""
    return tuple(_script(vessel, plan.plane) for vessel in plan.mission.traffic)


def _script(vessel: Vessel, plane: Plane) -> Script:
    track = vessel.track
    points: tuple[Point, ...] = ()
    if isinstance(track, Steady):
        start, course = metres(track.start, plane), math.radians(track.course_deg)
    else:
        start, *rest = (metres(point, plane) for point in track.points)
        points = tuple(rest)
        course = ops.atan2(points[0][1] - start[1], points[0][0] - start[0])
    changes = tuple(sorted(vessel.changes, key=lambda change: change.at_s))
    return Script(
        name=vessel.name,
        number=number_of(vessel.name),
        length_m=vessel.length_m,
        speed=vessel.speed_mps,
        start=start,
        course=ops.wrap(course),
        points=points,
        changes=changes,
        gives_way=vessel.gives_way,
        sensed=vessel.sensed,
    )


def begin(script: Script) -> Motion:
    """A vessel under way where it starts."""
    x, y = script.start
    return Motion(x, y, script.course, script.speed, script.course, script.speed)


def advance(script: Script, motion: Motion, t_s: float, boats: Sequence[Body], dt: float) -> Motion:
    """The motion a step later.

    A vessel turns with a radius of at least 2.5 lengths and gains or loses 3 m/s a second over its length (0.05 to
    0.3 m/s^2). One that gives way turns 45 deg to starboard while a boat ahead or to starboard would come nearer than
    1.5 C0 within two minutes, and goes back when none would on its old course.

    Args:
        script: what it is to do
        motion: what it did until now
        t_s: since the beginning, at the end of the step [s]
        boats: of the fleet
        dt: length of the step [s]
    """
    course, wanted, leg, done = motion.course, motion.wanted, motion.leg, motion.done
    while done < len(script.changes) and script.changes[done].at_s <= t_s:
        change = script.changes[done]
        if change.do == "turn":
            course, leg = ops.wrap(course + math.radians(change.value or 0.0)), len(script.points)
        else:
            wanted = change.value or 0.0
        done += 1
    if leg < len(script.points):
        x, y = script.points[leg]
        if math.hypot(x - motion.x, y - motion.y) < TURN_RADIUS_LENGTHS * script.length_m:
            leg += 1
        else:
            course = ops.atan2(y - motion.y, x - motion.x)
    gives_way = motion.gives_way
    if script.gives_way and int(t_s) != int(t_s - dt):  # looks once a second
        gives_way = any(_in_the_way(script, motion, course, wanted, boat) for boat in boats)

    rate = min(TURN_RATE_RADPS, motion.speed / (TURN_RADIUS_LENGTHS * script.length_m)) * dt
    turn = ops.wrap(course + (GIVES_WAY_RAD if gives_way else 0.0) - motion.chi)
    gain = min(max(3.0 / script.length_m, 0.05), 0.3) * dt
    vx, vy = motion.velocity
    return Motion(
        x=motion.x + vx * dt,
        y=motion.y + vy * dt,
        chi=ops.wrap(motion.chi + min(max(turn, -rate), rate)),
        speed=motion.speed + min(max(wanted - motion.speed, -gain), gain),
        course=course,
        wanted=wanted,
        leg=leg,
        done=done,
        gives_way=gives_way,
    )


def own_distance(length_m: float) -> float:
    """C0, which boats keep between their centre and the middle line of a vessel so long [m]."""
    return 1.2 + 0.1 * length_m + min(max(0.4 * length_m, 6.0), 30.0)


def _in_the_way(script: Script, motion: Motion, course: float, wanted: float, boat: Body) -> bool:
    """Whether a boat comes too near on the course wanted; while giving way wherever it bears."""
    x, y, vx, vy = boat
    dx, dy = x - motion.x, y - motion.y
    bearing = ops.wrap(ops.atan2(dy, dx) - course)
    if not motion.gives_way and not AHEAD_RAD <= bearing <= ABAFT_RAD:
        return False
    s, c = ops.sincos(course)
    wx, wy = vx - wanted * c, vy - wanted * s
    closing = -(dx * wx + dy * wy)
    if closing <= 0.0:
        return False
    t = min(closing / max(wx * wx + wy * wy, 1e-9), LOOKS_AHEAD_S)
    return math.hypot(dx + wx * t, dy + wy * t) < KEEPS_CLEAR * own_distance(script.length_m)


# -- what boats receive ------------------------------------------------------------------------------------------------
def period_s(script: Script) -> float:
    """Between two reports [s]."""
    if isinstance(script.sensed, Lidar):
        return NEVER_S
    return script.sensed.interval_s if isinstance(script.sensed, Ais) else 1.0 / script.sensed.rate_hz


def reports(script: Script, t_s: float, seed: int) -> int:
    """How many reports there have been until then; vessels do not speak in step."""
    period = period_s(script)
    return math.floor(t_s / period + uniform(seed, script.number, Purpose.PHASE))


def report(
    script: Script, motion: Motion, boat: Listener, number: int, stamp_ns: int, t_s: float, seed: int
) -> Sighting | None:
    """What a boat receives of a report; None where it does not: out of range, lost, or in a gap.

    AIS tells what the vessel itself believes, the same to everybody. Positions are seen from the boat: where it is
    wrong about itself, it is wrong about the vessel by as much, and without its own position it has none.

    Args:
        script: the vessel
        motion: what it does
        boat: who listens
        number: of the report
        stamp_ns: when
        t_s: when, since the beginning [s]
        seed: of the simulation
    """
    sensed = script.sensed
    if isinstance(sensed, Lidar):
        return None
    if math.hypot(motion.x - boat.x, motion.y - boat.y) > sensed.range_m:
        return None
    if any(gap.from_s <= t_s < gap.to_s for gap in sensed.gaps):
        return None
    if uniform(seed, script.number, boat.number, number, Purpose.LOSS) < sensed.loss:
        return None
    if isinstance(sensed, Ais):
        h = mix(seed, script.number, number)
        vx, vy = motion.velocity
        lat_deg, lon_deg = boat.plane.to_geographic(
            motion.x + sensed.noise_m * normal(h, Purpose.NORTH), motion.y + sensed.noise_m * normal(h, Purpose.EAST)
        )
        return Sighting(
            stamp_ns=stamp_ns,
            source="ais",
            name=script.name,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            position_error_m=sensed.noise_m,
            v_north_mps=vx + sensed.velocity_noise_mps * normal(h, Purpose.V_NORTH),
            v_east_mps=vy + sensed.velocity_noise_mps * normal(h, Purpose.V_EAST),
            length_m=script.length_m if sensed.tells_size else math.nan,
        )
    if not boat.knows_itself:
        return None
    h = mix(seed, script.number, boat.number, number)
    wrong = 2.0 * uniform(seed, script.number, boat.number, Purpose.SIZE) - 1.0
    lat_deg, lon_deg = boat.plane.to_geographic(
        motion.x + boat.error_n + sensed.noise_m * normal(h, Purpose.NORTH),
        motion.y + boat.error_e + sensed.noise_m * normal(h, Purpose.EAST),
    )
    return Sighting(
        stamp_ns=stamp_ns,
        source="positions",
        name="",
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        position_error_m=sensed.noise_m,
        length_m=script.length_m * (1.0 + sensed.size_error * wrong),
    )
