"""Reading recordings: through the index, or, when a crash left none, by a walk up to the last whole record."""

from __future__ import annotations

import contextlib
import heapq
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from msgspec import Struct

from fleet.errors import RecordingError
from fleet.recording.disk import DiskStream, in_words, open_new, parts, sync_folder
from fleet.recording.layout import Layout, attachment_at, layout_of, read_at, scan
from fleet.recording.seam import Attachment, Message
from fleet.recording.writer import CHUNK_BYTES, METADATA


class RecordingFile:
    """One file, open for reading; use with `with`. Raises RecordingError if it is not a recording."""

    def __init__(self, path: Path | str, file: IO[bytes] | None = None) -> None:
        self.path = Path(path)
        with contextlib.ExitStack() as undo:
            try:
                self._file = file if file is not None else self.path.open("rb")
                undo.callback(self._file.close)
                self._layout = layout_of(self._file, str(path))
            except OSError as error:
                raise RecordingError(f"cannot read {path}: {error.strerror or error}") from error
            undo.pop_all()

    @property
    def whole(self) -> bool:
        """Whether it was closed in good order."""
        return self._layout.whole

    @property
    def message_count(self) -> int:
        """Messages in the file."""
        return self._layout.messages

    @property
    def bad_chunks(self) -> int:
        """Chunks that did not decode so far: an index does not know of them until they are read."""
        return self._layout.bad_chunks

    @property
    def lost_tail_bytes(self) -> int:
        """Bytes behind the last whole record."""
        return self._layout.size - self._layout.good_end

    @property
    def header(self) -> dict[str, str]:
        """What the recorder said at the beginning."""
        return dict(self._layout.metadata.get(METADATA, {}))

    @property
    def topics(self) -> dict[str, str]:
        """Schema name of every topic."""
        return {channel.topic: self._schema_name(channel) for channel in self._layout.channels.values()}

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """First and last stamp; None if there is no message."""
        pieces = self._layout.pieces
        return (min(p.start_ns for p in pieces), max(p.end_ns for p in pieces)) if pieces else None

    def attachments(self) -> Iterator[Attachment]:
        """The files it carries; those that do not decode are left out."""
        for offset, length in self._layout.attachments:
            with contextlib.suppress(Exception):
                one = attachment_at(self._file, offset, length)
                yield Attachment(one.name, one.media_type, one.data)

    def messages(
        self, topics: Collection[str] | None = None, since_ns: int | None = None, until_ns: int | None = None
    ) -> Iterator[Message]:
        """Messages in order of their stamps, read as they are asked for.

        Args:
            topics: only these
            since_ns: not before
            until_ns: before this, not at it
        """
        wanted = {i for i, channel in self._layout.channels.items() if topics is None or channel.topic in topics}
        pieces = [
            piece
            for piece in self._layout.pieces
            if (since_ns is None or piece.end_ns >= since_ns)
            and (until_ns is None or piece.start_ns < until_ns)
            and (piece.channels is None or piece.channels & wanted)
        ]
        waiting: list[tuple[int, int, int, Any]] = []  # stamp, piece, place in it
        for number, piece in enumerate(sorted(pieces, key=lambda one: (one.start_ns, one.offset))):
            while waiting and waiting[0][0] < piece.start_ns:
                yield self._message(heapq.heappop(waiting)[3])
            for place, record in enumerate(self._records(piece)):
                stamp = getattr(record, "log_time", None)
                if stamp is None or record.channel_id not in wanted:
                    continue
                if (since_ns is None or stamp >= since_ns) and (until_ns is None or stamp < until_ns):
                    heapq.heappush(waiting, (stamp, number, place, record))
        while waiting:
            yield self._message(heapq.heappop(waiting)[3])

    def _records(self, piece: Any) -> list[Any]:
        try:
            return read_at(self._file, piece)
        except Exception:  # noqa: BLE001  damaged bytes raise anything; the other chunks are still good
            self._layout.bad_chunks += 1
            return []

    def _message(self, record: Any) -> Message:
        channel = self._layout.channels[record.channel_id]
        return Message(channel.topic, record.log_time, record.data, channel.message_encoding)

    def _schema_name(self, channel: Any) -> str:
        schema = self._layout.schemas.get(channel.schema_id)
        return str(schema.name) if schema is not None else str(channel.metadata.get("schema", ""))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> RecordingFile:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def read(
    path: Path | str,
    topics: Collection[str] | None = None,
    since_ns: int | None = None,
    until_ns: int | None = None,
) -> Iterator[Message]:
    """Messages of a recording with all its parts (`run.mcap`, `run.2.mcap`, ...), whole or damaged.

    Raises:
        RecordingError: no such file, or not a recording
    """
    for one in parts(Path(path)) or [Path(path)]:
        with RecordingFile(one) as file:
            yield from file.messages(topics, since_ns, until_ns)


class Repaired(Struct, frozen=True, kw_only=True):
    """What a repair found."""

    path: Path
    messages: int  # recovered
    lost_tail_bytes: int  # behind the last whole record
    bad_chunks: int  # in the middle, passed over
    was_whole: bool  # there was nothing to repair


def repair(path: Path | str, out: Path | str, open_stream: Callable[[Path], DiskStream] = open_new) -> Repaired:
    """Write what can be read of a recording into a new file, with an index.

    Raises:
        RecordingError: not a recording, `out` exists, or cannot be written
    """
    source, target = Path(path), Path(out)
    if target.exists():
        raise RecordingError(f"{target} exists already; name a new file for the repaired recording")
    draft = target.with_name(target.name + ".part")
    with RecordingFile(source) as file:
        was_whole = file.whole
        layout = scan(file._file, file._layout.size)
        try:
            draft.unlink(missing_ok=True)
            stream = open_stream(draft)
            try:
                _copy(file, layout, stream)
            finally:
                stream.close()
            draft.replace(target)
            sync_folder(target.parent)
        except OSError as error:
            draft.unlink(missing_ok=True)
            raise RecordingError(f"{target} not written: {in_words(error)}") from error
    return Repaired(
        path=target,
        messages=layout.messages,
        lost_tail_bytes=layout.size - layout.good_end,
        bad_chunks=layout.bad_chunks,
        was_whole=was_whole and not layout.bad_chunks,
    )


def _copy(file: RecordingFile, layout: Layout, stream: Any) -> None:
    """Header, attachments, channels and messages of `layout` into a new file."""
    from mcap.writer import Writer

    writer: Any = Writer(stream, chunk_size=CHUNK_BYTES)
    writer.start(library="fleet")
    for name, content in layout.metadata.items():
        writer.add_metadata(name, content)
    for one in file.attachments():
        writer.add_attachment(0, 0, one.name, one.media_type, one.content)
    schemas = {i: writer.register_schema(s.name, s.encoding, s.data) for i, s in sorted(layout.schemas.items())}
    channels = {
        i: writer.register_channel(c.topic, c.message_encoding, schemas.get(c.schema_id, 0), c.metadata)
        for i, c in sorted(layout.channels.items())
    }
    for piece in layout.pieces:
        for record in read_at(file._file, piece):
            if hasattr(record, "log_time"):
                channel_id = channels[record.channel_id]
                writer.add_message(channel_id, record.log_time, record.data, record.publish_time, record.sequence)
    writer.finish()
