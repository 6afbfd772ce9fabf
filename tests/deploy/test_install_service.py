"""`fleet agent check` and `fleet agent install-service`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from fleet.agent import service as fleet_service
from fleet.agent.config import load_config
from fleet.agent.service import MARK, service_of
from fleet.cli.main import main
from fleet.errors import UsageError
from tests.cli.terminal import here

PROGRAM = Path("/opt/fleet/bin/fleet")


@pytest.fixture
def boat(tmp_path: Path) -> Path:
    file = tmp_path / "otter-1.toml"
    file.write_text('boat = "otter-1"\n[link]\ntopology = "hub"\n')
    return file


# -- check -------------------------------------------------------------------------------------------------------------
def test_a_good_file_is_said_in_a_line_and_a_bad_one_with_every_misfit(boat: Path) -> None:
    good = here("agent", "check", str(boat))
    assert (good.returncode, good.stdout) == (0, f"{boat}: boat otter-1 of fleet demo, driver simulated\n")
    boat.write_text('boat = "otter-1"\nslots = 0\nspeed = 3\n')
    bad = here("agent", "check", str(boat))
    assert (bad.returncode, bad.stdout) == (2, "")
    assert len(bad.stderr.splitlines()) == 2
    told = json.loads(here("agent", "check", str(boat), "--json").stdout)
    assert (told["fit"], len(told["misfits"])) == (False, 2)


def test_the_environment_does_not_count_in_a_check(boat: Path) -> None:
    assert here("agent", "check", str(boat), FLEET_BOAT="NO NAME").returncode == 0
    assert here("agent", "--config", str(boat), "--check", FLEET_BOAT="NO NAME").returncode == 2


def test_an_open_link_is_said(boat: Path) -> None:
    boat.write_text('boat = "otter-1"\n[link]\nlisten = ["tcp/0.0.0.0:7447"]\n')
    refused = here("agent", "check", str(boat))
    assert refused.returncode == 2
    assert "link.insecure = true" in refused.stderr
    boat.write_text('boat = "otter-1"\n[link]\nlisten = ["tcp/0.0.0.0:7447"]\ninsecure = true\n')
    meant = here("agent", "check", str(boat))
    assert meant.returncode == 0
    assert "INSECURE" in meant.stderr


# -- the unit ----------------------------------------------------------------------------------------------------------
def test_the_unit_is_printed_and_nothing_is_written(boat: Path) -> None:
    run = here("agent", "install-service", "--config", str(boat))
    assert run.returncode == 0
    assert run.stdout.startswith(MARK)
    assert f" agent --config {boat}\n" in run.stdout
    assert list(boat.parent.iterdir()) == [boat]


def test_what_a_boat_writes_elsewhere_is_opened_and_nothing_more(boat: Path) -> None:
    plain = service_of(load_config(boat, {}, {}), Path("/etc/fleet/otter-1.toml"), PROGRAM)
    assert plain.name == "fleet-agent@otter-1.service"
    assert "StateDirectory=fleet/%i\n" in plain.text
    assert "ReadWritePaths" not in plain.text
    assert "ProtectHome=yes\nPrivateTmp=yes\n" in plain.text
    text = boat.read_text()
    boat.write_text('state_dir = "/srv/fleet"\nrecord = "/data/run.mcap"\n' + text)
    other = service_of(load_config(boat, {}, {}), Path("/home/anna/otter-1.toml"), PROGRAM, "anna")
    assert "ReadWritePaths=/srv/fleet\nReadWritePaths=/data\n" in other.text
    assert "StateDirectory" not in other.text
    assert "ProtectHome=read-only\n" in other.text
    assert "User=anna\n" in other.text


def test_newer_rosters_may_be_kept_beside_the_certificate(boat: Path) -> None:
    boat.write_text(
        'boat = "otter-1"\n[link]\ntopology = "hub"\nconnect = ["tls/10.0.0.2:7447"]\ncredentials = "/srv/keys"\n'
    )
    text = service_of(load_config(boat, {}, {}), Path("/etc/fleet/otter-1.toml"), PROGRAM).text
    assert "ReadWritePaths=-/srv/keys\n" in text


def test_a_path_that_systemd_would_read_otherwise_is_refused(boat: Path) -> None:
    config = load_config(boat, {}, {})
    for wrong in ("/etc/my fleet/b.toml", "/etc/50%/b.toml", '/etc/"b".toml', "/etc/$X.toml"):
        with pytest.raises(UsageError, match="expected a path of letters"):
            service_of(config, Path(wrong), PROGRAM)


def test_systemd_finds_nothing_wrong_with_what_is_printed(boat: Path, tmp_path: Path) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        pytest.skip("systemd-analyze is not installed")
    unit = tmp_path / "fleet-agent@otter-1.service"
    unit.write_text(here("agent", "install-service", "--config", str(boat)).stdout)
    run = subprocess.run([analyze, "verify", str(unit)], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


# -- installing it -----------------------------------------------------------------------------------------------------
def test_it_is_installed_below_a_folder_once_and_again(boat: Path, tmp_path: Path) -> None:
    root = tmp_path / "image"
    apply = ("agent", "install-service", "--config", str(boat), "--apply", "--root", str(root))
    first = here(*apply)
    unit = root / "etc/systemd/system/fleet-agent@otter-1.service"
    assert (first.returncode, first.stdout.splitlines()[0]) == (0, f"{unit}: written")
    assert unit.read_text() == here("agent", "install-service", "--config", str(boat)).stdout
    assert (root / "etc/sysusers.d/fleet.conf").read_text().startswith("u fleet ")
    assert f"{unit}: as it should be" in here(*apply).stdout
    boat.write_text(boat.read_text() + "lease_ms = 1000\n")
    boat.write_text('state_dir = "/srv/fleet"\n' + boat.read_text())
    assert f"{unit}: written" in here(*apply).stdout, "its own file is replaced"
    assert "ReadWritePaths=/srv/fleet" in unit.read_text()


def test_somebody_elses_file_is_left_alone_without_force(boat: Path, tmp_path: Path) -> None:
    root = tmp_path / "image"
    unit = root / "etc/systemd/system/fleet-agent@otter-1.service"
    unit.parent.mkdir(parents=True)
    unit.write_text("[Unit]\nDescription=mine\n")
    apply = ("agent", "install-service", "--config", str(boat), "--apply", "--root", str(root))
    refused = here(*apply)
    assert refused.returncode == 1
    assert "not written by this command; --force overwrites it" in refused.stderr
    assert unit.read_text() == "[Unit]\nDescription=mine\n"
    assert here(*apply, "--force").returncode == 0
    assert unit.read_text().startswith(MARK)


def test_without_root_it_is_refused_in_words(
    boat: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def never(*_: object, **__: object) -> list[str]:
        raise AssertionError("written without being root")

    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setattr(fleet_service, "install", never)
    assert main(["agent", "install-service", "--config", str(boat), "--apply"]) == 1
    assert "needs root: sudo" in capsys.readouterr().err
