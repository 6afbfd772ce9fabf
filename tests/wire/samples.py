"""One message of each kind, every field different."""

from __future__ import annotations

from typing import Any

from fleet.wire.messages import (
    MAJOR,
    Ack,
    BoatState,
    BoatStatus,
    Command,
    Echo,
    FleetEvent,
    ForeignOrder,
    FormationOrder,
    Frames,
    Held,
    MissionOrder,
    Revision,
    Signed,
    Stops,
)

STATE = BoatState(
    major=MAJOR,
    boat="b1",
    epoch=1_700_000_000_000_000_001,
    seq=42,
    stamp_ns=1_700_000_004_200_000_000,
    clock_ns=50_000_000,
    lat_deg=44.38,
    lon_deg=8.93,
    cog_rad=0.1,
    sog_mps=1.01,
    heading_rad=0.11,
    yaw_rate_radps=-0.02,
    position_error_m=0.5,
    lap=1,
    s_m=123.25,
    mode=2,
    reasons=1 << 18,
    plan_course_rad=0.12,
    plan_speed_mps=1.02,
    tangent_rad=0.13,
    straight_s=60.0,
    decided_yaw_rate_radps=0.14,
    decided_speed_mps=0.9,
    cross_track_m=-0.25,
    along_path_m=0.75,
    nearest="b2",
    nearest_m=11.5,
    mission_id="1700-anna",
    in_force=Revision(1, "anna"),
    held=Revision(2, "bob"),
    stops=("s1", "s2"),
    simulated=True,
    control=Revision(3, "carl"),
    length_m=2.5,
    foreign=ForeignOrder(
        serial=3,
        apply_ns=1_700_000_000_700_000_000,
        acting=True,
        offset_rad=0.75,
        factor=0.5,
        course_rad=1.5,
        sense=1.0,
        path_rad=0.75,
        reason=1,
        vessel="ferry",
    ),
)
STATUS = BoatStatus(
    major=MAJOR,
    boat="b1",
    epoch=17,
    stamp_ns=18,
    version="0.1.0",
    mode="avoid",
    reasons=("keeping clear",),
    mission_id="1700-anna",
    mission_title="Two boats",
    controller="anna",
    spacing_m=20.0,
    cruise_mps=1.0,
    battery_percent=80.0,
    peers=1,
    ticks=100,
    ticks_late=2,
    worst_late_ms=1.5,
    messages_heard=99,
    messages_lost=3,
    messages_refused=4,
    requests_refused=5,
    recording="disk full",
    driver="bus off",
    hull="unicycle",
    refusals=("4 x not finite",),
    switched_ns=19,
)
PLACES = (("b1", 0.0), ("b2", -1.0))
FORMATION = FormationOrder(
    MAJOR, "1700-anna", Revision(2, "bob"), Revision(1, "anna"), -20.0, 1.0, 2.5, 21, "wedge", 12.0, PLACES
)
MISSION = MissionOrder(MAJOR, "1700-anna", "anna", 22, b"\x80", 3.0)
SIGNED = Signed(b"body", b"signature", "operator.anna.00ff")
HELD = Held(MAJOR, SIGNED, 1.5)
COMMAND = Command(MAJOR, "id-1", "anna", "set", ("b1",), SIGNED, ("s1",), "nearest", "1700-anna", 23)
ACK = Ack(MAJOR, "id-1", "b1", False, "why", "old", "new", "0.1.0", True)
EVENT = FleetEvent(MAJOR, "b1", 24, "mode", "follow -> avoid", 2.0)
ECHO = Echo(MAJOR, 25)
FRAMES = Frames(MAJOR, "anna", b"\xfe\x00\x01", "b1", 26)
STOPS = Stops(MAJOR, (SIGNED,))
SAMPLES: dict[str, Any] = {
    type(message).__name__: message
    for message in (STATE, STATUS, FORMATION, MISSION, SIGNED, HELD, COMMAND, ACK, EVENT, ECHO, STOPS, FRAMES)
}
