"""Zenoh sessions: how they are configured, and the hub. Only the files `zenoh_*.py` import Zenoh."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import zenoh

from fleet.wire.credentials import files
from fleet.wire.credentials.access import rules
from fleet.wire.credentials.roster import Role
from fleet.wire.credentials.trust import Trust
from fleet.wire.link import SECURE, LinkConfig, Topology

LARGEST_RECEIVED = 2 << 20  # the transport drops what is larger, before it takes memory
MOST_TOKENS = 512


def session_config(mode: str, link: LinkConfig, trust: Trust | None = None, station: Role = "boat") -> zenoh.Config:
    """A Zenoh configuration: no scouting, no shared memory, quick retries; with credentials both sides show them."""
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
    if trust is not None:
        config["transport"]["link"]["tls"] = _tls(trust.folder)
        config["transport"]["link"]["protocols"] = list(SECURE)
        config["access_control"] = rules(trust.roster, time.time(), station, link.topology)
    return zenoh.Config.from_json5(json.dumps(config))


def _tls(folder: Path) -> dict[str, Any]:
    """Certificates of both sides, for TLS and QUIC alike."""
    own = {"private_key": str(folder / files.OWN_KEY), "certificate": str(folder / files.OWN_CERTIFICATE)}
    return {
        "root_ca_certificate": str(folder / files.AUTHORITY_CERTIFICATE),
        "enable_mtls": True,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
        **{f"{side}_{what}": path for side in ("listen", "connect") for what, path in own.items()},
    }


def mode_of(topology: Topology) -> str:
    """The mode of a boat's session."""
    return {"hub": "client", "routed": "router", "mesh": "peer"}[topology]


def direct(callback: Callable[[Any], object]) -> Any:
    """A callback in Zenoh's own thread; it must only deposit."""
    return zenoh.handlers.Callback(callback, indirect=False)
