"""The whole look, in the order in which one thing hangs on the other."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from fleet.agent.clock import kernel_error_ns
from fleet.agent.config import AgentConfig
from fleet.doctor import disk, hardware, machine, reach, wiring
from fleet.doctor.finding import Finding, ok, warn
from fleet.doctor.keys import credentials

UNITS = Path("/etc/systemd/system")
STATE = Path("/var/lib/fleet")  # of the unit's StateDirectory=


def examine(config: AgentConfig | None, patience_s: float) -> Iterator[Finding]:
    """Findings as they are made; without a configuration only about the machine."""
    yield from machine.versions(config.driver.kind if config is not None else "")
    yield machine.clock(kernel_error_ns())
    yield from machine.processor()
    if config is None:
        yield from disk.disk(Path.home() / ".local" / "state" / "fleet")
        yield warn("boat", "no configuration was named: only the machine was looked at", "fleet doctor --config FILE")
        return
    agent = wiring.agent_of(config.fleet, config.boat)
    service = _service(config.boat, agent)
    yield service
    if os.geteuid() == 0:
        yield warn("user", "looked at as root, who may do everything", "once more as who runs the agent: sudo -u fleet")
    kept = STATE / config.boat if service.verdict == "ok" and not config.state_dir else config.folder()
    yield from disk.disk(kept)
    if config.record not in ("", "none"):
        yield from disk.disk(Path(config.record).absolute().parent, "recordings")
    yield from credentials(config.link.credentials, config.fleet, config.boat)
    for device, what in wiring.serial_devices(config.driver).items():
        yield wiring.serial_line(device, what)
    if config.driver.kind == "can" and config.driver.can.interface == "socketcan":
        yield from wiring.can_link(config.driver.can.channel)
    yield from reach.links(config, patience_s)
    yield from hardware.driver(config, agent, patience_s)


def _service(boat: str, agent: int) -> Finding:
    """Whether the agent is started when the computer is."""
    unit = f"fleet-agent@{boat}.service"
    wanted = UNITS / "multi-user.target.wants" / unit
    runs = f"; it runs, process {agent}" if agent else ""
    if wanted.is_symlink() or wanted.exists():
        return ok("service", f"{unit} is enabled{runs}")
    return warn(
        "service",
        f"nothing starts the agent at the computer's start{runs}",
        f"fleet agent install-service --apply, then systemctl enable --now {unit.removesuffix('.service')}",
    )
