"""Writes values into a case file in place, keeping comments and order; the file is replaced whole
or not at all.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_case
from valvetrain.solution.atomic import write_text


def write_case_values(path: str | os.PathLike[str], changes: Mapping[str, Any]) -> None:
    """Set the values at the dotted key paths in ``changes`` in the TOML file ``path``.

    Values are written as a case file holds them ("3.9 mm", 0.75, "22, 22, 17 mm"). Where the file
    has ``{ value = ..., status = ... }`` the value inside is replaced; list positions are numbers
    (``published.0.role``). Only existing keys are set, and the result must still be a valid case.
    Raises :class:`InputError` and leaves the file untouched otherwise.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    target = Path(path)
    try:
        document = tomlkit.parse(target.read_bytes().decode("utf-8"))
    except (OSError, UnicodeDecodeError, TOMLKitError) as error:
        raise InputError(
            "the case file cannot be read as TOML; check the path and run 'valvetrain check' on it",
            target.name,
        ) from error
    for key_path, value in changes.items():
        _set(document, key_path, _plain(value), target.name)
    text = tomlkit.dumps(document)
    parse_case(text, target.stem, target.parent, target.name)
    write_text(target, text)


def _set(document: Any, key_path: str, value: Any, where: str) -> None:
    *heads, last = key_path.split(".")
    table = document
    for head in heads:
        table = _child(table, head, key_path, where)
    current = _child(table, last, key_path, where)
    if isinstance(current, dict) and "value" in current and not isinstance(value, Mapping):
        current["value"] = value
    else:
        table[int(last) if isinstance(table, list) else last] = value


def _plain(value: Any) -> Any:
    """Numbers and sequences of other libraries as the plain ones TOML knows."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    return [_plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def _child(table: Any, key: str, key_path: str, where: str) -> Any:
    try:
        return table[int(key) if isinstance(table, list) else key]
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise InputError(
            f"there is no '{key}' on the way to '{key_path}'; give the path of an existing value",
            where,
        ) from error
