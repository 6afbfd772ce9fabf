"""Access rules: who may say what to whom, made from the roster."""

from __future__ import annotations

from typing import Any

import pytest

from fleet.wire import keys
from fleet.wire.credentials.access import rules
from fleet.wire.credentials.roster import Identity, Role, Roster

NOW = 1000.0


def member(role: Role, name: str, serial: str, **more: Any) -> Identity:
    return Identity(role, name, serial, b"", 0, more.pop("ends_s", 2000), "", **more)


ROSTER = Roster(
    "f",
    7,
    0,
    (
        member("boat", "b1", "1"),
        member("boat", "b2", "2", revoked_s=5),
        member("boat", "b2", "3"),
        member("boat", "b3", "4", ends_s=999),
        member("operator", "anna", "5"),
        member("operator", "bert", "6", revoked_s=5),
        member("hub", "shore", "7"),
    ),
)


def allowed(made: dict[str, Any], who: str, flow: str, message: str) -> set[str]:
    """Key expressions on which somebody may say this."""
    subjects = {one["id"] for one in made["subjects"] if who in one["cert_common_names"]}
    names = {rule for policy in made["policies"] if subjects & set(policy["subjects"]) for rule in policy["rules"]}
    return {
        key
        for rule in made["rules"]
        if rule["id"] in names and flow in rule["flows"] and message in rule["messages"]
        for key in rule["key_exprs"]
    }


@pytest.mark.parametrize(("station", "topology"), [("hub", "hub"), ("boat", "routed"), ("boat", "mesh")])
def test_a_boat_writes_under_its_own_name_only(station: Role, topology: Any) -> None:
    made = rules(ROSTER, NOW, station, topology)
    for message in ("put", "delete", "reply", "declare_queryable"):
        assert allowed(made, "boat.b1.1", "ingress", message) == {"fleet/f/b1/**"}


def test_at_a_hub_only_operators_ask_for_commands_to_be_obeyed() -> None:
    made = rules(ROSTER, NOW, "hub", "hub")
    command = keys.key("f", "*", keys.COMMAND)
    assert command in allowed(made, "operator.anna.5", "ingress", "query")
    assert command not in allowed(made, "boat.b1.1", "ingress", "query")
    assert allowed(made, "boat.b1.1", "ingress", "liveliness_token") == {"fleet/f/b1/**"}


def test_an_operator_asks_and_is_there_and_publishes_nothing() -> None:
    made = rules(ROSTER, NOW, "hub", "hub")
    for message in ("put", "delete", "reply", "declare_queryable"):
        assert not allowed(made, "operator.anna.5", "ingress", message)
    assert allowed(made, "operator.anna.5", "ingress", "liveliness_token") == {"fleet/f/operator/anna/alive"}


@pytest.mark.parametrize("who", ["boat.b2.2", "boat.b3.4", "operator.bert.6", "boat.b9.9"])
@pytest.mark.parametrize("station", ["hub", "boat", "operator"])
def test_who_is_revoked_expired_or_unknown_may_nothing_and_hears_nothing(who: str, station: Role) -> None:
    made = rules(ROSTER, NOW, station, "routed")
    assert made["default_permission"] == "deny"
    assert who not in {name for one in made["subjects"] for name in one["cert_common_names"]}


def test_the_name_issued_anew_may_what_the_old_one_may_not() -> None:
    made = rules(ROSTER, NOW, "hub", "hub")
    assert allowed(made, "boat.b2.3", "ingress", "put") == {"fleet/f/b2/**"}


def test_a_client_of_a_hub_listens_to_hubs_only() -> None:
    made = rules(ROSTER, NOW, "boat", "hub")
    assert {name for one in made["subjects"] for name in one["cert_common_names"]} == {"hub.shore.7"}


def test_with_nobody_in_the_roster_everything_is_denied() -> None:
    made = rules(Roster("f", 1, 0), NOW, "boat", "hub")
    assert made["subjects"]
    assert made["policies"] == []
