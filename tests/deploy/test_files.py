"""The files in `deploy/`: what they name exists, and they say what the package says."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.main import get_command

from fleet.agent.config import load_config
from fleet.agent.service import template
from fleet.cli.main import app

ROOT = Path(__file__).parents[2]
DEPLOY = ROOT / "deploy"
BOATS = sorted((DEPLOY / "boats").glob("*.toml"))
UNITS = sorted((DEPLOY / "systemd").glob("*.service"))
COMPOSE: Any = yaml.safe_load((DEPLOY / "compose.yaml").read_text())


def takes(argv: list[str]) -> None:
    """Whether `fleet` knows these words and options; fails with its own words."""
    command: Any = get_command(app)
    words = list(argv)
    while hasattr(command, "commands"):
        word = words.pop(0) if words and words[0] in command.commands else "run"
        assert word in command.commands, (word, argv)
        command = command.commands[word]
    with command.make_context("fleet", words, resilient_parsing=False):
        pass


@pytest.mark.parametrize("file", BOATS, ids=lambda file: file.stem)
def test_a_boat_s_file_is_whole_and_says_all_that_is_the_boats(file: Path) -> None:
    config = load_config(file, {}, {})
    assert config.boat == file.stem
    said = tomllib.loads(file.read_text())
    assert {"boat", "fleet", "hull", "limits", "driver", "link"} <= set(said)
    assert config.link.credentials.endswith(f"/credentials/{config.boat}")
    assert not config.link.insecure


def test_there_is_a_boat_of_each_driver() -> None:
    assert {load_config(file, {}, {}).driver.kind for file in BOATS} == {"can", "mavlink"}


@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.stem)
def test_a_unit_is_the_packages_own(unit: Path) -> None:
    assert unit.read_text() == template(unit.name)


@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.stem)
def test_systemd_finds_nothing_wrong_with_a_unit(unit: Path, tmp_path: Path) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        pytest.skip("systemd-analyze is not installed")
    program = tmp_path / "fleet"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    name = unit.name.replace("@.", "@b1.")
    text = unit.read_text().replace("/opt/fleet/bin/fleet", str(program))
    (tmp_path / name).write_text(text)

    def verified() -> str:
        argv = [analyze, "verify", str(tmp_path / name)]
        run = subprocess.run(argv, capture_output=True, text=True, check=False)
        return f"{run.returncode} {run.stdout}{run.stderr}"

    assert verified() == "0 "
    (tmp_path / name).write_text(text.replace("WatchdogSec", "WatchdogSek"))
    assert "WatchdogSek" in verified()


@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.stem)
def test_a_unit_starts_what_fleet_has_and_restarts_it_within_the_time_for_resuming(unit: Path) -> None:
    keys = dict(line.split("=", 1) for line in unit.read_text().splitlines() if "=" in line and line[0] not in "#")
    program, *argv = shlex.split(keys["ExecStart"])
    assert program == "/opt/fleet/bin/fleet"
    if "$FLEET_HUB_OPTIONS" in argv:
        options = re.search(r"^FLEET_HUB_OPTIONS=(.*)$", (DEPLOY / "hub.env").read_text(), re.MULTILINE)
        assert options is not None
        argv = [argv[0], *shlex.split(options[1])]
    takes(argv)
    assert (keys["Type"], keys["Restart"], keys["StartLimitIntervalSec"]) == ("notify", "always", "0")
    assert "RestartPreventExitStatus" not in keys, "an adapter that is not there yet is a wrong configuration too"
    worst_s = int(keys["WatchdogSec"]) + int(keys["TimeoutAbortSec"]) + int(keys["RestartSec"])
    assert worst_s + 10 < 60, "hung, aborted, started and ready before a mission is not resumed any more"


def test_a_unit_may_ask_the_kernel_how_wrong_the_clock_is() -> None:
    text = template("fleet-agent@.service")
    assert "SystemCallFilter=adjtimex clock_adjtime\n" in text
    assert "ProtectClock" not in [line.split("=")[0] for line in text.splitlines()]


def test_compose_names_what_is_there() -> None:
    assert set(COMPOSE["services"]) == {"agent", "hub"}
    for service in COMPOSE["services"].values():
        takes(service["command"])
        assert service["cap_drop"] == ["ALL"]
        for mount in service["volumes"]:
            source = mount.split(":")[0]
            assert source in COMPOSE["volumes"] or source in ("./boat.toml", "./credentials"), mount
    build = COMPOSE["services"]["agent"]["build"]
    context = (DEPLOY / build["context"]).resolve()
    assert context == ROOT
    assert (context / build["dockerfile"]).is_file()


def test_the_image_recipe_copies_what_is_there_and_what_is_not_kept_out() -> None:
    recipe = (DEPLOY / "Dockerfile").read_text().replace("\\\n", " ")
    ignored = (ROOT / ".dockerignore").read_text().splitlines()
    copies = [line for line in recipe.splitlines() if line.startswith("COPY") and "--from" not in line]
    copied = [name for line in copies for name in line.split()[1:-1]]
    assert {"pyproject.toml", "constraints.txt", "fleet"} <= set(copied)
    for name in copied:
        assert (ROOT / name).exists()
        assert f"!{name}" in ignored
    extras = re.search(r"^ARG EXTRAS=(.*)$", recipe, re.MULTILINE)
    known = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert extras is not None
    assert set(extras[1].split(",")) <= set(known)
