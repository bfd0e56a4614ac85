"""Points of a scan from a file, known by its content: text block by block, PLY, STL and OBJ by trimesh."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import file_head

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
        return np.asarray(np.loadtxt(lines, comments=None, ndmin=2))
    except ValueError:
        pass
    for line in lines:
        parts = line.split()
        if len(parts) != width or not all(re.fullmatch(_NUMBER + rb"|[-+]?inf", part, re.I) for part in parts):  # fmt: skip
            raise InputError(
                f"a row of '{name}' is not as the others: '{_shown(line)}'; correct it or leave it out"
            )
    raise InputError(f"'{name}' holds rows that cannot be read as numbers; export the scan again")


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


#: Larger files and larger meshes are refused (bytes), and points drawn from the faces of a mesh.
MAX_BYTES, MAX_MESH, SURFACE = 20_000_000_000, 2_000_000_000, 60_000
_UNIT = (
    rb"(?im)^(?:comment|obj_info|#|solid).*?\bunits?\W+(mm|cm|m|inch|in|um|millimet\w+|met\w+)\b"
)


@dataclass(frozen=True, eq=False)
class Cloud:
    """A file of points: its ``form``, the ``unit`` it gives (empty where it gives none), and its
    ``blocks`` (n, 3) in file order; of a mesh its corners, and points drawn evenly by area from
    its faces, ``surface`` (n, 3).
    """

    name: str
    form: str
    unit: str
    blocks: Iterable[Array]
    surface: Array = field(default_factory=lambda: np.zeros((0, 3)))


def open_cloud(file: str | Path) -> Cloud:
    """The points of ``file``, and those of the faces of a mesh.

    Raises :class:`InputError` for a file that is missing, special, empty, truncated or no cloud;
    faults of a table of points show while blocks are read.
    """
    path = Path(file)
    name, head, size = file_head(path, "scan")
    if re.match(rb"ply\s", head):
        form = "PLY"
    elif head[:5].lower() == b"solid" and re.search(rb"facet|endsolid", head):
        form = "STL (text)"
    elif path.suffix.lower() == ".stl" or (
        size >= 84 and size == 84 + 50 * int.from_bytes(head[80:84], "little")
    ):
        form = "STL"
    elif re.search(rb"(?m)^v\s+[-+.\d]", head) or path.suffix.lower() == ".obj":
        form = "OBJ"
    else:
        form = "text"
    most = MAX_BYTES if form == "text" else MAX_MESH
    if size > most:
        raise InputError(f"'{name}' is larger than {most / 1e9:g} GB; thin the scan out")
    if form == "STL" and size != 84 + 50 * int.from_bytes(head[80:84], "little"):
        raise InputError(
            f"'{name}' is no whole STL file: it has not as many bytes as its header states triangles; export it again"
        )
    if form == "text":
        unit, blocks = columns_of_text(path, name, head)
        return Cloud(name, form, unit, blocks)
    corners, surface = _mesh(path, name, form)
    stated = re.search(rb"element\s+vertex\s+(\d+)", head) if form == "PLY" else None
    if stated is not None and int(stated[1]) != len(corners):
        raise InputError(
            f"'{name}' is cut off: its header states {stated[1].decode()[:20]} points, {len(corners)} are there; export it again"
        )
    rows = re.search(
        rb"format ascii.*element vertex[^\n]*\n(.*?)(?:element.*?)?end_header\s*\n([^\n]*)",
        head,
        re.DOTALL,
    )
    if form == "PLY" and rows and rows[1].count(b"property") != len(rows[2].split()):
        raise InputError(
            f"'{name}' has {len(rows[2].split())} numbers in its first row, its header states {rows[1].count(b'property')}; export it again"
        )
    word = re.search(_UNIT, head)
    return Cloud(name, form, _unit(word[1].decode().lower()) if word else "", [corners], surface)


def _unit(word: str) -> str:
    return {"in": "inch", "mil": "mm", "met": "m"}.get(word if word == "in" else word[:3], word)


def _mesh(path: Path, name: str, form: str) -> tuple[Array, Array]:
    """Corners of a mesh or points of a cloud by trimesh, and points drawn evenly from its faces."""
    try:
        import trimesh
    except ImportError as error:
        raise InputError(
            f"{form} files need the extra 'measure'; install it, or export the scan as text with x, y and z in columns"
        ) from error
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            trimesh.util.log.disabled = True  # it prints tracebacks of what it then reads otherwise
            loaded: Any = trimesh.load(path, file_type=form[:3].lower(), process=False)
        parts = [*loaded.geometry.values()] if hasattr(loaded, "geometry") else [loaded]
        corners = np.concatenate([np.zeros((0, 3)), *(part.vertices for part in parts)]).astype(
            float
        )
        solid = [part for part in parts if len(getattr(part, "faces", ()))]
        whole: Any = trimesh.util.concatenate(solid) if solid else None
        surface = np.zeros((0, 3))
        if whole is not None and np.all(np.isfinite(whole.vertices)) and whole.area > 0:
            surface = np.asarray(trimesh.sample.sample_surface(whole, SURFACE, seed=1)[0])
    except Exception as error:  # what trimesh cannot read it raises, or numpy does
        raise InputError(
            f"'{name}' is cut off or damaged and cannot be read as {form}; export it again"
        ) from error
    if not len(corners):
        raise InputError(f"'{name}' holds no point; export the scan as a mesh or a cloud of points")
    return corners, surface
