"""Does what ground stations wish, by the operator's library, in a thread of its own: a command waits for answers."""

from __future__ import annotations

import queue
import threading
from collections.abc import Sequence

from fleet.errors import FleetError
from fleet.gcs.wishes import MERGED, Done, Wish
from fleet.mission.check import check
from fleet.mission.model import Mission
from fleet.operator import Fleet, Outcome

MOST_PROBLEMS = 2  # named in one answer


class Captain:
    """Two threads: stops overtake everything, other wishes keep their order. Equal ones in a row become one command."""

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self._wishes: queue.Queue[Wish | None] = queue.Queue()
        self._stops: queue.Queue[Wish | None] = queue.Queue()
        self._done: queue.Queue[Done] = queue.Queue()
        self._threads = [
            threading.Thread(target=self._run, args=(wishes,), name=f"captain-{name}", daemon=True)
            for name, wishes in (("words", self._wishes), ("stops", self._stops))
        ]

    def start(self) -> None:
        """Begin."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End, after what is being done."""
        self._wishes.put(None)
        self._stops.put(None)
        for thread in self._threads:
            thread.join(10.0)

    def ask(self, wishes: Sequence[Wish]) -> None:
        """To be done."""
        for wish in wishes:
            (self._stops if wish.kind == "stop" else self._wishes).put(wish)

    def done(self) -> list[Done]:
        """What was done since the last call."""
        found = []
        while True:
            try:
                found.append(self._done.get_nowait())
            except queue.Empty:
                return found

    def _run(self, wishes: queue.Queue[Wish | None]) -> None:
        first = wishes.get()
        while first is not None:
            together, following = _alike(first, wishes)
            for done in fulfil(self._fleet, together):
                self._done.put(done)
            first = following if following is not None else wishes.get()


def _alike(first: Wish, wishes: queue.Queue[Wish | None]) -> tuple[list[Wish], Wish | None]:
    """The wish and those of its kind right behind it, where they may be merged; and the one after them."""
    together = [first]
    while first.kind in MERGED:
        try:
            more = wishes.get_nowait()
        except queue.Empty:
            break
        if more is None:
            wishes.put(None)
            break
        if more.kind != first.kind:
            return together, more
        together.append(more)
    return together, None


def fulfil(fleet: Fleet, wishes: Sequence[Wish]) -> list[Done]:
    """Do it; several wishes are of one kind that may be merged. What went wrong is in the answer."""
    first = wishes[0]
    try:
        if first.kind in MERGED:
            return _together(fleet, wishes)
        return [_alone(fleet, first)]
    except FleetError as error:
        return [Done(wish.number, False, _line(str(error)), silent=True) for wish in wishes]


def _together(fleet: Fleet, wishes: Sequence[Wish]) -> list[Done]:
    boats = list(dict.fromkeys(wish.boat for wish in wishes))
    word = {"hold": fleet.hold, "stop": fleet.stop_now, "return": fleet.return_home, "resume": fleet.resume}
    outcome = word[wishes[0].kind](boats)
    return [_of(outcome, wish, outcome.id) for wish in wishes]


def _of(outcome: Outcome, wish: Wish, value: object = None) -> Done:
    """What one boat answered."""
    ack = outcome.acks.get(wish.boat)
    if ack is None:
        return Done(wish.number, False, f"{wish.boat} does not answer", silent=True)
    return Done(wish.number, ack.ok, "" if ack.ok else _line(ack.reason), value=value)


def _alone(fleet: Fleet, wish: Wish) -> Done:
    if wish.kind == "ready":
        if wish.value:
            released = _of(fleet.release([wish.boat], wish.value), wish)
            if not released.ok:
                return released
        return _of(fleet.command("take", [wish.boat]), wish)
    if wish.kind == "take":
        return _all(fleet.take(), wish)
    if wish.kind == "set":
        return _all(fleet.set(*wish.value), wish)
    if wish.kind == "start":
        return _launch(fleet, wish)
    if wish.kind == "look":
        return Done(wish.number, True, value=fleet.mission_of(wish.boat))
    problems = check(wish.value).problems
    return Done(wish.number, not problems, _problems(problems))


def _problems(problems: Sequence[str]) -> str:
    more = f" (and {len(problems) - MOST_PROBLEMS} more)" if len(problems) > MOST_PROBLEMS else ""
    return _line("; ".join(problems[:MOST_PROBLEMS])) + more


def _all(outcome: Outcome, wish: Wish) -> Done:
    """What all boats answered; done when any did it, for the others get it from their neighbours."""
    ok = bool(outcome.acknowledged)
    refused = "; ".join(f"{boat}: {why}" for boat, why in outcome.refused.items())
    silent = f"{', '.join(outcome.silent)} did not answer" if outcome.silent else ""
    text = "; ".join(part for part in (refused, silent) if part)
    first = next(iter(outcome.refused.values()), "")
    if not ok and first and len(set(outcome.refused.values())) == 1:
        text = first
    return Done(wish.number, ok, _line(text), silent=not ok and not outcome.refused)


def _launch(fleet: Fleet, wish: Wish) -> Done:
    mission: Mission = wish.value
    problems = check(mission).problems
    if problems:
        return Done(wish.number, False, _problems(problems))
    outcome = fleet.launch(mission)
    own = outcome.acks.get(wish.boat)
    done = _all(outcome, wish)
    if own is None or not own.ok:
        why = f"{wish.boat} does not answer" if own is None else own.reason
        return Done(wish.number, False, _line(why), silent=own is None)
    return Done(wish.number, True, done.text, value=own.new)


def _line(text: str) -> str:
    return " ".join(text.split())[:300]
