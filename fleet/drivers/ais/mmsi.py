"""Identities of boats that have none: MMSIs of a country that does not exist (MID 200)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from zlib import crc32

FIRST, LAST = 200_000_000, 200_999_999
"""No administration has MID 200 (ITU: 201 to 775), so no vessel is taken for a boat of a fleet, nor the other way."""


def mmsis(boats: Iterable[str], given: Mapping[str, int]) -> dict[str, int]:
    """An MMSI for every boat: as given, else from its name, so that it is the same tomorrow."""
    found = {boat: given[boat] for boat in boats if boat in given}
    taken = set(given.values())
    for boat in sorted(set(boats) - set(found)):
        mmsi = FIRST + crc32(boat.encode()) % (LAST - FIRST + 1)
        while mmsi in taken:
            mmsi = FIRST + (mmsi + 1 - FIRST) % (LAST - FIRST + 1)
        found[boat] = mmsi
        taken.add(mmsi)
    return found
