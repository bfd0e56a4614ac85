"""Finds the line of a key path in the text of a TOML file, for messages that point at it."""

from __future__ import annotations

import re
from collections import Counter

_KEY_PART = r"""(?:"[^"\n]*"|'[^'\n]*'|[A-Za-z0-9_-]+)"""
_KEY = rf"{_KEY_PART}(?:\s*\.\s*{_KEY_PART})*"
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_KEY})\s*\]\]?\s*(?:#.*)?$")
_ASSIGNMENT = re.compile(rf"\s*({_KEY})\s*=(.*)$")
_STRING = re.compile(r'"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'')


def key_lines(text: str) -> dict[tuple[str, ...], int]:
    """Line number (from 1) of each table header and key; list positions are parts such as "0". Keys of inline tables share their line."""
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
    return next((lines[keys[:length]] for length in range(len(keys), 0, -1) if keys[:length] in lines), None)


def _parts(key: str) -> tuple[str, ...]:
    return tuple(part.strip("\"'") for part in re.findall(_KEY_PART, key))


def _indexed(parts: tuple[str, ...], counts: Counter[tuple[str, ...]], is_array: bool) -> tuple[str, ...]:
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
            fence = min(('"""', "'''"), key=lambda mark: line.find(mark) if mark in line else len(line))
            line = line.partition(fence)[2]
    bare = _STRING.sub("", line).split("#")[0]
    return max(depth, 0) + bare.count("[") + bare.count("{") - bare.count("]") - bare.count("}"), ""
