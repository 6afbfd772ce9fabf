"""`fleet credentials`: an authority, its stations, and what is said to a person."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fleet.cli.main import main
from fleet.wire.credentials import files


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("AUTHORITY", "FLEET", "CREDENTIALS", "CONNECT", "INSECURE", "OPERATOR"):
        monkeypatch.delenv(f"FLEET_{name}", raising=False)


def run(*argv: str) -> int:
    return main(["credentials", *argv])


def test_from_nothing_to_a_fleet_and_a_boat_less(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("init", "--fleet", "genoa") == 0
    assert run("boat", "otter-1", "--hosts", "10.0.0.11,otter-1.local") == 0
    assert run("hub", "shore", "--hosts", "10.0.0.5") == 0
    assert run("operator", "anna", "--days", "20") == 0
    assert run("revoke", "otter-1") == 0
    assert "boat otter-1 (" in capsys.readouterr().out
    assert run("show", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["fleet"], shown["roster"]) == ("genoa", 5)
    states = {one["name"]: (one["role"], one["state"].split(" 202")[0]) for one in shown["members"]}
    assert states == {
        "otter-1": ("boat", "revoked"),
        "shore": ("hub", "valid"),
        "anna": ("operator", "ends in 20 days"),
    }
    assert run("show", "credentials/anna") == 0
    assert "fleet genoa, roster 5" in capsys.readouterr().out


def test_one_variable_names_the_authority_for_all_of_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FLEET_AUTHORITY", "shore")
    assert run("init", "--fleet", "genoa") == 0
    assert run("operator", "anna") == 0
    assert run("show") == 0
    assert "fleet genoa, roster 2" in capsys.readouterr().out


def test_no_key_is_ever_shown(capsys: pytest.CaptureFixture[str]) -> None:
    run("init")
    run("boat", "b1")
    run("show")
    run("show", "credentials/b1", "--json")
    said = "".join(capsys.readouterr())
    assert "PRIVATE" not in said
    for key in (files.AUTHORITY_KEY, f"b1/{files.OWN_KEY}"):
        content = (Path("credentials") / key).read_text(encoding="ascii")
        assert content.splitlines()[1] not in said


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["init"], "credentials/authority.key: exists: expected a folder without an authority"),
        (["boat", "b1"], "boat b1: has a certificate until"),
        (["operator", "b1"], "there is a valid boat b1"),
        (["boat", "B2"], "boat 'B2': expected 1 to 32 of a-z"),
        (["boat", "b2", "--days", "0"], "--days 0: expected more than 0"),
        (["revoke", "b9"], "revoke b9: has no certificate to revoke; expected one of b1"),
        (["send"], "credentials send: expected --credentials FOLDER"),
    ],
)
def test_what_is_refused_says_what_was_expected(
    capsys: pytest.CaptureFixture[str], argv: list[str], words: str
) -> None:
    run("init")
    run("boat", "b1")
    before = (Path("credentials") / files.ROSTER).read_bytes()
    capsys.readouterr()
    assert run(*argv) == 2
    assert words in capsys.readouterr().err
    assert (Path("credentials") / files.ROSTER).read_bytes() == before


def test_a_renewed_boat_has_two_certificates(capsys: pytest.CaptureFixture[str]) -> None:
    run("init")
    run("boat", "b1")
    assert run("boat", "b1", "--renew") == 0
    capsys.readouterr()
    run("show", "--json")
    assert [one["state"] for one in json.loads(capsys.readouterr().out)["members"]] == ["valid", "valid"]
