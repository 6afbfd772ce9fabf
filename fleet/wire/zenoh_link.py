"""Zenoh sessions: how they are configured, and the hub. Only the files `zenoh_*.py` import Zenoh."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import Any

import zenoh

from fleet.errors import FleetError
from fleet.wire.link import LinkConfig, Topology

LARGEST_RECEIVED = 2 << 20  # the transport drops what is larger, before it takes memory
MOST_TOKENS = 512


def session_config(mode: str, link: LinkConfig) -> zenoh.Config:
    """A Zenoh configuration: no scouting, no shared memory, quick retries."""
    listen = list(link.listen) if mode != "client" else []
    config: dict[str, Any] = {
        "mode": mode,
        "connect": {
            "endpoints": list(link.connect),
            "timeout_ms": 0 if mode == "client" else -1,
            "exit_on_failure": mode == "client",
            "retry": {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 1.5},
        },
        "listen": {"endpoints": listen},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": mode == "peer"}},
        "timestamping": {"enabled": False},
        "queries_default_timeout": 3000,
        "transport": {
            "shared_memory": {"enabled": False},
            "link": {
                "rx": {"max_message_size": LARGEST_RECEIVED},
                "tx": {
                    "lease": link.lease_ms,
                    "keep_alive": link.keep_alive,
                    "queue": {"congestion_control": {"block": {"wait_before_close": 1_000_000}}},
                },
            },
        },
    }
    return zenoh.Config.from_json5(json.dumps(config))


def mode_of(topology: Topology) -> str:
    """The mode of a boat's session."""
    return {"hub": "client", "routed": "router", "mesh": "peer"}[topology]


def direct(callback: Callable[[Any], object]) -> Any:
    """A callback in Zenoh's own thread; it must only deposit."""
    return zenoh.handlers.Callback(callback, indirect=False)


def run_hub(listen: tuple[str, ...], stop: threading.Event, ready: Callable[[], None], lease_ms: int = 2000) -> None:
    """Be the hub until `stop`: a router that boats and operators connect to."""
    try:
        session = zenoh.open(session_config("router", LinkConfig(topology="hub", listen=listen, lease_ms=lease_ms)))
    except zenoh.ZError as error:
        raise FleetError(f"cannot listen at {', '.join(listen)}: {str(error).split(' at ')[0]}") from None
    with session:
        ready()
        stop.wait()
