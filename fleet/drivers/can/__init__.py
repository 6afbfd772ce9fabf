"""The driver of a boat whose thrusters hang on a controller on a CAN bus."""
