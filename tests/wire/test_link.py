"""What may leave this machine, and with which word."""

from __future__ import annotations

from typing import Any

import pytest

from fleet.errors import ConfigError
from fleet.wire.link import LinkConfig, check_link, on_loopback, warning


@pytest.mark.parametrize(
    "endpoint",
    ["tcp/127.0.0.1:7447", "tcp/127.8.9.1:1", "udp/[::1]:7447", "ws/localhost:80", "unixsock-stream//tmp/x"],
)
def test_these_stay_on_this_machine(endpoint: str) -> None:
    assert on_loopback(endpoint)


@pytest.mark.parametrize(
    "endpoint",
    [
        "tcp/0.0.0.0:7447",
        "tcp/[::]:7447",
        "tcp/10.0.0.5:7447",
        "tcp/localhost.example.org:7447",
        "tcp/127.0.0.1.example.org:7447",
        "quic/hub.example.org:7447?mixed_rel=1",
        "serial//dev/ttyUSB0",
        "nonsense",
        "tcp/:7447",
    ],
)
def test_these_leave_it_or_cannot_be_told(endpoint: str) -> None:
    assert not on_loopback(endpoint)


@pytest.mark.parametrize("where", ["listen", "connect"])
def test_beyond_loopback_without_credentials_is_refused_until_it_is_said_to_be_meant(where: str) -> None:
    ends: dict[str, Any] = {where: ("tcp/127.0.0.1:1", "tcp/0.0.0.0:7447")}
    with pytest.raises(ConfigError, match=rf"link\.{where} 'tcp/0\.0\.0\.0:7447' leaves this machine .* --insecure"):
        check_link(LinkConfig(**ends))
    meant = LinkConfig(**ends, insecure=True)
    check_link(meant)
    assert warning(meant).startswith("INSECURE: tcp/0.0.0.0:7447 with nothing signed")


def test_loopback_needs_no_word_and_warns_of_nothing() -> None:
    link = LinkConfig(listen=("tcp/127.0.0.1:7447",), connect=("udp/[::1]:7",))
    check_link(link)
    assert not warning(link)


@pytest.mark.parametrize("kind", ["tcp", "udp", "ws"])
def test_with_credentials_plain_transports_are_refused_on_loopback_too(kind: str) -> None:
    with pytest.raises(ConfigError, match=r"with credentials: expected tls/HOST:PORT or quic/HOST:PORT"):
        check_link(LinkConfig(connect=(f"{kind}/127.0.0.1:7447",), credentials="here"))
    check_link(LinkConfig(connect=("tls/10.0.0.5:7447", "quic/10.0.0.5:7447?mixed_rel=1"), credentials="here"))


def test_tls_without_credentials_is_refused() -> None:
    with pytest.raises(ConfigError, match="needs credentials"):
        check_link(LinkConfig(connect=("tls/127.0.0.1:7447",)))


def test_credentials_and_insecure_contradict_each_other() -> None:
    with pytest.raises(ConfigError, match="contradict"):
        check_link(LinkConfig(credentials="here", insecure=True))
