"""Runtime for fleets of unmanned surface vehicles."""

__version__ = "0.1.0"
