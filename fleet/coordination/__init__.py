"""Speeds that make and keep the formation."""

from fleet.coordination.consensus import Member, along_path_error, formation_speed
from fleet.coordination.wingman import Leader, cvt_speed, wingman_speed

__all__ = ["Leader", "Member", "along_path_error", "cvt_speed", "formation_speed", "wingman_speed"]
