"""The hub as a process of the simulation; `fleet hub` is the same for a harbour."""

from __future__ import annotations

import sys
import threading

from fleet.agent.process import end_on_signals, end_with_parent
from fleet.wire.zenoh_link import run_hub


def main(endpoint: str, lease_ms: int) -> None:
    """Run until told to end; one line on stdout when it is up."""
    stop = threading.Event()
    end_on_signals(stop)
    end_with_parent(stop)
    run_hub((endpoint,), stop, lambda: print("{}", flush=True), lease_ms)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
