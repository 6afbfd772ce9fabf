"""Every wrong mission gets its message, and all of them at once."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from msgspec import Struct

from fleet.errors import MissionError
from fleet.guidance.limits import Limits
from fleet.mission import model
from fleet.mission.load import examine, load
from fleet.mission.model import Mission

from .manual import action_table, check_table, ready_table
from .wrong import MISSION, WRONG, table

MANUAL = Path(__file__).parents[2] / "docs" / "missions.md"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "mission.toml"


def problems_of(file: Path, text: str) -> tuple[str, ...]:
    file.write_text(text, encoding="utf-8")
    with pytest.raises(MissionError) as caught:
        load(file)
    return caught.value.problems


def test_the_mission_that_the_table_spoils_is_right(file: Path) -> None:
    file.write_text(MISSION)
    _, findings = examine(file)
    assert findings.problems == findings.warnings == ()


@pytest.mark.parametrize(("right", "wrong", "message"), WRONG, ids=[message[:60] for _, _, message in WRONG])
def test_a_wrong_mission_gets_its_message(file: Path, right: str, wrong: str, message: str) -> None:
    assert MISSION.count(right) == 1
    assert problems_of(file, MISSION.replace(right, wrong)) == (message,)


@pytest.mark.parametrize("part", [MISSION, table(), ready_table(), action_table(), check_table()])
def test_the_manual_prints_what_the_code_does(part: str) -> None:
    assert part in MANUAL.read_text(encoding="utf-8")


def test_the_manual_explains_every_key() -> None:
    words = set(re.findall(r"[a-z_0-9]+", MANUAL.read_text(encoding="utf-8")))
    kinds: list[type[Struct]] = [Mission, Limits]
    kinds += [kind for kind in vars(model).values() if isinstance(kind, type) and issubclass(kind, Struct)]
    assert {name for kind in kinds for name in kind.__struct_fields__} <= words


def test_the_example_in_the_manual_can_be_sailed(file: Path) -> None:
    file.write_text(MANUAL.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0])
    _, findings = examine(file)
    assert findings.problems == findings.warnings == ()


def test_every_problem_of_the_shape_is_reported_at_once(file: Path) -> None:
    text = MISSION.replace("spacing_m = 20.0", "spacing_m = true").replace('kind = "straight"', 'kind = "line"')
    text = text.replace("slot = 0.0", 'slot = "last"').replace("collisions = 0", 'collisions = "none"')
    assert len(problems_of(file, text)) == 4


def test_every_problem_of_the_sense_is_reported_at_once(file: Path) -> None:
    text = MISSION.replace("spacing_m = 20.0", "spacing_m = 7.0").replace("cruise_mps = 1.0", "cruise_mps = 1.45")
    text = text.replace("home = [-20.0, 0.0]", "home = [-70.0, 0.0]").replace("collisions = 0", "colisions = 0")
    text = text.replace("at_s = 20.0", "at_s = 101.0").replace("s_m = 10.0", "s_m = 28.0")
    found = problems_of(file, text)
    assert [problem.split(" ")[0] for problem in found] == [
        "formation.cruise_mps",
        "formation.spacing_m",
        "boats[1].start",
        "home",
        "checks.colisions",
        "timeline[0].at_s",
    ]


def test_a_missing_file_names_the_ready_mission_that_may_be_meant() -> None:
    with pytest.raises(MissionError, match=r"^overtakin: neither a file nor a ready mission; did you mean"):
        load("overtakin")


def test_a_folder_and_a_picture_are_no_missions(tmp_path: Path, file: Path) -> None:
    with pytest.raises(MissionError, match="cannot be read"):
        load(tmp_path)
    file.write_bytes(b"title = '\n\xff\xd8'")
    with pytest.raises(MissionError, match="line 2: byte 0xff is not UTF-8 text"):
        load(file)


def test_a_file_from_windows_is_read_like_any_other(file: Path) -> None:
    file.write_bytes(b"\xef\xbb\xbf" + MISSION.replace("\n", "\r\n").encode())
    assert load(file).title == "Two boats in column"


def test_whole_numbers_without_end_and_nesting_without_end_are_refused(file: Path) -> None:
    huge = problems_of(file, MISSION.replace("spacing_m = 20.0", f"spacing_m = 1{'0' * 400}"))
    assert huge == ("formation.spacing_m = a number of 1329 bits (line 24): expected a number",)
    deep = problems_of(file, MISSION.replace("home = [-20.0, 0.0]", f"home = {'[' * 5000}{']' * 5000}"))
    assert len(deep) == 1


def test_what_will_work_but_perhaps_not_as_meant_is_a_warning(file: Path) -> None:
    text = MISSION.replace("s_m = 10.0", "s_m = 23.0").replace(
        "[[timeline]]", '[[timeline]]\nat_s = 5.0\ndo = "resume"\n\n[[timeline]]', 1
    )
    text = text.replace(
        "[formation]", '[paths.spare]\nkind = "straight"\nstart = [0.0, 20.0]\nend = [200.0, 20.0]\n\n[formation]'
    )
    text = (
        text.replace("[checks]", "[environment]\ncurrent_mps = 2.0\n\n[checks]")
        .replace("[250.0, 50.0]", "[201.0, 50.0]")
        .replace("[250.0, -50.0]", "[201.0, -50.0]")
    )
    file.write_text(text)
    _, findings = examine(file)
    assert findings.problems == ()
    assert findings.warnings == (
        "paths.spare (line 23): no boat sails this path",
        "boats[1].start (line 21): b2 begins 7.0 m from b1; slots need 8.0 m",
        "environment.current_mps = 2 (line 45): boats that make 1.5 m/s cannot stem it",
        "paths.line (line 6): 1.0 m from the fence at 200 m of its length; keeping clear needs 6 m to move in",
        'timeline[0].do = "resume" (line 37): b1 had no hold before 5 s',
        'timeline[0].do = "resume" (line 37): b2 had no hold before 5 s',
    )  # fmt: skip


def test_a_change_after_the_end_of_the_path_is_a_warning(file: Path) -> None:
    file.write_text(MISSION.replace("at_s = 20.0", "at_s = 190.0").replace("duration_s = 100.0", "duration_s = 300.0"))
    _, findings = examine(file)
    assert findings.warnings == (
        "timeline[0].at_s = 190 (line 31): by then the foremost boat has reached the end of its path, "
        "and the mission is over",
    )
