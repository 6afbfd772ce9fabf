"""What a boat remembers about foreign vessels: numbers only, so that it is recorded and handed on."""

from __future__ import annotations

from msgspec import Struct

from fleet.avoidance.foreign.decision import Search
from fleet.avoidance.foreign.types import Action, Encounter


class Sighted(Struct, frozen=True, gc=False):
    """When boats that have been looked at enter a vessel's domain, on the law's clock; NEVER_S not at all."""

    number: float
    entry: float  # on the paths [s]
    held: float  # on the alteration that is held [s]


class Glance(Struct, frozen=True, gc=False):
    """A look that goes on in the next tick: some boats have been looked at."""

    boats: float  # how many there are
    done: float  # how many of them have been looked at
    beside: float  # 1 the path's course is clear beside the path, for all of them so far
    seen: tuple[Sighted, ...]


class Memory(Struct, frozen=True, gc=False):
    """What a boat remembers from tick to tick."""

    encounters: tuple[Encounter, ...]  # by number
    sailed: Action  # what is sailed now
    ordered: Action  # what was decided last; sailed from `ordered.at` on
    turning: float  # 1 until the named way round is nearly done
    decided_s: float  # when it was decided last
    due_s: float  # when the next look is due
    bad_s: float  # seconds for which the held action has failed
    free_s: float  # seconds for which the path has been clear
    beside_s: float  # seconds for which the path's course has been clear beside the path
    banked: float  # 1 the held course is bent by a bank
    serial: float  # decisions so far, resuming included
    target: float  # number of the vessel of the last decision, -1 none
    reason: float  # Reason of the last decision
    waited_s: float  # seconds a follower has seen the need to act without an order
    alone: float  # 1 a follower that decided for itself, until it resumes
    search: Search | None  # a decision that goes on in the next tick
    glance: Glance | None  # a look that goes on in the next tick
