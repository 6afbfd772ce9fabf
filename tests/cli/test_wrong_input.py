"""Wrong command lines: the message on stderr, nothing on stdout, and the exit code."""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet.cli.main import main

NOBODY = "tcp/127.0.0.1:1"

WRONG: list[tuple[list[str], int, str]] = [
    (["sail"], 2, "No such command 'sail'."),
    (["statsu"], 2, "No such command 'statsu'. Did you mean 'status'?"),
    (["sim"], 2, "error: expected a MISSION (fleet mission list names the ready ones), or --case"),
    (["sim", "overtakin"], 2, 'error: overtakin: neither a file nor a ready mission; did you mean "overtaking"?'),
    (["sim", "overtaking", "--warp", "0"], 2, "error: --warp 0: expected 0.1 to 100"),
    (["sim", "overtaking", "--warp", "101"], 2, "error: --warp 101: expected 0.1 to 100"),
    (["sim", "overtaking", "--warp", "nan"], 2, "error: --warp nan: expected 0.1 to 100"),
    (["sim", "overtaking", "--warp", "fast"], 2, "Invalid value for '--warp'"),
    (["sim", "overtaking", "--boats", "0"], 2, "error: --boats 0: expected 1 to 1000"),
    (["sim", "overtaking", "--boats", "many"], 2, "Invalid value for '--boats': 'many': expected a whole number"),
    (["sim", "overtaking", "--seed", "-1"], 2, "error: --seed -1: expected 0 to 1000000000"),
    (["sim", "overtaking", "--topology", "star"], 2, "Invalid value for '--topology'"),
    (
        ["sim", "overtaking", "--method", "circel"],
        2,
        'keeping_clear.method = "circel" (--method): no such method; did you mean "circle"?',
    ),
    (["sim", "overtaking", "--set", "formation.spacing_m"], 2, "expected dotted.key=value"),
    (["sim", "overtaking", "--set", "formation.spacing_m=3"], 2, "b1 and b2 are 3.0 m apart on path line"),
    (["mission", "check", "nowhere.toml"], 2, "error: nowhere.toml: neither a file nor a ready mission"),
    (["mission", "show", "overtaking", "--out", "a.txt"], 2, "error: --out a.txt: expected a name that ends in .png"),
    (["mission", "show", "overtaking", "--out", "/no/where/a.png"], 2, "error: --out /no/where/a.png: No such file"),
    (["run", "show"], 1, "error: no run in"),
    (["run", "repair", "yesterday"], 1, "error: no run in"),
    (["set", "spacing"], 2, "Missing argument 'VALUE'."),
    (["set", "spacing", "far"], 2, "error: spacing 'far': expected a number in m"),
    (["set", "spacing", "nan", "--yes"], 2, "error: spacing 'nan': expected a number in m"),
    (["set", "speed", "-inf", "--yes"], 2, "error: speed '-inf': expected a number in m/s"),
    (["set", "depth", "3"], 2, "error: set 'depth': expected one of spacing, lateral, speed, pattern, leader, slots"),
    (["set", "lateral", "wide"], 2, "error: lateral 'wide': expected a number in m"),
    (["set", "spacing", "-20"], 2, "error: set spacing asks before it is sent, and there is no terminal to ask on"),
    (["launch", "overtaking"], 2, "error: launch asks before it is sent"),
    (["launch", "overtaking", "--in", "-1", "--yes"], 2, "error: --in -1: expected at least 0 and at most 600 s"),
    (["resume"], 2, "error: resume asks before it is sent"),
    (["return"], 2, "error: return asks before it is sent"),
    (["release"], 2, "error: release asks before it is sent"),
    (["forget", "b1"], 2, "error: forget asks before it is sent"),
    (["forget"], 2, "Missing argument 'BOAT...'."),
    (["resume", "--at", "here"], 2, "error: --at 'here': expected nearest, or an abscissa in m"),
    (["hold", "B 1"], 2, "error: boat 'B 1': expected 1 to 32 of a-z, 0-9 and -"),
    (["hold", "--connect", "localhost"], 2, "error: --connect 'localhost': expected an endpoint such as tcp/127.0.0.1"),
    (["hold", "--connect", "tcp/127.0.0.1:99999"], 2, "expected an endpoint such as tcp/127.0.0.1:7447"),
    (["hold", "--timeout", "0"], 2, "error: --timeout 0: expected more than 0 and at most 600 s"),
    (["hold", "--timeout", "nan"], 2, "error: --timeout nan: expected more than 0 and at most 600 s"),
    (["hold", "--fleet", "My Fleet"], 2, "error: fleet 'My Fleet': expected 1 to 32 of a-z, 0-9 and -"),
    (["hold", "--operator", "operator"], 2, "error: operator 'operator': this name is kept for operators"),
    (["hold", "--connect", NOBODY, "--timeout", "0.3"], 4, f"error: nothing answers at {NOBODY}"),
    (["status", "--connect", NOBODY, "--timeout", "0.3"], 4, f"error: nothing answers at {NOBODY}"),
    (["agent", "--check"], 2, "error: boat: no name given; expected --boat NAME"),
    (
        ["agent", "--boat", "B1", "--topology", "hub", "--connect", NOBODY, "--check"],
        2,
        "error: boat 'B1': expected 1 to 32",
    ),
    (["agent", "--boat", "b1", "--config", "no.toml", "--check"], 2, "error: no.toml: no such file"),
    (["agent", "--boat", "b1", "--control-hz", "0", "--check"], 2, "control_hz = 0: expected a number from 1 to 100"),
    (
        ["agent", "--boat", "b1", "--topology", "star", "--check"],
        2,
        'link.topology = "star": expected one of hub, mesh, routed',
    ),
    (["agent", "--boat", "b1", "--listen", "7447"], 2, "error: --listen '7447': expected an endpoint"),
    (["hub", "--listen", "7447"], 2, "error: --listen '7447': expected an endpoint such as tcp/127.0.0.1:7447"),
    (["hub", "--listen", "tcp/192.0.2.1:7447"], 2, "leaves this machine without credentials"),
    (
        ["hub", "--listen", "tcp/192.0.2.1:7447", "--insecure"],
        1,
        "error: cannot listen at tcp/192.0.2.1:7447: Cannot assign",
    ),
    (["hub", "--listen", "tls/127.0.0.1:7447"], 2, "error: --listen 'tls/127.0.0.1:7447' needs credentials"),
    (
        ["hub", "--credentials", "/nowhere"],
        2,
        "error: /nowhere: no such folder; expected one made by `fleet credentials`",
    ),
    (["status", "--connect", "tcp/192.0.2.1:7447"], 2, "error: --connect 'tcp/192.0.2.1:7447' leaves this machine"),
    (["gcs", "--endpoint", "tcp:127.0.0.1:1"], 2, "error: --endpoint 'tcp:127.0.0.1:1': expected udp:HOST:PORT or"),
    (["gcs", "--endpoint", "udp:10.0.0.5:14550"], 2, "expected --signing-key FILE, or --insecure on a network"),
    (["gcs", "--autopilot", "px4"], 2, "error: --autopilot 'px4': expected ardupilot or generic"),
    (["gcs", "--sysid", "b1=0"], 2, "error: --sysid 'b1=0': expected BOAT=N with N from 1 to 250, such as b1=1"),
    (["gcs", "--sysid", "b1=3,b2=3"], 2, "error: --sysid 'b2=3': b1 has 3 already"),
    (["gcs", "--template", "nowhere.toml"], 2, "error: nowhere.toml: neither a file nor a ready mission"),
    (["gcs", "--signing-key", "/nowhere", "--connect", NOBODY], 2, "error: --signing-key '/nowhere': No such file"),
    (["gcs", "--connect", NOBODY], 4, "error: nothing answers at tcp/127.0.0.1:1"),
    (["status", "--credentials", "/nowhere"], 2, "error: /nowhere: no such folder"),
    (["credentials", "show", "/nowhere"], 2, "error: /nowhere/roster.json: no such file; expected the signed roster"),
    (["credentials", "boat", "b1", "--authority", "/nowhere"], 2, "error: /nowhere: no such folder"),
    (["sim", "overtaking", "--credentials", "/nowhere"], 2, "error: --credentials /nowhere: no folder 'b1'; expected"),
]


@pytest.mark.parametrize(("argv", "code", "message"), WRONG, ids=[" ".join(row[0]) for row in WRONG])
def test_wrong_input(
    argv: list[str],
    code: int,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("FLEET", "CONNECT", "OPERATOR", "BOAT", "RUNS", "CONFIG", "TRACE"):
        monkeypatch.delenv(f"FLEET_{name}", raising=False)
    assert main(argv) == code
    said = capfd.readouterr()
    words = " ".join(said.err.replace("`$.", "`").split())
    assert message in words or message.replace(" - at", " at") in words
    assert said.out == ""
    assert "Traceback" not in said.err
    assert list(tmp_path.iterdir()) == []
