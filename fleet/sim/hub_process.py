"""The hub as a process of the simulation; `fleet hub` is the same for a harbour."""

from __future__ import annotations

import sys
import threading

import msgspec

from fleet.agent.journal import set_up
from fleet.agent.process import end_on_signals, end_with_parent
from fleet.wire.credentials.trust import load
from fleet.wire.link import LinkConfig
from fleet.wire.zenoh_hub import run_hub
from fleet.wire.zenoh_log import capture


def main(link: LinkConfig) -> None:
    """Run until told to end; one line on stdout when it is up."""
    stop = threading.Event()
    end_on_signals(stop)
    end_with_parent(stop)
    set_up("hub")
    trust = load(link.credentials, "", "hub") if link.credentials else None
    if trust is not None:
        capture()
    run_hub(link, stop, lambda: print("{}", flush=True), trust)


if __name__ == "__main__":
    main(msgspec.json.decode(sys.argv[1], type=LinkConfig))
