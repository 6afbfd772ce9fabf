"""The shore side as a library: commands with acknowledgements, and the picture of the fleet."""

from fleet.operator.connection import OperatorConfig
from fleet.operator.fleet import Fleet
from fleet.operator.outcome import Outcome
from fleet.operator.view import BoatView

__all__ = ["BoatView", "Fleet", "OperatorConfig", "Outcome"]
