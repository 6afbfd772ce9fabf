"""Curves parametrised by their abscissa s: lines, arcs, polylines, sines, splines."""

from fleet.paths.build import arc, polyline, straight
from fleet.paths.curve import Cell, PathPoint, beyond, evaluate, within_lap
from fleet.paths.errors import PathError, Point
from fleet.paths.lane import Lane, Shift, lane, shift_length
from fleet.paths.path import NEVER_M, Path, sample
from fleet.paths.smooth import sine, through

__all__ = [
    "NEVER_M",
    "Cell",
    "Lane",
    "Path",
    "PathError",
    "PathPoint",
    "Point",
    "Shift",
    "arc",
    "beyond",
    "evaluate",
    "lane",
    "polyline",
    "sample",
    "shift_length",
    "sine",
    "straight",
    "through",
    "within_lap",
]
