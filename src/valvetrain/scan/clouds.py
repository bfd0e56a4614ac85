"""Points of a scan from a file, block by block: PLY, STL, OBJ, text; known by content, sizes
checked before anything is taken.
"""

from __future__ import annotations

import re
import stat
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
#: Bytes read at a time, longest line, and most lines of words before the numbers.
BLOCK, MAX_LINE_LENGTH, MAX_HEADINGS = 4_000_000, 100_000, 100
#: Most columns of a cloud of points.
MAX_COLUMNS = 100
_NUMBER = rb"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?|[-+]?nan"
_ROW = re.compile(
    rb"\s*(?:%s)(?:\s*[;,\t|]\s*(?:%s)|\s+(?:%s)){2,}\s*[;,|]?\s*" % ((_NUMBER,) * 3), re.I
)
_DECIMAL_COMMA = re.compile(rb"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")


def line_blocks(stream: BinaryIO, name: str) -> Iterator[list[bytes]]:
    """Whole lines, some megabytes at a time. Raises :class:`InputError` for a line that no table
    has.
    """
    rest = b""
    while True:
        read = stream.read(BLOCK)
        if not read:
            break
        whole, mark, rest = (rest + read).rpartition(b"\n")
        if len(rest) > MAX_LINE_LENGTH:
            raise InputError(
                f"'{name}' has a line of more than {MAX_LINE_LENGTH} characters, so it is no text of points"
            )
        if mark:
            yield whole.split(b"\n")
    if rest.strip():
        yield [rest]


def numbers_in(lines: Sequence[bytes], name: str) -> Array:
    """Numbers (lines, columns) parted by blanks. Raises :class:`InputError` naming a line that is
    not as the others.
    """
    width = len(lines[0].split())
    if not 3 <= width <= MAX_COLUMNS:
        raise InputError(
            f"'{name}' has a row of {width} numbers: '{_shown(lines[0])}'; three are needed, x, y and z"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            values: Array = np.fromstring(b" ".join(lines), dtype=float, sep=" ")
        fits = values.size == width * len(lines) and all(
            len(line.split()) == width for line in lines
        )
    except (ValueError, DeprecationWarning):
        fits = False
    if not fits:
        for line in lines:
            parts = line.split()
            if len(parts) != width or not all(
                re.fullmatch(_NUMBER + rb"|[-+]?inf", part, re.I) for part in parts
            ):
                raise InputError(
                    f"a row of '{name}' is not as the others: '{_shown(line)}'; correct it or leave it out"
                )
        raise InputError(
            f"'{name}' holds rows that cannot be read as numbers; export the scan again"
        )
    return values.reshape(-1, width)


def _shown(line: bytes) -> str:
    return line.strip()[:40].decode("ascii", "replace")


def columns_of_text(path: Path, name: str, head: bytes) -> tuple[str, Iterator[Array]]:
    """Unit that the headings give and blocks (n, 3) of a text of columns. Raises
    :class:`InputError` for bytes that are no text.
    """
    if b"\0" in head:
        raise InputError(
            f"'{name}' is no scan that is read: PLY, STL and OBJ are, and text with x, y, z in columns; export it so"
        )
    lines = head.split(b"\n")
    first = next(
        (k for k, line in enumerate(lines) if _ROW.fullmatch(line.replace(b"\r", b""))), -1
    )
    if first < 0 or first > MAX_HEADINGS:
        raise InputError(
            f"'{name}' holds no rows of x, y and z; export the scan as PLY, STL, OBJ or text with three columns"
        )
    headings = b"\n".join(lines[:first]).decode("utf-8", "replace").lower()
    unit_match = re.search(
        r"[\[(]\s*(mm|cm|m|inch|in|um)\s*[\])]|\bunits?\W+(mm|cm|m|inch|in|um)\b", headings
    )
    unit = "" if unit_match is None else (unit_match[1] or unit_match[2])
    places = _places(headings.split("\n")[-1] if first else "", lines[first])
    return "inch" if unit == "in" else unit, _rows(path, name, first, _comma(lines[first]), places)


def _comma(line: bytes) -> bytes:
    """Meaning of a comma in a row: a point of decimals or a blank."""
    parts = re.split(rb"[;\t|\s]+", line.strip())
    return b"." if sum(bool(_DECIMAL_COMMA.fullmatch(part)) for part in parts) >= 3 else b" "


def _places(heading: str, row: bytes) -> list[int]:
    """Columns of x, y and z: by their names where the heading has as many words as the row, else
    the first three.
    """
    column_names = [
        word
        for word in re.split(r"[;,\t|\s]+", re.sub(r"[\[(].*?[\])]|^\W+", " ", heading).strip())
        if word
    ]
    named = [column_names.index(axis) for axis in "xyz" if axis in column_names]
    return named if len(named) == 3 else [0, 1, 2]


def _rows(path: Path, name: str, skip: int, comma: bytes, places: list[int]) -> Iterator[Array]:
    table = bytes.maketrans(b",;|\t\r", comma + b"    ")
    with path.open("rb") as stream:
        for lines in line_blocks(stream, name):
            text_rows = [line.translate(table) for line in lines[skip:]]
            skip = max(0, skip - len(lines))
            text_rows = [
                line
                for line in text_rows
                if line.strip() and not line.lstrip().startswith((b"#", b"//", b"%"))
            ]
            if text_rows:
                rows = numbers_in(text_rows, name)
                if rows.shape[1] <= max(places):
                    raise InputError(
                        f"a row of '{name}' has {rows.shape[1]} numbers, fewer than those before it; export the scan again"
                    )
                yield rows[:, places]


#: Longest head of a file (bytes), most properties of a point, points taken at a time, and corners of a face.
MAX_HEAD_LENGTH, MAX_PROPERTIES, PLY_AT_A_TIME, MAX_CORNERS = 65_536, 100, 200_000, 255
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
    face: tuple[str, ...]


def ply_points(path: Path, name: str, size: int) -> tuple[str, Iterator[Array]]:
    """Unit that the head gives, and blocks (n, 3). Raises :class:`InputError` for a head that does
    not fit the file of ``size`` bytes.
    """
    with path.open("rb") as stream:
        head = _head(stream.read(MAX_HEAD_LENGTH), name)
    column_names = [word for word, _ in head.properties]
    if any(axis not in column_names for axis in "xyz"):
        raise InputError(f"the points of '{name}' have no x, y and z; export the scan again")
    if head.count < 1:
        raise InputError(f"'{name}' holds no point; export the scan again")
    if not head.order:
        if 2 * len(column_names) * head.count > size - head.length + 1:
            raise InputError(_short(name, head.count, size))
        return head.unit, _text(path, name, head, [column_names.index(axis) for axis in "xyz"])
    row = np.dtype([(f"p{k}", head.order + kind) for k, (_, kind) in enumerate(head.properties)])
    end = head.length + row.itemsize * head.count
    if end > size:
        raise InputError(_short(name, head.count, size))
    if not (_face_fits(path, head, end) if head.face else size == end):
        raise InputError(
            f"what follows the {head.count} points of '{name}' is not what its header states, so they may be shifted; export it again"
        )
    return head.unit, _binary(path, head, row, [f"p{column_names.index(axis)}" for axis in "xyz"])


def _short(name: str, count: int, size: int) -> str:
    return f"'{name}' is cut off: its header states {count} points, more than its {size} bytes can hold; export it again"


def _face_fits(path: Path, head: _Head, end: int) -> bool:
    """Whether the first list after the points, from the byte ``end`` on, names corners that there are; any other
    element does.
    """
    if "" in head.face:
        return True
    corners, index = (np.dtype(head.order + kind) for kind in head.face)
    with path.open("rb") as stream:
        stream.seek(end)
        first, rest = stream.read(corners.itemsize), stream.read(MAX_CORNERS * index.itemsize)
    count = int.from_bytes(first, "big" if head.order == ">" else "little")
    named = rest[: count * index.itemsize]
    whole = 3 <= count <= MAX_CORNERS and len(named) == count * index.itemsize
    return whole and bool(np.max(np.frombuffer(named, index)) < head.count)


def _head(content: bytes, name: str) -> _Head:
    end = re.search(rb"(?m)^end_header[ \t]*\r?\n", content)
    if end is None:
        raise InputError(f"'{name}' begins as PLY, but its head has no end; export it again")
    lines = content[: end.start()].decode("ascii", "replace").split("\n")
    order, count, unit, here = None, -1, "", ""
    face: tuple[str, ...] = ()
    properties: list[tuple[str, str]] = []
    for line in (one.split() for one in lines[1:]):
        match line:
            case ["format", form, *_] if form in _FORMATS:
                order = _FORMATS[form]
            case ["comment" | "obj_info", *column_names]:
                found = re.search(
                    r"\bunits?\W+(mm|cm|m|inch|in|um|millimet\w+|met\w+)\b",
                    " ".join(column_names),
                    re.I,
                )
                unit = _unit(found[1]) if found else unit
            case ["element", "vertex", number] if re.fullmatch(r"\d{1,15}", number) and count < 0:
                here, count = "vertex", int(number)
            case ["element", word, *number]:
                if count < 0:
                    raise InputError(
                        f"'{name}' holds '{word[:20]}' before its points; export the points first"
                    )
                here = word
                if not face and number != ["0"]:
                    face = ("", "")
            case ["property", "list", corners, index, _] if (
                face == ("", "") and corners in _TYPES and index in _TYPES
            ):
                face = (_TYPES[corners], _TYPES[index])
            case ["property", *_] if face == ("", ""):
                face = ("", "other")
            case ["property", kind, word] if (
                here == "vertex" and kind in _TYPES and len(properties) < MAX_PROPERTIES
            ):
                properties.append((word, _TYPES[kind]))
            case ["property", *_] if here == "vertex":
                raise InputError(
                    f"a property of the points of '{name}' is none that PLY has for points: '{' '.join(line)[:40]}'"
                )
    if order is None or count < 0:
        raise InputError(
            f"the head of '{name}' has no format or no points (element vertex); export it again"
        )
    return _Head(order, count, tuple(properties), end.end(), unit, face)


def _unit(word: str) -> str:
    word = word.lower()
    return (
        "inch"
        if word == "in"
        else "mm"
        if word.startswith("milli")
        else "m"
        if word.startswith("met")
        else word
    )


def _binary(path: Path, head: _Head, row: np.dtype[np.void], names: list[str]) -> Iterator[Array]:
    with path.open("rb") as stream:
        stream.seek(head.length)
        for first in range(0, head.count, PLY_AT_A_TIME):
            rows = np.frombuffer(
                stream.read(row.itemsize * min(PLY_AT_A_TIME, head.count - first)), row
            )
            with np.errstate(invalid="ignore"):  # NaN of any kind are counted later
                block = np.column_stack([rows[one].astype(float) for one in names])
            yield block


def _text(path: Path, name: str, head: _Head, places: list[int]) -> Iterator[Array]:
    left = head.count
    with path.open("rb") as stream:
        stream.seek(head.length)
        for lines in line_blocks(stream, name):
            text_rows = [line for line in lines if line.strip()][:left]
            left -= len(text_rows)
            if text_rows:
                rows = numbers_in(text_rows, name)
                if rows.shape[1] != len(head.properties):
                    raise InputError(
                        f"a row of '{name}' has {rows.shape[1]} numbers, its header states {len(head.properties)}; export it again"
                    )
                yield rows[:, places]
            if not left:
                return
    raise InputError(
        f"'{name}' is cut off: {left} of the {head.count} points that its header states are missing; export it again"
    )


#: Larger files are refused (bytes); triangles of a binary STL taken at a time, and bytes of one.
MAX_BYTES, CLOUDS_AT_A_TIME, FACET = 20_000_000_000, 100_000, 50
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True, eq=False)
class Cloud:
    """A file of points: its ``form``, the ``unit`` it gives (empty where it gives none), and its
    ``blocks`` (n, 3) in file order.
    """

    name: str
    form: str
    unit: str
    blocks: Iterator[Array]


def open_cloud(file: str | Path) -> Cloud:
    """The points of ``file``; corners of a mesh are its points, each facet's own.

    Raises :class:`InputError` for a file that is missing, special, empty, truncated or no cloud;
    later faults show while blocks are read.
    """
    path = Path(file)
    name = path.name[:80] or str(path)[:80]
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            raise InputError(f"'{name}' is no regular file; give the scan as a file")
        with path.open("rb") as stream:
            head = stream.read(4096)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", "") or "the name is no file name"
        raise InputError(
            f"scan '{name}' cannot be read: {reason.lower()}; check the name and the folder"
        ) from error
    size = found.st_size
    if not head.strip():
        raise InputError(f"'{name}' is empty; export the scan again")
    if size > MAX_BYTES:
        raise InputError(f"'{name}' is larger than {MAX_BYTES / 1e9:g} GB; thin the scan out")
    if re.match(rb"ply\s", head):
        unit, blocks = ply_points(path, name, size)
        return Cloud(name, "PLY", unit, blocks)
    if head[:5].lower() == b"solid" and re.search(rb"facet|endsolid", head):
        return Cloud(name, "STL (text)", _unit_in_head(head), _marked(path, name, b"vertex"))
    if path.suffix.lower() == ".stl" or (
        size >= 84 and size == 84 + FACET * int.from_bytes(head[80:84], "little")
    ):
        return Cloud(name, "STL", "", _stl(path, name, size))
    if re.search(rb"(?m)^v\s+[-+.\d]", head) or path.suffix.lower() == ".obj":
        return Cloud(name, "OBJ", _unit_in_head(head), _marked(path, name, b"v"))
    unit, blocks = columns_of_text(path, name, head)
    return Cloud(name, "text", unit, blocks)


def _unit_in_head(head: bytes) -> str:
    """Unit that a comment of a text file gives."""
    found = re.search(rb"(?im)^(?:#|solid).*?\bunits?\W+(mm|cm|m|inch|in|um)\b", head)
    return found[1].decode().lower().replace("inch", "in").replace("in", "inch") if found else ""


def _stl(path: Path, name: str, size: int) -> Iterator[Array]:
    with path.open("rb") as stream:
        head = stream.read(84)
        count = int.from_bytes(head[80:], "little")
        if count < 1 or size != 84 + FACET * count:
            raise InputError(
                f"'{name}' is no whole STL file: it states {count} facets, which need {84 + FACET * count} bytes, and has "
                f"{size}; export it again"
            )
        for first in range(0, count, CLOUDS_AT_A_TIME):
            data = stream.read(FACET * min(CLOUDS_AT_A_TIME, count - first))
            with np.errstate(invalid="ignore"):
                block = np.frombuffer(data, _FACET)["corners"].reshape(-1, 3).astype(float)
            yield block


def _marked(path: Path, name: str, mark: bytes) -> Iterator[Array]:
    """Numbers behind a word at the beginning of a line."""
    found = 0
    with path.open("rb") as stream:
        for lines in line_blocks(stream, name):
            text_rows = [
                one[len(mark) :]
                for line in lines
                if (one := line.strip()).startswith(mark)
                and one[len(mark) : len(mark) + 1].isspace()
            ]
            if text_rows:
                found += len(text_rows)
                yield numbers_in(text_rows, name)[:, :3]
    if not found:
        raise InputError(f"'{name}' holds no point; export the scan as a mesh or a cloud of points")
