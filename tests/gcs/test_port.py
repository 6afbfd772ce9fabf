"""Sockets: who is spoken to, who is heard; wrong endpoints and open ones are refused in words."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.errors import ConfigError, UsageError
from fleet.gcs.port import LARGEST_SENT, Port, is_loopback, joined, parse
from fleet.gcs.run import GcsConfig
from fleet.gcs.seat import Peer


@pytest.fixture
def station() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        one.settimeout(5.0)
        yield one


def test_a_station_that_listens_is_spoken_to_and_heard(station: socket.socket) -> None:
    port = Port([f"udp:127.0.0.1:{station.getsockname()[1]}"])
    port.send([(None, b"hello")], 0.0)
    payload, address = station.recvfrom(100)
    station.sendto(b"you", address)
    port.wait(5.0)
    assert payload == b"hello"
    assert port.receive(0.0) == [((0, None), b"you")]
    port.close()


def test_a_stranger_is_not_heard_at_an_endpoint_of_ours(station: socket.socket) -> None:
    port = Port([f"udp:127.0.0.1:{station.getsockname()[1]}"])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(b"obey", ("127.0.0.1", port.numbers[0]))
        port.wait(0.05)
        assert port.receive(0.0) == []
    port.close()


def test_a_guest_is_told_everything_while_it_speaks(station: socket.socket) -> None:
    port = Port(["udpin:127.0.0.1:0"])
    port.send([(None, b"nobody is there")], 0.0)
    station.sendto(b"hello", ("127.0.0.1", port.numbers[0]))
    port.wait(5.0)
    [(peer, payload)] = port.receive(1.0)
    assert payload == b"hello"
    port.send([(peer, b"answer"), (None, b"for all")], 1.0)
    assert station.recv(100) == b"answer"
    port.welcome(peer, 1.0)
    port.send([(None, b"news")], 2.0)
    assert station.recv(100) == b"news"
    port.send([(None, b"too late")], 12.0)
    station.setblocking(False)
    with pytest.raises(BlockingIOError):
        station.recv(100)
    port.close()


def test_frames_that_leave_together_go_in_few_datagrams() -> None:
    guest = (0, ("127.0.0.1", 1))
    frames = [(None, b"a"), (None, b"b"), (guest, b"c"), (guest, b"d"), (None, b"e")]
    assert list(joined(frames)) == [(None, b"ab"), (guest, b"cd"), (None, b"e")]
    assert list(joined([])) == []


@given(st.lists(st.tuples(st.sampled_from([None, (0, None), (1, None)]), st.binary(min_size=12, max_size=280))))
def test_joining_keeps_every_byte_and_the_order(frames: list[tuple[Peer | None, bytes]]) -> None:
    datagrams = list(joined(frames))
    for peer in (None, (0, None), (1, None)):
        assert b"".join(d for to, d in datagrams if to == peer) == b"".join(f for to, f in frames if to == peer)
    assert all(len(datagram) <= LARGEST_SENT for _, datagram in datagrams)
    assert b"".join(d for _, d in datagrams) == b"".join(f for _, f in frames)


def test_a_station_that_is_not_there_costs_nothing() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as gone:
        gone.bind(("127.0.0.1", 0))
        number = gone.getsockname()[1]
    port = Port([f"udp:127.0.0.1:{number}"])
    began = time.monotonic()
    for _ in range(100):
        port.send([(None, b"x")], 0.0)
        port.receive(0.0)
    assert time.monotonic() - began < 1.0
    port.close()


@pytest.mark.parametrize(
    "text", ["", "udp", "udp:127.0.0.1", "tcp:127.0.0.1:1", "udp:127.0.0.1:0", "udp:h:99999", "udp::5"]
)
def test_a_wrong_endpoint_is_named(text: str) -> None:
    with pytest.raises(ConfigError, match="expected udp:HOST:PORT or udpin:HOST:PORT"):
        parse(text)


def test_a_port_in_use_is_named(station: socket.socket) -> None:
    with pytest.raises(ConfigError, match="in use"):
        Port([f"udpin:127.0.0.1:{station.getsockname()[1]}"])


@pytest.mark.parametrize(
    ("host", "own"),
    [
        ("127.0.0.1", True),
        ("localhost", True),
        ("::1", True),
        ("0.0.0.0", False),
        ("10.0.0.5", False),
        ("gcs.local", False),
    ],
)
def test_what_is_this_machine_only(host: str, own: bool) -> None:
    assert is_loopback(host) == own


def test_beyond_this_machine_needs_a_key_or_a_word(tmp_path: Path) -> None:
    where = ("udp:10.0.0.5:14550",)
    with pytest.raises(UsageError, match="expected --signing-key FILE, or --insecure"):
        GcsConfig(endpoints=where).check()
    assert GcsConfig(endpoints=where, insecure=True).check() == [
        "INSECURE: whoever reaches udp:10.0.0.5:14550 can command the boats (--insecure)"
    ]
    (tmp_path / "key").write_text("a long passphrase")
    assert GcsConfig(endpoints=where, signing_key=str(tmp_path / "key")).check() == []
    assert GcsConfig().check() == []
    with pytest.raises(UsageError, match="expected ardupilot or generic"):
        GcsConfig(autopilot="px4").check()
