"""A boat with an autopilot that speaks MAVLink, such as ArduPilot Rover: own sockets, pymavlink's dialect module."""
