"""`fleet --help` is instant, and nothing a user types gives a traceback."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

import pytest

import fleet.cli.main as program
from fleet import __version__
from tests.cli.terminal import FLEET, environment, fleet

HEAVY = ("zenoh", "msgspec", "mcap", "numpy", "matplotlib", "rich.live", "asyncio")
EMPTY = "import typer\napp = typer.Typer()\n@app.command()\ndef main() -> None:\n    'Nothing.'\napp()\n"
ROUNDS = 6


def cpu_s(argv: list[str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(argv, stdout=subprocess.DEVNULL, check=True, env=environment())
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.parametrize(
    "asked", [["--help"], ["--version"], ["mission", "--help"], ["sim", "--help"], ["status", "--help"]]
)
def test_help_imports_nothing_heavy(asked: list[str]) -> None:
    probe = (
        "import sys; from fleet.cli.main import main; code = main(sys.argv[1:]); "
        f"print([name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr); sys.exit(code)"
    )
    ended = subprocess.run([sys.executable, "-c", probe, *asked], capture_output=True, text=True, check=True)
    assert ended.stderr.strip() == "[]"


def test_help_costs_at_most_1_2_times_an_empty_typer_program(tmp_path: Path) -> None:
    empty = tmp_path / "empty.py"
    empty.write_text(EMPTY)
    theirs = min(cpu_s([sys.executable, str(empty), "--help"]) for _ in range(ROUNDS))
    ours = min(cpu_s([*FLEET, "--help"]) for _ in range(ROUNDS))
    assert ours <= 1.2 * theirs


def test_version() -> None:
    ended = fleet("--version")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, f"fleet {__version__}\n", "")


def test_every_command_has_a_help() -> None:
    groups = {"mission": ("list", "show", "check"), "run": ("list", "show", "report", "repair")}
    orders = ["launch", "set", "resume", "hold", "abort", "return", "stop-now", "release", "take", "forget"]
    commands = [*orders, "sim", "status", "agent", "hub"]
    lines = [[name] for name in commands] + [[group, name] for group, names in groups.items() for name in names]
    for line in lines:
        assert program.main([*line, "--help"]) == 0


def test_a_bug_is_one_line_and_says_how_to_see_more(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("fleet.mission.load.ready", lambda: 1 // 0)
    assert program.main(["mission", "list"]) == 1
    assert capsys.readouterr().err == (
        f"error: a bug in fleet {__version__}: ZeroDivisionError: integer division or modulo by zero; "
        "FLEET_TRACE=1 shows where\n"
    )
    monkeypatch.setenv("FLEET_TRACE", "1")
    with pytest.raises(ZeroDivisionError):
        program.main(["mission", "list"])


def test_a_reader_that_goes_away_is_no_trouble() -> None:
    line = f"{' '.join(FLEET)} mission show overtaking --text | head -n 1"
    ended = subprocess.run(["bash", "-c", line], capture_output=True, text=True, env=environment(), check=True)
    assert ended.stderr == ""


def test_no_colour_without_a_terminal() -> None:
    assert "\x1b" not in fleet("mission", "show", "overtaking").stdout
