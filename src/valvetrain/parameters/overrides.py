"""Values of a case changed from outside its file, written as the file would hold them."""

from __future__ import annotations

import copy
import math
import tomllib
from collections.abc import Mapping
from typing import Any

from valvetrain.errors import InputError
from valvetrain.units.text import clipped

#: Marks a value that is removed from the case.
REMOVED = object()
_SOURCE = "set from outside the case file"


def read_assignment(text: str, where: str = "") -> tuple[str, Any]:
    """Key path and value of ``"spring.wire_diameter=4.1 mm"``.

    The value is read as TOML where it is TOML (``24``, ``true``, ``[0, 4, 7]``), else as text
    (``4.1 mm``); nothing after the sign removes the key. Raises :class:`InputError` without a path
    or an equals sign.
    """
    if any(
        "\ud800" <= char <= "\udfff" for char in text
    ):  # bytes of the command line that are not UTF-8
        raise InputError(
            f"'{clipped(text)}' is not UTF-8, which a case file is; write it otherwise, or rename the file",
            where,
        )
    path, sign, value = text.partition("=")
    path = path.strip()
    if not sign or not path or not all(part.strip() for part in path.split(".")):
        raise InputError(
            f"'{text[:60]}' sets nothing; write a key path, '=' and a value, as in 'spring.wire_diameter=4.1 mm'",
            where,
        )
    return ".".join(part.strip() for part in path.split(".")), _read_value(value.strip())


def _read_value(text: str) -> Any:
    if not text:
        return REMOVED
    try:
        tree = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return tree["value"] if set(tree) == {"value"} else text


def with_values(tree: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a case file's ``tree`` with the dotted paths in ``changes`` set; a changed value
    loses its note on status and source.

    Raises :class:`InputError` for a path that leads through a plain value or past the end of a
    list.
    """
    changed: dict[str, Any] = copy.deepcopy(dict(tree))
    for path, value in changes.items():
        _set(changed, path, value)
    return changed


def _set(tree: dict[str, Any], path: str, value: Any) -> None:
    *heads, last = path.split(".")
    table: Any = tree
    for depth, head in enumerate(heads):
        key: Any = _place(table, head, path) if isinstance(table, list) else head
        if isinstance(table, dict):
            table.setdefault(head, {})
        if depth == len(heads) - 1 and last.isdecimal() and (several := _several(table[key])):
            table[key] = several
        table = table[key]
        if not isinstance(table, (dict, list)):
            place = ".".join(heads[: depth + 1])
            raise InputError(
                f"'{place}' is the plain value {str(table)[:40]!r}, which has no '{last}'; set it as a whole",
                path,
            )
    key = _place(table, last, path) if isinstance(table, list) else last
    if value is REMOVED:
        if isinstance(table, dict) and key not in table:
            raise InputError(
                "is not in the case, so it cannot be removed; check the key path", path
            )
        del table[key]
    else:
        # What is published has notes of its own, of another form.
        table[key] = value if "published" in heads else {"value": value, "source": _SOURCE}


def _several(found: Any) -> list[Any]:
    """Numbers that a file holds as one text (``"0, 1.5 mm"``), one by one; empty for any other value."""
    text = found.get("value") if isinstance(found, dict) else found
    if not isinstance(text, str) or "," not in text:
        return []
    unit = text.rpartition(",")[2].lstrip(" +-0123456789.eE").strip()
    numbers = [part.strip().removesuffix(unit).strip() for part in text.split(",")]
    try:
        return [
            f"{one} {unit}" if unit else float(one) for one in numbers if math.isfinite(float(one))
        ]
    except ValueError:
        return []


def _place(table: list[Any], key: str, path: str) -> int:
    if not key.isdecimal() or int(key) >= len(table):
        raise InputError(
            f"'{key}' is no place in a list of {len(table)}; name one by its number from 0, such as '0.{key}'",
            path,
        )
    return int(key)
