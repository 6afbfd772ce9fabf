"""Recorder of one run or one boat: an MCAP file, written by a thread of its own so that a control loop never waits.

`put` appends to a bounded queue. The thread takes the queue every 0.1 s, hands whole chunks to the operating system
every `flush_s` and forces them to the disk every `fsync_s`. After `kill -9` at most `flush_s` and 0.1 s are missing,
after a power cut at most `fsync_s` more. When the disk fails, the recording stops and `trouble` says why; the loop goes
on.
"""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import IO, Any, cast

from fleet.recording.disk import DiskStream, free_bytes, in_words, open_new, part, parts
from fleet.recording.seam import Attachment, Channel, guessed_encoding

POLL_S = 0.1  # how often the queue is emptied
CHUNK_BYTES = 128 * 1024  # larger chunks cost memory and, with a flush every second, are never reached
METADATA = "run"  # name of the metadata record that holds the header


class Recorder:
    """Writes one recording; a new part (`run.2.mcap`, ...) begins after `part_bytes`, `part_s`, or a restart.

    Args:
        path: the file; never overwritten, if it exists the next free part is begun
        header: what was recorded, where, by which version
        attachments: files to carry along, such as the mission
        flush_s: what may be lost when the process is killed [s]
        fsync_s: what may be lost in a power cut [s]
        room: messages that may wait for the disk; more are dropped and counted
        wait: for simulators without a clock to keep: `put` waits for room instead of dropping
        reserve_bytes: free space left to others; below it the recording ends in good order
        part_bytes, part_s: where a part ends, because the index of a part is held in memory until then
        open_stream: opens a new file for writing
    """

    def __init__(
        self,
        path: Path | str,
        header: Mapping[str, str] | None = None,
        attachments: Iterable[Attachment] = (),
        *,
        flush_s: float = 1.0,
        fsync_s: float = 5.0,
        room: int = 8192,
        wait: bool = False,
        reserve_bytes: int = 16 * 1024 * 1024,
        part_bytes: int = 256 * 1024 * 1024,
        part_s: float = 3600.0,
        open_stream: Callable[[Path], DiskStream] = open_new,
    ) -> None:
        self.path = Path(path)
        self.trouble = ""
        self.dropped = 0
        self.written = 0
        self._header, self._attachments = dict(header or {}), tuple(attachments)
        self._flush_s, self._fsync_s, self._room, self._wait = flush_s, fsync_s, room, wait
        self._reserve_bytes, self._part_bytes, self._part_s = reserve_bytes, part_bytes, part_s
        self._open_stream = open_stream
        self._queue: deque[tuple[str, int, bytes]] = deque()
        self._channels: dict[str, Channel] = {}
        self._ids: dict[str, int] = {}
        self._closing = False
        self._wake = threading.Event()
        self._stream: DiskStream | None = None
        self._writer: Any = None  # mcap.writer.Writer, whose flush and finish have no types
        self._begun_s = self._flushed_s = self._synced_s = time.monotonic()
        self._first = self.path
        self._number = len(parts(self.path)) and _number(parts(self.path)[-1])
        self._guarded(self._begin_part)
        self._thread = threading.Thread(target=self._guarded, args=(self._run,), name="recorder", daemon=True)
        self._thread.start()

    def channel(self, topic: str, schema_name: str, encoding: str, schema: bytes = b"") -> None:
        """Declare a topic before its first message; saying it twice changes nothing.

        Args:
            topic: such as `/otter-1/state`
            schema_name: such as `fleet.State`
            encoding: of the messages, `json` or `msgpack`
            schema: JSON schema of the messages; empty if there is none
        """
        self._channels.setdefault(topic, Channel(topic, schema_name, encoding, schema))

    def put(self, topic: str, stamp_ns: int, payload: bytes) -> None:
        """Keep one message. Costs about a microsecond, never raises, never waits (unless opened with `wait`)."""
        if self.trouble or self._closing:
            self.dropped += 1
        elif len(self._queue) < self._room or (self._wait and self._got_room()):
            self._queue.append((topic, stamp_ns, payload))
        else:
            self.dropped += 1

    def close(self, timeout_s: float = 5.0) -> None:
        """Write what waits, and the index. Returns after `timeout_s` even if the disk does not."""
        self._closing = True
        self._wake.set()
        self._thread.join(timeout_s)
        if self._thread.is_alive() and not self.trouble:
            self.trouble = f"disk too slow: {len(self._queue)} messages not written {timeout_s:g} s after the end"

    def _got_room(self) -> bool:
        self._wake.set()
        while len(self._queue) >= self._room and not self.trouble:
            time.sleep(0.001)
        return not self.trouble

    def _guarded(self, action: Callable[[], None]) -> None:
        """Run `action`; whatever it raises ends the recording, in words, and nothing else."""
        try:
            action()
        except OSError as error:
            self._stop(in_words(error))
        except Exception as error:  # noqa: BLE001  a loop at sea outlives its recorder, whatever that dies of
            self._stop(f"recorder failed: {type(error).__name__}: {error}")

    def _stop(self, trouble: str) -> None:
        """Give up: the file stays as it is, without an index, readable up to its last whole chunk."""
        self.trouble = trouble
        self.dropped += len(self._queue)
        self._queue.clear()
        self._writer = None
        stream, self._stream = self._stream, None
        if stream is not None:
            try:
                stream.close()
            except OSError:
                return  # why it stopped is already said

    def _run(self) -> None:
        while not self._closing and not self.trouble:
            self._wake.wait(POLL_S)
            self._wake.clear()
            self._drain()
            self._tend()
        if not self.trouble:
            self._drain()
            self._end_part()

    def _drain(self) -> None:
        for _ in range(len(self._queue)):
            self._add(*self._queue.popleft())

    def _add(self, topic: str, stamp_ns: int, payload: bytes) -> None:
        if self._writer is None or not isinstance(payload, bytes) or not 0 <= stamp_ns < 2**63:
            self.dropped += 1
            return
        channel_id = self._ids.get(topic) or self._register(topic, payload)
        self._writer.add_message(channel_id, stamp_ns, payload, stamp_ns)
        self.written += 1

    def _register(self, topic: str, payload: bytes) -> int:
        channel = self._channels.setdefault(topic, Channel(topic, "", guessed_encoding(payload), b""))
        schema_id = 0
        if channel.schema:
            schema_id = self._writer.register_schema(channel.schema_name, "jsonschema", channel.schema)
        named = {"schema": channel.schema_name} if channel.schema_name else {}
        channel_id: int = self._writer.register_channel(topic, channel.encoding, schema_id, named)
        self._ids[topic] = channel_id
        return channel_id

    def _tend(self) -> None:
        """Flush, sync, begin a new part, when it is time to."""
        now = time.monotonic()
        if self._writer is None or self._stream is None or now - self._flushed_s < self._flush_s - POLL_S / 2:
            return
        self._writer.flush()
        self._flushed_s = now
        if now - self._synced_s < self._fsync_s:
            return
        _sync(self._stream)
        self._synced_s = now
        free = free_bytes(self.path.parent)
        if free < self._reserve_bytes:
            self._end_part()
            self._stop(f"disk nearly full: {free >> 20} MB free, {self._reserve_bytes >> 20} MB are left to others")
        elif self._stream.tell() > self._part_bytes or now - self._begun_s > self._part_s:
            self._end_part()
            self._begin_part()

    def _begin_part(self) -> None:
        from mcap.writer import Writer  # only who records pays for it: 4.5 MB

        self._number += 1
        self.path = part(self._first, self._number)
        self._stream = self._open_stream(self.path)
        self._ids = {}
        self._writer = Writer(cast("IO[bytes]", self._stream), chunk_size=CHUNK_BYTES)
        self._writer.start(library="fleet")
        self._writer.add_metadata(METADATA, {**self._header, "part": str(self._number)})
        for one in self._attachments:
            self._writer.add_attachment(0, 0, one.name, one.media_type, one.content)
        self._writer.flush()
        _sync(self._stream)
        self._begun_s = self._flushed_s = self._synced_s = time.monotonic()

    def _end_part(self) -> None:
        if self._writer is None or self._stream is None:
            return
        self._writer.finish()
        _sync(self._stream)
        self._writer = None
        self._stream.close()
        self._stream = None


def _number(path: Path) -> int:
    """Number of a part: 1 for `run.mcap`, 2 for `run.2.mcap`."""
    middle = path.stem.rpartition(".")[2]
    return int(middle) if middle.isdigit() and "." in path.stem else 1


def _sync(stream: DiskStream) -> None:
    """Force what is written to the disk; what cannot be forced (a device, a pipe) need not be."""
    try:
        os.fsync(stream.fileno())
    except OSError as error:
        if error.errno != 22:  # EINVAL
            raise
