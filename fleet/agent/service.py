"""The systemd unit of one boat: from its configuration to text, and onto a machine."""

from __future__ import annotations

import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

from msgspec import Struct

from fleet.agent.config import AgentConfig
from fleet.errors import FleetError, UsageError

MARK = "# Written by `fleet agent install-service`"
USER = "fleet"
SYSUSERS = 'u fleet - "fleet agent" /var/lib/fleet\n'
HOMES = ("/home", "/root", "/run/user")  # what ProtectHome= hides
PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/._-+@=,")


class Service(Struct, frozen=True):
    """What is to be installed."""

    name: str  # fleet-agent@b1.service
    text: str
    user: str


def template(name: str) -> str:
    """A unit as `deploy/systemd/` has it."""
    return (files("fleet.agent") / "units" / name).read_text(encoding="utf-8")


def service_of(config: AgentConfig, config_file: Path, program: Path, user: str = USER) -> Service:
    """The unit of this boat.

    Args:
        config: the boat's
        config_file: where it was read from; the unit names it
        program: `fleet`, as it is to be started
        user: who runs it

    Raises:
        UsageError: a path that cannot stand in a unit
    """
    config_file = config_file.absolute()
    paths = [program, config_file, *_written(config)]
    paths += [Path(config.link.credentials).absolute()] if config.link.credentials else []
    for path in paths:
        if set(str(path)) - PLAIN:
            raise UsageError(f"{path}: expected a path of letters, digits and {''.join(sorted(PLAIN - _LETTERS))}")
    lines = []
    for line in template("fleet-agent@.service").splitlines():
        key, _, _ = line.partition("=")
        if key == "ExecStart":
            lines.append(f"ExecStart={program} agent --config {config_file}")
        elif key == "User":
            lines.append(f"User={user}")
        elif key in ("StateDirectory", "StateDirectoryMode") and config.state_dir:
            continue
        elif key == "ReadWritePaths":
            lines += [f"ReadWritePaths={path}" for path in _written(config)]
            lines += [f"ReadWritePaths=-{Path(config.link.credentials).absolute()}"] if config.link.credentials else []
        elif key == "ProtectHome" and any(_below_a_home(path) for path in paths):
            lines.append("ProtectHome=read-only")
        elif key == "PrivateTmp" and any(path.is_relative_to("/tmp") for path in paths):
            continue
        else:
            lines.append(line)
    return Service(f"fleet-agent@{config.boat}.service", "\n".join(lines) + "\n", user)


_LETTERS = frozenset(character for character in PLAIN if character.isalnum())


def _written(config: AgentConfig) -> list[Path]:
    """Folders outside of the unit's own state directory that this boat writes to."""
    found = [Path(config.state_dir).absolute()] if config.state_dir else []
    if config.record not in ("", "none"):
        found.append(Path(config.record).absolute().parent)
    return list(dict.fromkeys(found))


def _below_a_home(path: Path) -> bool:
    return any(path.is_relative_to(home) for home in HOMES)


def install(service: Service, root: Path, *, force: bool = False) -> list[str]:
    """Put it below `root`; what was done, in lines. FleetError where something of somebody else is in the way.

    On the machine itself (`root` is /) systemd is told, too, and the user is made where there is none of the name.
    """
    place = root / "etc" / "systemd" / "system" / service.name
    told = [_put(place, service.text, force=force)]
    if service.user == USER:
        users = root / "etc" / "sysusers.d" / "fleet.conf"
        told.append(_put(users, SYSUSERS, force=force, marked=False))
        if root == Path("/"):
            told += _run("systemd-sysusers", str(users))
    if root == Path("/"):
        if Path("/run/systemd/system").is_dir():
            told += _run("systemctl", "daemon-reload")
        else:
            told.append("systemd does not run here: nothing was told to it")
    return told


def _put(place: Path, text: str, *, force: bool, marked: bool = True) -> str:
    """Write a file, whole or not at all."""
    try:
        if place.is_symlink() or place.exists():
            held = place.read_text(encoding="utf-8") if place.is_file() else ""
            if held == text:
                return f"{place}: as it should be"
            ours = marked and held.startswith(MARK)
            if not ours and not force:
                raise FleetError(f"{place}: is there already and not written by this command; --force overwrites it")
        place.parent.mkdir(parents=True, exist_ok=True)
        new = place.with_name(f".{place.name}.new")
        new.write_text(text, encoding="utf-8")
        new.chmod(0o644)
        new.replace(place)
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "is not text; --force overwrites it"
        raise FleetError(f"{place}: {why}") from None
    return f"{place}: written"


def _run(*argv: str) -> list[str]:
    """A command of the system; FleetError with what it said."""
    found = shutil.which(argv[0])
    if found is None:
        raise FleetError(f"{argv[0]}: not found; run it yourself: {' '.join(argv)}")
    done = subprocess.run([found, *argv[1:]], capture_output=True, text=True, timeout=60, check=False)
    if done.returncode:
        said = " ".join((done.stderr or done.stdout).split())
        raise FleetError(f"{' '.join(argv)}: {said or f'ended with {done.returncode}'}")
    return [f"{' '.join(argv)}: done"]
