"""The bus: what an agent or an operator needs of the network, small enough to have an honest twin in memory.

Nothing here blocks but `ask_all`, which is the operator's. Callbacks of a network only deposit; `poll_*` hands over
what was deposited, so that the thread that decides is the thread that reads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

OWN_KEPT = 8  # messages of one kind under the own name that wait to be fetched


class Heard(NamedTuple):
    """A message as it arrived."""

    sender: str  # the boat on whose key it came
    payload: bytes
    at_ns: int  # when it was fetched, by the station's own clock


class Request(NamedTuple):
    """Something asked of this boat; `reply` exactly once, from any thread, or `drop`."""

    what: str  # fleet.wire.keys.ASKED
    payload: bytes
    reply: Callable[[bytes], None]
    drop: Callable[[], None]


class Answer(NamedTuple):
    """A peer's answer to `ask`."""

    boat: str
    what: str
    payload: bytes


class Bus(Protocol):
    """One boat's end of the network."""

    def open(self) -> bool:
        """Try once to connect and declare; True when the bus is ready. Call again until it is."""

    def alone_with_my_name(self) -> bool:
        """False when somebody else is alive under this boat's name."""

    def announce(self) -> None:
        """Declare the liveliness token: from now on this boat is ready."""

    def link_up(self) -> bool:
        """Whether any other station is connected."""

    def watch(self, boat: str) -> None:
        """Listen to this boat's state from now on, in a ring of its own."""

    def unwatch(self, boat: str) -> None:
        """Listen to it no longer."""

    def put_state(self, payload: bytes) -> None:
        """Publish the own state: best effort, may be dropped."""

    def put(self, what: str, payload: bytes) -> None:
        """Publish something else: status, event."""

    def poll_states(self, bound: int) -> list[Heard]:
        """States that arrived since the last call, at most `bound` a sender, oldest first a sender."""

    def poll_requests(self, bound: int) -> list[Request]:
        """Requests that arrived since the last call."""

    def poll_answers(self) -> list[Answer]:
        """Answers that arrived since the last call."""

    def ask(self, boat: str, what: str, payload: bytes) -> None:
        """Ask one boat, without waiting; the answer, if any, comes by `poll_answers`."""

    def listen_own(self, what: str) -> None:
        """Keep what somebody else on board publishes under this boat's own name, such as scans."""

    def poll_own(self, what: str) -> list[Heard]:
        """The newest of that since the last call, at most 8, oldest first; `at_ns` is when it arrived."""

    def alive(self) -> frozenset[str]:
        """Boats whose liveliness token is up, oneself apart."""

    def operators(self) -> frozenset[str]:
        """Operators whose liveliness token is up."""

    def overflowed(self) -> int:
        """How many messages were lost here because nobody fetched them."""

    def close(self) -> None:
        """Leave the network."""


class Shore(Protocol):
    """An operator's end of the network: hears every boat, asks boats and waits for their answers."""

    def open(self, timeout_s: float) -> bool:
        """Connect within the timeout; False when nobody answers."""

    def listen(self, what: Iterable[str]) -> None:
        """Keep what boats publish under these names until `heard` fetches it."""

    def heard(self) -> list[tuple[str, str, bytes]]:
        """(what, boat, payload) since the last call."""

    def alive(self) -> frozenset[str]:
        """Boats whose token is up."""

    def ask_all(self, what: str, payload: bytes, timeout_s: float, boat: str = "*") -> dict[str, bytes]:
        """Ask all boats (or one) and wait; who did not answer in time is not in the result."""

    def tell(self, what: str, payload: bytes, boat: str) -> None:
        """The same of one boat without waiting; its answer is not looked at."""

    def close(self) -> None:
        """Leave the network."""
