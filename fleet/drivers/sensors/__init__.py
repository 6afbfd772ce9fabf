"""Sensors beside the driver that steers: found by name, read together, ranked."""
