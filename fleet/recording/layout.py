"""Where things lie in an MCAP file: from its index when it has one, else found by walking through it."""

from __future__ import annotations

import io
import struct
from typing import IO, TYPE_CHECKING, Any

from msgspec import Struct, field

from fleet.errors import RecordingError

if TYPE_CHECKING:
    from mcap.records import Channel, Message, Schema

MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")  # opcode and length in front of every record
_FOOTER_BYTES = _HEAD.size + 20 + len(MAGIC)
_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 1, 2, 3, 4, 5, 6
_ATTACHMENT, _METADATA, _LAST_OPCODE = 9, 12, 15


class Piece(Struct):
    """A chunk, or a message outside of chunks."""

    offset: int
    length: int  # with opcode and length
    start_ns: int
    end_ns: int
    channels: frozenset[int] | None = None  # None: not known without reading it


class Layout(Struct):
    """What a file holds and where."""

    size: int
    whole: bool  # closed in good order
    good_end: int  # end of the last whole record
    pieces: list[Piece] = field(default_factory=list)
    schemas: dict[int, Any] = field(default_factory=dict)
    channels: dict[int, Any] = field(default_factory=dict)
    attachments: list[tuple[int, int]] = field(default_factory=list)  # offset, length
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: int = 0
    bad_chunks: int = 0


def layout_of(file: IO[bytes], name: str) -> Layout:
    """Layout of an open file, by its index if it has a sound one.

    Raises:
        RecordingError: it is not an MCAP file
    """
    size = file.seek(0, io.SEEK_END)
    file.seek(0)
    magic = file.read(len(MAGIC))
    if magic != MAGIC:
        begins = "it is empty" if not magic else f"it begins with {magic!r}, an MCAP file with {MAGIC!r}"
        raise RecordingError(f"{name}: not a recording: {begins}")
    return _indexed(file, size) or scan(file, size)


def _indexed(file: IO[bytes], size: int) -> Layout | None:
    """Layout from the index at the end; None if there is none that can be used."""
    from mcap.reader import SeekingReader

    if size < _FOOTER_BYTES + len(MAGIC):
        return None
    file.seek(size - _FOOTER_BYTES)
    tail = file.read(_FOOTER_BYTES)
    if not tail.endswith(MAGIC) or _HEAD.unpack_from(tail) != (_FOOTER, 20):
        return None
    file.seek(0)
    try:
        summary = SeekingReader(file).get_summary()
        if summary is None or summary.statistics is None or not _complete(summary, size):
            return None
        found = Layout(size=size, whole=True, good_end=size, messages=summary.statistics.message_count)
        found.schemas, found.channels = dict(summary.schemas), dict(summary.channels)
        for index in summary.chunk_indexes:
            known = frozenset(index.message_index_offsets) or None
            times = index.message_start_time, index.message_end_time
            found.pieces.append(Piece(index.chunk_start_offset, index.chunk_length, *times, known))
        found.attachments = [(index.offset, index.length) for index in summary.attachment_indexes]
        for place in summary.metadata_indexes:
            _take_metadata(found, _body(file, place.offset, place.length))
    except Exception:  # noqa: BLE001  whatever is wrong with the index: the records themselves are looked at instead
        return None
    return found


def _complete(summary: Any, size: int) -> bool:
    """Whether the index covers every message, and points inside the file."""
    if any(index.chunk_start_offset + index.chunk_length > size for index in summary.chunk_indexes):
        return False
    return bool(summary.chunk_indexes) or summary.statistics.message_count == 0


def scan(file: IO[bytes], size: int) -> Layout:
    """Layout found record by record, up to the last whole one."""
    found = Layout(size=size, whole=False, good_end=len(MAGIC))
    at = len(MAGIC)
    file.seek(at)
    while at + _HEAD.size <= size:
        opcode, length = _HEAD.unpack(file.read(_HEAD.size))
        end = at + _HEAD.size + length
        if end > size or not (0 < opcode <= _LAST_OPCODE or opcode >= 0x80):
            break
        if opcode in (_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _METADATA):
            _take(found, opcode, file.read(length), at)
        else:
            file.seek(end)
            if opcode == _ATTACHMENT:
                found.attachments.append((at, end - at))
        at = found.good_end = end
        if opcode == _FOOTER:
            found.good_end = min(size, end + len(MAGIC))
            break
    return found


def _take(found: Layout, opcode: int, body: bytes, at: int) -> None:
    """Add one record to a layout; one that does not decode is counted and passed over."""
    try:
        if opcode == _METADATA:
            _take_metadata(found, body)
        else:
            records = read_piece(opcode, body)
            known = {record.id for record in records if not hasattr(record, "log_time") and hasattr(record, "topic")}
            messages = [record for record in records if hasattr(record, "log_time")]
            if any(one.channel_id not in found.channels and one.channel_id not in known for one in messages):
                raise ValueError("messages of a channel that was lost")
            _take_records(found, records)
            if messages:
                times = [one.log_time for one in messages]
                channels = frozenset(one.channel_id for one in messages)
                length = _HEAD.size + len(body)
                found.pieces.append(Piece(at, length, min(times), max(times), channels))
                found.messages += len(messages)
    except Exception:  # noqa: BLE001  damaged bytes raise anything from KeyError to ZstdError
        found.bad_chunks += 1


def _take_records(found: Layout, records: list[Channel | Schema | Message]) -> None:
    from mcap.records import Channel, Schema

    for record in records:
        if isinstance(record, Schema):
            found.schemas[record.id] = record
        elif isinstance(record, Channel):
            found.channels[record.id] = record


def _take_metadata(found: Layout, body: bytes) -> None:
    from mcap.data_stream import ReadDataStream
    from mcap.records import Metadata

    record = Metadata.read(ReadDataStream(io.BytesIO(body)))
    found.metadata[record.name] = record.metadata


def read_piece(opcode: int, body: bytes) -> list[Any]:
    """Records of a chunk (its checksum compared), or the one record that this is."""
    from mcap.data_stream import ReadDataStream
    from mcap.records import Channel, Chunk, Message, Schema
    from mcap.stream_reader import breakup_chunk

    stream = ReadDataStream(io.BytesIO(body))
    if opcode == _CHUNK:
        return list(breakup_chunk(Chunk.read(stream), validate_crc=True))
    if opcode == _MESSAGE:
        return [Message.read(stream, len(body))]
    return [Schema.read(stream) if opcode == _SCHEMA else Channel.read(stream)]


def read_at(file: IO[bytes], piece: Piece) -> list[Any]:
    """Records of a piece of a layout."""
    file.seek(piece.offset)
    opcode, length = _HEAD.unpack(file.read(_HEAD.size))
    return read_piece(opcode, file.read(length))


def attachment_at(file: IO[bytes], offset: int, length: int) -> Any:
    """Attachment of a layout."""
    from mcap.data_stream import ReadDataStream
    from mcap.records import Attachment

    return Attachment.read(ReadDataStream(io.BytesIO(_body(file, offset, length))))


def _body(file: IO[bytes], offset: int, length: int) -> bytes:
    file.seek(offset + _HEAD.size)
    return file.read(length - _HEAD.size)
