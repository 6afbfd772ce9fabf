"""MAVProxy as a person uses it: commands to its stdin, answers on its screen. A real process, without windows."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Self

MODULES = "link,wp,param,arm,mode,cmdlong"
LONGEST_S = 10.0


def program() -> str | None:
    """Where it is installed."""
    beside = Path(sys.executable).with_name("mavproxy.py")
    return str(beside) if beside.exists() else shutil.which("mavproxy.py")


class Mavproxy:
    """One ground station."""

    def __init__(self, port: int, folder: Path, *more: str) -> None:
        """Args: port: where it listens, 0 for none; folder: where it runs."""
        name = program()
        assert name is not None
        master = [f"--master=udpin:127.0.0.1:{port}"] if port else []
        command = [sys.executable, "-u", name, *master, "--no-state", f"--default-modules={MODULES}", *more]
        self._child = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._text = ""
        self._more = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._child.stdout is not None
        while piece := self._child.stdout.read1(65536):  # type: ignore[attr-defined]
            with self._more:
                self._text += piece.decode(errors="replace")
                self._more.notify_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._child.kill()  # it has nothing to leave in good order
        self._child.wait()
        self._reader.join(5.0)
        for pipe in (self._child.stdin, self._child.stdout):
            if pipe is not None:
                pipe.close()

    def say(self, command: str) -> int:
        """Type a command; where on the screen its answers begin."""
        assert self._child.stdin is not None
        with self._more:
            mark = len(self._text)
        self._child.stdin.write(command.encode() + b"\n")
        self._child.stdin.flush()
        return mark

    def see(self, pattern: str, since: int = 0, at_most_s: float = LONGEST_S) -> str:
        """Wait until it stands on the screen; what stands there."""
        deadline = time.monotonic() + at_most_s
        with self._more:
            while True:
                found = re.search(pattern, self._text[since:])
                if found is not None:
                    return found[0]
                left = deadline - time.monotonic()
                assert left > 0.0, f"not seen: {pattern!r}, but\n{self._text[since:]}"
                self._more.wait(left)

    def ask(self, command: str, *patterns: str, at_most_s: float = LONGEST_S) -> None:
        """Type it, and wait for every answer."""
        mark = self.say(command)
        for pattern in patterns:
            self.see(pattern, mark, at_most_s)
