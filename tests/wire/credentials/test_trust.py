"""A station's folder: what is wrong with it is said at the start; and rosters that come later."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from fleet.errors import ConfigError
from fleet.wire.codec import Refused
from fleet.wire.credentials import authority, files
from fleet.wire.credentials.trust import load
from fleet.wire.messages import Signed
from tests.wire.credentials.fleet_of import FLEET, Issued

NOW = 1_700_000_000.0
DAY = 86400.0


class Clock:
    def __init__(self) -> None:
        self.now = NOW

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def issued(tmp_path: Path, clock: Clock) -> Issued:
    return Issued(tmp_path / "a", clock, operators=("anna", "bert"))


# -- at the start ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", [files.AUTHORITY_CERTIFICATE, files.OWN_CERTIFICATE, files.OWN_KEY, files.ROSTER])
def test_a_missing_file_is_named_with_what_it_is(issued: Issued, name: str) -> None:
    (issued.folder / "b1" / name).unlink()
    with pytest.raises(ConfigError, match=rf"b1/{name}: no such file; expected .*`fleet credentials"):
        issued.boat("b1")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (files.AUTHORITY_CERTIFICATE, "not a certificate; expected X.509 in PEM"),
        (files.OWN_CERTIFICATE, "not a certificate; expected X.509 in PEM"),
        (files.OWN_KEY, "not a private key; expected EC P-256 in PEM"),
        (files.ROSTER, "not a roster: .* expected what `fleet credentials` writes"),
    ],
)
@pytest.mark.parametrize("content", [b"", b"rubbish", b"\x00" * 999, b"{}", b"-----BEGIN CERTIFICATE-----\nAAAA\n"])
def test_a_damaged_file_is_named_with_what_was_expected(issued: Issued, name: str, words: str, content: bytes) -> None:
    (issued.folder / "b1" / name).write_bytes(content)
    with pytest.raises(ConfigError, match=rf"b1/{name}: {words}"):
        issued.boat("b1")


@pytest.mark.parametrize("mode", [0o604, 0o640, 0o602, 0o777])
def test_a_key_that_others_may_read_or_change_is_refused(issued: Issued, mode: int) -> None:
    (issued.folder / "b1" / files.OWN_KEY).chmod(mode)
    with pytest.raises(ConfigError, match=rf"b1/own\.key: its mode is {mode:04o}, .*expected 0600"):
        issued.boat("b1")


def test_a_folder_that_others_may_change_is_refused(issued: Issued) -> None:
    (issued.folder / "b1").chmod(0o775)
    with pytest.raises(ConfigError, match="b1: its mode is 0775, so that others may change it: expected 0700"):
        issued.boat("b1")


def test_no_folder_is_named(issued: Issued) -> None:
    with pytest.raises(ConfigError, match="gone: no such folder; expected one made by `fleet credentials`"):
        load(issued.folder / "gone", FLEET, "boat")


def test_an_expired_certificate_is_named_with_the_day(issued: Issued, clock: Clock) -> None:
    clock.now += 366 * DAY
    with pytest.raises(ConfigError, match=r"b1/own\.pem: expired 2024-11-13; expected a valid one"):
        issued.boat("b1")


def test_a_clock_before_the_certificate_is_doubted(issued: Issued, clock: Clock) -> None:
    clock.now = 0.0
    with pytest.raises(ConfigError, match=r"valid only from .* this machine's clock says 1970-01-01: is it right\?"):
        issued.boat("b1")


def test_another_authoritys_certificate_is_refused(issued: Issued, tmp_path: Path, clock: Clock) -> None:
    other = Issued(tmp_path / "other", clock)
    for name in (files.OWN_CERTIFICATE, files.OWN_KEY):
        shutil.copy(other.folder / "b1" / name, issued.folder / "b1" / name)
    with pytest.raises(ConfigError, match=r"b1/own\.pem: not issued by the authority in authority\.pem"):
        issued.boat("b1")


def test_another_stations_key_is_refused(issued: Issued) -> None:
    shutil.copy(issued.folder / "b2" / files.OWN_KEY, issued.folder / "b1" / files.OWN_KEY)
    with pytest.raises(ConfigError, match=r"b1/own\.key: not the key of own\.pem"):
        issued.boat("b1")


def test_another_authoritys_roster_is_refused(issued: Issued, tmp_path: Path, clock: Clock) -> None:
    other = Issued(tmp_path / "other", clock)
    shutil.copy(other.folder / files.ROSTER, issued.folder / "b1" / files.ROSTER)
    with pytest.raises(ConfigError, match=r"b1/roster\.json: not signed by the authority"):
        issued.boat("b1")


@pytest.mark.parametrize(
    ("station", "role", "name", "fleet", "words"),
    [
        ("b1", "operator", "", FLEET, r"own\.pem: of boat b1 \(\w+\); expected one of operator"),
        ("anna", "boat", "b1", FLEET, r"own\.pem: of operator anna \(\w+\); expected one of boat b1"),
        ("b1", "boat", "b2", FLEET, r"own\.pem: of boat b1 \(\w+\); expected one of boat b2"),
        ("b1", "boat", "b1", "genoa", "credentials of fleet 'f'; expected those of fleet 'genoa'"),
    ],
)
def test_the_wrong_folder_is_named(
    issued: Issued, clock: Clock, station: str, role: str, name: str, fleet: str, words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        load(issued.folder / station, fleet, role, name, now=clock)  # type: ignore[arg-type]


def test_a_revoked_station_does_not_start(issued: Issued) -> None:
    issued.authority.revoke("b1", NOW)
    with pytest.raises(ConfigError, match=r"b1/own\.pem: boat b1 \(\w+\) is revoked; expected a certificate"):
        issued.boat("b1")


def test_thirty_days_before_its_end_it_is_said(issued: Issued, clock: Clock) -> None:
    trust = issued.boat("b1")
    clock.now = NOW + 334.9 * DAY
    assert not trust.warning()
    clock.now = NOW + 335.1 * DAY
    assert trust.warning() == "its certificate ends in 30 days"
    clock.now = NOW + 366 * DAY
    assert trust.warning() == "its certificate expired 2024-11-13"
    issued.authority.revoke("b1", NOW)
    trust.look()
    assert trust.warning() == "its certificate was revoked 2023-11-14"


# -- signatures --------------------------------------------------------------------------------------------------------
def test_who_said_it_is_known_and_any_change_is_seen(issued: Issued) -> None:
    words = issued.operator().sign("mission", b"sail")
    b1 = issued.boat("b1")
    assert b1.signer("mission", words).name == "anna"
    bert = issued.operator("bert").common_name
    for changed in (
        Signed(b"sailx", words.signature, words.signer),
        Signed(words.body, words.signature[:-1] + bytes([words.signature[-1] ^ 1]), words.signer),
        Signed(words.body, b"x", words.signer),
        Signed(words.body, words.signature, bert),
    ):
        with pytest.raises(Refused, match="forged or altered"):
            b1.signer("mission", changed)
    with pytest.raises(Refused, match="forged or altered"):
        b1.signer("command", words)  # said for something else
    with pytest.raises(Refused, match="is not signed"):
        b1.signer("mission", Signed(words.body))
    with pytest.raises(Refused, match="is signed by 'nobody', who is not in the roster"):
        b1.signer("mission", Signed(words.body, words.signature, "nobody"))


def test_the_words_of_another_fleet_of_the_same_people_are_not_taken(issued: Issued, tmp_path: Path) -> None:
    elsewhere = authority.create(tmp_path / "e", "genoa", NOW)
    elsewhere.issue("operator", "anna", NOW)
    words = load(tmp_path / "e" / "anna", "genoa", "operator", now=lambda: NOW).sign("mission", b"sail")
    with pytest.raises(Refused, match="not in the roster"):
        issued.boat("b1").signer("mission", words)


# -- rosters -----------------------------------------------------------------------------------------------------------
def test_a_newer_roster_is_taken_up_from_the_wire_and_kept(issued: Issued) -> None:
    b1, anna = issued.boat("b1"), issued.operator()
    before = (issued.folder / "b1" / files.ROSTER).read_bytes()
    issued.authority.revoke("anna", NOW)
    newer = (issued.folder / files.ROSTER).read_bytes()
    (issued.folder / "b1" / files.ROSTER).write_bytes(before)
    assert b1.told(newer, "the wire")
    assert (issued.folder / "b1" / files.ROSTER).read_bytes() == newer
    with pytest.raises(Refused, match=r"operator anna \(\w+\), revoked"):
        b1.signer("mission", anna.sign("mission", b""))
    assert not b1.told(before, "the wire"), "an older one played again"
    with pytest.raises(Refused, match="revoked"):
        b1.signer("mission", anna.sign("mission", b""))


def test_a_newer_roster_is_taken_up_from_the_folder(issued: Issued) -> None:
    b1 = issued.boat("b1")
    b1.look()
    number = b1.roster.number
    issued.authority.issue("boat", "b8", NOW)
    assert b1.look()
    assert b1.roster.number == number + 1
    assert not b1.look()


def test_a_roster_that_is_not_the_authoritys_changes_nothing(issued: Issued, tmp_path: Path, clock: Clock) -> None:
    b1 = issued.boat("b1")
    other = Issued(tmp_path / "other", clock, boats=[f"x{k}" for k in range(9)])
    for content in ((other.folder / files.ROSTER).read_bytes(), b"", b"{}", os.urandom(300)):
        before = b1.roster
        with pytest.raises(Refused, match="roster"):
            b1.told(content, "the wire")
        assert b1.roster is before
