"""A run that never was: two boats overtake each other on a straight path, as a simulator would record it."""

from __future__ import annotations

import math
from pathlib import Path

from fleet.recording.runs import Run
from fleet.recording.topics import (
    EVENT,
    Event,
    State,
    Status,
    Truth,
    declare_boat,
    declare_fleet,
    encode,
    state_topic,
    status_topic,
    truth_topic,
)
from fleet.recording.writer import Recorder

T0 = 1_790_000_000_000_000_000
CHANGE_S, DURATION_S = 20.0, 120.0

MISSION = """
title = "Overtaking on a straight path <&>"
duration_s = 120.0
datum = { lat_deg = 44.1, lon_deg = 9.8 }
[paths.line]
kind = "straight"
start = [0.0, 0.0]
end = [200.0, 0.0]
[formation]
spacing_m = 20.0
cruise_mps = 1.0
[[boats]]
name = "red"
path = "line"
slot = 1.0
start = { s_m = 20.0 }
[[boats]]
name = "blue"
path = "line"
slot = 0.0
start = { s_m = 0.0 }
[checks]
min_separation_m = 5.0
collisions = 0
"""


def bump(t: float) -> float:
    """0 to 1 and back while they pass."""
    return math.exp(-(((t - 55.0) / 9.0) ** 2))


def sail(folder: Path, names: tuple[str, str] = ("red", "blue")) -> Run:
    """Write the run."""
    run = Run(folder)
    folder.mkdir(parents=True, exist_ok=True)
    run.mission_file.write_text(MISSION)
    recorder = Recorder(run.recording, {"mission": "overtaking"}, wait=True)
    declare_fleet(recorder)
    s = [20.0, 0.0]
    speed = [0.0, 0.0]
    for name in names:
        declare_boat(recorder, name, truth=True)
    for tick in range(int(DURATION_S * 10) + 1):
        t = tick / 10.0
        stamp = T0 + tick * 100_000_000
        spacing = 20.0 if t < CHANGE_S else -20.0
        if abs(t - CHANGE_S) < 0.01:
            for name in names:
                event = Event(stamp_ns=stamp, boat=name, kind="formation", text="spacing 20 -> -20 m", value=-20.0)
                recorder.put(EVENT, stamp, encode(event))
        error = (s[1] - 0.0) - (s[0] - spacing)
        for i, name in enumerate(names):
            e = error if i == 0 else -error
            wanted = 1.0 + 0.3 * math.tanh(0.3 * e)
            speed[i] += (wanted - speed[i]) * 0.1 / 2.0
            s[i] += speed[i] * 0.1
            side = 4.0 if i == 0 else -4.0
            avoiding = 40.0 < t < 70.0
            truth = Truth(
                stamp_ns=stamp, x_m=s[i], y_m=side * bump(t), psi_rad=0.0, u_mps=speed[i], v_mps=0.0, r_radps=0.0,
                vx_mps=speed[i], vy_mps=0.0, lat_deg=44.1, lon_deg=9.8, length_m=2.4,
            )  # fmt: skip
            state = State(
                stamp_ns=stamp, x_m=s[i], y_m=side * bump(t), psi_rad=0.0, sog_mps=speed[i], u_d_mps=wanted,
                s_m=s[i], mode="avoid" if avoiding else "follow", reasons=["avoiding"] if avoiding else [],
                y_e_m=side * bump(t), e_s_m=e, spacing_m=spacing, avoiding=avoiding,
            )  # fmt: skip
            recorder.put(truth_topic(name), stamp, encode(truth))
            recorder.put(state_topic(name), stamp, encode(state))
            if avoiding and abs(t - 40.1) < 0.01:
                event = Event(
                    stamp_ns=stamp, boat=name, kind="avoid", text="keeps clear of the other", reasons=["ahead"]
                )
                recorder.put(EVENT, stamp, encode(event))
            if tick % 10 == 0:
                recorder.put(status_topic(name), stamp, encode(Status(stamp_ns=stamp, ticks=tick, messages_lost=1)))
    recorder.close()
    assert not recorder.trouble
    return run
