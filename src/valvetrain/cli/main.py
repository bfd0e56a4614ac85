"""The command line ``valvetrain``: a thin interface to studies and report."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from valvetrain.cli.guard import GuardedGroup
from valvetrain.errors import InputError
from valvetrain.registry import find, words

app = typer.Typer(
    cls=GuardedGroup, name="valvetrain", pretty_exceptions_enable=False, invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Dynamics of valve springs and valvetrains, from the static curve to coil clash.",
    epilog="Exit codes: 0 done, 1 a run or a part of its answer failed, 2 wrong input, 130 interrupted (143 by SIGTERM).",
)  # fmt: skip


def _version(wanted: bool) -> None:
    if wanted:
        from valvetrain import __version__

        typer.echo(f"valvetrain {__version__}")
        raise typer.Exit


@app.callback()
def start(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")] = False,
) -> None:
    """Dynamics of valve springs and valvetrains, from the static curve to coil clash."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def _register_all() -> None:
    """Add every registered command; one that an installed package brings and that cannot be loaded is left out with a sentence."""
    for word in words("commands"):
        try:
            find("commands", word)(app)
        except InputError as error:
            sys.stderr.write(f"note: {error}\n")


_register_all()


def main() -> None:
    """The console script."""
    # Runs are parallel over cases; linear algebra on matrices of this size only loses to threads of its own (2.2 s instead of 1.5).
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app(prog_name="valvetrain")
