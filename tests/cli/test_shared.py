"""What commands share: the options of which a link is made, and how those end that go on until they are told."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest
import typer
from typer.testing import CliRunner

from fleet.cli.ending import Ending
from fleet.cli.options import Json, Link, linked

APP = typer.Typer(rich_markup_mode=None)
given: list[tuple[Link, str, bool]] = []


@APP.command()
@linked
def say(reach: Link, word: str, json: Json = False) -> None:
    """A word to boats."""
    given.append((reach, word, json))


def test_a_command_is_given_the_link_that_its_options_say(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("FLEET_FLEET", "FLEET_CONNECT", "FLEET_OPERATOR", "FLEET_CREDENTIALS", "FLEET_INSECURE"):
        monkeypatch.delenv(name, raising=False)
    given.clear()
    run = CliRunner().invoke
    assert run(APP, ["hold"]).exit_code == 0
    monkeypatch.setenv("FLEET_FLEET", "genoa")
    options = ["--connect", "tcp/10.0.0.1:7447", "--operator", "anna", "--timeout", "5", "--credentials", "me"]
    assert run(APP, ["hold", "--json", *options, "--insecure"]).exit_code == 0
    assert given == [
        (Link("demo", None, "", 3.0), "hold", False),
        (Link("genoa", ["tcp/10.0.0.1:7447"], "anna", 5.0, "me", True), "hold", True),
    ]


def test_its_help_names_its_own_and_the_shared_options() -> None:
    text = CliRunner().invoke(APP, ["--help"]).output
    assert "A word to boats." in text
    for name in ("--json", "--fleet", "--connect", "--operator", "--timeout", "--credentials", "--insecure"):
        assert name in text


@pytest.fixture
def handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("handlers")
@pytest.mark.parametrize(("first", "then", "code"), [("SIGINT", "SIGTERM", 130), ("SIGTERM", "SIGINT", 0)])
def test_the_first_word_to_end_decides(first: str, then: str, code: int) -> None:
    ending = Ending()
    assert not ending.told.is_set()
    for name in (first, then):
        signal.raise_signal(getattr(signal, name))
        assert ending.told.is_set()
        assert ending.exit_code == code
