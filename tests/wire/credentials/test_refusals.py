"""What Zenoh's log says about refusals, in our words; its lines as version 1.10.2 writes them."""

from __future__ import annotations

import logging

import pytest

from fleet.wire.zenoh_log import AGAIN_S, Refusals

AT = b"2026-11-28T15:39:34.620668Z"
RULE = AT + b" TRACE rx-1 ThreadId(09) zenoh::net::routing::interceptor::access_control: "
INTERCEPTED = AT + b" TRACE rx-1 ThreadId(09) zenoh::net::routing::interceptor: Msg intercepted!"
TLS = b"  WARN acc-0 ThreadId(05) zenoh_link_tls::unicast: "
WHO = b"59d6 on Interface(lo)+CertCommonName(boat.a.22ff)+Transport(Quic)+59d6 is "


def words(*lines: bytes) -> dict[str, int]:
    one = Refusals()
    for line in lines:
        one.read(line)
    return dict(one.counts)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            TLS + b"invalid peer certificate: UnknownIssuer. Hint: increase the system open file limit.",
            "a stranger: invalid peer certificate: UnknownIssuer",
        ),
        (
            TLS
            + b"invalid peer certificate: certificate expired: verification time 1795880376 (UNIX), but certificate "
            b"is not valid after 1795793973 (86403 seconds ago). Hint: increase the system open file limit.",
            "a stranger: invalid peer certificate: expired 2026-11-27",
        ),
        (
            b"  WARN acc-0 ThreadId(05) zenoh_link_commons::quic::unicast: QUIC acceptor failed: "
            b'Error { code: 74, reason: "peer sent no certificates" }) at /x/u.rs:686. Hint: increase the limit.',
            "a stranger: peer sent no certificates",
        ),
    ],
)
def test_a_handshake_that_fails_is_a_stranger_with_the_reason(line: bytes, said: str) -> None:
    assert words(AT + line) == {said: 1}


def test_a_message_that_may_not_pass_is_named_with_who_and_what() -> None:
    line = RULE + WHO + b"unauthorized to Put (ingress) on fleet/f/b/state"
    assert words(line, INTERCEPTED, line, INTERCEPTED) == {"boat a (22ff) may not put fleet/f/b/state": 2}


def test_rules_that_are_only_looked_up_are_no_refusal() -> None:
    looked_up = RULE + WHO + b"unauthorized to Put (ingress) on fleet/f/b/state"
    passes = RULE + WHO + b"authorized to Put (ingress) on fleet/f/a/state"
    assert words(looked_up, passes, INTERCEPTED) == {}
    assert words(looked_up) == {}
    assert words(RULE + WHO + b"unauthorized to Put (egress) on fleet/f/b/state", INTERCEPTED) == {}


def test_somebody_of_another_thread_is_not_blamed() -> None:
    line = RULE + WHO + b"unauthorized to Put (ingress) on fleet/f/b/state"
    assert words(line, INTERCEPTED.replace(b"(09)", b"(10)")) == {}


def test_a_hub_that_is_not_there_yet_is_no_refusal() -> None:
    assert words(AT + b"  WARN ThreadId(01) zenoh::net::runtime::orchestrator: Unable to connect to any of [x]") == {}


def test_the_same_is_said_once_in_a_while_and_counted(caplog: pytest.LogCaptureFixture) -> None:
    one = Refusals()
    with caplog.at_level(logging.WARNING):
        for _ in range(100):
            one.read(AT + b"  WARN acc-0 ThreadId(05) zenoh_link_tls::unicast: peer sent no certificates. Hint: x")
    assert len(caplog.records) == 1
    assert AGAIN_S >= 1.0
    assert one.counts.total() == 100
    assert one.fresh() == ["a stranger: peer sent no certificates"]
    assert one.fresh() == []


def test_many_different_ones_do_not_fill_the_memory() -> None:
    one = Refusals()
    for k in range(2000):
        one.read(RULE + WHO + b"unauthorized to Put (ingress) on fleet/f/x%d/state" % k)
        one.read(INTERCEPTED)
    assert len(one.counts) <= 300
    assert one.counts.total() == 2000


@pytest.mark.parametrize(
    "line", [b"", b"\xff\xfe", RULE, INTERCEPTED, b" WARN ", RULE + b"(ingress) is unauthorized to"]
)
def test_any_line_is_read(line: bytes) -> None:
    words(line)
