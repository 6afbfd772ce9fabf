"""What may be said about an AIS receiver."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from fleet.drivers.ais.mmsi import FIRST, LAST


class AisOptions(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`options` of a sensor of kind `ais`."""

    ignore_mmsi: tuple[int, ...] = ()  # boats of the fleet that carry transponders, and the like
    ignore_range: tuple[int, int] = (FIRST, LAST)  # what `fleet export ais` uses, should it come back
    accurate_m: Annotated[float, Meta(gt=0.0, le=100.0)] = 4.0  # 1 sigma per axis, with the accuracy bit (10 m)
    inaccurate_m: Annotated[float, Meta(gt=0.0, le=100.0)] = 10.0  # without it
    class_a_m: Annotated[float, Meta(gt=2.0, le=500.0)] = 100.0  # length of a class A ship that has not told it yet
