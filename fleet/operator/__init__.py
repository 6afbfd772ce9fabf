"""The shore side as a library: commands with acknowledgements, and the picture of the fleet."""

from fleet.operator.fleet import BoatView, Fleet, OperatorConfig
from fleet.operator.outcome import Outcome

__all__ = ["BoatView", "Fleet", "OperatorConfig", "Outcome"]
