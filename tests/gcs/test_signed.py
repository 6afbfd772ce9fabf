"""With credentials a boat passes on only frames that an operator signed for it; signed MAVLink to stations."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from msgspec import Struct

from fleet.agent.guard import Guard
from fleet.agent.orders import Orders
from fleet.gcs.bridge import Bridge
from fleet.gcs.run import Signer
from fleet.gcs.sysids import Sysids
from fleet.wire.codec import Refused, encode
from fleet.wire.credentials import authority
from fleet.wire.credentials.trust import Trust, load
from fleet.wire.messages import MAJOR, Frames, Signed
from tests.gcs.deck import MAVLINK, Deck

NOW_NS = 1_700_000_000_000_000_000


class Fleet(Struct):
    """Who there is."""

    guard: Guard
    anna: Trust
    boat2: Trust


@pytest.fixture
def fleet(tmp_path: Path) -> Fleet:
    now = NOW_NS * 1e-9
    made = authority.create(tmp_path / "a", "f", now)
    made.issue("operator", "anna", now)
    for boat in ("b1", "b2"):
        made.issue("boat", boat, now)

    def trust(role: str, name: str) -> Trust:
        return load(tmp_path / "a" / name, "f", role, name, now=lambda: now)  # type: ignore[arg-type]

    guard = Guard(Orders("b1", simulated=True, version="0"), trust("boat", "b1"), lambda: 1_000_000)
    return Fleet(guard, trust("operator", "anna"), trust("boat", "b2"))


def frames(signer: Trust, boat: str = "b1", stamp_ns: int = NOW_NS, operator: str = "anna") -> bytes:
    return encode(signer.sign("frames", encode(Frames(MAJOR, operator, b"frame", boat, stamp_ns))))


def test_what_an_operator_signed_goes_on_once(fleet: Fleet) -> None:
    payload = frames(fleet.anna)
    assert fleet.guard.frames(payload, NOW_NS).frames == b"frame"
    with pytest.raises(Refused, match="played again"):
        fleet.guard.frames(payload, NOW_NS)
    assert fleet.guard.frames(frames(fleet.anna, stamp_ns=NOW_NS + 1), NOW_NS)


def test_what_nobody_or_a_boat_signed_or_what_is_for_another_boat_does_not(fleet: Fleet) -> None:
    plain = encode(Frames(MAJOR, "anna", b"frame", "b1", NOW_NS))
    wrong = {
        "are not signed": plain,
        "only operators command": frames(fleet.boat2),
        "another boat's": frames(fleet.anna, boat="b2"),
        "is signed by operator anna": frames(fleet.anna, operator="bert"),
        "played again": frames(fleet.anna, stamp_ns=NOW_NS - 200_000_000_000),
    }
    for why, payload in wrong.items():
        with pytest.raises(Refused, match=why):
            fleet.guard.frames(payload, NOW_NS)
    with pytest.raises(Refused):
        fleet.guard.frames(encode(Signed(plain, b"x" * 64, "anna")), NOW_NS)


def test_with_a_passphrase_vehicles_sign_and_hear_only_what_is_signed(tmp_path: Path) -> None:
    key = tmp_path / "key"
    key.write_text("a long passphrase\n")
    deck = Deck()
    signer = Signer(str(key))
    deck.bridge = Bridge(MAVLINK, Sysids({}), operator="gcs", autopilot=3, sign=signer)
    deck.views = Deck("b1").views
    secret = hashlib.sha256(b"a long passphrase").digest()
    deaf = deck.station
    deaf.read = lambda datagram: None  # type: ignore[method-assign]
    friend = deck.join()
    friend.codec.signing.secret_key = secret
    friend.codec.signing.sign_outgoing = True
    reader = friend._reader.signing
    reader.secret_key = secret
    deck.run(2.0)
    friend.codec.signing.timestamp = reader.timestamp
    assert friend.all("HEARTBEAT", 1), "signed, or it would not have been read"
    deaf.mode(1, 4)
    assert not friend.all("COMMAND_ACK")
    friend.mode(1, 4)
    assert friend.last("COMMAND_ACK").result == 0
