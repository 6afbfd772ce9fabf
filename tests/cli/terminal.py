"""Running `fleet` as a user does: a process of its own."""

from __future__ import annotations

import contextlib
import io
import os
import pty
import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

FLEET = [sys.executable, "-m", "fleet.cli.main"]
DEADLINE_S = 30.0


def environment(**more: str) -> dict[str, str]:
    """Without what the developer has set."""
    return {**{k: v for k, v in os.environ.items() if not k.startswith("FLEET_")}, **more}


def fleet(*argv: str, cwd: Path | None = None, **more: str) -> subprocess.CompletedProcess[str]:
    """Run to the end, without a terminal."""
    return subprocess.run(
        [*FLEET, *argv],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=90,
        cwd=cwd,
        env=environment(**more),
        check=False,
    )


def here(*argv: str, **more: str) -> subprocess.CompletedProcess[str]:
    """As `fleet`, in this process: starting one takes longer than most commands' work."""
    from fleet.cli.main import main

    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch.dict(os.environ, environment(**more), clear=True),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        code = main(argv)
    return subprocess.CompletedProcess(argv, code, out.getvalue(), err.getvalue())


def at_terminal(
    *argv: str, hold_s: float, hangs_up: bool = False, then: Callable[[], None] = lambda: None
) -> tuple[int, str]:
    """A command on a terminal, with a key held down for so long; exit code and what was shown.

    Args:
        argv: of `fleet`
        hold_s: from the time that it asks for the key
        hangs_up: the terminal is closed then, as by a line that is cut
        then: called at the end of that
    """
    ours, theirs = pty.openpty()
    child = subprocess.Popen([*FLEET, *argv], stdin=theirs, stdout=theirs, stderr=theirs, env=environment())
    os.close(theirs)
    shown, until_s, held = b"", 0.0, False
    deadline = time.monotonic() + 60.0
    try:
        while child.poll() is None and time.monotonic() < deadline:
            if select.select([ours], [], [], 0.05)[0]:
                try:
                    shown += os.read(ours, 4096)
                except OSError:
                    break
            if not until_s and b"hold a key" in shown:
                until_s = time.monotonic() + hold_s
            if time.monotonic() < until_s:
                os.write(ours, b" ")
            elif until_s and not held:
                held = True
                then()
                if hangs_up:
                    break
        if hangs_up:
            os.close(ours)
            ours = -1
        return child.wait(30), shown.decode()
    finally:
        child.kill()
        child.wait()
        if ours >= 0:
            os.close(ours)


@contextlib.contextmanager
def running(*argv: str, errors: Path | None = None, **more: str) -> Iterator[subprocess.Popen[str]]:
    """A command that stays; killed at the end if it still runs."""
    with (errors or Path(os.devnull)).open("w") as stderr:
        child = subprocess.Popen(
            [*FLEET, *argv], stdout=subprocess.PIPE, stderr=stderr, text=True, env=environment(**more)
        )
    try:
        yield child
    finally:
        child.kill()
        child.wait(10)
        if child.stdout is not None:
            child.stdout.close()


def until(condition: Callable[[], bool], what: str, within_s: float = DEADLINE_S) -> None:
    """Wait for something; fails with its name."""
    deadline = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < deadline, f"not within {within_s:g} s: {what}"
        time.sleep(0.02)
