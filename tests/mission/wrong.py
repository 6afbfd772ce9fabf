"""Wrong missions, and the message that each gets. The manual prints this table (docs/missions.md)."""

# ruff: noqa: E501 - one row, one line

from __future__ import annotations

MISSION = """\
title = "Two boats in column"
datum = { lat_deg = 44.38, lon_deg = 8.93 }
duration_s = 100.0
home = [-20.0, 0.0]

[paths.line]
kind = "straight"
start = [0.0, 0.0]
end = [200.0, 0.0]

[[boats]]
name = "b1"
path = "line"
slot = 1.0
start = { s_m = 30.0 }

[[boats]]
name = "b2"
path = "line"
slot = 0.0
start = { s_m = 10.0 }

[formation]
spacing_m = 20.0
cruise_mps = 1.0

[fence]
points = [[-50.0, -50.0], [250.0, -50.0], [250.0, 50.0], [-50.0, 50.0]]

[[timeline]]
at_s = 20.0
do = "set spacing"
value = 15.0

[checks]
collisions = 0
"""
"""A right mission; every row below spoils it in one way."""

B1_START = "start = { s_m = 30.0 }"
B2_START = "start = { s_m = 10.0 }"
CHANGE = 'do = "set spacing"\nvalue = 15.0'

SHIP = """\
[[traffic]]
name = "mv"
length_m = 40.0
speed_mps = 5.0
track = { kind = "course", start = [200.0, 90.0], course_deg = 270.0 }
"""
"""Another vessel, put in before the checks."""


def ship(right: str = "", wrong: str = "", *more: str) -> str:
    """The vessel spoilt in one place, or with a further line."""
    return SHIP.replace(right, wrong, 1) + "".join(f"{line}\n" for line in more) + "\n[checks]"


WRONG: tuple[tuple[str, str, str], ...] = (  # what stands there, what is written instead, the message
    # TOML
    ("[formation]", "[formation", "line 23, column 11: Expected ']' at the end of a table declaration, in: [formation"),
    ('name = "b1"', 'name = "b1', "line 12, column 11: Illegal character '\\n', in: name = \"b1"),
    ("duration_s = 100.0", "duration_s = ", "line 3, column 14: Invalid value, in: duration_s ="),
    # shape
    ("spacing_m = 20.0", "spacing = 20.0", 'formation.spacing (line 24): unknown key; did you mean "spacing_m"?'),
    ("cruise_mps = 1.0", "", "formation.cruise_mps (line 23): missing, expected a number above 0"),
    ("cruise_mps = 1.0", "cruise_mps = -1", "formation.cruise_mps = -1 (line 25): expected a number above 0"),
    ("spacing_m = 20.0", 'spacing_m = "20 m"', 'formation.spacing_m = "20 m" (line 24): expected a number'),
    ("spacing_m = 20.0", "spacing_m = nan", "formation.spacing_m = nan (line 24): expected a number"),
    ("lat_deg = 44.38", "lat_deg = 144.38", "datum.lat_deg = 144.38 (line 2): expected a number from -90 to 90"),
    ('name = "b2"', 'name = "B 2"', 'boats[1].name = "B 2" (line 18): expected a name of 1 to 32 characters a-z, 0-9 or -'),
    ('kind = "straight"', 'kind = "strait"', 'paths.line.kind = "strait" (line 7): expected one of straight, arc, polyline, sine, through; did you mean "straight"?'),
    ('kind = "straight"', "", "paths.line.kind (line 6): missing, expected one of straight, arc, polyline, sine, through"),
    ("end = [200.0, 0.0]", "end = [200.0]", "paths.line.end = [200] (line 9): expected [north_m, east_m] from the datum or { lat_deg = , lon_deg = }"),
    ("end = [200.0, 0.0]", "end = [200.0, true]", "paths.line.end[1] = true (line 9): expected a number"),
    ("[250.0, 50.0], [-50.0, 50.0]]", "]", "fence.points (line 28): expected at least 3 entries, got 2"),
    ("[checks]", '[lost]\noperator = "panic"\n\n[checks]', 'lost.operator = "panic" (line 36): expected one of continue, hold, return'),
    # names
    ('name = "b2"', 'name = "b1"', 'boats[1].name = "b1" (line 18): a boat before it has this name'),
    ('path = "line"\nslot = 0.0', 'path = "lime"\nslot = 0.0', 'boats[1].path = "lime" (line 19): no such path; did you mean "line"?'),
    ("slot = 0.0", 'slot = 0.0\nhull = "oter"', 'boats[1].hull = "oter" (line 21): no such hull; did you mean "otter"?'),
    ("[checks]", '[keeping_clear]\nmethod = "scorin"\n\n[checks]', 'keeping_clear.method = "scorin" (line 36): no such method; did you mean "scoring"?'),
    ("collisions = 0", "colisions = 0", 'checks.colisions = 0 (line 36): no such check; did you mean "collisions"?'),
    ('do = "set spacing"', 'do = "set spaceing"', 'timeline[0].do = "set spaceing" (line 32): no such action; did you mean "set spacing"?'),
    (CHANGE, 'do = "kill"\nboats = ["b3"]', 'timeline[0].boats[0] = "b3" (line 33): no such boat; known: b1, b2'),
    # paths
    ("end = [200.0, 0.0]", "end = [0.0, 0.0]", "paths.line (line 6): points 1 and 2 coincide at [0.00, 0.00] m; expected neighbours apart from each other"),
    ("end = [200.0, 0.0]", "end = { lat_deg = 8.93, lon_deg = 44.38 }", "paths.line.end = [8.93, 44.38] (line 9): 4644 km from the datum; at most 50 km; are latitude and longitude swapped?"),
    ('kind = "straight"', 'kind = "sine"\namplitude_m = 15.0\nwavelength_m = 30.0', "paths.line (line 6): bends with a radius of 1.5 m; b1 (and 1 more) needs 4.3 m (1.5 m/s at 0.35 rad/s)"),
    ('kind = "straight"', 'kind = "sine"\namplitude_m = 15.0\nwavelength_m = 1e-6', "paths.line.wavelength_m = 1e-06 (line 9): expected a number of at least 1"),
    # boats
    ("slot = 0.0", "slot = 1.0", "boats[1].slot = 1 (line 20): b1 has this slot on path line"),
    (B2_START, "start = { }", "boats[1].start (line 21): expected position and heading_deg, or s_m on its path"),
    (B2_START, "start = { position = [10.0, 0.0] }", "boats[1].start.heading_deg (line 21): missing, needed with position: degrees clockwise from north"),
    (B2_START, "start = { s_m = 10.0, heading_deg = 90 }", "boats[1].start.heading_deg = 90 (line 21): only with position: with s_m the boat heads along its path"),
    (B2_START, "start = { s_m = 210.0 }", "boats[1].start.s_m = 210 (line 21): path line goes from 0 to 200.0 m"),
    (B2_START, "start = { s_m = 26.0 }", "boats[1].start (line 21): b2 begins 4.0 m from b1; at least the safety radius, 6.0 m"),
    (B2_START, "start = { s_m = 10.0, speed_mps = 2.0 }", "boats[1].start.speed_mps = 2 (line 21): faster than speed_max_mps = 1.5"),
    ("slot = 0.0", "slot = 0.0\nlimits = { speed_min_mps = 1.6 }", "boats[1].limits.speed_min_mps = 1.6 (line 21): expected at least 0.2 m/s below speed_max_mps = 1.5"),
    # formation
    ("spacing_m = 20.0", "spacing_m = 7.0", "formation.spacing_m = 7 (line 24): b1 and b2 are 7.0 m apart on path line; at least 8.0 m"),
    ("spacing_m = 20.0", "spacing_m = 200.0", "formation.spacing_m = 200 (line 24): from b2 to b1 the formation is 200 m long, path line only 200 m"),
    ("cruise_mps = 1.0", "cruise_mps = 1.45", "formation.cruise_mps = 1.45 (line 25): b1 (and 1 more) needs 0.1 to 1.4 m/s to keep its place"),
    ("[checks]", "[environment]\ngnss_sigma_m = 3.5\n\n[checks]", "timeline[0].value = 15 (line 33): b1 and b2 are 15.0 m apart on path line; at least 16.4 m"),
    ("[checks]", "[keeping_clear]\nradius_m = 2.0\n\n[checks]", "keeping_clear.radius_m = 2 (line 36): hulls of 2.4 m touch within it; expected more"),
    # patterns
    ("cruise_mps = 1.0", 'cruise_mps = 1.0\npattern = "wegde"', 'formation.pattern = "wegde" (line 26): expected one of abreast, column, echelon, wedge, wingman'),
    (CHANGE, 'do = "set lateral"\nvalue = 6.0\n\n[[timeline]]\nat_s = 30.0\ndo = "set pattern"\nvalue = "abreast"', 'timeline[1].value = "abreast" (line 38): b1 and b2 are 6.0 m apart on path line; at least 8.0 m'),
    (CHANGE, 'do = "set lateral"\nvalue = 60.0\n\n[[timeline]]\nat_s = 30.0\ndo = "set pattern"\nvalue = "abreast"', 'timeline[1].value = "abreast" (line 38): the lane 60 m to starboard of path line leaves the fence at 0 m, at [0.0, 60.0] m'),
    ("cruise_mps = 1.0", 'cruise_mps = 1.0\nvacancies = "fill"', 'formation.vacancies = "fill" (line 26): expected one of close-up, keep-gaps'),
    (CHANGE, 'do = "set pattern"\nvalue = "echelom"', """timeline[0].value = "echelom" (line 33): pattern 'echelom': no such pattern; did you mean "echelon"?"""),
    (CHANGE, 'do = "set pattern"\nvalue = 3', "timeline[0].value = 3 (line 33): expected text: one of column, abreast, echelon, wedge, wingman"),
    (CHANGE, 'do = "set spacing"\nvalue = "wide"', 'timeline[0].value = "wide" (line 33): expected a number: metres'),
    (CHANGE, 'do = "set leader"\nvalue = "b3"', "timeline[0].value = \"b3\" (line 33): leader 'b3': no such boat; known: b1, b2"),
    (CHANGE, 'do = "set slots"\nvalue = "b2=1"', 'timeline[0].value = "b2=1" (line 33): b1 and b2 both have slot 1 on path line'),
    (CHANGE, 'do = "set slots"\nvalue = "b2"', "timeline[0].value = \"b2\" (line 33): slots 'b2': expected BOAT=SLOT, such as b1=0, a number up to 1000"),
    # fence and home
    (B2_START, "start = { s_m = 10.0, offset_m = 60.0 }", "boats[1].start (line 21): outside the fence, at [10.0, 60.0] m"),
    ("home = [-20.0, 0.0]", "home = [-70.0, 0.0]", "home = [-70, 0] (line 4): outside the fence"),
    ("end = [200.0, 0.0]", "end = [260.0, 0.0]", "paths.line (line 6): leaves the fence at 250 m of its length, at [250.0, 0.0] m"),
    ("[250.0, -50.0], [250.0, 50.0]", "[250.0, 50.0], [250.0, -50.0]", "fence.points (line 28): crosses itself: the edges that begin at points 1 and 3 meet"),
    ("home = [-20.0, 0.0]", 'lost = { operator = "return" }', "home: missing, needed because lost.operator is return"),
    ("[checks]", "[battery]\ncritical_percent = 30\n\n[checks]", "battery.critical_percent = 30 (line 36): above reserve_percent = 20"),
    # timeline
    ("at_s = 20.0", "at_s = 200.0", "timeline[0].at_s = 200 (line 31): after the end, duration_s = 100"),
    ("value = 15.0", "", "timeline[0].value (line 30): missing, set spacing needs one: metres"),
    ("value = 15.0", "value = -5.0", "timeline[0].value = -5 (line 33): b1 and b2 are 5.0 m apart on path line; at least 8.0 m"),
    ("value = 15.0", 'value = 15.0\nboats = ["b1"]', 'timeline[0].boats = ["b1"] (line 34): set spacing concerns the whole fleet; expected none'),
    ('do = "set spacing"', 'do = "hold"', "timeline[0].value = 15 (line 33): hold takes no value"),
    ('do = "set spacing"', 'do = "set speed"', "timeline[0].value = 15 (line 33): b1 (and 1 more) needs 0.1 to 1.4 m/s to keep its place"),
    (CHANGE, 'do = "forget"', "timeline[0].boats (line 30): missing, forget needs the names of boats"),
    (CHANGE, 'do = "battery"\nvalue = 120', "timeline[0].value = 120 (line 33): expected percent, from 0 to 100"),
    # checks
    ("collisions = 0", "collisions = -1", "checks.collisions = -1 (line 36): expected at least 0"),
    ("collisions = 0", "min_separation_m = 25", "checks.min_separation_m = 25 (line 36): cannot be kept: slots are 15 m apart"),
    ("collisions = 0", "speed_max_mps = 0.8", "checks.speed_max_mps = 0.8 (line 36): cannot be kept: cruise is 1 m/s"),
    ("collisions = 0", "finished = 0", "checks.finished = 0 (line 36): expected 1"),
    # other vessels
    ("[checks]", ship("40.0", "140.0"), "traffic[0].length_m = 140 (line 37): expected a number from 5 to 100"),
    ("[checks]", ship("5.0", "9.0"), "traffic[0].speed_mps = 9 (line 38): expected a number from 0 to 8"),
    ("[checks]", ship('"mv"', '"b1"'), 'traffic[0].name = "b1" (line 36): a boat has this name'),
    ("[checks]", ship(", course_deg = 270.0", ""), "traffic[0].track.course_deg (line 39): missing, expected a number"),
    ("[checks]", ship('"course"', '"circle"'), 'traffic[0].track.kind = "circle" (line 39): expected one of course, waypoints'),
    ("[checks]", ship('"course", start = [200.0, 90.0], course_deg = 270.0', '"waypoints", points = [[200.0, 90.0], [200.0, 90.5]]'), "traffic[0].track.points (line 39): points 1 and 2 are less than 1 m apart"),
    ("[checks]", ship("[200.0, 90.0]", "[34.0, 5.0]"), "traffic[0].track (line 39): begins 6.4 m from b1; their hulls need 21.2 m"),
    ("[checks]", ship("", "", 'changes = [{ at_s = 50.0, do = "sink" }]'), 'traffic[0].changes[0].do = "sink" (line 40): expected one of speed, stop, turn'),
    ("[checks]", ship("", "", 'changes = [{ at_s = 50.0, do = "turn" }]'), "traffic[0].changes[0].value (line 40): missing, turn needs one: degrees, + to starboard"),
    ("[checks]", ship("", "", 'changes = [{ at_s = 50.0, do = "turn", value = 270.0 }]'), "traffic[0].changes[0].value = 270 (line 40): expected -180 to 180 degrees, and not 0"),
    ("[checks]", ship("", "", 'changes = [{ at_s = 50.0, do = "stop", value = 1.0 }]'), "traffic[0].changes[0].value = 1 (line 40): stop takes no value"),
    ("[checks]", ship("", "", 'changes = [{ at_s = 50.0, do = "speed", value = 20.0 }]'), "traffic[0].changes[0].value = 20 (line 40): expected a number from 0 to 8"),
    ("[checks]", ship("", "", 'changes = [{ at_s = 500.0, do = "stop" }]'), "traffic[0].changes[0].at_s = 500 (line 40): after the end, duration_s = 100"),
    ("[checks]", ship("", "", 'sensed = { kind = "radar" }'), 'traffic[0].sensed.kind = "radar" (line 40): expected one of ais, positions, lidar; did you mean "lidar"?'),
    ("[checks]", ship("", "", 'sensed = { kind = "ais", interval_s = 1.0 }'), "traffic[0].sensed.interval_s = 1 (line 40): expected a number from 2 to 10"),
    ("[checks]", ship("", "", 'sensed = { kind = "positions", loss = 2.0 }'), "traffic[0].sensed.loss = 2 (line 40): expected a number from 0 to 1"),
    ("[checks]", ship("", "", 'sensed = { kind = "ais", gaps = [{ from_s = 30.0, to_s = 20.0 }] }'), "traffic[0].sensed.gaps[0].to_s = 20 (line 40): expected after from_s = 30"),
)  # fmt: skip


def table() -> str:
    """The rows as the manual prints them."""
    lines = ["| right | wrong | message |", "|---|---|---|"]
    for right, wrong, message in WRONG:
        lines.append(f"| {_code(right)} | {_code(wrong) or '(left out)'} | {_code(message)} |")
    return "\n".join(lines)


def _code(text: str) -> str:
    """TOML in a cell of a table."""
    return "<br>".join(f"`{line.strip()}`" for line in text.split("\n") if line.strip())
