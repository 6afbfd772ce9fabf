"""What sensors saw becomes knowledge: the tracks of other vessels."""

from fleet.sensing.track import Target, Track, TrackParams, begin, lost, predict, seen, update_ais, update_position

__all__ = ["Target", "Track", "TrackParams", "begin", "lost", "predict", "seen", "update_ais", "update_position"]
