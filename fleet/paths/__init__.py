"""Curves parametrised by their abscissa s: lines, arcs, polylines, sines, splines."""

from fleet.paths.build import arc, polyline, straight
from fleet.paths.curve import Cell, PathPoint, beyond, evaluate, within_lap
from fleet.paths.errors import PathError, Point
from fleet.paths.path import NEVER_M, Path, sample
from fleet.paths.smooth import sine, through

__all__ = [
    "NEVER_M",
    "Cell",
    "Path",
    "PathError",
    "PathPoint",
    "Point",
    "arc",
    "beyond",
    "evaluate",
    "polyline",
    "sample",
    "sine",
    "straight",
    "through",
    "within_lap",
]
