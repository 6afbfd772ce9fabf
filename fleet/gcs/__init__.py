"""Every boat of a fleet as a MAVLink vehicle, for QGroundControl, Mission Planner or MAVProxy."""
