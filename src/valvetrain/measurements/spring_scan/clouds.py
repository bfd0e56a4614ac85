"""Points of a scan from a file, block by block: PLY, STL, OBJ, text; known by content, sizes checked before anything is taken."""

from __future__ import annotations

import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.spring_scan.ply import ply_points
from valvetrain.measurements.spring_scan.text_points import columns_of_text, line_blocks, numbers_in

Array = NDArray[np.float64]
#: Larger files are refused (bytes); triangles of a binary STL taken at a time, and bytes of one.
MOST_BYTES, AT_A_TIME, FACET = 20_000_000_000, 100_000, 50
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True, eq=False)
class Cloud:
    """A file of points: its ``form``, the ``unit`` it tells (empty where it does not), and its ``blocks`` (n, 3) as they stand in it."""

    name: str
    form: str
    unit: str
    blocks: Iterator[Array]


def open_cloud(file: str | Path) -> Cloud:
    """The points of ``file``; corners of a mesh are its points, each facet's own.

    Raises :class:`InputError` for a file that is missing, special, empty, truncated or no cloud; later faults show while blocks are read.
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
        raise InputError(f"scan '{name}' cannot be read: {reason.lower()}; check the name and the folder") from error
    size = found.st_size
    if not head.strip():
        raise InputError(f"'{name}' is empty; export the scan again")
    if size > MOST_BYTES:
        raise InputError(f"'{name}' is larger than {MOST_BYTES / 1e9:g} GB; thin the scan out")
    if re.match(rb"ply\s", head):
        unit, blocks = ply_points(path, name, size)
        return Cloud(name, "PLY", unit, blocks)
    if head[:5].lower() == b"solid" and re.search(rb"facet|endsolid", head):
        return Cloud(name, "STL (text)", _told(head), _marked(path, name, b"vertex"))
    if path.suffix.lower() == ".stl" or (size >= 84 and size == 84 + FACET * int.from_bytes(head[80:84], "little")):
        return Cloud(name, "STL", "", _stl(path, name, size))
    if re.search(rb"(?m)^v\s+[-+.\d]", head) or path.suffix.lower() == ".obj":
        return Cloud(name, "OBJ", _told(head), _marked(path, name, b"v"))
    unit, blocks = columns_of_text(path, name, head)
    return Cloud(name, "text", unit, blocks)


def _told(head: bytes) -> str:
    """Unit that a comment of a text file tells."""
    found = re.search(rb"(?im)^(?:#|solid).*?\bunits?\W+(mm|cm|m|inch|in|um)\b", head)
    return found[1].decode().lower().replace("inch", "in").replace("in", "inch") if found else ""


def _stl(path: Path, name: str, size: int) -> Iterator[Array]:
    with path.open("rb") as stream:
        head = stream.read(84)
        count = int.from_bytes(head[80:84], "little") if len(head) == 84 else -1
        if count < 1 or size < 84 + FACET * count:
            raise InputError(
                f"'{name}' is no whole STL file: it states {max(count, 0)} facets, which need {84 + FACET * max(count, 0)} bytes, and has "
                f"{size}; export it again"
            )
        for first in range(0, count, AT_A_TIME):
            data = stream.read(FACET * min(AT_A_TIME, count - first))
            yield np.frombuffer(data, _FACET)["corners"].reshape(-1, 3).astype(float)


def _marked(path: Path, name: str, mark: bytes) -> Iterator[Array]:
    """Numbers behind a word at the beginning of a line."""
    found = 0
    with path.open("rb") as stream:
        for lines in line_blocks(stream, name):
            kept = [
                one[len(mark) :] for line in lines if (one := line.strip()).startswith(mark) and one[len(mark) : len(mark) + 1].isspace()
            ]
            if kept:
                found += len(kept)
                yield numbers_in(kept, name)[:, :3]
    if not found:
        raise InputError(f"'{name}' holds no point; export the scan as a mesh or a cloud of points")
