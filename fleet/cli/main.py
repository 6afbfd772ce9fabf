"""`fleet`: the program. Nothing here or in the modules it imports may import more than Typer."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from fleet import __version__
from fleet.cli import (
    credentials,
    doctor,
    drive,
    export,
    gcs,
    hub,
    mission,
    orders,
    run,
    sail,
    say,
    station,
    status,
    sweep,
    words,
)
from fleet.errors import FleetError

TRACE = "FLEET_TRACE"
INTERRUPTED = 130

app = typer.Typer(
    name="fleet",
    no_args_is_help=True,
    rich_markup_mode=None,  # rich's help costs as much again as all of Typer
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)


def _version(wanted: bool) -> None:
    if wanted:
        say.out(f"fleet {__version__}")
        raise typer.Exit


@app.callback()
def fleet(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Sail a fleet of unmanned surface vehicles: simulate, command, look back.

    Exit codes: 0 done; 1 error, or a check that does not hold; 2 wrong input; 3 some boats did not acknowledge; 4 no
    boat in reach; 5 refused by a safety check; 130 interrupted.
    """


sail.add_to(app)
orders.add_to(app)
words.add_to(app)
status.add_to(app)
station.add_to(app)
hub.add_to(app)
drive.add_to(app)
gcs.add_to(app)
app.add_typer(mission.app, name="mission")
app.add_typer(credentials.app, name="credentials")
app.add_typer(doctor.app, name="doctor")
app.add_typer(export.app, name="export")
app.add_typer(run.app, name="run")
app.add_typer(sweep.app, name="sweep")


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command line; the exit code. No traceback reaches the user unless FLEET_TRACE is set."""
    try:
        app(args=None if argv is None else list(argv), prog_name="fleet")
    except SystemExit as end:
        return _flushed(end.code if isinstance(end.code, int) else int(bool(end.code)))
    except FleetError as error:
        if os.environ.get(TRACE):
            raise
        say.error(str(error))
        return _flushed(error.exit_code)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        return _quiet(1)
    except Exception as error:  # the last line of defence
        if os.environ.get(TRACE):
            raise
        words = " ".join(f"{type(error).__name__}: {error}".split())
        say.error(f"a bug in fleet {__version__}: {words}; {TRACE}=1 shows where")
        return _flushed(1)
    return _flushed(0)


def _flushed(code: int) -> int:
    """The code, once all that was printed is out; quiet when nobody reads it any more."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        return _quiet(code or 1)
    return code


def _quiet(code: int) -> int:
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code


if __name__ == "__main__":
    sys.exit(main())
