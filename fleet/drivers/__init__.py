"""This boat's hardware: one small protocol, one file for each kind."""
