"""What a boat's configuration says about its sensors: `[[driver.sensors]]`, the first one is believed first."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import Meta, Struct, field

from fleet.errors import ConfigError
from fleet.mission.problem import texts
from fleet.mission.structure import problems

Use = Literal["fix", "heading", "yaw-rate", "traffic", "scan"]
NAVIGATION = frozenset({"fix", "heading", "yaw-rate"})
EVERYTHING = frozenset({*NAVIGATION, "traffic", "scan"})
T = TypeVar("T", bound=Struct)


class SensorConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One sensor. Kind `driver` stands for what the driver itself measures, and gives it a rank other than the last."""

    kind: Annotated[str, Meta(min_length=1)]
    name: str = ""  # in words about it; empty: its kind
    endpoint: str = ""  # serial:DEVICE:BAUD, tcp:HOST:PORT, udp:HOST:PORT (there we listen)
    insecure: bool = False  # it is meant that anybody on the network can write to this endpoint
    use: tuple[Use, ...] = ()  # of what it gives; empty: all
    delay_s: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.0  # from a measurement to its arrival here
    silent_s: Annotated[float, Meta(gt=0.0, le=3600.0)] = 3.0  # nothing to use for so long is trouble
    options: dict[str, Any] = field(default_factory=dict)  # of its kind

    @property
    def called(self) -> str:
        """How it is called."""
        return self.name or self.kind

    def options_as(self, kind: type[T]) -> T:
        """`options` as the struct of its kind; ConfigError with every misfit."""
        found = texts(problems(self.options, kind))
        if found:
            raise ConfigError("\n".join(f"driver.sensors, {self.called}: options: {text}" for text in found))
        try:
            return msgspec.convert(self.options, kind)
        except msgspec.ValidationError as error:
            raise ConfigError(f"driver.sensors, {self.called}: options: {error}") from None
