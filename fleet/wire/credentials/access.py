"""Access rules for Zenoh, made from the roster: what each neighbour may say to this station. All else is refused.

A boat writes under its own name only, reads its peers, and asks them for missions and formations; operators ask,
commands included; a hub relays everything. Where every boat is a router, a boat may also pass on an operator's
commands and presence: commands are signed, so that it cannot forge them.
"""

from __future__ import annotations

from typing import Any

from fleet.wire import keys
from fleet.wire.credentials.roster import Identity, Role, Roster
from fleet.wire.link import Topology

EVERYTHING = (
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "reply",
    "declare_queryable",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
)
LISTENS = ("declare_subscriber", "declare_liveliness_subscriber", "liveliness_query")
OWN = ("put", "delete", "reply", "declare_queryable", "liveliness_token")
PEERS_ASK = (keys.MISSION, keys.FORMATION, keys.ECHO, keys.STOPS)


def rules(roster: Roster, now_s: float, station: Role, topology: Topology) -> dict[str, Any]:
    """The `access_control` of a Zenoh configuration.

    Args:
        roster: in force
        now_s: seconds of UTC since 1970; who is revoked or expired may nothing
        station: what this station is
        topology: how it is connected; a client of a hub listens to hubs only
    """
    everything = f"fleet/{roster.fleet}/**"
    made: list[dict[str, Any]] = [
        _rule("all", ("ingress", "egress"), EVERYTHING, everything),
        _rule("told", ("egress",), EVERYTHING, everything),
        _rule("listens", ("ingress",), LISTENS, everything),
    ]
    hubs, boats, operators = (roster.of(role, now_s) for role in ("hub", "boat", "operator"))
    policies: list[tuple[tuple[str, ...], tuple[Identity, ...]]] = [(("all",), hubs)]
    if station == "operator":  # hears what it is connected to; what it says is signed
        policies.append((("all",), boats))
    elif station == "hub" or topology != "hub":
        made += _for_operators(roster.fleet)
        policies += [(("told", "listens", "operate"), operators)]
        policies += [(("told", "operator-" + one.name), (one,)) for one in operators]
        made += [_presence(roster.fleet, one.name) for one in {one.name: one for one in operators}.values()]
        shared: tuple[str, ...] = ("told", "listens", "ask")
        made.append(_rule("ask", ("ingress",), ("query",), *_asked(roster.fleet, "*", PEERS_ASK)))
        if station == "boat":
            made.append(_rule("relay", ("ingress",), ("query",), *_asked(roster.fleet, "*", keys.ASKED)))
            made.append(_presence(roster.fleet, "*", "relay-presence"))
            shared = (*shared, "relay", "relay-presence")
        policies.append((shared, boats))
        for name in sorted({one.name for one in boats}):
            made.append(_rule(f"own-{name}", ("ingress",), OWN, f"fleet/{roster.fleet}/{name}/**"))
            policies.append(((f"own-{name}",), tuple(one for one in boats if one.name == name)))
    subjects = [
        {"id": f"s{number}", "cert_common_names": [one.common_name for one in who]}
        for number, (_, who) in enumerate(policies)
        if who
    ]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": made,
        "subjects": subjects or [{"id": "nobody", "cert_common_names": ["nobody"]}],
        "policies": [
            {"rules": list(names), "subjects": [f"s{number}"]} for number, (names, who) in enumerate(policies) if who
        ],
    }


def _asked(fleet: str, boat: str, what: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(keys.key(fleet, boat, one) for one in what)


def _for_operators(fleet: str) -> list[dict[str, Any]]:
    return [_rule("operate", ("ingress",), ("query",), *_asked(fleet, "*", keys.ASKED))]


def _presence(fleet: str, operator: str, name: str = "") -> dict[str, Any]:
    return _rule(
        name or f"operator-{operator}", ("ingress",), ("liveliness_token",), keys.operator_key(fleet, operator)
    )


def _rule(name: str, flows: tuple[str, ...], messages: tuple[str, ...], *key_exprs: str) -> dict[str, Any]:
    return {
        "id": name,
        "permission": "allow",
        "flows": list(flows),
        "messages": list(messages),
        "key_exprs": list(key_exprs),
    }
