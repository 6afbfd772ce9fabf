"""The radio: a ring of what everybody said, and what each receiver holds of each sender.

Boats of a batch are rows (K, B): row = boat, column = scenario; lane = boat * B + scenario. Alone there is one column,
of floats.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from fleet.ops import FloatArray
from fleet.sim.batch.draws import Purpose, Words, begin, more, uniform
from fleet.sim.batch.hearing import TICK_S, Message
from fleet.sim.batch.scenarios import IntArray, Scenarios

_FIELDS = len(Message.__struct_fields__)
Told = list[tuple[Message[Any], ...]]
"""For each block of lanes, what is held of each other boat, by number."""


class Mail(Protocol):
    """Posts and delivers."""

    clean: bool

    def post(self, now: int, messages: list[Message[Any]]) -> None:
        """Everybody's message of this tick."""

    def deliver(self, now: int) -> Told:
        """What has arrived by now."""


def others(boats: int) -> IntArray:
    """(K - 1, K): the numbers of the others, ascending, for each boat."""
    table = [[j for j in range(boats) if j != i] for i in range(boats)]
    return np.array(table, dtype=np.intp).reshape(boats, boats - 1).T.copy()


def delay_ticks(delay_s: FloatArray) -> IntArray:
    """A message is heard a tick later at the soonest."""
    return np.maximum(np.ceil(delay_s / TICK_S - 1e-6), 1.0).astype(np.intp)


def mute_ticks(mute_s: FloatArray) -> FloatArray:
    """Messages of this tick and later ones are never heard."""
    return np.ceil(mute_s / TICK_S - 1e-6)


def is_clean(scenarios: Scenarios) -> bool:
    """Nothing is lost."""
    return not bool((scenarios.loss > 0.0).any() or np.isfinite(scenarios.mute_s).any())


class BatchMail:
    """For arrays."""

    def __init__(self, scenarios: Scenarios, rows: IntArray, slots: int) -> None:
        """For some rows of the scenarios; slots: of the ring, one more than the longest delay of them all."""
        boats, cases = scenarios.boats, len(rows)
        self._boats = boats
        self._others = others(boats)
        delays = delay_ticks(scenarios.delay_s)
        self._delay, self._loss = delays[rows], scenarios.loss[rows]
        self.clean = is_clean(scenarios)
        self._same = bool((delays == delays[0]).all())
        self._ring = np.zeros((slots, _FIELDS, boats, cases))
        self._held = np.zeros((_FIELDS, boats - 1, boats, cases))
        self._held[0] = -1.0
        self._mute = mute_ticks(scenarios.mute_s)[rows].T[self._others]
        receiver = np.arange(boats).reshape(1, boats, 1)
        self._hash: Words | None = None
        if (scenarios.loss > 0.0).any():
            self._hash = begin(scenarios.seed, scenarios.case[rows], self._others[:, :, None], receiver)

    def keep(self, columns: IntArray) -> None:
        """Go on with some scenarios only."""
        self._delay, self._loss = self._delay[columns], self._loss[columns]
        self._ring, self._held = self._ring[..., columns], self._held[..., columns]
        self._mute = self._mute[..., columns]
        if self._hash is not None:
            self._hash = self._hash[..., columns]

    def take_in(self, other: BatchMail) -> None:
        """The scenarios of another chunk as well."""
        self._delay = np.concatenate((self._delay, other._delay))
        self._loss = np.concatenate((self._loss, other._loss))
        self._ring = np.concatenate((self._ring, other._ring), axis=-1)
        self._held = np.concatenate((self._held, other._held), axis=-1)
        self._mute = np.concatenate((self._mute, other._mute), axis=-1)
        if self._hash is not None and other._hash is not None:
            self._hash = np.concatenate((self._hash, other._hash), axis=-1)

    def post(self, now: int, messages: list[Message[Any]]) -> None:
        """Into the ring."""
        slot = self._ring[now % len(self._ring)]
        shape = slot.shape[1:]
        for row, value in zip(slot, structs.astuple(messages[0]), strict=True):
            row[:] = value.reshape(shape)

    def deliver(self, now: int) -> Told:
        """Everything that is due now and not lost takes the place of what was held."""
        if self.clean and self._same:
            sent = now - int(self._delay[0])
            if sent >= 0:
                self._held = self._ring[sent % len(self._ring)].take(self._others, axis=1)
        else:
            self._receive(now - self._delay)
        lanes = self._held.reshape(_FIELDS, self._boats - 1, -1)
        return [tuple(Message(*lanes[:, c]) for c in range(self._boats - 1))]

    def _receive(self, sent: IntArray) -> None:
        """Messages of the ticks `sent`, one per scenario."""
        if self._same:
            came = self._ring[int(sent[0]) % len(self._ring)][:, self._others]
        else:
            columns = np.arange(len(sent))
            came = self._ring[sent % len(self._ring), :, :, columns].transpose(1, 2, 0)[:, self._others]
        heard: NDArray[np.bool_] = (sent >= 0) & (sent < self._mute)
        if self._hash is not None:
            h = more(more(self._hash, np.maximum(sent, 0)), int(Purpose.LOSS))
            heard = heard & (uniform(h) >= self._loss)
        np.copyto(self._held, came, where=heard)


class LoneMail:
    """For the boats of one scenario, on floats."""

    def __init__(self, scenarios: Scenarios) -> None:
        boats = scenarios.boats
        self._others = others(boats).T.tolist()
        self._delay = int(delay_ticks(scenarios.delay_s)[0])
        self._loss = float(scenarios.loss[0])
        self.clean = is_clean(scenarios)
        nothing: Message[float] = Message(-1.0, *[0.0] * (_FIELDS - 1))
        self._ring: list[list[Message[float]]] = [[nothing] * boats for _ in range(self._delay + 1)]
        self._held = [[nothing] * (boats - 1) for _ in range(boats)]
        self._mute: list[float] = mute_ticks(scenarios.mute_s)[0].tolist()
        seed_case = more(more(0, scenarios.seed), int(scenarios.case[0]))
        self._hash = [[more(more(seed_case, j), i) for j in row] for i, row in enumerate(self._others)]

    def post(self, now: int, messages: list[Message[Any]]) -> None:
        """Into the ring."""
        self._ring[now % len(self._ring)] = messages

    def deliver(self, now: int) -> Told:
        """As `BatchMail.deliver`."""
        sent = now - self._delay
        if sent >= 0:
            came = self._ring[sent % len(self._ring)]
            for i, row in enumerate(self._others):
                for c, j in enumerate(row):
                    if sent < self._mute[j] and not self._lost(i, c, sent):
                        self._held[i][c] = came[j]
        return [tuple(row) for row in self._held]

    def _lost(self, receiver: int, column: int, sent: int) -> bool:
        if self._loss <= 0.0:
            return False
        return uniform(more(more(self._hash[receiver][column], sent), int(Purpose.LOSS))) < self._loss
