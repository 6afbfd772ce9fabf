"""From sentences to fixes, headings and yaw rates. Pure: sentences and times are handed in.

A receiver says one fix in several sentences, an epoch. The fix counts when all kinds of sentences have come that the
epoch before had, or 0.15 s after the first.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import Annotated

from msgspec import Meta, Struct
from msgspec.structs import replace

from fleet.drivers.ais.options import AisOptions
from fleet.drivers.nmea.codec import Gga, Gst, Heading, Rmc, Rot, Sentence, Unusable, Vtg, decode
from fleet.drivers.nmea.delay import DAY_NS, Delay
from fleet.drivers.seam import Observed
from fleet.drivers.sensors.jumps import Jumps, distance_m

DAY_S = 86_400.0
GATHER_NS = 150_000_000
EPOCH_NS = 500_000_000  # a sentence without a time, or with an error, so much later is of another epoch
DISAGREE_M = 10.0  # two sentences of one epoch
BACK_MOST = 10  # epochs from the past; then it is the receiver's time that was wrong
ERROR_OLD_NS = 5_000_000_000

Metres = Annotated[float, Meta(gt=0.0, le=100.0)]


class NmeaOptions(AisOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`options` of a sensor of kind `nmea`; a multiplexed line has AIS on it too."""

    gps_m: Metres = 1.5  # 1 sigma per axis at HDOP 1: without corrections (GGA quality 1 and 3)
    dgps_m: Metres = 0.8  # with SBAS or a reference station (2)
    float_m: Metres = 0.3  # RTK float (5)
    fixed_m: Metres = 0.02  # RTK fixed (4)
    unknown_m: Metres = 3.0  # without any word on it
    hdop_most: Annotated[float, Meta(gt=0.0, le=50.0)] = 4.0  # fixes with a worse one are refused
    velocity_error_mps: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.1  # 1 sigma per axis
    fastest_mps: Annotated[float, Meta(gt=0.0, le=50.0)] = 15.0  # a fix farther off than so fast a boat gets is a jump
    heading_error_deg: Annotated[float, Meta(gt=0.0, le=45.0)] = 2.0  # 1 sigma
    heading_offset_deg: Annotated[float, Meta(ge=-180.0, le=180.0)] = 0.0  # added to every heading: how it is mounted
    variation_deg: Annotated[float, Meta(ge=-180.0, le=180.0)] | None = None  # + east; for magnetic headings


class Epoch(Struct):
    """What was said of one moment."""

    time_s: float
    stamp_ns: int  # when it was measured
    gathered_ns: int  # when its first sentence came
    gga: Gga | None = None
    rmc: Rmc | None = None
    vtg: Vtg | None = None
    void: str = ""
    done: bool = False
    kinds: frozenset[str] = frozenset()


class Receiver:
    """Everything that one line says about the own boat."""

    def __init__(self, options: NmeaOptions, delay_s: float = 0.0) -> None:
        self._options, self._delay_ns = options, int(delay_s * 1e9)
        self.counts: Counter[str] = Counter()  # sentences, by what came of them
        self.why_no_fix = ""
        self.why_no_heading = ""
        self._epoch: Epoch | None = None
        self._before: frozenset[str] = frozenset()
        self._delay = Delay()
        self._late_ns = 0  # of the last epoch
        self._back = 0
        self._void = ("", "", -DAY_NS)  # why a sentence said that there is no fix, of which kind it was, and when
        self._sigma: tuple[float, int] = (math.nan, -DAY_NS)  # of GST, and when
        self._jumps = Jumps(options.fastest_mps)
        self._new = Observed()

    def take(self, line: bytes, stamp_ns: int) -> None:
        """A sentence arrives."""
        try:
            said = decode(line)
            used = self._hear(said, stamp_ns)
        except Unusable as error:
            self.counts[str(error)] += 1
            self._refused(line, str(error), stamp_ns)
            return
        self.counts[used] += 1

    def observed(self, now_ns: int) -> Observed:
        """What is new since the last call."""
        epoch = self._epoch
        if epoch is not None and not epoch.done and now_ns - epoch.gathered_ns > GATHER_NS:
            self._finish(epoch)
        new, self._new = self._new, Observed()
        return new

    # -- sentences -------------------------------------------------------------------------------------------------
    def _hear(self, said: Sentence, stamp_ns: int) -> str:
        """One sentence that says something; how it is counted."""
        if isinstance(said, Gga | Rmc):
            self._position(said, stamp_ns)
        elif isinstance(said, Vtg):
            epoch = self._epoch
            if epoch is not None and stamp_ns - epoch.gathered_ns < EPOCH_NS:
                epoch.vtg, epoch.kinds = said, epoch.kinds | {"VTG"}
                self._finish_if_whole(epoch)
        elif isinstance(said, Gst):
            self._sigma = (said.sigma_m, stamp_ns)
        elif isinstance(said, Rot):
            self._say(yaw_rate_ns=self._measured(stamp_ns), yaw_rate_radps=said.yaw_rate_radps)
        else:
            self._heading(said, stamp_ns)
        return "accepted"

    def _refused(self, line: bytes, why: str, stamp_ns: int) -> None:
        """A sentence that was whole and says that there is nothing; a void one spoils the epoch's other sentences."""
        kind = line[3:6]
        if why in ("checksum", "no checksum", "characters", "too long", "no sentence"):
            return
        if kind in (b"GGA", b"RMC"):
            self.why_no_fix = why
            self._void, epoch = (why, kind.decode("ascii"), stamp_ns), self._epoch
            if epoch is not None and stamp_ns - epoch.gathered_ns < EPOCH_NS:
                epoch.void, epoch.kinds = why, epoch.kinds | {self._void[1]}
                self._finish_if_whole(epoch)
        elif kind in (b"HDT", b"THS", b"HDG", b"HDM"):
            self.why_no_heading = why

    def _position(self, said: Gga | Rmc, stamp_ns: int) -> None:
        epoch = self._epoch
        if epoch is None or said.time_s != epoch.time_s:
            epoch = self._begin(said.time_s, stamp_ns)
        elif epoch.done and stamp_ns - epoch.gathered_ns > EPOCH_NS:
            raise Unusable("time stands still")
        if isinstance(said, Gga):
            epoch.gga, epoch.kinds = said, epoch.kinds | {"GGA"}
        else:
            epoch.rmc, epoch.kinds = said, epoch.kinds | {"RMC"}
        self._finish_if_whole(epoch)

    def _heading(self, said: Heading, stamp_ns: int) -> None:
        psi = said.heading_rad + math.radians(self._options.heading_offset_deg)
        if said.magnetic:
            declared = self._options.variation_deg
            variation = said.variation_rad if declared is None else math.radians(declared)
            if math.isnan(variation):
                raise Unusable("magnetic, variation not known")
            psi += variation
        self._say(
            heading_ns=self._measured(stamp_ns),
            heading_rad=math.remainder(psi, 2.0 * math.pi),
            heading_error_rad=math.radians(self._options.heading_error_deg),
        )

    def _measured(self, stamp_ns: int) -> int:
        """When a sentence without a time was measured: what shares a line with a fix that comes late is late too."""
        return stamp_ns - self._delay_ns - (self._late_ns if self._late_ns > EPOCH_NS else 0)

    # -- epochs ----------------------------------------------------------------------------------------------------
    def _begin(self, time_s: float, stamp_ns: int) -> Epoch:
        """A new epoch; Unusable where its time is not later than that of the one before."""
        old = self._epoch
        if old is not None:
            passed_s = (time_s - old.time_s + 0.5 * DAY_S) % DAY_S - 0.5 * DAY_S
            if passed_s < 0.0:
                self._back += 1
                if self._back < BACK_MOST:
                    raise Unusable("time goes back")
                self._delay = Delay()
            elif not old.done:
                self._finish(old)
            self._before = old.kinds if stamp_ns - old.gathered_ns < ERROR_OLD_NS else frozenset()
        self._back = 0
        late_ns = self._late_ns = self._delay.late_ns(time_s, stamp_ns)
        if late_ns > EPOCH_NS:
            self.counts["late"] += 1
        self._epoch = Epoch(time_s, stamp_ns - late_ns - self._delay_ns, stamp_ns)
        why, kind, at_ns = self._void
        if stamp_ns - at_ns < GATHER_NS:  # said of the same moment, a little before
            self._epoch.void, self._epoch.kinds = why, frozenset({kind})
        return self._epoch

    def _finish_if_whole(self, epoch: Epoch) -> None:
        if self._before and epoch.kinds >= self._before:
            self._finish(epoch)

    def _finish(self, epoch: Epoch) -> None:
        """The fix of an epoch, if it is one."""
        if epoch.done:
            return
        epoch.done = True
        why = epoch.void or self._fix(epoch)
        self.why_no_fix = why or ("its sentences come late" if self._late_ns > EPOCH_NS else "")
        self.counts["fixes"] += not why
        if why:
            self.counts[f"no fix: {why}"] += 1

    def _fix(self, epoch: Epoch) -> str:
        """Say the fix; '' or why it is none."""
        place = epoch.gga or epoch.rmc
        if place is None:
            return "no position"
        if epoch.gga is not None and epoch.rmc is not None and _apart_m(epoch.gga, epoch.rmc) > DISAGREE_M:
            return "its sentences disagree"
        sigma_m, why = self._error(epoch)
        if why:
            return why
        if not self._jumps.plausible((place.lat_deg, place.lon_deg, epoch.stamp_ns)):
            return "position jumps"
        v_north, v_east = _velocity(epoch)
        self._say(
            fix_ns=epoch.stamp_ns,
            lat_deg=place.lat_deg,
            lon_deg=place.lon_deg,
            position_error_m=sigma_m,
            v_north_mps=v_north,
            v_east_mps=v_east,
            velocity_error_mps=self._options.velocity_error_mps,
        )
        return ""

    def _error(self, epoch: Epoch) -> tuple[float, str]:
        """1-sigma error of the position [m]; or why it is too large."""
        options, gga = self._options, epoch.gga
        if gga is not None and gga.hdop > options.hdop_most:
            return math.nan, "HDOP too high"
        told_m, at_ns = self._sigma
        if epoch.gathered_ns - at_ns < ERROR_OLD_NS and math.isfinite(told_m):
            return told_m, ""
        if gga is None or math.isnan(gga.hdop):
            return options.unknown_m, ""
        at_one = {2: options.dgps_m, 4: options.fixed_m, 5: options.float_m}.get(gga.quality, options.gps_m)
        return at_one * gga.hdop, ""

    def _say(self, **values: float) -> None:
        self._new = replace(self._new, **values)


def _velocity(epoch: Epoch) -> tuple[float, float]:
    """Of RMC, else of VTG, else not known."""
    for said in (epoch.rmc, epoch.vtg):
        if said is not None and math.isfinite(said.v_north_mps + said.v_east_mps):
            return said.v_north_mps, said.v_east_mps
    return math.nan, math.nan


def _apart_m(a: Gga, b: Rmc) -> float:
    return distance_m(a.lat_deg, a.lon_deg, b.lat_deg, b.lon_deg)
