"""The authority: what it gives, what it refuses, and what stays revoked."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from fleet.errors import ConfigError, UsageError
from fleet.wire.credentials import authority, files, keys
from fleet.wire.credentials.roster import Identity, read_body, read_envelope
from fleet.wire.credentials.trust import load
from tests.wire.credentials.fleet_of import FLEET, Issued

NOW = 1_700_000_000.0
DAY = 86400.0


@pytest.fixture
def issued(tmp_path: Path) -> Issued:
    return Issued(tmp_path / "a", lambda: NOW)


def members(one: Issued) -> list[Identity]:
    content = files.read(one.folder, files.ROSTER)
    return list(read_body(read_envelope(content, "roster"), "roster").members)


def test_a_station_gets_what_it_needs_in_one_folder_and_nobody_else_may_read_its_key(issued: Issued) -> None:
    folder = issued.folder / "b1"
    assert {one.name for one in folder.iterdir()} == {
        files.AUTHORITY_CERTIFICATE,
        files.OWN_CERTIFICATE,
        files.OWN_KEY,
        files.ROSTER,
    }
    assert stat.S_IMODE((folder / files.OWN_KEY).stat().st_mode) == 0o600
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert stat.S_IMODE((issued.folder / files.AUTHORITY_KEY).stat().st_mode) == 0o600


def test_a_certificate_names_role_name_and_serial_and_the_hosts_where_it_is_reached(issued: Issued) -> None:
    from cryptography.x509 import SubjectAlternativeName

    folder = issued.authority.issue("hub", "shore", NOW, hosts=("10.0.0.5", "hub.example.org"))
    certificate = keys.certificate_of((folder / files.OWN_CERTIFICATE).read_bytes(), "")
    serial = members(issued)[-1].serial
    assert keys.common_name(certificate) == f"hub.shore.{serial}"
    names = certificate.extensions.get_extension_for_class(SubjectAlternativeName).value
    assert {str(one.value) for one in names} == {"localhost", "127.0.0.1", "::1", "10.0.0.5", "hub.example.org"}


def test_the_longest_name_fits_into_a_common_name(issued: Issued) -> None:
    issued.authority.issue("operator", "o" * 32, NOW)


def test_every_station_of_the_authority_gets_the_newest_roster(issued: Issued) -> None:
    issued.authority.issue("boat", "b9", NOW)
    rosters = {(issued.folder / name / files.ROSTER).read_bytes() for name in ("b1", "b2", "anna", "b9")}
    assert rosters == {(issued.folder / files.ROSTER).read_bytes()}


def test_what_is_revoked_stays_revoked_when_the_name_is_issued_anew(issued: Issued) -> None:
    old = issued.boat("b2")
    words = old.sign("formation", b"x")
    issued.authority.revoke("b2", NOW)
    issued.authority.issue("boat", "b2", NOW)
    both = [one for one in members(issued) if one.name == "b2"]
    assert [bool(one.revoked_s) for one in both] == [True, False]
    assert both[0].serial != both[1].serial
    b1, new = issued.boat("b1"), issued.boat("b2")
    assert b1.signer("formation", new.sign("formation", b"x")).serial == both[1].serial
    with pytest.raises(Exception, match=rf"boat b2 \({both[0].serial}\), revoked"):
        b1.signer("formation", words)


def test_renewing_leaves_the_old_certificate_valid_to_its_end(issued: Issued) -> None:
    with pytest.raises(UsageError, match="boat b1: has a certificate until 2024-11-13; expected another name, --renew"):
        issued.authority.issue("boat", "b1", NOW)
    old = issued.boat("b1")
    issued.authority.issue("boat", "b1", NOW, renew=True)
    assert issued.boat("b2").signer("x", old.sign("x", b"")).name == "b1"
    assert issued.boat("b1").common_name != old.common_name


def test_nothing_is_overwritten(issued: Issued) -> None:
    before = (issued.folder / files.AUTHORITY_KEY).read_bytes()
    with pytest.raises(UsageError, match=r"authority\.key: exists: expected a folder without an authority"):
        authority.create(issued.folder, FLEET, NOW)
    assert (issued.folder / files.AUTHORITY_KEY).read_bytes() == before


@pytest.mark.parametrize(
    ("role", "name", "more", "words"),
    [
        ("boat", "B 9", {}, "boat 'B 9': expected 1 to 32"),
        ("boat", "operator", {}, "this name is kept for operators"),
        ("operator", "b1", {}, "there is a valid boat b1"),
        ("boat", "b9", {"days": 0.0}, "--days 0: expected more than 0"),
        ("boat", "b9", {"days": 1e9}, "--days 1e\\+09: expected more than 0 and at most 3650"),
        ("boat", "b9", {"hosts": ("10.0.0.5:7447",)}, "--hosts '10.0.0.5:7447': expected names or addresses"),
    ],
)
def test_what_cannot_be_issued_is_refused_and_leaves_nothing(
    issued: Issued, role: str, name: str, more: dict[str, object], words: str
) -> None:
    number = issued.authority.roster.number
    with pytest.raises(UsageError, match=words):
        issued.authority.issue(role, name, NOW, **more)  # type: ignore[arg-type]
    assert issued.authority.roster.number == number
    assert not (issued.folder / "b9").exists()


def test_nobody_is_revoked_twice(issued: Issued) -> None:
    issued.authority.revoke("b1", NOW)
    with pytest.raises(UsageError, match="revoke b1: has no certificate to revoke; expected one of anna, b2, b3"):
        issued.authority.revoke("b1", NOW)


def test_an_authority_whose_key_others_may_read_is_not_used(issued: Issued) -> None:
    (issued.folder / files.AUTHORITY_KEY).chmod(0o640)
    with pytest.raises(ConfigError, match=r"authority\.key: its mode is 0640, .*expected 0600"):
        authority.load(issued.folder)


def test_an_authority_is_found_again_with_its_roster(issued: Issued) -> None:
    again = authority.load(issued.folder)
    assert again.roster == issued.authority.roster
    again.issue("boat", "b7", NOW)
    assert load(issued.folder / "b7", FLEET, "boat", now=lambda: NOW).name == "b7"


def test_expired_ones_leave_the_roster_after_90_days_revoked_ones_stay(issued: Issued) -> None:
    issued.authority.revoke("b1", NOW)
    issued.authority.issue("boat", "b9", NOW + (365 + 91) * DAY)
    assert [one.name for one in members(issued)] == ["b1", "b9"]
