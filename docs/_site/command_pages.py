"""The page of the command line: every command with its arguments and options, read from the program itself."""

from __future__ import annotations

from pathlib import Path

import typer
from generated import heading, write_changed

from valvetrain.cli.main import app as program

INTRODUCTION = """One section per command. ``valvetrain COMMAND --help`` prints the same. ``CASE`` is a case that ships, a case file or
the folder of a kept run. Exit codes: 0 done, 1 a run or a part of its answer failed, 2 wrong input, 130 interrupted (143 by SIGTERM).

"""


def literal(text: str) -> str:
    """A text of the program inside reStructuredText, none of its signs taken for markup."""
    return "".join(f"\\{sign}" if sign in "*`|_\\" else sign for sign in text)


def rows(command) -> str:
    """Arguments, then options, a row each."""
    found = []
    for one in command.params:
        if one.name == "help":
            continue
        if one.param_type_name == "argument":
            word = one.metavar or one.name.upper()
        else:
            word = ", ".join(one.opts) + (
                "" if one.is_flag else f" {one.metavar or one.type.name.upper()}"
            )
        found.append(
            f"   * - ``{word}``\n     - {literal(' '.join((getattr(one, 'help', '') or '').split()))}\n"
        )
    return (
        ".. list-table::\n   :widths: 30 70\n   :class: options\n\n" + "".join(found) + "\n"
        if found
        else ""
    )


def page() -> str:
    """The text of the page."""
    group = typer.main.get_command(program)
    text = heading("Command line", "=") + INTRODUCTION
    for name, command in group.commands.items():
        text += (
            heading(f"valvetrain {name}", "-")
            + literal(" ".join((command.help or "").split()))
            + "\n\n"
            + rows(command)
        )
    return text


def write(app) -> None:
    """Write the page before the sources are read."""
    write_changed(Path(app.srcdir) / "commands.rst", page())


def setup(app):
    """Write the page of a build."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
