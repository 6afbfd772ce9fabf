"""A driver is told which commands of operators were accepted, each once, and no others."""

from __future__ import annotations

from pathlib import Path

from fleet.agent.process import join
from tests.agent.harness import Sea, mission


def test_accepted_commands_are_told_once_and_refused_ones_not(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(boats=1))
    heard: list[str] = []
    sea.agent("b1").orders.obeyed = heard.append
    sea.run(0.5)
    sea.command("resume")
    assert heard == [], "there is no mission to resume"
    sea.launch()
    sea.command("take", command_id="same")
    sea.command("take", command_id="same")
    sea.command("launch", operator="bert", order=sea.mission_words(operator="bert"))
    assert heard == ["launch", "take"], "the second take was the first, and bert does not hold control"


def test_what_hardware_says_becomes_an_event(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(boats=1))
    agent = sea.agent("b1")

    class Talks:
        """Hardware that waits for operators, and speaks."""

        simulated = True

        def __init__(self) -> None:
            self.heard: list[str] = []
            self.said_so = ["PreArm: GPS 1: Bad fix"]

        def obeyed(self, kind: str) -> None:
            self.heard.append(kind)

        def said(self) -> list[str]:
            said, self.said_so = self.said_so, []
            return said

    hardware = Talks()
    sea.each_tick.append(join(agent, hardware))  # type: ignore[arg-type]
    sea.run(1.0)
    assert sea.says("b1", "autopilot") == ["PreArm: GPS 1: Bad fix"]
    sea.command("take")
    assert hardware.heard == ["take"]
