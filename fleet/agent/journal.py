"""Logs: one JSON object a line where a machine reads, plain lines on a terminal."""

from __future__ import annotations

import json
import logging
import sys
import time


class JsonLines(logging.Formatter):
    """`{"time", "level", "logger", "boat", "event", "text"}` on one line."""

    def __init__(self, boat: str) -> None:
        super().__init__()
        self._boat = boat

    def format(self, record: logging.LogRecord) -> str:
        """One record as one line."""
        line = {
            "time": time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created)) + f".{record.msecs:03.0f}Z",
            "level": record.levelname.lower(),
            "logger": record.name,
            "boat": self._boat,
            "event": getattr(record, "event", ""),
            "text": record.getMessage(),
        }
        if record.exc_info:
            line["trace"] = self.formatException(record.exc_info)
        return json.dumps(line)


def set_up(boat: str, level: int = logging.INFO) -> None:
    """Log to stderr."""
    handler = logging.StreamHandler(sys.stderr)
    if sys.stderr.isatty():
        handler.setFormatter(logging.Formatter(f"%(asctime)s {boat} %(levelname)s %(message)s"))
    else:
        handler.setFormatter(JsonLines(boat))
    root = logging.getLogger()
    root.handlers[:] = [handler]
    root.setLevel(level)
