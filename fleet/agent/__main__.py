"""`python -m fleet.agent RESOLVED`: the agent's process, with its configuration as one JSON object."""

from __future__ import annotations

import sys
import threading

import msgspec

from fleet.agent.config import AgentConfig
from fleet.agent.journal import set_up
from fleet.agent.process import end_on_signals, end_with_parent, run_agent
from fleet.errors import FleetError
from fleet.wire.zenoh_log import capture


def main() -> int:
    """Run; the exit code."""
    config = msgspec.json.decode(sys.argv[1], type=AgentConfig)
    stop = threading.Event()
    end_on_signals(stop)
    set_up(config.boat)
    if "--with-parent" in sys.argv[2:]:
        end_with_parent(stop)
    if config.link.credentials:
        capture()
    try:
        run_agent(config, stop)
    except FleetError as error:
        print(f"fleet agent: {error}", file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
