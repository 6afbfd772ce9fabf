"""Wrong family files, and the message that each gets. The manual prints this table (docs/sweeps.md)."""

# ruff: noqa: E501 - one row, one line

from __future__ import annotations

FAMILY = """\
title = "Two boats meet"
boats = 2
cases = 100
seed = 7

[layout]
kind = "meeting"
cruise_mps = { even = [0.7, 1.5] }
late_s = { normal = [0.0, 2.0], within = [-3.0, 3.0] }
apart_m = 20.0

[radio]
loss = 0.1

[grid]
"keeping_clear.method" = ["scoring", "circle"]
"radio.delay_s" = [0.0, 0.5]

[checks]
collisions_max = 0
"""
"""A right family; every row below spoils it in one way."""

COLUMN = """\
title = "A column closes up"
boats = 3
cases = 100
duration_s = 200.0

[layout]
kind = "column"
along_m = { even = [-2.0, 2.0] }

[formation]
spacing_m = { even = [15.0, 20.0] }
cruise_mps = 1.0

[[timeline]]
at_s = 60.0
do = "set spacing"
value = 10.0
"""
"""A right family with a formation; spoilt by the rows of the second list."""

WRONG: tuple[tuple[str, str, str], ...] = (  # what stands there, what is written instead, the message
    # TOML and shape
    ("[radio]", "[radio", "line 12, column 7: Expected ']' at the end of a table declaration, in: [radio"),
    ("loss = 0.1", "los = 0.1", 'radio.los (line 13): unknown key; did you mean "loss"?'),
    ("boats = 2", "boats = 0", "boats = 0 (line 2): expected a whole number from 1 to 100"),
    ("boats = 2", "boats = 2.5", "boats = 2.5 (line 2): expected a whole number from 1 to 100"),
    ("boats = 2", "", "boats: missing, expected a whole number from 1 to 100"),
    ("cases = 100", "cases = 0", "cases = 0 (line 3): expected a whole number from 1 to 1000000"),
    ("cases = 100", "cases = 2000000", "cases = 2000000 (line 3): expected a whole number from 1 to 1000000"),
    ("seed = 7", "seed = -1", "seed = -1 (line 4): expected a whole number from 0 to 1000000000"),
    ("seed = 7", 'seed = "seven"', 'seed = "seven" (line 4): expected a whole number from 0 to 1000000000'),
    ("loss = 0.1", "loss = -0.1", "radio.loss = -0.1 (line 13): expected a number from 0 to 1"),
    ("loss = 0.1", "loss = nan", "radio.loss = nan (line 13): expected a number from 0 to 1"),
    ('kind = "meeting"', 'kind = "meting"', 'layout.kind = "meting" (line 7): expected one of meeting, circle, column, merging, anywhere, formations, circuit, wingman, vessels, imazu; did you mean "meeting"?'),
    ('kind = "meeting"', "", "layout.kind (line 6): missing, expected one of meeting, circle, column, merging, anywhere, formations, circuit, wingman, vessels, imazu"),
    ("apart_m = 20.0", "apart_m = true", "layout.apart_m = true (line 10): expected a number of at least 0"),
    # distributions
    ("even = [0.7, 1.5]", "even = [1.5, 0.7]", "layout.cruise_mps (line 8): even: low 1.5 above high 0.7"),
    ("even = [0.7, 1.5]", "even = [0.7]", "layout.cruise_mps (line 8): even: expected [low, high]"),
    ("even = [0.7, 1.5]", "even = 0.7", "layout.cruise_mps.even = 0.7 (line 8): expected a list"),
    ("even = [0.7, 1.5]", "evenly = [0.7, 1.5]", 'layout.cruise_mps.evenly (line 8): unknown key; did you mean "even"?'),
    ("even = [0.7, 1.5]", "even = [0.7, 1.5], one_of = [1.0, 1.2]", "layout.cruise_mps (line 8): expected exactly one of even, log_even, normal, one_of; got even and one_of"),
    ("{ even = [0.7, 1.5] }", "{ }", "layout.cruise_mps (line 8): expected exactly one of even, log_even, normal, one_of"),
    ("{ even = [0.7, 1.5] }", "{ one_of = [] }", "layout.cruise_mps (line 8): expected at least one number to choose from"),
    ("{ even = [0.7, 1.5] }", "{ log_even = [0.0, 1.5] }", "layout.cruise_mps (line 8): log_even: expected low above 0, got 0"),
    ("normal = [0.0, 2.0]", "normal = [0.0, -2.0]", "layout.late_s (line 9): normal: expected a standard deviation of at least 0, got -2"),
    ("within = [-3.0, 3.0]", "within = [90.0, 99.0]", "layout.late_s (line 9): within: no number of normal can come to lie there"),
    ("loss = 0.1", "loss = { even = [-0.1, 0.3] }", "radio.loss (line 13): numbers from -0.1 to 0.3 can come; expected 0 to 1"),
    # what cannot be sailed
    ("even = [0.7, 1.5]", "even = [0.7, 2.0]", "layout.cruise_mps (line 8): 0.7 to 2 m/s can come; expected 0 to 1.5 m/s, as boats can sail"),
    ("boats = 2", "boats = 30", "boats = 30 (line 2): in 100% of cases none of 100 draws begins with all boats 20 m apart"),
    ("apart_m = 20.0", "apart_m = 0.0\nmeet_s = 3.0", "layout (line 6): boats can begin 0.6 m apart; at least the safety radius, 6 m"),
    ("[radio]", '[[timeline]]\nat_s = 9.0\ndo = "hold"\n\n[radio]', "timeline[0] (line 12): only a formation takes commands; expected none"),
    ("seed = 7", 'seed = 7\nhull = "oter"', 'hull = "oter" (line 5): no such hull; did you mean "otter"?'),
    ("seed = 7", 'seed = 7\nhulls = ["unicycle", "oter"]', 'hulls[1] = "oter" (line 5): no such hull; did you mean "otter"?'),
    ("seed = 7", 'seed = 7\nhulls = ["otter", "otter"]', 'hulls[1] = "otter" (line 5): a hull before it is the same'),
    ('kind = "meeting"', 'kind = "anywhere"\nturn_deg = 120.0\nmeet_s = 4.0\nafter_s = 1.0', "layout.turn_deg = 120 (line 8): paths can bend with 1.7 m; boats need 4.3 m"),
    ("[radio]", "[formation]\nspacing_m = 15.0\ncruise_mps = 1.0\n\n[radio]", "formation (line 12): boats of a meeting sail each for itself; expected column or merging"),
    ("[radio]", "[keeping_clear]\nradius_m = 2.0\n\n[radio]", "keeping_clear.radius_m = 2 (line 13): hulls of 2.4 m touch within it; expected more"),
    ("[radio]", "[trouble]\nnot_avoiding = [3]\n\n[radio]", "trouble.not_avoiding[0] = 3 (line 13): no such boat; they are numbered 1 to 2"),
    ("[radio]", "[trouble]\nmute = [1]\n\n[radio]", "trouble.mute_at_s (line 12): missing: which boats are mute, and from when on, go together"),
    # the grid
    ('"radio.delay_s"', '"radio.delay"', 'grid.radio.delay (line 17): unknown key; did you mean "delay_s"?'),
    ('"radio.delay_s"', '"radios.delay_s"', 'grid.radios (line 15): unknown key; did you mean "duration_s"?'),
    ('"radio.delay_s"', '"title.delay_s"', "grid.title.delay_s (line 17): title.delay_s is the same at every point; it cannot be varied"),
    ('"radio.delay_s"', '"cases"', "grid.cases (line 17): cases is the same at every point; it cannot be varied"),
    ("[0.0, 0.5]", "[]", "grid.radio.delay_s = [] (line 17): expected at least one value"),
    ("[0.0, 0.5]", "0.5", "grid.radio.delay_s = 0.5 (line 17): expected a list of values"),
    ("[0.0, 0.5]", "[0.0, 0.5, -0.5]", "grid.radio.delay_s[2] = -0.5 (line 17): expected a number from 0 to 10"),
    ("[0.0, 0.5]", "[0.0, 60.0]", "grid.radio.delay_s[1] = 60 (line 17): expected a number from 0 to 10"),
    ("[0.0, 0.5]", "[0.5, 0.5]", "grid.radio.delay_s[1] = 0.5 (line 17): a value before it is the same"),
    ("[0.0, 0.5]", '[0.0, 0.1, 0.2, 0.3, 0.4]\n"layout.aside_m" = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]\nboats = [2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]', "grid (line 15): 1100 points; at most 1000"),
    ("[0.0, 0.5]", "[[0.0, 0.5]]", "grid.radio.delay_s[0] = [0, 0.5] (line 17): expected a number or text"),
    ('["scoring", "circle"]', '["scoring", "circel"]', 'grid.keeping_clear.method[1] = "circel" (line 16): no such method; did you mean "circle"?'),
    ('["scoring", "circle"]', "[true]", "grid.keeping_clear.method[0] = true (line 16): expected a number or text"),
    # checks
    ("collisions_max = 0", "colisions_max = 0", 'checks.colisions_max = 0 (line 20): no such check; did you mean "collisions_max"?'),
    ("collisions_max = 0", "collisions_max = -1", "checks.collisions_max = -1 (line 20): expected at least 0"),
    ("collisions_max = 0", "contacts_max = 0", "checks.contacts_max = 0 (line 20): there is no such figure without foreign vessels"),
    ("collisions_max = 0", "arrived_min = 99", "checks.arrived_min = 99 (line 20): expected at most 1"),
)  # fmt: skip

WRONG_COLUMN: tuple[tuple[str, str, str], ...] = (
    ("duration_s = 200.0", "", "duration_s: missing, a column has no goal and sails until the time is up"),
    ("spacing_m = { even = [15.0, 20.0] }", "spacing_m = 7.0", "formation.spacing_m = 7 (line 11): boats can come to be 7 m apart on one path; at least 8.0 m"),
    ("even = [15.0, 20.0]", "even = [-15.0, 15.0]", "formation.spacing_m (line 11): boats can come to be 0 m apart on one path; at least 8.0 m"),
    ("even = [15.0, 20.0]", "even = [-15.0, 15.0], within = [9.0, 15.0]", "formation.spacing_m (line 11): within: only with normal"),
    ("value = 10.0", "value = -7.5", "timeline[0].value = -7.5 (line 17): boats can come to be 7.5 m apart on one path; at least 8.0 m"),
    ("value = 10.0", "value = 10.0\ntimes = 0.5", "timeline[0] (line 14): set spacing: expected exactly one of value and times"),
    ("value = 10.0", "times = 0.5", "timeline[0].times = 0.5 (line 17): boats can come to be 7.5 m apart on one path; at least 8.0 m"),
    ("value = 10.0", "", "timeline[0] (line 14): set spacing: expected exactly one of value and times"),
    ('do = "set spacing"\nvalue = 10.0', 'do = "set speed"\nvalue = 1.45', "timeline[0].value = 1.45 (line 17): expected 0.1 to 1.4 m/s, as boats can sail in formation"),
    ("at_s = 60.0", "at_s = 260.0", "timeline[0].at_s = 260 (line 15): after the end, duration_s = 200"),
    ("cruise_mps = 1.0", "cruise_mps = 1.45", "formation.cruise_mps = 1.45 (line 12): expected 0.1 to 1.4 m/s, as boats can sail"),
    ("cruise_mps = 1.0", "cruise_mps = 1.0\nspeed_min_mps = 1.0", "formation.cruise_mps = 1 (line 12): expected 1.1 to 1.4 m/s, as boats can sail"),
    ("even = [-2.0, 2.0] }", "even = [-2.0, 2.0] }\nspeed_share = 2.0", "layout.speed_share = 2 (line 9): begins faster than speed_max_mps = 1.5"),
    ("even = [-2.0, 2.0]", "even = [-9.0, 9.0]", "layout (line 6): boats can begin 1.0 m apart; at least the safety radius, 6 m"),
    ("[formation]", "[keeping_clear.params]\nhorizon_s = 60.0\n\n[formation]", 'keeping_clear.params.horizon_s = 60 (line 11): scoring has no such number to tune; did you mean "horizon_min_s"?'),
    ("[formation]", "[trouble]\nstopped = [2]\n\n[formation]", "trouble.stopped (line 11): expected layout meeting or circle, where boats meet at a point"),
    ("[formation]\nspacing_m = { even = [15.0, 20.0] }\ncruise_mps = 1.0", "", "formation: missing, a column needs spacing_m and cruise_mps"),
    ('kind = "column"\nalong_m = { even = [-2.0, 2.0] }', 'kind = "circle"\nradius_m = 4.0', "formation (line 10): boats of a circle sail each for itself; expected column or merging"),
    ('kind = "column"\nalong_m = { even = [-2.0, 2.0] }', 'kind = "merging"\npaths = 4', "layout.paths = 4 (line 8): more than boats = 3"),
    ('kind = "column"\nalong_m = { even = [-2.0, 2.0] }', 'kind = "merging"\ncorner_radius_m = 2.0', "layout.corner_radius_m = 2 (line 8): boats need 4.3 m (1.5 m/s at 0.35 rad/s)"),
    ('kind = "column"', 'kind = "formations"', "timeline[0] (line 14): two formations take no commands; expected none"),
    ('kind = "column"\nalong_m = { even = [-2.0, 2.0] }', 'kind = "circuit"\ncorner_radius_m = 16.0', "layout.corner_radius_m = 16 (line 8): expected 4.3 m, as boats turn, to 15 m, half of the shorter side"),
    ('kind = "column"\nalong_m = { even = [-2.0, 2.0] }', 'kind = "circuit"\napart_m = 40.0', "layout.apart_m = 40 (line 8): 3 boats on a lap of 119.4 m; expected less"),
    ('kind = "column"\nalong_m = { even = [-2.0, 2.0] }', 'kind = "merging"\nmeet_s = 3.0', "layout.meet_s = 3 (line 8): boats begin in the bend; expected more"),
    ('kind = "column"', 'kind = "wingman"', "formation (line 10): layout.cruise_mps of a wingman's leader counts; expected none"),
)  # fmt: skip

SHIP = """\
title = "A formation meets a vessel"
boats = 3
cases = 100

[layout]
kind = "vessels"
vessels = { one_of = [1, 2] }

[formation]
spacing_m = 10.0
cruise_mps = 1.0

[radio]
loss = 0.1

[checks]
contacts_max = 0
"""
"""A right family with foreign vessels; spoilt by the rows of the third list."""

WRONG_SHIP: tuple[tuple[str, str, str], ...] = (
    ("one_of = [1, 2]", "one_of = [0, 2]", "layout.vessels (line 7): expected 1 to 8"),
    ("one_of = [1, 2]", "even = [1, 9]", "layout.vessels (line 7): expected 1 to 8"),
    ("vessels = { one_of = [1, 2] }", 'sensor = "radar"', 'layout.sensor = "radar" (line 7): expected one of ais, exact, mixed, positions'),
    ('kind = "vessels"\nvessels = { one_of = [1, 2] }', 'kind = "imazu"\ngeometry = 23', "layout.geometry = 23 (line 7): expected a whole number from 1 to 22"),
    ("[formation]\nspacing_m = 10.0\ncruise_mps = 1.0", "", "formation: missing, 3 boats that meet vessels need spacing_m and cruise_mps"),
    ("boats = 3", "boats = 1", "formation (line 9): one boat is none; expected boats of at least 2"),
    ("spacing_m = 10.0", "spacing_m = 7.0", "formation.spacing_m = 7 (line 10): boats can come to be 7 m apart; at least 8.0 m"),
    ("cruise_mps = 1.0", "cruise_mps = 1.45", "formation.cruise_mps = 1.45 (line 11): expected 0.1 to 1.4 m/s, as boats can sail"),
    ("loss = 0.1", "clock_error_s = 0.1", "radio.clock_error_s = 0.1 (line 14): not with foreign vessels; expected none"),
    ("[radio]", "[trouble]\nnot_avoiding = [1]\n\n[radio]", "trouble (line 13): not with foreign vessels; expected none"),
    ("[radio]", '[keeping_clear]\nmethod = "circle"\n\n[radio]', 'keeping_clear.method = "circle" (line 14): not with foreign vessels; expected none'),
    ("vessels = { one_of = [1, 2] }", "bend_deg = 40.0\nbank_m = 15.0", "layout.bank_m = 15 (line 8): the path bends; a bank lies beside a straight one"),
    ("vessels = { one_of = [1, 2] }", "bend_deg = 40.0\nbend_before_s = 130.0", "layout.bend_before_s = 130 (line 8): before the start; expected less than meet_s"),
    ("vessels = { one_of = [1, 2] }", "crossing_deg = 90.0", "formation (line 9): boats that cross each other are none; expected layout.crossing_deg or formation"),
    ("contacts_max = 0", "standstills_max = 0", "checks.standstills_max = 0 (line 17): there is no such figure with foreign vessels"),
)  # fmt: skip

WRONG_SETS: tuple[tuple[str, str], ...] = (  # after --set, with the first family; the message
    ("boats", '--set = "boats": expected dotted.key=value'),
    ("boats=0", "boats = 0 (--set): expected a whole number from 1 to 100"),
    ("radio.los=0.2", "radio.los (--set): unknown key; known: clock_error_s"),
    ("radio.loss=lots", 'radio.loss = "lots" (--set): expected a number from 0 to 1'),
    ("title.short=x", "title.short (line 1): cannot be set: title is a single value"),
    ("layout.cruise_mps.even=[2, 1]", "layout.cruise_mps (line 8): even: low 2 above high 1"),
    ("grid.radio.loss=0.2", "grid.radio.loss = 0.2 (--set): expected a list of values"),
    ("checks.collisions_max=none", 'checks.collisions_max = "none" (--set): expected a number'),
)


def tables() -> list[str]:
    """The rows as the manual prints them."""
    both = [_table("| right | wrong | message |", rows) for rows in (WRONG, WRONG_COLUMN, WRONG_SHIP)]
    lines = [
        "| `--set` | message |",
        "|---|---|",
        *(f"| {_code(given)} | {_code(text)} |" for given, text in WRONG_SETS),
    ]
    return [*both, "\n".join(lines)]


def _table(head: str, rows: tuple[tuple[str, str, str], ...]) -> str:
    lines = [head, "|---|---|---|"]
    for right, wrong, message in rows:
        lines.append(f"| {_code(right)} | {_code(wrong) or '(left out)'} | {_code(message)} |")
    return "\n".join(lines)


def _code(text: str) -> str:
    """TOML in a cell of a table."""
    return "<br>".join(f"`{line.strip()}`" for line in text.split("\n") if line.strip())
