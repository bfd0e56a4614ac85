"""Points of a scan from a file, known by its content: a table of text, or PLY, STL and OBJ by trimesh."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.tables import read_content, read_text_table, text_of
from valvetrain.parameters.bounded_file import file_head

#: Most columns and lines of a table of points.
MAX_COLUMNS, MAX_LINES = 100, 50_000_000
#: Larger files are refused (bytes), and points drawn from the faces of a mesh.
MAX_BYTES, SURFACE = 2_000_000_000, 60_000
_UNIT = (
    rb"(?im)^(?:comment|obj_info|#|solid).*?\bunits?\W+(mm|cm|m|inch|in|um|millimet\w+|met\w+)\b"
)


@dataclass(frozen=True, eq=False)
class Cloud:
    """A file of points: its ``form``, the ``unit`` it gives (empty where it gives none), and its
    ``points`` (n, 3); of a mesh its corners, and points drawn evenly by area from its faces,
    ``surface`` (n, 3).
    """

    name: str
    form: str
    unit: str
    points: Array
    surface: Array = field(default_factory=lambda: np.zeros((0, 3)))


def open_cloud(file: str | Path) -> Cloud:
    """The points of ``file``, and those of the faces of a mesh.

    Raises :class:`InputError` for a file that is missing, special, empty, truncated or no cloud.
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
    if size > MAX_BYTES:
        raise InputError(f"'{name}' is larger than {MAX_BYTES / 1e9:g} GB; thin the scan out")
    if form == "STL" and size != 84 + 50 * int.from_bytes(head[80:84], "little"):
        raise InputError(
            f"'{name}' is no whole STL file: it has not as many bytes as its header states triangles; export it again"
        )
    word = re.search(_UNIT, head)
    unit = _unit(word[1].decode().lower()) if word else ""
    if form == "text":
        points, of_column = _table(path, name)
        return Cloud(name, form, of_column or unit, points)
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
    return Cloud(name, form, unit, corners, surface)


def _table(path: Path, name: str) -> tuple[Array, str]:
    """Points (n, 3) of a text of columns, by the names x, y and z or else the first three, and their unit."""
    text = text_of(read_content(path, MAX_BYTES, "scan"), name)
    count = re.match(r"\s*\d+[ \t]*\r?\n", text)  # some forms begin with the number of points
    table = read_text_table(text[count.end() if count else 0 :], name, MAX_COLUMNS, MAX_LINES, gaps=True)  # fmt: skip
    names = [word.lower() for word in table.names]
    places = [names.index(axis) for axis in "xyz"] if {*"xyz"} <= {*names} else [0, 1, 2]
    if len(names) < 3:
        raise InputError(f"'{name}' has rows of {len(names)} numbers; three are needed, x, y and z")
    return table.rows[:, places], _unit(table.units[places[0]].lower())


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
