"""Missions by name, with overrides, for N boats, and over the wire."""

from __future__ import annotations

import tomllib
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet.errors import MissionError, UsageError
from fleet.mission.check import check
from fleet.mission.load import decode, encode, examine, load, multiply, ready, text_of
from fleet.mission.problem import Key
from fleet.mission.toml_lines import key_lines

READY = (
    "barge",
    "circuit",
    "comes-back",
    "harbour",
    "late-joiner",
    "overtaking",
    "overtaking-circle",
    "patterns",
    "ship",
    "survey-column",
    "swath",
    "three-crossing",
    "wingman",
    "wingman-circle",
    "wingman-colregs",
)

plain: Any = st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.floats() | st.text(max_size=8)
trees = st.recursive(
    plain,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


def test_the_ready_missions_are_listed_with_their_titles() -> None:
    assert tuple(ready()) == READY
    assert ready()["overtaking"].endswith("the one behind overtakes")


FIT = {"swath": 5, "wingman": 3, "wingman-circle": 2, "wingman-colregs": 2}
"""Abreast the turns have room for so many; wingmen need paths of their own."""


@pytest.mark.parametrize("name", READY)
def test_a_ready_mission_has_neither_problems_nor_warnings(name: str) -> None:
    _, findings = examine(name)
    assert findings.problems == ()
    assert all("come within" in text for text in findings.warnings)
    assert len(findings.warnings) == (3 if name == "three-crossing" else 0)  # each two of them meet, which is its point


@pytest.mark.parametrize("name", READY)
def test_what_goes_over_the_wire_comes_out_alike(name: str) -> None:
    mission = load(name)
    content = encode(mission)
    assert decode(content) == mission
    assert encode(decode(content)) == content


def test_equal_missions_give_equal_bytes_in_whatever_order_they_were_written() -> None:
    mission = load("overtaking")
    other = msgspec.structs.replace(mission, checks=dict(reversed(mission.checks.items())))
    assert list(other.checks) != list(mission.checks)
    assert encode(other) == encode(mission)


@given(st.binary(max_size=64))
def test_bytes_that_are_no_mission_are_refused(content: bytes) -> None:
    with pytest.raises(MissionError):
        decode(content)


@settings(max_examples=200)
@given(st.data())
def test_one_spoilt_value_is_refused_by_name_or_does_no_harm(data: st.DataObject) -> None:
    tree = msgspec.to_builtins(load("overtaking"))
    here, path = tree, []
    while isinstance(here, dict | list) and here and (not path or data.draw(st.booleans())):
        key = data.draw(st.sampled_from(sorted(here) if isinstance(here, dict) else range(len(here))))
        path.append(key)
        parent, here = here, here[key]
    parent[key] = data.draw(trees)
    found: tuple[str, ...] = ()
    try:
        check(decode(msgspec.msgpack.encode(tree)))  # finds problems or does not, but never fails
    except MissionError as error:
        found = error.problems
    assert all(str(path[0]) in problem for problem in found)


def test_a_received_mission_tells_every_misfit() -> None:
    tree = msgspec.to_builtins(load("overtaking"))
    tree["formation"]["spacing_m"] = float("inf")
    tree["boats"][1]["name"] = "b2\n"
    with pytest.raises(MissionError) as caught:
        decode(msgspec.msgpack.encode(tree))
    assert caught.value.problems == (
        "boats[1].name = 'b2\\n': expected a name of 1 to 32 characters a-z, 0-9 or -",
        "formation.spacing_m = inf: expected a number",
    )


def test_overrides_change_tables_entries_and_boats_by_name() -> None:
    mission = load(
        "overtaking",
        [
            "formation.spacing_m=18",
            "boats.b1.limits.speed_max_mps=2",
            "boats.1.start.s_m=22",
            "timeline.0.value = -18",
            "keeping_clear.method=circle",
            "radio.loss=0.1",
            "fence.points=[[-60.0,-70.0],[400.0,-70.0],[400.0,70.0],[-60.0,70.0],[-70.0,0.0]]",
        ],
    )
    assert mission.formation.spacing_m == 18.0
    assert mission.boats[0].limits.speed_max_mps == 2.0
    assert mission.boats[1].start.s_m == 22.0
    assert mission.timeline[0].value == -18.0
    assert mission.keeping_clear.method == "circle"
    assert mission.radio.loss == 0.1
    assert mission.fence is not None
    assert len(mission.fence.points) == 5


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("formation.spacing_m", '--set = "formation.spacing_m": expected dotted.key=value'),
        ("formation.spacng_m=3", 'formation.spacng_m (--set): unknown key; known: gain_per_m'),
        ("formation.spacing_m=wide", 'formation.spacing_m = "wide" (--set): expected a number'),
        ("formation.spacing_m=3", "formation.spacing_m = 3 (--set): b1 and b2 are 3.0 m apart on path line; at least"),
        ("boats.b7.slot=2", "boats.b7 (line 13): no such entry in boats: it has 2 entries, counted from 0; known: b1"),
        ("timeline.1.value=2", "timeline.1 (line 38): no such entry in timeline: it has 1 entries, counted from 0"),
        ("title.x=2", "title.x (line 3): cannot be set: title is a single value"),
        ('title="a\\nb"', "title = 'a\\nb' (--set): expected one line of printable text"),
    ],
)  # fmt: skip
def test_a_wrong_override_says_what_is_wrong(override: str, message: str) -> None:
    with pytest.raises(MissionError) as caught:
        load("overtaking", [override])
    assert any(problem.startswith(message) for problem in caught.value.problems), caught.value.problems


def leaves(value: Any, key: Key = ()) -> set[Key]:
    if isinstance(value, dict | list) and value:
        items = value.items() if isinstance(value, dict) else enumerate(value)
        return set().union(*(leaves(item, (*key, k)) for k, item in items))
    return {key}


AWKWARD = '''\
a."b c".d = 1 # [not.a.table]
"e" = """
[nor = this]
"""
'f'={ g = [1, { h = "}" }], i.j = 2 }
[[k]]
l = [ # a comment, with ]
  [1, 2],
  '#',
]
[k.m]
n = 1979-05-27T07:32:00Z
[[k.o]]
p = true
[[k.o]]
p = """x"""" # one quote and three
[[k]]
l = -1e-3
'''


@pytest.mark.parametrize("text", [*(text_of(name) for name in READY), AWKWARD], ids=[*READY, "awkward"])
def test_the_line_of_every_value_is_found(text: str) -> None:
    lines = key_lines(text)
    assert leaves(tomllib.loads(text)) <= set(lines)


def test_lines_count_from_one_through_comments_and_long_texts() -> None:
    lines = key_lines(AWKWARD)
    assert lines[("a", "b c", "d")] == 1
    assert lines[("f", "g", 1, "h")] == lines[("f", "i", "j")] == 5
    assert lines[("k", 0, "l", 1)] == 9
    assert lines[("k", 0, "o", 1, "p")] == 16
    assert lines[("k", 1, "l")] == 18


@pytest.mark.parametrize("name", READY)
@pytest.mark.parametrize("boats", [1, 2, 3, 5, 10])
def test_a_ready_mission_sails_with_any_reasonable_number_of_boats(name: str, boats: int) -> None:
    mission, findings = examine(name, boats=boats)
    most = FIT.get(name, boats)
    assert (findings.problems == ()) == (boats <= most)
    assert [boat.name for boat in mission.boats] == [f"b{i + 1}" for i in range(boats)]


def test_more_boats_continue_the_column_behind_and_all_move_ahead_onto_the_path() -> None:
    boats = multiply(load("overtaking"), 4).boats
    assert [boat.slot for boat in boats] == [1.0, 0.0, -1.0, -2.0]
    assert [boat.start.s_m for boat in boats] == [60.0, 40.0, 20.0, 0.0]


def test_more_boats_on_a_circuit_begin_behind_the_last_slot() -> None:
    boats = multiply(load("circuit"), 5).boats
    assert [boat.start.s_m for boat in boats] == pytest.approx([30.0, 15.0, 110.0, 100.0, 90.0])


def test_fewer_boats_leave_the_timeline_without_those_that_stay_at_home() -> None:
    mission = multiply(load("late-joiner"), 2)
    assert mission.timeline == ()


def test_boats_that_a_path_has_no_room_for_are_refused_with_the_length() -> None:
    with pytest.raises(MissionError, match="from b20 to b1 the formation is 380 m long, path line only 280 m"):
        load("overtaking", boats=20)


@pytest.mark.parametrize("boats", [0, -1, 1001])
def test_a_fleet_of_none_or_too_many_is_refused(boats: int) -> None:
    with pytest.raises(UsageError, match="expected 1 to 1000"):
        load("overtaking", boats=boats)
