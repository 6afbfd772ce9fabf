"""How a boat moves: models that take surge over ground along the heading, and yaw rate."""

from fleet.hulls import catamaran, three_dof, unicycle
from fleet.hulls.types import CALM, STEP_S, Hull, HullState, Water
from fleet.plugins import Kinds

HULLS: Kinds[Hull] = Kinds(
    "fleet.hulls",
    {"unicycle": unicycle, "otter": three_dof, "catamaran": catamaran},
    needs=("description", "start", "velocity", "advance", "advance_by"),
)
"""Models by the name that mission files use; other packages may add some."""

__all__ = ["CALM", "HULLS", "STEP_S", "Hull", "HullState", "Water"]
