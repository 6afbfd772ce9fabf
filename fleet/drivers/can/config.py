"""Configuration of the `can` driver; nothing of python-can is imported here."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct, field

from fleet.drivers.can.loops import LoopParams
from fleet.guidance.thrust import Thrusters


class CanConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which bus, which frames, which boat."""

    interface: Annotated[str, Meta(min_length=1)] = "socketcan"  # any that python-can knows
    channel: Annotated[str, Meta(min_length=1)] = "can0"
    options: dict[str, str | bool | int | float] = field(default_factory=dict)  # more arguments of python-can's Bus
    dbc: str = ""  # file with the frames; empty: the `viam.dbc` of the package
    command_age_s: Annotated[float, Meta(gt=0.0, le=2.0)] = 0.5  # an older command is not passed on
    silent_s: Annotated[float, Meta(gt=0.0, le=10.0)] = 1.0  # a controller that says nothing for so long is lost
    velocity_error_mps: Annotated[float, Meta(ge=0.0, le=5.0)] = (
        0.1  # 1 sigma per axis, where the controller does not fuse
    )
    heading_error_deg: Annotated[float, Meta(ge=0.0, le=45.0)] = 2.0
    thrusters: Thrusters = field(default_factory=Thrusters)
    loops: LoopParams = field(default_factory=LoopParams)
