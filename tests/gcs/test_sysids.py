"""Numbers of boats: given by name, kept, unique; clashes refused in words."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.errors import UsageError
from fleet.gcs.sysids import MOST, Sysids, parse


def test_the_lowest_free_number_is_given_and_kept_over_a_restart(tmp_path: Path) -> None:
    file = tmp_path / "below" / "gcs-demo.json"
    first = Sysids({}, file)
    assert [first.of(boat)[0] for boat in ("b1", "b2", "b3")] == [1, 2, 3]
    again = Sysids({}, file)
    assert [again.of(boat)[0] for boat in ("b3", "b4", "b1")] == [3, 4, 1]


def test_what_is_configured_goes_first() -> None:
    sysids = Sysids({"b2": 1})
    assert sysids.of("b1") == (2, "")
    assert sysids.of("b2") == (1, "")


def test_a_remembered_number_yields_to_a_configured_one(tmp_path: Path) -> None:
    file = tmp_path / "kept.json"
    Sysids({}, file).of("b1")
    sysids = Sysids({"b9": 1}, file)
    assert sysids.of("b1")[0] == 2
    assert sysids.of("b9")[0] == 1


def test_an_autopilot_has_the_number_that_it_has_and_a_clash_is_refused() -> None:
    sysids = Sysids({"b3": 9})
    assert sysids.of("b1", autopilot=7) == (7, "")
    number, why = sysids.of("b2", autopilot=7)
    assert number == 0
    assert why == "its autopilot has sysid 7, which b1 has: give it another, or b1 by --sysid"
    assert "which b3 has" in sysids.of("b4", autopilot=9)[1]
    assert "--sysid says 9" in sysids.of("b3", autopilot=8)[1]
    assert "expected 1 to 250" in sysids.of("b5", autopilot=255)[1]


def test_more_boats_than_numbers_are_refused() -> None:
    sysids = Sysids({})
    assert [sysids.of(f"b{i}")[0] for i in range(1, MOST + 1)] == list(range(1, MOST + 1))
    assert sysids.of("b251") == (0, "all numbers from 1 to 250 are given")


def test_a_spoilt_file_is_as_good_as_none(tmp_path: Path) -> None:
    file = tmp_path / "kept.json"
    for content in (b"", b"[1]", b'{"b1": "x"}', b'{"b1": 4000}'):
        file.write_bytes(content)
        assert Sysids({}, file).of("b1") == (1, "")


@given(
    st.lists(st.tuples(st.integers(0, 20), st.integers(0, 5)), max_size=40),
    st.dictionaries(st.sampled_from("abc"), st.integers(1, 5)),
)
def test_no_two_boats_ever_have_one_number(asked: list[tuple[int, int]], configured: dict[str, int]) -> None:
    if len(set(configured.values())) != len(configured):
        return
    sysids = Sysids(configured)
    given_: dict[str, int] = {}
    for boat, autopilot in asked:
        name = "abc"[boat] if boat < 3 else f"b{boat}"
        if name in given_:
            continue
        number, why = sysids.of(name, autopilot)
        assert bool(number) != bool(why)
        if number:
            assert number not in given_.values()
            given_[name] = number


@pytest.mark.parametrize("text", ["b1", "b1=0", "b1=251", "=3", "b1=x", "b1=1,b1=2", "b1=1,b2=1"])
def test_a_wrong_option_is_named(text: str) -> None:
    with pytest.raises(UsageError, match="--sysid"):
        parse([text])


def test_a_right_option_is_read() -> None:
    assert parse(["b1=3,b2=4", "c=250"]) == {"b1": 3, "b2": 4, "c": 250}
