"""gpsd: its JSON on a TCP port."""
