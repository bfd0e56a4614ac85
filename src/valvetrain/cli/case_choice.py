"""The case a command works on: from the library or a file, with the values set on the command line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case


def choose_case(name: str, settings: Sequence[str] | None = None, elements_per_coil: int | None = None) -> Case:
    """Load the case ``name`` with ``settings`` (``key.path=value``) and the mesh of ``--elements-per-coil``.

    Raises :class:`InputError`; an error in a value set here is placed at its option, not at a line of the file.
    """
    from valvetrain.parameters.loading import load_case
    from valvetrain.parameters.overrides import read_assignment

    changes: dict[str, Any] = {}
    options: dict[str, str] = {}
    for text in settings or ():
        path, value = read_assignment(text, "--set")
        changes[path], options[path] = value, f"--set {path}"
    if elements_per_coil is not None:
        changes["rod.elements_per_coil"], options["rod.elements_per_coil"] = elements_per_coil, "--elements-per-coil"
    try:
        return load_case(name, changes)
    except InputError as error:
        raise _placed(error, options) from None


def _placed(error: InputError, options: dict[str, str]) -> InputError:
    key = error.where.rpartition(", ")[2]
    for path, option in options.items():
        if key == path or key.startswith(f"{path}."):
            return InputError(error.reason, option)
    if options and key and any(path.startswith(f"{key}.") for path in options):
        return InputError(error.reason, f"{key} with {', '.join(options.values())}")
    return error
