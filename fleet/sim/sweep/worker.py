"""A process that sails parts for another: asked and answered over pipes; it ends with its owner, even in mid-part."""

from __future__ import annotations

import os
import signal
import struct
import threading
from queue import SimpleQueue
from typing import BinaryIO

import msgspec
from msgspec import Struct

from fleet.sim.sweep.family import loads
from fleet.sim.sweep.parts import Part, pack, sail

HEAD = struct.Struct("<BQ")  # what it is, and its length
READY, DONE, WRONG = 0, 1, 2


class Work(Struct, frozen=True):
    """First line that a worker is told; the others are parts."""

    text: str
    seed: int


def main() -> None:
    """Sail what stdin names, a line a part; results go to stdout, each with its kind and length before it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C at the terminal is for the owner to decide on
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what anything prints is not an answer
    lines: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_listen, args=(lines,), daemon=True).start()
    work = msgspec.json.decode(lines.get(), type=Work)
    family = loads(work.text)
    _answer(answers, READY, b"")
    while True:
        part = msgspec.json.decode(lines.get(), type=Part)
        try:
            content, kind = pack(sail(family, work.seed, part)), DONE
        except Exception as error:  # noqa: BLE001  it is the owner's to say
            content, kind = f"{type(error).__name__}: {error}".encode(), WRONG
        _answer(answers, kind, content)


def _listen(lines: SimpleQueue[bytes]) -> None:
    """Pass on what is asked on stdin; the owner's end is ours."""
    rest = b""
    while more := os.read(0, 1 << 16):  # a buffered stream would be locked when the interpreter ends
        *whole, rest = (rest + more).split(b"\n")
        for line in whole:
            lines.put(line)
    os._exit(0)


def _answer(to: BinaryIO, kind: int, content: bytes) -> None:
    to.write(HEAD.pack(kind, len(content)))
    to.write(content)
    to.flush()


if __name__ == "__main__":
    main()
