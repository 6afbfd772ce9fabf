"""`fleet hub`: the process of a harbour."""

from __future__ import annotations

from typing import Annotated

import typer

from fleet.cli import say
from fleet.cli.ending import Ending
from fleet.cli.options import DEFAULT_ENDPOINT, DEFAULT_SECURE, Credentials, Insecure, Json, endpoints
from fleet.errors import FleetError, UsageError


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command("hub")(hub)


def hub(
    listen: Annotated[
        list[str] | None,
        typer.Option(
            envvar="FLEET_LISTEN",
            metavar="ENDPOINT",
            help=f"Where to listen, several with commas.  [default: {DEFAULT_ENDPOINT}, with credentials tls/...]",
        ),
    ] = None,
    credentials: Credentials = None,
    insecure: Insecure = False,
    json: Json = False,
) -> None:
    """Be the hub that boats and operators connect to.

    Until SIGTERM or Ctrl-C; on loopback unless told otherwise. Beyond loopback with credentials, or with the word that
    it is meant without.
    """
    where = endpoints(listen, "--listen") or ((DEFAULT_SECURE,) if credentials else (DEFAULT_ENDPOINT,))
    from fleet.agent.journal import set_up
    from fleet.agent.notify import Notifier
    from fleet.wire.credentials.trust import load
    from fleet.wire.link import LinkConfig, check_link, warning

    link = LinkConfig(topology="hub", listen=where, credentials=credentials or "", insecure=insecure)
    check_link(link, listen="--listen")
    for one in where:
        _probe(one)
    trust = load(credentials, "", "hub") if credentials else None
    set_up("hub")
    for words in (warning(link), trust.warning() if trust is not None else ""):
        if words:
            say.note(words)
    from fleet.wire.zenoh_hub import run_hub
    from fleet.wire.zenoh_log import capture

    if trust is not None:
        capture()
    ending = Ending()
    manager = Notifier()

    def ready() -> None:
        if json:
            say.out_json({"listen": list(where)}, indent=None)
        else:
            say.out(f"hub listens at {', '.join(where)}; Ctrl-C ends it")

    run_hub(link, ending.told, ready, trust, lambda: manager.whole_tick(True, warning(link) or "listens"))
    manager.ends()
    raise typer.Exit(ending.exit_code)


def _probe(endpoint: str) -> None:
    """A port in use, or an address that is not ours, said in words before Zenoh says it in its own."""
    import socket

    kind, _, rest = endpoint.partition("/")
    if kind not in ("tcp", "tls", "ws"):
        return
    host, _, port = rest.split("?")[0].split("#")[0].rpartition(":")
    host = host.strip("[]")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, int(port)))
    except socket.gaierror as error:
        raise UsageError(f"--listen {endpoint}: {error.strerror}") from None
    except OSError as error:
        raise FleetError(f"cannot listen at {endpoint}: {error.strerror}") from None
