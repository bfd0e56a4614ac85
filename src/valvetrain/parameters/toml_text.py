"""Writes the tree of a case file as TOML text."""

from __future__ import annotations

import datetime
import json
import re
import tomllib
from bisect import bisect_left
from collections.abc import Mapping
from typing import Any

from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.units import PlainInteger, PlainNumber


def toml_text(tree: Mapping[str, Any], path: tuple[str, ...] = ()) -> str:
    """``tree`` (as ``tomllib`` reads it) as TOML: plain values first, then its tables under
    headers; reading it gives ``tree`` again.
    """
    lines, tables = [], []
    for key, value in tree.items():
        if isinstance(value, Mapping) and "value" not in value:
            tables.append(f"\n[{_dotted((*path, key))}]\n{toml_text(value, (*path, key))}")
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            tables += [
                f"\n[[{_dotted((*path, key))}]]\n{toml_text(item, (*path, key))}" for item in value
            ]
        else:
            lines.append(f"{_key(key)} = {_value(value)}\n")
    return "".join([*lines, *tables])


def resolved(tree: Mapping[str, Any], lift_law: LiftLawParameters | None) -> dict[str, Any]:
    """``tree`` with the lift table of ``lift_law`` in place of the file that it was read from
    (None: as it is).
    """
    if lift_law is None:
        return dict(tree)
    unchanged = {
        key: value
        for key, value in tree["lift_law"].items()
        if key in ("lift_of", "zero_of_angle", "status", "source")
    }
    units = {"cam_angles": "rad"}
    table: dict[str, Any] = {"kind": lift_law.kind, "lift_of": lift_law.lift_of}
    for name, value in lift_law.values.items():
        unit = units.get(name, "m")
        if isinstance(value, tuple):
            table[name] = [f"{item!r} {unit}" for item in value]
        else:
            table[name] = value if isinstance(value, int) else f"{value!r} {unit}"
    if lift_law.zero_of_angle:
        table["zero_of_angle"] = lift_law.zero_of_angle
    return {**tree, "lift_law": unchanged | table}


def inline(value: Any) -> str:
    """One value as TOML writes it on a line: ``{ formula = "beehive", lower = "26 mm" }``.

    >>> inline([0, 4, 7])
    '[0, 4, 7]'
    """
    return _value(value)


def _dotted(path: tuple[str, ...]) -> str:
    return ".".join(map(_key, path))


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _value(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Mapping):
        return (
            f"{{ {', '.join(f'{_key(key)} = {_value(item)}' for key, item in value.items())} }}"
            if value
            else "{}"
        )
    if isinstance(value, (datetime.date, datetime.time)):
        return value.isoformat()
    if isinstance(value, (PlainNumber, PlainInteger)) and value.unit:
        return json.dumps(f"{float(value)!r} {value.unit}")
    return repr(value.item() if hasattr(value, "item") else value)


#: Beginning of a line that may be the first of a statement: a header, or a key and a sign.
_STATEMENT = re.compile(r"^[ \t]*(?:\[|[^\s#,\[\]{}][^\n=#,]*=)", re.MULTILINE)


def find_line(text: str, path: tuple[str | int, ...]) -> int | None:
    """Line of the statement that writes the value at ``path``, or of the nearest table that holds it.

    It is the statement with which the value first appears in what ``tomllib`` reads from the beginning
    of the text, so every way to write TOML is understood.
    """
    starts = [found.start() for found in _STATEMENT.finditer(text)]
    ends = [0, *starts[1:], len(text)]
    trees: dict[int, Any] = {0: {}}

    def complete(count: int) -> int:
        """How many of the first ``count`` statements are TOML by themselves: the last may end inside a value."""
        while count not in trees:
            try:
                trees[count] = tomllib.loads(text[: ends[count]])
            except ValueError:
                count -= 1
        return count

    def holds(count: int) -> bool:
        item = trees[complete(count)]
        for key in path:
            try:
                item = item[int(key)] if isinstance(item, list) else item[key]
            except (LookupError, TypeError, ValueError):
                return False
        return True

    while path and not holds(len(starts)):
        path = path[:-1]
    if not path:
        return None
    first = bisect_left(range(len(starts) + 1), True, key=holds)
    return text.count("\n", 0, starts[complete(first - 1)]) + 1
