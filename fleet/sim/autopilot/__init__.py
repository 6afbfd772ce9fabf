"""An autopilot for simulated hulls: ArduPilot Rover's words and habits, over real MAVLink."""
