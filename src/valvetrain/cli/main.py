"""The command line ``valvetrain``: a thin interface to studies and report."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from functools import cache
from typing import Annotated

import typer

from valvetrain.cli.guard import GuardedGroup
from valvetrain.errors import InputError
from valvetrain.registry import find, places


def _start(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """Dynamics of valve springs and valvetrains, from the static curve to coil clash."""
    if version:
        from valvetrain import __version__

        typer.echo(f"valvetrain {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def app_of(chosen: Sequence[str]) -> typer.Typer:
    """The command line with these commands; one that an installed package brings and that cannot be
    loaded is left out with a sentence.
    """
    made = typer.Typer(
        cls=GuardedGroup,
        name="valvetrain",
        pretty_exceptions_enable=False,
        invoke_without_command=True,
        context_settings={"help_option_names": ["-h", "--help"]},
        help="Dynamics of valve springs and valvetrains, from the static curve to coil clash.",
        epilog="Exit codes: 0 done, 1 a run or a part of its answer failed, 2 wrong input, 130 interrupted (143 by SIGTERM).",
    )
    made.callback()(_start)
    for word in chosen:
        try:
            find("commands", word)(made)
        except InputError as error:
            sys.stderr.write(f"note: {error}\n")
    return made


@cache
def _whole() -> typer.Typer:
    return app_of(tuple(places("commands")))


def __getattr__(name: str) -> typer.Typer:
    """``app``: the command line with all commands, made when it is first requested."""
    if name == "app":
        return _whole()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def main() -> None:
    """Load the requested command alone, and run it."""
    # Runs are parallel over cases; linear algebra on matrices of this size only loses to threads of
    # its own (2.2 s instead of 1.5).
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    requested = sys.argv[1:2]
    # one command needs none of the others, whose modules and options take a tenth of a second;
    # completion needs all
    alone = (
        bool(requested)
        and requested[0] in places("commands")
        and "_VALVETRAIN_COMPLETE" not in os.environ
    )
    gc.disable()  # what modules and options make stays to the end: to look through it again takes a sixth of the start
    app = app_of(requested) if alone else _whole()
    gc.freeze()
    gc.enable()
    app(prog_name="valvetrain")
