"""What the boat's own scanners see, as sightings: clusters of returns, put where the boat was when it saw them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Annotated

from msgspec import Meta, Struct

from fleet import ops
from fleet.agent.step import Nav
from fleet.agent.traffic import SCAN
from fleet.drivers.seam import Sighting
from fleet.sensing.clusters import Cluster, ClusterParams, Motion, clusters, seen_before
from fleet.sensing.scan import Scan

OLD_S = 0.5  # of a scan; and how far the boat's motion is reckoned back
HEADING_RAD = 0.02  # 1-sigma error of the heading, which swings everything round the boat
EARLIER, EARLIER_S = 3, 0.35  # one of so many scans before, no older, must show a thing too; slow scanners are believed
SHORTEST_M = 2.0  # of a vessel; a buoy is kept clear of like one


class ScanParams(ClusterParams, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`[scans]` of an agent's configuration."""

    every_s: Annotated[float, Meta(ge=0.05, le=5.0)] = 0.5  # a scanner's scans are looked at so often
    avoid: bool = True  # things that scans show are foreign vessels, and kept clear of


class Tally(Struct):
    """What came of scans so far."""

    scans: int = 0
    looked: int = 0  # of them; the others came too soon after one that was
    unplaced: int = 0  # looked at when the boat did not know where it was, or too late
    things: int = 0
    banks: int = 0  # too long for a vessel: passed over
    once: int = 0  # things that no scan shortly before showed: spray, or a line of ranges that came damaged
    few: int = 0  # returns of things with too few of them
    own: int = 0  # returns of the own hull


class Outlook:
    """From scans to sightings."""

    def __init__(self, params: ScanParams | None = None) -> None:
        self._params = params or ScanParams()
        self._looked_ns: dict[str, int] = {}
        self._earlier: dict[str, deque[Scan]] = {}  # of each scanner, the newest last
        self._last: dict[str, tuple[int, int]] = {}  # things and banks, by scanner
        self.tally = Tally()

    def sightings(
        self,
        scans: Iterable[Scan],
        nav: Nav[float],
        to_geographic: Callable[[float, float], tuple[float, float]],
        now_ns: int,
    ) -> Iterator[list[Sighting]]:
        """Sightings of the newest scan of each scanner, if it is time for one; scanner by scanner.

        Args:
            scans: since the last call
            nav: of the boat, now
            to_geographic: (north, east) [m] to latitude and longitude
            now_ns: now
        """
        newest: dict[str, Scan] = {}
        for scan in scans:
            self.tally.scans += 1
            newest[scan.scanner] = scan
            self._earlier.setdefault(scan.scanner, deque(maxlen=EARLIER + 1)).append(scan)
        for scanner, scan in newest.items():
            last_ns = self._looked_ns.get(scanner)
            if last_ns is not None and scan.stamp_ns - last_ns < round(self._params.every_s * 1e9):
                continue
            self._looked_ns[scanner] = scan.stamp_ns
            self.tally.looked += 1
            age_s = (now_ns - scan.stamp_ns) * 1e-9
            if nav.sound < 0.5 or not -0.1 <= age_s <= OLD_S:
                self.tally.unplaced += 1
                continue
            things = self._things(scan, nav)
            if self._params.avoid:
                yield [_sighting(thing, scan, nav, to_geographic, now_ns) for thing in things]

    def _things(self, scan: Scan, nav: Nav[float]) -> tuple[Cluster, ...]:
        s, c = ops.sincos(nav.psi)
        motion = Motion(nav.vx * c + nav.vy * s, nav.vy * c - nav.vx * s, nav.r)
        found = clusters(scan, motion, self._params)
        least_ns = scan.stamp_ns - round(EARLIER_S * 1e9)
        earlier = [one for one in self._earlier[scan.scanner] if least_ns <= one.stamp_ns < scan.stamp_ns]
        before = seen_before(found.clusters, scan, earlier, motion, self._params)
        things = tuple(thing for thing, there in zip(found.clusters, before, strict=True) if there)
        tally = self.tally
        tally.things += len(things)
        tally.once += len(before) - len(things)
        tally.banks += found.banks
        tally.few += found.few
        tally.own += found.own
        self._last[scan.scanner] = (len(things), found.banks)
        return things

    def words(self) -> tuple[str, ...]:
        """A line for each scanner: what its last scan showed."""
        return tuple(
            f"{scanner}: {things} on the water" + (f", {banks} too long for a vessel" if banks else "")
            for scanner, (things, banks) in sorted(self._last.items())
        )


def _sighting(
    cluster: Cluster,
    scan: Scan,
    nav: Nav[float],
    to_geographic: Callable[[float, float], tuple[float, float]],
    now_ns: int,
) -> Sighting:
    """A cluster in the world: the boat is reckoned back to when it was seen."""
    stamp_ns = scan.stamp_ns + round(cluster.t * 1e9)
    back = (now_ns - stamp_ns) * 1e-9
    s, c = ops.sincos(nav.psi - nav.r * back)
    x = nav.x - nav.vx * back + cluster.ahead * c - cluster.starboard * s
    y = nav.y - nav.vy * back + cluster.ahead * s + cluster.starboard * c
    lat_deg, lon_deg = to_geographic(x, y)
    away = math.hypot(cluster.ahead, cluster.starboard)
    return Sighting(
        stamp_ns=stamp_ns,
        source=SCAN,
        name="",
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        position_error_m=math.hypot(cluster.sigma, HEADING_RAD * away),
        length_m=max(cluster.length, SHORTEST_M),
    )
