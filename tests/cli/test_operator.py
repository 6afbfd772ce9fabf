"""An operator's commands against a real hub, a world and two agents, in the order of a day at sea."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.conftest import LONG, Afloat
from tests.cli.terminal import FLEET, environment, running, until

pytestmark = pytest.mark.sails
SCRIPT = Path(__file__).parents[2] / "docs" / "script.md"


def boats(afloat: Afloat) -> dict[str, dict[str, object]]:
    return {one["boat"]: one for one in json.loads(afloat.fleet("status", "--json").stdout)["boats"]}


def modes(afloat: Afloat) -> list[object]:
    return [one["mode"] for one in boats(afloat).values()]


def on_a_terminal(afloat: Afloat, answer: str, *argv: str) -> tuple[int, str, str]:
    """Run with a terminal to ask on, and answer; exit code, stdout, what the terminal showed."""
    ours, theirs = pty.openpty()
    link = {"FLEET_FLEET": "sim", "FLEET_CONNECT": afloat.connect, "FLEET_OPERATOR": "anna"}
    child = subprocess.Popen(
        [*FLEET, *argv], stdin=theirs, stderr=theirs, stdout=subprocess.PIPE, env=environment(**link), text=True
    )
    os.close(theirs)
    shown = ""
    while "[y/N]" not in shown:
        shown += os.read(ours, 4096).decode()
    os.write(ours, f"{answer}\n".encode())
    out, _ = child.communicate(timeout=30)
    while True:
        try:
            more = os.read(ours, 4096)
        except OSError:  # the terminal is closed
            break
        if not more:
            break
        shown += more.decode()
    os.close(ours)
    return child.returncode, out, shown


def test_there_is_nothing_to_set_before_a_launch(afloat: Afloat) -> None:
    ended = afloat.fleet("set", "spacing", "15", "--yes")
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == "error: no boat of fleet 'sim' holds a mission: `fleet launch MISSION` first\n"


def test_launch_asks_with_target_old_and_new(afloat: Afloat) -> None:
    changes = [word for change in LONG for word in ("--set", change)]
    code, out, shown = on_a_terminal(afloat, "n", "launch", "overtaking", *changes)
    assert (code, out) == (1, "")
    assert f"launch: fleet sim at {afloat.connect}, ALL 2 boats (b1, b2): none -> Two boats on one line" in shown
    assert "not confirmed: nothing was sent" in shown
    code, out, shown = on_a_terminal(afloat, "y", "launch", "overtaking", *changes)
    assert code == 0, shown
    assert out.splitlines()[1:] == ["  b1  acknowledged", "  b2  acknowledged"]
    until(lambda: modes(afloat) == ["follow", "follow"], "both boats follow")


def test_plotters_see_the_boats_as_ais_targets(afloat: Afloat) -> None:
    from pyais import decode

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plotter:
        plotter.bind(("127.0.0.1", 0))
        plotter.settimeout(30.0)
        where = f"127.0.0.1:{plotter.getsockname()[1]}"
        argv = [*FLEET, "export", "ais", "--udp", where, "--mmsi", "b2=235000001", "--interval", "0.5"]
        link = environment(FLEET_FLEET="sim", FLEET_CONNECT=afloat.connect)
        child = subprocess.Popen(argv, env=link, stderr=subprocess.PIPE, text=True)
        names: dict[int, str] = {}
        places: dict[int, float] = {}
        while len(names) < 2 or len(places) < 2:
            said = decode(plotter.recv(1024))
            if said.msg_type == 24 and said.partno == 0:
                names[said.mmsi] = said.shipname
            elif said.msg_type == 18:
                places[said.mmsi] = said.lat
        child.send_signal(signal.SIGTERM)
        _, told = child.communicate(timeout=30)
    assert child.returncode == 0, told
    (own,) = set(names) - {235000001}
    assert names == {own: "SIM B1", 235000001: "SIM B2"}
    assert 200_000_000 <= own < 201_000_000
    assert all(abs(lat - 44.38) < 0.01 for lat in places.values())
    assert f"b1  MMSI {own}" in told


def test_status_shows_every_boat(afloat: Afloat) -> None:
    ended = afloat.fleet("status")
    assert ended.returncode == 0
    head, *_ = ended.stdout.splitlines()
    assert head == "fleet sim: 2 of 2 boats alive; control: anna"
    assert "formation: spacing 20 m, cruise 1 m/s, revision 0:launch" in ended.stdout
    one = boats(afloat)["b1"]
    assert one["mode"] == "follow"
    assert one["controller"] == "anna"
    assert one["nearest"] == "b2"
    assert 0.0 <= one["age_s"] < 2.0


def test_set_takes_a_negative_number_and_prints_old_and_new(afloat: Afloat) -> None:
    ended = afloat.fleet("set", "spacing", "-20", "--yes")
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.splitlines() == ["set spacing: 20 m -> -20 m", "  b1  acknowledged", "  b2  acknowledged"]
    answer = json.loads(afloat.fleet("set", "speed", "1.1", "--yes", "--json").stdout)
    assert (answer["old"], answer["new"], answer["ok"], answer["exit_code"]) == ("1 m/s", "1.1 m/s", True, 0)
    assert answer["boats"]["b1"]["answer"] == "acknowledged"


def test_what_cannot_be_sailed_is_refused_before_anything_moves(afloat: Afloat) -> None:
    assert afloat.fleet("set", "pattern", "wegde", "--yes").returncode == 2
    assert afloat.fleet("set", "leader", "b9", "--yes").stderr.startswith("error: leader 'b9': no such boat")
    double = afloat.fleet("set", "slots", "b2=1", "--yes")
    assert double.returncode == 5
    assert double.stderr == "error: set slots b2=1: slots: b1 and b2 both have slot 1 on path line\n"
    ended = afloat.fleet("set", "spacing", "5", "--yes")
    assert (ended.returncode, ended.stdout) == (5, "")
    assert ended.stderr.startswith("error: set spacing 5: ")
    assert "at least 8.0 m" in ended.stderr


def test_another_operator_is_refused_until_he_takes_control_but_may_always_hold(afloat: Afloat) -> None:
    ended = afloat.fleet("set", "speed", "1.0", "--yes", operator="berta")
    assert ended.returncode == 3
    assert "b1  refused: anna holds control; `fleet take` takes it over" in ended.stdout
    assert ended.stderr == "error: 2 of 2 boats did not acknowledge\n"
    assert afloat.fleet("hold", operator="berta").returncode == 0
    until(lambda: modes(afloat) == ["hold", "hold"], "both boats hold")
    taken = afloat.fleet("take", operator="berta")
    assert (taken.returncode, taken.stdout.splitlines()[0]) == (0, "take: anna -> berta")
    assert afloat.fleet("take").returncode == 0


def test_resume_of_one_boat(afloat: Afloat) -> None:
    ended = afloat.fleet("resume", "b1", "--yes")
    assert (ended.returncode, ended.stdout.splitlines()) == (0, ["resume: hold -> follow", "  b1  acknowledged"])
    until(lambda: boats(afloat)["b1"]["mode"] in ("follow", "avoid"), "b1 follows")
    assert boats(afloat)["b2"]["mode"] == "hold"


def test_a_stop_must_be_released_before_the_boat_moves(afloat: Afloat) -> None:
    assert afloat.fleet("stop-now", "b1").returncode == 0
    until(lambda: boats(afloat)["b1"]["mode"] == "neutral", "b1 is neutral")
    refused = afloat.fleet("resume", "b1", "--yes")
    assert refused.returncode == 5
    assert "release first" in refused.stdout
    assert afloat.fleet("release", "b1", "--yes").returncode == 0
    until(lambda: boats(afloat)["b1"]["mode"] == "hold", "b1 holds")


def test_who_does_not_answer_is_named(afloat: Afloat) -> None:
    ended = afloat.fleet("hold", "b1", "b9", "--timeout", "1")
    assert ended.returncode == 3
    assert ended.stdout.splitlines()[1:] == ["  b1  acknowledged", "  b9  not answered"]
    assert afloat.fleet("hold", "b9", "--timeout", "0.5").returncode == 4


def test_a_boat_that_is_alive_is_not_forgotten(afloat: Afloat) -> None:
    ended = afloat.fleet("forget", "b2", "--yes")
    assert (ended.returncode, ended.stderr) == (2, "error: forget b2: still alive; expected boats that fell silent\n")


def test_watch_gives_a_line_of_json_at_a_time(afloat: Afloat) -> None:
    link = {"FLEET_FLEET": "sim", "FLEET_CONNECT": afloat.connect}
    with running("status", "--watch", "--json", **link) as watch:
        assert watch.stdout is not None
        lines = [json.loads(watch.stdout.readline()) for _ in range(3)]
        watch.send_signal(2)
        assert watch.wait(10) == 130
    assert all([one["boat"] for one in line["boats"]] == ["b1", "b2"] for line in lines)
    assert lines[0]["stamp_ns"] < lines[1]["stamp_ns"]


def test_the_script_in_the_manual_runs(afloat: Afloat) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", SCRIPT.read_text(encoding="utf-8"), re.DOTALL)
    assert len(block.splitlines()) == 15
    assert "tcp/127.0.0.1:7447" in block
    assert afloat.fleet("resume", "--yes").returncode == 0
    ended = subprocess.run(
        [sys.executable, "-c", block.replace("tcp/127.0.0.1:7447", afloat.connect)],
        capture_output=True,
        text=True,
        timeout=60,
        env=environment(),
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert "acknowledged" in ended.stdout
    assert "in formation" in ended.stdout


def test_abort_ends_the_mission(afloat: Afloat) -> None:
    ended = afloat.fleet("abort")
    assert ended.returncode == 0
    until(lambda: not any(one["mission_id"] for one in boats(afloat).values()), "no boat holds a mission")
