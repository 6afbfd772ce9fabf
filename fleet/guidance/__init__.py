"""One boat follows its path, or keeps its station."""

from fleet.guidance.limits import Limits
from fleet.guidance.station import Station, StationParams, keep_station
from fleet.guidance.virtual_target import Follow, FollowParams, course_over_ground, follow

__all__ = [
    "Follow",
    "FollowParams",
    "Limits",
    "Station",
    "StationParams",
    "course_over_ground",
    "follow",
    "keep_station",
]
