"""`python -m fleet.agent.examine < MISSION`: whether a mission can be sailed, found out apart from the boat's own loop.

Checking a mission of many kilometres of curves takes seconds, and its arithmetic would hold up the loop thread for as
long; here it costs the boat a share of another core. Prints the problems as a JSON array.
"""

from __future__ import annotations

import contextlib
import os
import resource
import subprocess
import sys

import msgspec

from fleet.wire.codec import Refused

LONGEST_S = 30.0
MOST_MEMORY = 1 << 30
NICE = 10


def apart(content: bytes) -> tuple[str, ...]:
    """Problems of an encoded mission, found by a process of its own; Refused when it does not come to an end."""
    try:
        child = subprocess.run(
            [sys.executable, "-m", "fleet.agent.examine"],
            input=content,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=LONGEST_S,
            check=True,
        )
        return msgspec.json.decode(child.stdout, type=tuple[str, ...])
    except subprocess.TimeoutExpired:
        raise Refused(f"takes longer than {LONGEST_S:g} s to check") from None
    except (OSError, subprocess.CalledProcessError, msgspec.DecodeError):
        raise Refused("could not be checked") from None


def main() -> None:
    """Check what stands on stdin."""
    with contextlib.suppress(OSError):
        os.nice(NICE)
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    from fleet.mission.check import check
    from fleet.mission.load import decode

    problems = check(decode(sys.stdin.buffer.read())).problems
    sys.stdout.buffer.write(msgspec.json.encode(problems[:3]))


if __name__ == "__main__":
    main()
