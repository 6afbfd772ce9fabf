"""How a boat moves: models that take surge over ground along the heading, and yaw rate."""

from fleet.hulls import catamaran, three_dof, unicycle
from fleet.hulls.types import CALM, STEP_S, Hull, HullState, Water

HULLS: dict[str, Hull] = {"unicycle": unicycle, "otter": three_dof, "catamaran": catamaran}
"""Models by the name that mission files use."""

__all__ = ["CALM", "HULLS", "STEP_S", "Hull", "HullState", "Water"]
