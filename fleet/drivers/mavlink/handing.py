"""An autopilot's frames to ground stations and theirs to it, unchanged, within bounds. No socket; times handed in."""

from __future__ import annotations

import struct

from fleet.drivers.mavlink.frames import V2, cut

LISTENED_S = 5.0  # who said nothing for so long does not listen any more
OUT_BPS, OUT_BYTES = 8000.0, 16000.0  # to ground stations: bytes a second, and at once
IN_BPS, IN_BYTES = 2000.0, 2000.0  # to the autopilot, whose line carries set-points too
SET_POINTS = frozenset((82, 84, 86))  # SET_ATTITUDE_TARGET, SET_POSITION_TARGET_LOCAL_NED, ..._GLOBAL_INT
COMMAND_INT, COMMAND_LONG, DO_REPOSITION = 75, 76, 192
COMMAND_AT = 28  # bytes of the payload before the number of the command, in both


class Bucket:
    """So many bytes a second, and so many at once."""

    def __init__(self, rate: float, most: float) -> None:
        self._rate, self._most, self._room, self._at_s = rate, most, most, 0.0

    def takes(self, size: int, now_s: float) -> bool:
        """Whether there is room; it is used then."""
        self._room = min(self._most, self._room + self._rate * max(0.0, now_s - self._at_s))
        self._at_s = now_s
        if size > self._room:
            return False
        self._room -= size
        return True


class Handing:
    """For one autopilot."""

    def __init__(self, sysid: int, own_sysid: int) -> None:
        """Args: sysid: of the autopilot; own_sysid: of the agent, whose HEARTBEATs its failsafe waits for."""
        self._names = (sysid, own_sysid)
        self._out: list[bytes] = []
        self._up, self._down = Bucket(OUT_BPS, OUT_BYTES), Bucket(IN_BPS, IN_BYTES)
        self._listened_s = -1e9
        self._waiting = 0
        self.dropped = 0

    def listened(self, now_s: float) -> None:
        """Somebody listens."""
        self._listened_s = now_s

    def tap(self, frame: bytes) -> None:
        """A frame of the autopilot."""
        if self._waiting + len(frame) <= OUT_BYTES:
            self._out.append(bytes(frame))
            self._waiting += len(frame)
        else:
            self.dropped += 1

    def give(self, now_s: float) -> bytes:
        """What goes to ground stations now; nothing while nobody listens."""
        frames, self._out, self._waiting = self._out, [], 0
        if now_s - self._listened_s > LISTENED_S:
            return b""
        passed = [frame for frame in frames if self._up.takes(len(frame), now_s)]
        self.dropped += len(frames) - len(passed)
        return b"".join(passed)

    def take(self, payload: bytes, now_s: float, *, driving: bool) -> tuple[list[bytes], str]:
        """(frames for the autopilot, why others do not go on).

        Never frames under the agent's own name: they would keep the autopilot's failsafe quiet when the agent is dead.
        Never set-points while the agent drives: two that steer one boat take turns.
        """
        passed: list[bytes] = []
        why = ""
        for frame, source in cut(payload):
            if source in self._names:
                why = f"a ground station uses sysid {source}, which is not its own"
            elif driving and sets_point(frame):
                why = "a ground station's set-point: the agent steers"
            elif self._down.takes(len(frame), now_s):
                passed.append(frame)
            else:
                self.dropped += 1
                why = "more frames than the autopilot's line is given for them"
        return passed, why


def sets_point(frame: bytes) -> bool:
    """Whether a frame tells a boat in GUIDED where to go."""
    if frame[0] == V2:
        number, payload = frame[7] | frame[8] << 8 | frame[9] << 16, frame[10 : 10 + frame[1]]
    else:
        number, payload = frame[5], frame[6 : 6 + frame[1]]
    if number in SET_POINTS:
        return True
    if number not in (COMMAND_INT, COMMAND_LONG):
        return False
    command = payload[COMMAND_AT : COMMAND_AT + 2].ljust(2, b"\0")
    return bool(struct.unpack("<H", command)[0] == DO_REPOSITION)
