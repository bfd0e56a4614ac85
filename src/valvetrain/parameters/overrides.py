"""The tree of a case file: its notes (status, source) taken out, and values changed from outside, written
as the file would hold them.
"""

from __future__ import annotations

import copy
import math
import re
import tomllib
from collections.abc import Mapping
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.case import STATUSES, Note
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.schema_types import MAX_LINE_LENGTH, text_problem
from valvetrain.units.text import clipped

#: Marks a value that is removed from the case.
REMOVED = object()
_SOURCE = "set from outside the case file"
_VALUE_KEYS = {"value", "status", "source", "comment"}
#: Tables in which these keys are data of their own.
_OWN_MEANING = ("published", "train.published")


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


_IN_OBJECT = re.compile(
    r"(?:springs\.0|(?P<train>train\.springs\.[^.]+\.\d+))(?:\.(?:wire|card))?\."
)


def file_key(key: str) -> str:
    """A key as case files have it; places in a list are ``[0]`` or ``.0``.

    >>> file_key("springs.0.wire.wire_diameter"), file_key("train.springs.nested[1].wire.pitch")
    ('spring.wire_diameter', 'train.springs.nested.1.pitch')
    """
    key = re.sub(r"\[(\d+)\]", r".\1", key)
    found = _IN_OBJECT.match(key)
    return key if found is None else f"{found['train'] or 'spring'}.{key[found.end() :]}"


def with_values(tree: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a case file's ``tree`` with the dotted paths in ``changes`` set; a changed value
    loses its note on status and source. Errors as :func:`set_value`.
    """
    changed: dict[str, Any] = copy.deepcopy(dict(tree))
    for path, value in changes.items():
        set_value(changed, path, value, _SOURCE)
    return changed


def set_value(tree: dict[str, Any], path: str, value: Any, source: str = "") -> None:
    """Set the ``value`` at a dotted path of a case file's ``tree`` in place, noted with its ``source``;
    :data:`REMOVED` removes it, a function makes the value of the bare one that is there.

    Raises :class:`InputError` for a path that leads through a plain value, past the end of a list, or,
    for a function, to nothing.
    """
    heads = file_key(path).split(".")
    last = heads.pop()
    published = "published" in heads  # what is published has notes of its own, of another form
    table: Any = tree
    for depth, head in enumerate(heads):
        key = _key(table, head, path, made=not callable(value))
        if isinstance(table, dict):
            table.setdefault(key, {})
        if not published and is_note(table[key]):
            table[key] = table[key]["value"]
        if depth == len(heads) - 1 and last.isdecimal() and (several := _several(table[key])):
            table[key] = several
        table = table[key]
        if not isinstance(table, (dict, list)):
            place = ".".join(heads[: depth + 1])
            raise InputError(
                f"'{place}' is the plain value {str(table)[:40]!r}, which has no '{last}'; set it as a whole",
                path,
            )
    key = _key(table, last, path, made=not callable(value))
    if value is REMOVED:
        if isinstance(table, dict) and key not in table:
            raise InputError(
                "is not in the case, so it cannot be removed; check the key path", path
            )
        del table[key]
        return
    if callable(value):
        value = value(split_notes({"": table[key]})[0][""])
    table[key] = value if published or not source else {"value": value, "source": source}


def _key(table: Any, key: str, path: str, made: bool) -> Any:
    """A key of a table, or place in a list; ``made``: whether a table that lacks it gets it."""
    if isinstance(table, list):
        if not key.isdecimal() or int(key) >= len(table):
            raise InputError(
                f"'{key[:20]}' is no place in a list of {len(table)}; name one by its number from 0, such as '0.{key[:20]}'",
                path,
            )
        return int(key)
    if not made and key not in table:
        raise InputError(f"the case has no '{key[:60]}' there; {nearest(key, tuple(table))}", path)
    return key


def _several(text: Any) -> list[Any]:
    """Numbers that a file holds as one text (``"0, 1.5 mm"``), one by one; empty for any other value."""
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


def split_notes(tree: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Note], dict[str, str]]:
    """Bare tree, notes by key path, and the reason of each bad note by key path.

    ``{ value = "4 mm", status = "published", source = "key" }`` becomes "4 mm" with a note;
    ``status`` and ``source`` in any other table are a note on the whole table.
    """
    notes: dict[str, Note] = {}
    bad: dict[str, str] = {}
    clean = {key: _walk(value, key, notes, bad) for key, value in tree.items()}
    return clean, notes, bad


def is_note(value: Any) -> bool:
    """Whether a value of a case file is one with a note: ``{ value = "4 mm", status = "measured" }``."""
    return isinstance(value, dict) and "value" in value and set(value) <= _VALUE_KEYS


def _walk(value: Any, path: str, notes: dict[str, Note], bad: dict[str, str]) -> Any:
    if path in _OWN_MEANING:
        return value
    if isinstance(value, list):
        return [_walk(item, f"{path}.{index}", notes, bad) for index, item in enumerate(value)]
    if not isinstance(value, dict):
        return value
    note = {key: value[key] for key in ("status", "source") if key in value}
    if note:
        status, source = note.get("status"), note.get("source", "")
        if not isinstance(source, str):
            bad[path] = "source must be text, such as the key of a reference"
        elif reason := text_problem(source, MAX_LINE_LENGTH):
            bad[path] = reason
        elif status in (None, *STATUSES):
            notes[path] = Note(status, source)
        else:
            shown = clipped(str(status), 30)
            bad[path] = f"status '{shown}' is unknown; {nearest(shown, STATUSES)}"
    if is_note(value):
        return _walk(value["value"], path, notes, bad)
    return {
        key: _walk(item, f"{path}.{key}", notes, bad)
        for key, item in value.items()
        if key not in note
    }
