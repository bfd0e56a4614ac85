"""``valvetrain new`` writes a commented case file to begin with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from valvetrain.cli.options import JsonOption, QuietOption
from valvetrain.errors import InputError
from valvetrain.parameters.templates import KINDS, template_text


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("new")(new)


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the case; NAME.toml is written.")],
    kind: Annotated[
        str,
        typer.Option(
            "--kind", "--train", metavar="KIND", help=f"Kind of case: {', '.join(f'{word} ({told})' for word, told in KINDS.items())}."
        ),
    ] = "spring",
    as_json: JsonOption = False, quiet: QuietOption = False,
) -> None:  # fmt: skip
    """Write NAME.toml, a commented case with plausible values that runs as it stands."""
    from valvetrain.cli.outcome import Outcome, deliver

    path = write_template(name, kind)
    data = {"command": "new", "kind": kind, "files": [str(path)]}
    words = f"{path}: {KINDS[kind]}; put in your values, then run 'valvetrain run {path}'"
    deliver(Outcome(data, lambda console: console.print(words, soft_wrap=True)))


def write_template(name: str, kind: str) -> Path:
    """Write the template of ``kind`` (a word of :data:`KINDS`) to ``name`` with ``.toml`` behind; the path.

    Raises :class:`InputError` for an unknown kind, a name that no file may bear, or a file that is there.
    """
    from valvetrain.parameters.loading import library_names
    from valvetrain.solution.atomic import write_text

    text = template_text(kind)
    stem = name.removesuffix(".toml")
    if not stem.strip() or stem.endswith(("/", "..")) or not stem.isprintable() or len(Path(stem).name) > 80:
        raise InputError(f"'{name[:40]}' cannot be the name of a file; give such as my-spring", "NAME")
    if stem in library_names():
        raise InputError(f"'{stem}' is a case of the library; choose another name", "NAME")
    path = Path(f"{stem}.toml")
    try:
        taken = path.exists() or path.is_symlink()
    except OSError as error:
        raise InputError(f"'{name[:40]}' cannot be the name of a file ({error.strerror}); give such as my-spring", "NAME") from None
    if taken:
        raise InputError(f"the file '{path}' is there already; choose another name or remove it", "NAME")
    return write_text(path, text.replace("NAME.toml", str(path)))
