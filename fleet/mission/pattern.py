"""Patterns: where in a formation each slot lies, ahead and abeam; and which boat takes which slot."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from msgspec import Struct

Place = tuple[float, float]
"""Metres ahead of slot 0 along the path, and to starboard of it."""


class Pattern(Struct, frozen=True):
    """One way to draw up a fleet."""

    meaning: str
    place: Callable[[float, float, float], Place]
    """(slot, spacing, lateral) -> its place."""
    both_sides: bool
    """Slots are counted to both sides of slot 0; else backwards from it."""
    lateral: bool
    """Boats sail beside their path."""


PATTERNS: dict[str, Pattern] = {
    "column": Pattern("one behind the other", lambda slot, d, w: (slot * d, 0.0), False, False),
    "abreast": Pattern("side by side, a survey's swath", lambda slot, d, w: (0.0, slot * w), True, True),
    "echelon": Pattern("each further back and further out", lambda slot, d, w: (slot * d, -slot * w), False, True),
    "wedge": Pattern("a point, and two arms behind it", lambda slot, d, w: (-abs(slot) * d, slot * w), True, True),
    "wingman": Pattern("each on its own path, beside its leader", lambda slot, d, w: (0.0, 0.0), True, False),
}
"""Every pattern by the name that a mission gives it."""


class Shape(Struct, frozen=True):
    """A formation: what an operator may change while it sails."""

    pattern: str
    spacing_m: float
    """From slot to slot, + ahead."""
    lateral_m: float
    """From slot to slot, + to starboard."""
    cruise_mps: float
    slots: tuple[float, ...]
    """Of each boat, in the order of the roster."""

    def place(self, number: int) -> Place:
        """Metres ahead of slot 0 and to starboard of the path, of a boat of the roster."""
        return PATTERNS[self.pattern].place(self.slots[number], self.spacing_m, self.lateral_m)

    @property
    def places(self) -> tuple[Place, ...]:
        """Of all boats, in the order of the roster."""
        place = PATTERNS[self.pattern].place
        return tuple(place(slot, self.spacing_m, self.lateral_m) for slot in self.slots)

    def ahead(self, number: int) -> float:
        """o_i: metres ahead of slot 0."""
        return self.place(number)[0]

    def abeam(self, number: int) -> float:
        """n_i: metres to starboard of the path."""
        return self.place(number)[1]

    @property
    def leading(self) -> int:
        """Number of the boat that leads: the foremost, of several the one nearest to slot 0."""
        return min(range(len(self.slots)), key=lambda i: (-self.ahead(i), abs(self.slots[i]), i))

    def leader_of(self, number: int) -> int | None:
        """Whom a wingman sails beside: the boat one slot nearer to slot 0; None for slot 0 itself."""
        slot = self.slots[number]
        inner = [i for i, other in enumerate(self.slots) if abs(other) < abs(slot) and other * slot >= 0.0]
        return max(inner, key=lambda i: (abs(self.slots[i]), -i), default=None)


def slots_of(pattern: str, boats: int) -> tuple[float, ...]:
    """The slots of so many boats, the first ones first: 0, -1, -2, ... or 0, 1, -1, 2, -2, ..."""
    if not PATTERNS[pattern].both_sides:
        return tuple(0.0 - i for i in range(boats))
    return tuple(0.0 + (i + 1) // 2 * (1 if i % 2 else -1) for i in range(boats))


def closed_up(slots: Sequence[float], gone: Sequence[bool]) -> tuple[float, ...]:
    """The slots when boats are gone: on either side of slot 0 those further out move in, the gone get what is left.

    If the boat in slot 0 is gone, the one that was next to it takes its place, from the side of positive slots first.
    Nobody moves for a boat that comes back: it keeps the slot that it has.
    """
    new = list(slots)

    def fill(line: list[int]) -> None:
        places = sorted((new[i] for i in line), key=abs)
        after = [i for i in line if not gone[i]] + [i for i in line if gone[i]]
        for i, slot in zip(after, places, strict=True):
            new[i] = slot

    outward = sorted(range(len(slots)), key=lambda i: (abs(slots[i]), i))
    tip, starboard, port = ([i for i in outward if (slots[i] > 0.0) - (slots[i] < 0.0) == side] for side in (0, 1, -1))
    first, other = (starboard, port) if any(not gone[i] for i in starboard) else (port, starboard)
    fill(tip + first)
    fill(other)
    return tuple(new)


def redrawn(shape: Shape, pattern: str) -> Shape:
    """The same boats in another pattern: each takes the slot that makes all ways together shortest.

    What counts is the sum of the squares, ahead of the middle of all and abeam: then no two ways cross needlessly.
    """
    slots = slots_of(pattern, len(shape.slots))
    place = PATTERNS[pattern].place
    here = shape.places
    there = [place(slot, shape.spacing_m, shape.lateral_m) for slot in slots]
    mean = sum(x for x, _ in there) / len(there) - sum(x for x, _ in here) / len(here)
    cost = [[(x - a + mean) ** 2 + (y - b) ** 2 for x, y in there] for a, b in here]
    return Shape(pattern, shape.spacing_m, shape.lateral_m, shape.cruise_mps, tuple(slots[j] for j in assigned(cost)))


def assigned(cost: Sequence[Sequence[float]]) -> list[int]:
    """The column for each row of a square matrix, each once, that makes the sum least (Kuhn and Munkres)."""
    n = len(cost)
    row_price, column_price = [0.0] * (n + 1), [0.0] * (n + 1)
    row_of = [n] * (n + 1)  # row that has each column; column n is a place to begin from
    for row in range(n):
        row_of[n], column = row, n
        least, came_from, seen = [float("inf")] * n, [n] * n, [False] * (n + 1)
        while row_of[column] != n:
            seen[column] = True
            i = row_of[column]
            for j in range(n):
                over = cost[i][j] - row_price[i] - column_price[j]
                if not seen[j] and over < least[j]:
                    least[j], came_from[j] = over, column
            step, following = min((least[j], j) for j in range(n) if not seen[j])
            for j in range(n + 1):
                if seen[j]:
                    row_price[row_of[j]] += step
                    column_price[j] -= step
                elif j < n:
                    least[j] -= step
            column = following
        while column != n:
            row_of[column] = row_of[came_from[column]]
            column = came_from[column]
    columns = [0] * n
    for j in range(n):
        columns[row_of[j]] = j
    return columns
