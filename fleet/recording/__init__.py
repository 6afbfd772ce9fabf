"""Runs on disk: written so that a crash costs a second, read even when damaged, repaired."""
