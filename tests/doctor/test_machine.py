"""What the computer on board shows, and what is said about it."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from fleet.agent.clock import UNDISCIPLINED_NS
from fleet.doctor import disk, machine
from fleet.doctor.keys import credentials

NOW = 1_790_000_000.0


@pytest.mark.parametrize(
    ("error_ns", "now_s", "verdict", "word"),
    [
        (3_000_000, NOW, "ok", "right to 3 ms"),
        (100_000_000, NOW, "ok", "right to 100 ms"),
        (400_000_000, NOW, "warn", "right to 0.4 s only"),
        (UNDISCIPLINED_NS, NOW, "warn", "nothing disciplines it"),
        (3_000_000, 86_400.0, "fail", "it shows 1970-01-02"),
    ],
)
def test_a_clock(error_ns: int, now_s: float, verdict: str, word: str) -> None:
    found = machine.clock(error_ns, now_s)
    assert (found.verdict, found.found) == (verdict, word)
    assert bool(found.do) == (verdict != "ok")


def board(root: Path, **files: str) -> Path:
    """A machine as it shows itself in files."""
    places = {
        "load": "proc/loadavg",
        "governor": "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor",
        "temp": "sys/class/thermal/thermal_zone0/temp",
        "throttled": "sys/devices/platform/soc/soc:firmware/get_throttled",
    }
    for name, text in files.items():
        file = root / places[name]
        file.parent.mkdir(parents=True)
        file.write_text(text + "\n")
    return root


@pytest.mark.parametrize(
    ("files", "found"),
    [
        ({}, []),
        ({"governor": "ondemand", "temp": "48312", "throttled": "0x0"}, ["ok", "ok", "ok"]),
        ({"governor": "powersave"}, ["warn governor powersave"]),
        ({"load": "999.0 1 1 1/2 3"}, [f"warn load 999.0 on {os.cpu_count()} cores"]),
        ({"temp": "72000"}, ["warn 72 degrees C"]),
        ({"temp": "81000"}, ["fail 81 degrees C"]),
        ({"temp": "n/a", "throttled": "?", "governor": "\xff"}, ["ok"]),
        ({"throttled": "50005"}, ["fail supply voltage too low, throttled"]),
        ({"throttled": "0x50000"}, ["warn since the start: supply voltage too low, throttled"]),
        ({"throttled": "0x10008"}, ["fail too hot", "warn since the start: supply voltage too low"]),
    ],
)
def test_processor_and_supply(tmp_path: Path, files: dict[str, str], found: list[str]) -> None:
    seen = list(machine.processor(board(tmp_path, **files)))
    if all(word == "ok" for word in found):
        assert all(one.verdict == "ok" for one in seen)
    else:
        assert [f"{one.verdict} {one.found}" for one in seen] == found
        assert all(one.do for one in seen)


def test_versions_of_a_driver_whose_library_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(machine.LIBRARIES, "can", ("python-can", "no-such-library"))
    wrong = [one for one in machine.versions("can") if one.verdict == "fail"]
    assert [one.found for one in wrong] == ["no-such-library is not installed"]
    assert "pip install 'fleet-usv[can]'" in wrong[0].do
    assert all(one.verdict == "ok" for one in machine.versions("mavlink"))


# -- disk and credentials ----------------------------------------------------------------------------------------------
def test_a_state_folder_is_tried_and_left_as_it_was(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "yet"
    found = list(disk.disk(folder))
    assert found[0].verdict == "ok"
    assert found[0].found == f"{folder} can be made"
    assert not list(tmp_path.iterdir())
    assert next(iter(disk.disk(tmp_path))).found == f"{tmp_path} can be written to"


def test_a_state_folder_that_is_a_file_or_on_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    (wrong,) = disk.disk(tmp_path / "file")
    assert (wrong.verdict, wrong.found) == ("fail", f"{tmp_path / 'file'}: Not a directory")
    for free, verdict in ((2_000_000_000, "ok"), (500_000_000, "warn"), (50_000_000, "fail")):
        usage = type("Usage", (), {"free": free})
        monkeypatch.setattr(disk.shutil, "disk_usage", lambda place, usage=usage: usage)
        assert list(disk.disk(tmp_path))[-1].verdict == verdict


def test_credentials_that_are_missing_anothers_open_or_about_to_end(tmp_path: Path) -> None:
    from fleet.wire.credentials.authority import create

    def look(folder: Path, boat: str = "b1") -> list[tuple[str, str]]:
        return [(one.verdict, one.found) for one in credentials(str(folder), "demo", boat)]

    assert not list(credentials("", "demo", "b1"))
    missing = tmp_path / "b1"
    assert look(missing) == [("fail", f"{missing}: no such folder; expected one made by `fleet credentials`")]
    founded = create(tmp_path / "shore", "demo", time.time())
    folder = founded.issue("boat", "b1", time.time(), days=365.0, hosts=[], renew=False)
    ((verdict, found),) = look(folder)
    assert verdict == "ok"
    assert found.startswith(f"{folder}: valid until ")
    assert look(folder, "b2")[0][0] == "fail", "another boat's"
    (folder / "own.key").chmod(0o640)
    ((verdict, found),) = look(folder)
    assert verdict == "fail"
    assert "expected 0600" in found
    soon = founded.issue("boat", "b3", time.time(), days=7.0, hosts=[], renew=False)
    ((verdict, found),) = look(soon, "b3")
    assert verdict == "warn"
    assert "its certificate ends in" in found
