"""Writes the tree of a case file as TOML text."""

from __future__ import annotations

import datetime
import json
import re
from collections import Counter
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


_KEY_PART = r"""(?:"[^"\n]*"|'[^'\n]*'|[A-Za-z0-9_-]+)"""
_KEY = rf"{_KEY_PART}(?:\s*\.\s*{_KEY_PART})*"
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_KEY})\s*\]\]?\s*(?:#.*)?$")
_ASSIGNMENT = re.compile(rf"\s*({_KEY})\s*=(.*)$")
_STRING = re.compile(r'"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'')


def key_lines(text: str) -> dict[tuple[str, ...], int]:
    """Line number (from 1) of each table header and key; list positions are parts such as "0". Keys
    of inline tables share their line.
    """
    lines: dict[tuple[str, ...], int] = {}
    counts: Counter[tuple[str, ...]] = Counter()
    table: tuple[str, ...] = ()
    depth, fence = 0, ""
    for number, line in enumerate(text.splitlines(), start=1):
        if not fence and depth <= 0:
            header, assignment = _HEADER.match(line), _ASSIGNMENT.match(line)
            if header:
                table = _indexed(_parts(header[2]), counts, header[1] == "[[")
                lines.setdefault(table, number)
                continue
            if assignment:
                path = (*table, *_parts(assignment[1]))
                for length in range(len(table) + 1, len(path) + 1):
                    lines.setdefault(path[:length], number)
                line = assignment[2]
                for inner in re.finditer(rf"[{{,]\s*({_KEY_PART})\s*=", line):
                    lines.setdefault((*path, *_parts(inner[1])), number)
                depth = 0
        depth, fence = _nesting(line, depth, fence)
    return lines


def find_line(text: str, path: tuple[str | int, ...]) -> int | None:
    """Line of ``path``, or of the nearest table that holds it."""
    lines = key_lines(text)
    keys = tuple(str(part) for part in path)
    return next(
        (lines[keys[:length]] for length in range(len(keys), 0, -1) if keys[:length] in lines), None
    )


def _parts(key: str) -> tuple[str, ...]:
    return tuple(part.strip("\"'") for part in re.findall(_KEY_PART, key))


def _indexed(
    parts: tuple[str, ...], counts: Counter[tuple[str, ...]], is_array: bool
) -> tuple[str, ...]:
    path: tuple[str, ...] = ()
    for position, part in enumerate(parts):
        path = (*path, part)
        if is_array and position == len(parts) - 1:
            counts[path] += 1
        if counts[path]:
            path = (*path, str(counts[path] - 1))
    return path


def _nesting(line: str, depth: int, fence: str) -> tuple[int, str]:
    """Bracket depth and open multi-line string after ``line``."""
    while fence or '"""' in line or "'''" in line:
        if fence:
            _, found, line = line.partition(fence)
            if not found:
                return depth, fence
            fence = ""
        else:
            fence = min(
                ('"""', "'''"), key=lambda mark: line.find(mark) if mark in line else len(line)
            )
            line = line.partition(fence)[2]
    bare = _STRING.sub("", line).split("#")[0]
    return max(depth, 0) + bare.count("[") + bare.count("{") - bare.count("]") - bare.count("}"), ""
