"""Speeds that make and keep the formation."""

from fleet.coordination.consensus import Member, along_path_error, formation_speed

__all__ = ["Member", "along_path_error", "formation_speed"]
