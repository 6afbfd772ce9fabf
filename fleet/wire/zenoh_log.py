"""What Zenoh refuses, said in our own log: handshakes that fail, and messages that the access rules do not let pass.

Zenoh tells these things only in its own log, which goes to the process's standard output. A process that calls
`capture` gets that output through a pipe, reads it, and says what matters once in a while, with names and counts.
"""

from __future__ import annotations

import logging
import os
import re
import sys
import threading
import time
from collections import Counter, deque
from typing import Final

import zenoh

from fleet.wire.credentials.roster import day, words_of
from fleet.wire.credentials.trust import Trust

log = logging.getLogger("fleet.wire")
FILTER = "warn,zenoh::net::routing::interceptor=trace"
ROUTINE = ("zenoh::net::runtime::orchestrator", "zenoh::net::routing::hat")  # that a hub is not there yet, and such
TRIES, TRY_AGAIN_S = 5, 0.2  # to learn who a neighbour is
AGAIN_S = 10.0  # between two lines of the same words
MOST_WORDS = 256  # different ones that are counted
PIPE_BYTES = 1 << 20
_DENIED: Final = re.compile(rb"(?:CertCommonName\(([^)]*)\).*?)?(\w+) is unauthorized to (.+?) \(ingress\) on (\S+)")
_NOBODY: Final = re.compile(rb"access_control: (\w+) did not match any configured ACL subject")
_THREAD: Final = re.compile(rb"ThreadId\((\d+)\)")
_COLOURS: Final = re.compile(rb"\x1b\[[0-9;]*m")
_EXPIRED: Final = re.compile(r"certificate expired: .*?not valid after (\d+).*")
_REASON: Final = re.compile(r'reason: "([^"]*)"')


class Refusals:
    """What was refused, in words, with counts."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self._said: dict[str, tuple[float, int]] = {}
        self._fresh: deque[str] = deque(maxlen=16)
        self._sessions: list[tuple[zenoh.Session, Trust]] = []
        self._last: dict[bytes, bytes] = {}  # by thread: what the access rules said last, if it was no

    def watch(self, session: zenoh.Session, trust: Trust) -> None:
        """Learn names of neighbours from this session."""
        self._sessions.append((session, trust))

    def forget(self, session: zenoh.Session) -> None:
        """This session ends."""
        self._sessions = [one for one in self._sessions if one[0] is not session]

    def read(self, line: bytes) -> None:
        """One line of Zenoh's log."""
        if b"access_control: " in line:
            self._rule(line)
        elif b"interceptor: Msg intercepted!" in line:
            self._intercepted(line)
        elif b" WARN " in line or b" ERROR " in line:
            self._warned(line)

    def _rule(self, line: bytes) -> None:
        nobody = _NOBODY.search(line)
        if nobody is not None:
            self._of_nobody(nobody[1].decode(), TRIES)
            return
        thread = _THREAD.search(line)
        if thread is not None:
            if b" is unauthorized to " in line and b"(ingress)" in line:
                self._last[thread[1]] = line
            else:
                self._last.pop(thread[1], None)

    def _of_nobody(self, zid: str, tries: int) -> None:
        """Somebody may nothing; who it is the session knows a moment later."""
        who, where = self._neighbour(zid)
        if not where and tries:
            timer = threading.Timer(TRY_AGAIN_S, self._of_nobody, (zid, tries - 1))
            timer.daemon = True
            timer.start()
            return
        self._say(f"{who} at {where or 'an address that is gone'}: nothing of it is let pass")

    def _intercepted(self, line: bytes) -> None:
        thread = _THREAD.search(line)
        said = self._last.pop(thread[1], None) if thread is not None else None
        denied = _DENIED.search(said) if said is not None else None
        if denied is None:
            return  # of somebody who may nothing, which was said when it came
        who = words_of(denied[1].decode()) if denied[1] else self._neighbour(denied[2].decode())[0]
        self._say(f"{who} may not {denied[3].decode().lower()} {denied[4].decode()[:120]}")

    def _neighbour(self, zid: str) -> tuple[str, str]:
        """Who has this id, and where; with the reason why it is not believed."""
        for session, trust in tuple(self._sessions):
            try:
                links = session.info.links()
            except zenoh.ZError:
                continue
            for link in links:
                if str(link.zid) == zid:
                    name = link.auth_identifier or ""
                    member = trust.roster.find(name)
                    trouble = member.trouble(time.time()) if member is not None else "not in the roster"
                    return f"{words_of(name)}{', ' + trouble if trouble else ''}", str(link.dst)
        return f"a neighbour {zid}", ""

    def _warned(self, line: bytes) -> None:
        text = line.decode(errors="replace").strip()
        if any(part in text for part in ROUTINE):
            return
        text = text.split(": ", 1)[-1]
        reason = _REASON.search(text)
        text = (reason[1] if reason else text).split(" Hint:")[0].split(" at /")[0].rstrip(".")
        text = _EXPIRED.sub(lambda match: f"expired {day(int(match[1]))}", text)
        peer = "a stranger" if "certificate" in text else "the network"
        self._say(f"{peer}: {text[:200]}")

    def fresh(self) -> list[str]:
        """What was said since the last call, once in a while for the same words."""
        return [self._fresh.popleft() for _ in range(len(self._fresh))]

    def _say(self, words: str) -> None:
        if words not in self.counts and len(self.counts) >= MOST_WORDS:
            words = "others"
        self.counts[words] += 1
        at, before = self._said.get(words, (-AGAIN_S, 0))
        now = time.monotonic()
        if now - at < AGAIN_S:
            return
        self._fresh.append(words)
        times = self.counts[words] - before
        self._said[words] = now, self.counts[words]
        log.warning("refused: %s%s", words, f" ({times} times)" if times > 1 else "", extra={"event": "refused"})


refusals = Refusals()


def watch(session: zenoh.Session, trust: Trust | None) -> None:
    """Learn names of neighbours from a session with credentials."""
    if trust is not None:
        refusals.watch(session, trust)


def forget(session: zenoh.Session) -> None:
    """The session ends."""
    refusals.forget(session)


def capture() -> None:
    """Read Zenoh's log from now on; once, before the first session, by a process that is a station and nothing else."""
    sys.stdout.flush()
    keep = os.dup(1)
    reads, writes = os.pipe()
    try:
        import fcntl

        fcntl.fcntl(writes, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
    except (ImportError, AttributeError, OSError):
        pass
    os.dup2(writes, 1)
    os.close(writes)
    sys.stdout = os.fdopen(keep, "w", buffering=1)
    os.environ["NO_COLOR"] = "1"
    threading.Thread(target=_run, args=(reads,), name="zenoh-log", daemon=True).start()
    zenoh.init_log_from_env_or(FILTER)


def _run(reads: int) -> None:
    """Never ends: nobody reading would stop Zenoh."""
    rest = b""
    while True:
        try:
            content = os.read(reads, 1 << 16)
        except OSError:
            return
        if not content:
            return
        lines = (rest + content).split(b"\n")
        rest = lines.pop()[-4096:]
        for line in lines:
            try:
                refusals.read(_COLOURS.sub(b"", line))
            except Exception:
                log.exception("a line of Zenoh's log could not be read", extra={"event": "internal-error"})
