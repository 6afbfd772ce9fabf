"""What a loop needs of a recording, and the two recordings that write nothing to disk."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from msgspec import Struct


class Attachment(Struct, frozen=True):
    """A file carried inside a recording, such as the mission."""

    name: str
    media_type: str
    content: bytes


class Channel(NamedTuple):
    """What the messages of one topic are."""

    topic: str
    schema_name: str
    encoding: str  # "json" or "msgpack"
    schema: bytes  # JSON schema; empty: none


class Message(NamedTuple):
    """One recorded message."""

    topic: str
    stamp_ns: int
    payload: bytes
    encoding: str = "json"


class Recording(Protocol):
    """Where a loop puts what it wants to keep. No call raises because of the disk, none waits for it but `close`."""

    trouble: str
    dropped: int

    def channel(self, topic: str, schema_name: str, encoding: str, schema: bytes = b"") -> None:
        """Declare a topic before its first message."""

    def put(self, topic: str, stamp_ns: int, payload: bytes) -> None:
        """Keep one message."""

    def close(self, timeout_s: float = 5.0) -> None:
        """Finish the recording."""


class NullRecorder:
    """Records nothing."""

    trouble = ""
    dropped = 0

    def channel(self, topic: str, schema_name: str, encoding: str, schema: bytes = b"") -> None:
        """Nothing to declare."""

    def put(self, topic: str, stamp_ns: int, payload: bytes) -> None:
        """Nothing to keep."""

    def close(self, timeout_s: float = 5.0) -> None:
        """Nothing to finish."""


class MemoryRecorder:
    """Keeps everything in memory: for tests and short batches."""

    def __init__(self) -> None:
        self.trouble = ""
        self.dropped = 0
        self.channels: dict[str, Channel] = {}
        self.messages: list[Message] = []

    def channel(self, topic: str, schema_name: str, encoding: str, schema: bytes = b"") -> None:
        """Declare a topic; saying it twice changes nothing."""
        self.channels.setdefault(topic, Channel(topic, schema_name, encoding, schema))

    def put(self, topic: str, stamp_ns: int, payload: bytes) -> None:
        """Keep one message; a topic nobody declared becomes one without a schema."""
        if topic not in self.channels:
            self.channel(topic, "", guessed_encoding(payload))
        self.messages.append(Message(topic, stamp_ns, payload, self.channels[topic].encoding))

    def close(self, timeout_s: float = 5.0) -> None:
        """The messages stay."""


def guessed_encoding(payload: bytes) -> str:
    """Encoding of a message on a topic that nobody declared."""
    return "json" if payload[:1] in (b"{", b"[") else "msgpack"
