"""Rows of numbers in large texts, block by block."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
#: Bytes read at a time, longest line, and most lines of words before the numbers.
BLOCK, LONGEST_LINE, MOST_HEADINGS = 4_000_000, 100_000, 100
#: Most columns of a cloud of points.
MOST_COLUMNS = 100
_NUMBER = rb"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?|[-+]?nan"
_ROW = re.compile(rb"\s*(?:%s)(?:\s*[;,\t|]\s*(?:%s)|\s+(?:%s)){2,}\s*[;,|]?\s*" % ((_NUMBER,) * 3), re.I)
_DECIMAL_COMMA = re.compile(rb"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")


def line_blocks(stream: BinaryIO, name: str) -> Iterator[list[bytes]]:
    """Whole lines, some megabytes at a time. Raises :class:`InputError` for a line that no table has."""
    rest = b""
    while True:
        read = stream.read(BLOCK)
        if not read:
            break
        whole, mark, rest = (rest + read).rpartition(b"\n")
        if len(rest) > LONGEST_LINE:
            raise InputError(f"'{name}' has a line of more than {LONGEST_LINE} characters, so it is no text of points")
        if mark:
            yield whole.split(b"\n")
    if rest.strip():
        yield [rest]


def numbers_in(lines: Sequence[bytes], name: str) -> Array:
    """Numbers (lines, columns) parted by blanks. Raises :class:`InputError` naming a line that is not as the others."""
    width = len(lines[0].split())
    if not 3 <= width <= MOST_COLUMNS:
        raise InputError(f"'{name}' has a row of {width} numbers: '{_shown(lines[0])}'; three are needed, x, y and z")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            values: Array = np.fromstring(b" ".join(lines), dtype=float, sep=" ")
        fits = values.size == width * len(lines) and all(len(line.split()) == width for line in lines)
    except (ValueError, DeprecationWarning):
        fits = False
    if not fits:
        for line in lines:
            parts = line.split()
            if len(parts) != width or not all(re.fullmatch(_NUMBER + rb"|[-+]?inf", part, re.I) for part in parts):
                raise InputError(f"a row of '{name}' is not as the others: '{_shown(line)}'; correct it or leave it out")
        raise InputError(f"'{name}' holds rows that cannot be read as numbers; export the scan again")
    return values.reshape(-1, width)


def _shown(line: bytes) -> str:
    return line.strip()[:40].decode("ascii", "replace")


def columns_of_text(path: Path, name: str, head: bytes) -> tuple[str, Iterator[Array]]:
    """Unit that the headings tell and blocks (n, 3) of a text of columns. Raises :class:`InputError` for bytes that are no text."""
    if b"\0" in head:
        raise InputError(f"'{name}' is no scan that is read: PLY, STL and OBJ are, and text with x, y, z in columns; export it so")
    lines = head.split(b"\n")
    first = next((k for k, line in enumerate(lines) if _ROW.fullmatch(line.replace(b"\r", b""))), -1)
    if first < 0 or first > MOST_HEADINGS:
        raise InputError(f"'{name}' holds no rows of x, y and z; export the scan as PLY, STL, OBJ or text with three columns")
    headings = b"\n".join(lines[:first]).decode("utf-8", "replace").lower()
    told = re.search(r"[\[(]\s*(mm|cm|m|inch|in|um)\s*[\])]|\bunits?\W+(mm|cm|m|inch|in|um)\b", headings)
    unit = "" if told is None else (told[1] or told[2])
    places = _places(headings.split("\n")[-1] if first else "", lines[first])
    return "inch" if unit == "in" else unit, _rows(path, name, first, _comma(lines[first]), places)


def _comma(line: bytes) -> bytes:
    """What a comma stands for in a row: a point of decimals or a blank."""
    parts = re.split(rb"[;\t|\s]+", line.strip())
    return b"." if sum(bool(_DECIMAL_COMMA.fullmatch(part)) for part in parts) >= 3 else b" "


def _places(heading: str, row: bytes) -> list[int]:
    """Columns of x, y and z: by their names where the heading has as many words as the row, else the first three."""
    words = [word for word in re.split(r"[;,\t|\s]+", re.sub(r"[\[(].*?[\])]|^\W+", " ", heading).strip()) if word]
    named = [words.index(axis) for axis in "xyz" if axis in words]
    return named if len(named) == 3 else [0, 1, 2]


def _rows(path: Path, name: str, skip: int, comma: bytes, places: list[int]) -> Iterator[Array]:
    table = bytes.maketrans(b",;|\t\r", comma + b"    ")
    with path.open("rb") as stream:
        for lines in line_blocks(stream, name):
            kept = [line.translate(table) for line in lines[skip:]]
            skip = max(0, skip - len(lines))
            kept = [line for line in kept if line.strip() and not line.lstrip().startswith((b"#", b"//", b"%"))]
            if kept:
                rows = numbers_in(kept, name)
                if rows.shape[1] <= max(places):
                    raise InputError(f"a row of '{name}' has {rows.shape[1]} numbers, fewer than those before it; export the scan again")
                yield rows[:, places]
