"""Vertices of a PLY file, text or binary of either byte order."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.spring_scan.text_points import line_blocks, numbers_in

Array = NDArray[np.float64]
#: Longest head of a file (bytes), most properties of a point, and points taken at a time.
LONGEST_HEAD, MOST_PROPERTIES, AT_A_TIME = 65_536, 100, 200_000
_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class _Head:
    order: str
    count: int
    properties: tuple[tuple[str, str], ...]
    length: int
    unit: str


def ply_points(path: Path, name: str, size: int) -> tuple[str, Iterator[Array]]:
    """Unit that the head tells, and blocks (n, 3). Raises :class:`InputError` for a head that does not fit the file of ``size`` bytes."""
    with path.open("rb") as stream:
        head = _head(stream.read(LONGEST_HEAD), name)
    words = [word for word, _ in head.properties]
    if any(axis not in words for axis in "xyz"):
        raise InputError(f"the points of '{name}' have no x, y and z; export the scan again")
    if head.count < 1:
        raise InputError(f"'{name}' holds no point; export the scan again")
    if not head.order:
        if 2 * len(words) * head.count > size - head.length + 1:
            raise InputError(_short(name, head.count, size))
        return head.unit, _text(path, name, head, [words.index(axis) for axis in "xyz"])
    row = np.dtype([(f"p{k}", head.order + kind) for k, (_, kind) in enumerate(head.properties)])
    if head.length + row.itemsize * head.count > size:
        raise InputError(_short(name, head.count, size))
    return head.unit, _binary(path, head, row, [f"p{words.index(axis)}" for axis in "xyz"])


def _short(name: str, count: int, size: int) -> str:
    return f"'{name}' is cut off: its header states {count} points, more than its {size} bytes can hold; export it again"


def _head(content: bytes, name: str) -> _Head:
    end = re.search(rb"(?m)^end_header[ \t]*\r?\n", content)
    if end is None:
        raise InputError(f"'{name}' begins as PLY, but its head has no end; export it again")
    lines = content[: end.start()].decode("ascii", "replace").split("\n")
    order, count, unit, here = None, -1, "", ""
    properties: list[tuple[str, str]] = []
    for line in (one.split() for one in lines[1:]):
        match line:
            case ["format", form, *_] if form in _FORMATS:
                order = _FORMATS[form]
            case ["comment" | "obj_info", *words]:
                found = re.search(r"\bunits?\W+(mm|cm|m|inch|in|um|millimet\w+|met\w+)\b", " ".join(words), re.I)
                unit = _unit(found[1]) if found else unit
            case ["element", "vertex", number] if re.fullmatch(r"\d{1,15}", number) and count < 0:
                here, count = "vertex", int(number)
            case ["element", word, *_]:
                if count < 0:
                    raise InputError(f"'{name}' holds '{word[:20]}' before its points; export the points first")
                here = word
            case ["property", kind, word] if here == "vertex" and kind in _TYPES and len(properties) < MOST_PROPERTIES:
                properties.append((word, _TYPES[kind]))
            case ["property", *_] if here == "vertex":
                raise InputError(f"a property of the points of '{name}' is none that PLY has for points: '{' '.join(line)[:40]}'")
    if order is None or count < 0:
        raise InputError(f"the head of '{name}' has no format or no points (element vertex); export it again")
    return _Head(order, count, tuple(properties), end.end(), unit)


def _unit(word: str) -> str:
    word = word.lower()
    return "inch" if word == "in" else "mm" if word.startswith("milli") else "m" if word.startswith("met") else word


def _binary(path: Path, head: _Head, row: np.dtype[np.void], names: list[str]) -> Iterator[Array]:
    with path.open("rb") as stream:
        stream.seek(head.length)
        for first in range(0, head.count, AT_A_TIME):
            rows = np.frombuffer(stream.read(row.itemsize * min(AT_A_TIME, head.count - first)), row)
            yield np.column_stack([rows[one].astype(float) for one in names])


def _text(path: Path, name: str, head: _Head, places: list[int]) -> Iterator[Array]:
    left = head.count
    with path.open("rb") as stream:
        stream.seek(head.length)
        for lines in line_blocks(stream, name):
            kept = [line for line in lines if line.strip()][:left]
            left -= len(kept)
            if kept:
                rows = numbers_in(kept, name)
                if rows.shape[1] != len(head.properties):
                    raise InputError(
                        f"a row of '{name}' has {rows.shape[1]} numbers, its header states {len(head.properties)}; export it again"
                    )
                yield rows[:, places]
            if not left:
                return
    raise InputError(f"'{name}' is cut off: {left} of the {head.count} points that its header states are missing; export it again")
