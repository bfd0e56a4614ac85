"""The case a command works on: from the library, a file or a saved run, with the values set on the
command line.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case

#: Options of the command line -> what they set in the table of every spring.
IN_EVERY_SPRING = {
    "--elements-per-coil": "options.finite-element.elements_per_coil", "--solid-elements-per-coil": "options.solid.elements_per_coil",
    "--solid-core": "options.solid.core", "--solid-rings": "options.solid.rings", "--solid-time-limit": "options.solid.time_limit",
}  # fmt: skip


def choose_case(
    name: str,
    settings: Sequence[str] | None = None,
    elements_per_coil: int | None = None,
    more: Mapping[str, Any] | None = None,
) -> Case:
    """Load the case ``name`` with ``settings`` (``key.path=value``), the mesh of
    ``--elements-per-coil`` and ``more`` options of
    :data:`IN_EVERY_SPRING` by their names.

    A saved run is called by its folder. Raises :class:`InputError`; an error in a value
    set here is placed at its option, not at a line of the file.
    """
    from valvetrain.parameters.loading import library_names, load_case
    from valvetrain.parameters.overrides import read_assignment
    from valvetrain.runs.saved_runs import run_of_path

    changes: dict[str, Any] = {}
    options: dict[str, str] = {}
    for text in settings or ():
        path, value = read_assignment(text, "--set")
        changes[path], options[path] = value, f"--set {path}"
    saved = None if not name.strip() or name in library_names() else run_of_path(Path(name))
    source = name if saved is None else saved.case_file
    try:
        given = {"--elements-per-coil": elements_per_coil, **(more or {})}
        for option, value in given.items():
            for path in _spring_paths(load_case(source).text) if value is not None else ():
                (
                    changes[f"{path}.{IN_EVERY_SPRING[option]}"],
                    options[f"{path}.{IN_EVERY_SPRING[option]}"],
                ) = value, option
        return load_case(source, changes)
    except InputError as error:
        raise _placed(error, options) from None


def _spring_paths(text: str) -> list[str]:
    """Key paths of every spring of a case file."""
    tree = tomllib.loads(text)
    places = {"spring": tree.get("spring", {})} if "train" not in tree else {}
    places |= {
        f"train.springs.{name}": springs
        for name, springs in tree.get("train", {}).get("springs", {}).items()
    }
    paths = []
    for path, springs in places.items():
        paths += (
            [f"{path}.{place}" for place in range(len(springs))]
            if isinstance(springs, list)
            else [path]
        )
    return paths


def folder_of(name: str) -> Path:
    """Folder that files named in the case are looked for in."""
    from valvetrain.parameters.loading import LIBRARY, library_names
    from valvetrain.runs.saved_runs import run_of_path

    if name in library_names():
        return LIBRARY
    saved = run_of_path(Path(name))
    return Path(name).parent if saved is None else saved.case_file.parent


def _placed(error: InputError, options: dict[str, str]) -> InputError:
    key = error.where.rpartition(", ")[2]
    for path, option in options.items():
        if key == path or key.startswith(f"{path}."):
            return InputError(error.reason, option)
    if options and key and any(path.startswith(f"{key}.") for path in options):
        return InputError(error.reason, f"{key} with {', '.join(dict.fromkeys(options.values()))}")
    return error
