"""Names and keys."""

from __future__ import annotations

import pytest

from fleet.errors import UsageError
from fleet.wire import keys


def test_a_key_names_fleet_boat_and_what() -> None:
    assert keys.key("demo", "b1", keys.STATE) == "fleet/demo/b1/state"
    assert keys.boat_of("fleet/demo/b1/state") == "b1"


def test_an_operators_key_is_nobodys_boat() -> None:
    key = keys.operator_key("demo", "anna")
    assert key == "fleet/demo/operator/anna/alive"
    assert keys.operator_of(key) == "anna"


@pytest.mark.parametrize("name", ["b1", "a", "otter-1", "0", "-", "x" * 32])
def test_names_that_are_taken(name: str) -> None:
    assert keys.valid_name("boat", name) == name


@pytest.mark.parametrize(
    "name",
    ["", "B1", "b 1", "b/1", "*", "**", "$*", "ä", "b_1", "b1\n", "x" * 33, "operator", "b1\x00", "..", "?", "#"],
)
def test_names_that_are_refused(name: str) -> None:
    with pytest.raises(UsageError, match="boat"):
        keys.valid_name("boat", name)
