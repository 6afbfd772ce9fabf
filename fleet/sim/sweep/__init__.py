"""Sweeps: families of scenarios sailed by the thousand, kept part by part, judged, compared."""
