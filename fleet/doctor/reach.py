"""Is the hub there, are the other boats, and do they take us?"""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Callable, Iterator

from msgspec import structs

from fleet.agent.config import AgentConfig
from fleet.doctor.finding import Finding, fail, ok, warn
from fleet.errors import ConfigError
from fleet.wire.bus import Bus
from fleet.wire.link import LinkConfig, warning

STREAMS = ("tcp", "tls", "ws")  # that a plain connection can try
LOOK_S = 0.02
Opens = Callable[[LinkConfig], Bus]


def links(config: AgentConfig, patience_s: float, opens: Opens | None = None) -> Iterator[Finding]:
    """Every place to connect to; a hub must be there, other boats may be switched off.

    Args:
        config: the boat's
        patience_s: for each place
        opens: a bus that connects with a link, not yet open; Zenoh when None
    """
    link = config.link
    if warning(link):
        yield warn("link", warning(link), "fleet credentials, and name the folder as link.credentials")
    if not link.connect:
        yield ok("link", f"others connect to us at {', '.join(link.listen)}")
    opens = opens or (lambda one: _zenoh(config, one))
    for endpoint in link.connect:
        wrong = _connection(endpoint, patience_s) or _session(link, endpoint, patience_s, opens)
        if not wrong:
            yield ok("link", f"{endpoint}: connected, and taken")
        elif link.topology == "hub":
            yield fail("link", f"{endpoint}: {wrong[0]}", wrong[1])
        else:
            yield warn("link", f"{endpoint}: {wrong[0]}", f"is that boat switched on? {wrong[1]}")


def _zenoh(config: AgentConfig, link: LinkConfig) -> Bus:
    from fleet.wire.credentials.trust import load
    from fleet.wire.zenoh_bus import ZenohBus

    trust = load(link.credentials, config.fleet, "boat", config.boat) if link.credentials else None
    return ZenohBus(config.fleet, config.boat, link, time.time_ns, trust)


def _connection(endpoint: str, patience_s: float) -> tuple[str, str] | None:
    """What is wrong with a plain connection, and what to do; None: nothing, or it cannot be tried."""
    kind, _, rest = endpoint.partition("/")
    if kind not in STREAMS:
        return None
    host, _, port = rest.split("?")[0].split("#")[0].rpartition(":")
    try:
        with socket.create_connection((host.strip("[]"), int(port)), timeout=patience_s):
            return None
    except socket.gaierror:
        return f"no address for the name {host}", "a number instead of a name needs no server of names"
    except ConnectionRefusedError:
        return "nobody listens there", "start it: systemctl status fleet-hub; is the port right?"
    except TimeoutError:
        return f"no answer within {patience_s:g} s", "is it on? a firewall? ping it"
    except OSError as error:
        return error.strerror or str(error), "ip route: is there a way to it?"


class _Heard(logging.Handler):
    """Keeps what the wire says about why it does not connect."""

    def __init__(self) -> None:
        super().__init__()
        self.text = ""

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the last."""
        self.text = record.getMessage()


def _session(link: LinkConfig, endpoint: str, patience_s: float, opens: Opens) -> tuple[str, str] | None:
    """What is wrong with a session over a connection that can be made."""
    heard, log = _Heard(), logging.getLogger("fleet.wire")
    log.addHandler(heard)
    was, log.propagate = log.propagate, False
    try:
        bus = opens(structs.replace(link, topology="hub", connect=(endpoint,), listen=()))
    except ConfigError:
        return "not tried: the credentials are not good", "see credentials"
    try:
        deadline = time.monotonic() + patience_s
        while not bus.open():
            if time.monotonic() > deadline:
                why = heard.text.rpartition("trying on: ")[2].strip(" !")
                return f"no session within {patience_s:g} s{': ' + why if why else ''}", _advice(link)
            time.sleep(LOOK_S)
    finally:
        bus.close()
        log.removeHandler(heard)
        log.propagate = was
    return None


def _advice(link: LinkConfig) -> str:
    if link.credentials:
        return "fleet credentials show: same authority on both sides, not expired, not revoked? are both clocks right?"
    return "is it a fleet hub or agent that listens there, and without credentials?"
