"""Scenarios by the thousand in lock-step: the very `step` that boats run, on arrays; or one of them on floats."""

from fleet.sim.batch.results import Results, Trace
from fleet.sim.batch.run import run
from fleet.sim.batch.scenarios import Change, Scenarios, assemble

__all__ = ["Change", "Results", "Scenarios", "Trace", "assemble", "run"]
