"""The parser of all commands is built once for all tests of a process: typer's runner builds it for
every call, which takes 30 ms.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import typer.main
import typer.testing

from valvetrain.cli.main import app


@cache
def parser() -> Any:
    """The command line of the package with all commands."""
    return typer.main.get_command(app)


def command_of(requested: typer.Typer) -> Any:
    """``typer.main.get_command``, without building the whole command line again."""
    return parser() if requested is app else typer.main.get_command(requested)


if hasattr(typer.testing, "_get_command"):  # else each call builds its own, as typer does
    typer.testing._get_command = command_of
