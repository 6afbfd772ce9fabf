"""Planar laser scanners: the SCIP 2.0 protocol over TCP or a serial line, and scans that others publish."""
