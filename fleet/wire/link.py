"""How a station reaches the others, and whether it may do so without credentials."""

from __future__ import annotations

import ipaddress
import re
from typing import Literal

import msgspec

from fleet.errors import ConfigError

Topology = Literal["hub", "routed", "mesh"]
SECURE = ("tls", "quic")
"""Transports that show and check certificates."""
_ENDPOINT = re.compile(r"(?P<kind>[a-z-]+)/(?P<host>\[[^]]*\]|[^:/?#\[\]]*)(:\d+)?([?#].*)?")


class LinkConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a station reaches the others."""

    topology: Topology = "routed"
    connect: tuple[str, ...] = ()  # endpoints such as tls/10.0.0.5:7447
    listen: tuple[str, ...] = ()  # where this station listens; loopback unless it says otherwise
    lease_ms: int = 2000
    keep_alive: int = 8
    credentials: str = ""  # folder of this station's own, made by `fleet credentials`; only tls and quic then
    insecure: bool = False  # meant: beyond loopback, with nothing signed and nothing encrypted


def on_loopback(endpoint: str) -> bool:
    """Whether an endpoint does not leave this machine."""
    match = _ENDPOINT.fullmatch(endpoint)
    if endpoint.startswith("unixsock-stream/"):
        return True
    if match is None or match["kind"] == "serial":
        return False
    host = match["host"].strip("[]")
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def abroad(link: LinkConfig) -> tuple[str, ...]:
    """Endpoints that leave this machine."""
    return tuple(one for one in (*link.listen, *link.connect) if not on_loopback(one))


def check_link(link: LinkConfig, *, listen: str = "link.listen", connect: str = "link.connect") -> None:
    """ConfigError where a link would be open to strangers without a word that says it is meant.

    Args:
        link: what is asked for
        listen: what the user calls the places to listen at, such as `--listen`
        connect: what the user calls the places to connect to
    """
    if link.credentials and link.insecure:
        raise ConfigError("link.credentials and link.insecure = true contradict each other: expected one of them")
    for name, endpoints in ((listen, link.listen), (connect, link.connect)):
        for one in endpoints:
            kind = one.partition("/")[0]
            if link.credentials and kind not in SECURE:
                raise ConfigError(f"{name} {one!r} with credentials: expected tls/HOST:PORT or quic/HOST:PORT")
            if not link.credentials and kind in SECURE:
                raise ConfigError(
                    f"{name} {one!r} needs credentials: expected link.credentials, or --credentials FOLDER"
                )
            if not link.credentials and not link.insecure and not on_loopback(one):
                raise ConfigError(
                    f"{name} {one!r} leaves this machine without credentials, and whoever reaches it could command the "
                    "boats: expected a folder made by `fleet credentials` (link.credentials, --credentials), or the "
                    "word that this is meant (link.insecure = true, --insecure)"
                )


def warning(link: LinkConfig) -> str:
    """What is to be said at every start of a station that is open to strangers; '' for others."""
    open_to = abroad(link)
    if link.credentials or not open_to:
        return ""
    where = ", ".join(open_to)
    return f"INSECURE: {where} with nothing signed and nothing encrypted; whoever reaches it commands the boats"
