"""Sheets of a workbook as text. The library ends its process where a sheet claims more than there is
memory for, so a workbook is tried in a process of its own first.
"""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError
from valvetrain.solution.read_apart import tried_apart

#: How files of workbooks begin: a zip archive, an OLE container.
MARKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
#: A sheet beyond these is no table of lifts; a workbook that unpacks to more (bytes) holds one.
MAX_ROWS, MAX_COLUMNS, MAX_UNPACKED = 50_000, 60, 100_000_000
EXTRA = "install the extra 'measure' (pip install 'valvetrain[measure]')"
_REMEDY = "delete cells far from the table, or export the table as text"


@dataclass(frozen=True, slots=True)
class Sheet:
    """A sheet: its ``title``, ``text`` with tabs between cells, whether it holds a number
    (``numeric``) and whether it is ``too_large``, of which no text is read.
    """

    title: str
    text: str = ""
    numeric: bool = False
    too_large: bool = False


def sheets_of(content: bytes, name: str) -> list[Sheet]:
    """The sheets of a workbook in their order. Raises :class:`InputError` for one that is damaged or
    claims too much, and where the extra is missing.
    """
    shown = name[:80]
    try:
        import python_calamine  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"'{shown}' is a workbook, which needs python-calamine; {EXTRA}"
        ) from error
    unpacked = _unpacked(content)
    if unpacked > MAX_UNPACKED:
        raise InputError(
            f"'{shown}' unpacks to {unpacked / 1e6:.0f} MB, so it is no table of lifts; {_REMEDY}"
        )
    unreadable = "is no workbook that can be read; save it again or export the table as text"
    with tempfile.TemporaryDirectory(prefix="valvetrain.") as folder:
        path = Path(folder, "workbook")
        path.write_bytes(content)
        tried_apart(f"{__name__}:read_sheets", path, f"'{shown}'", unreadable)
        return read_sheets(path)


def _unpacked(content: bytes) -> int:
    """Bytes that a zip archive states for all it holds; 0 of anything else."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return sum(member.file_size for member in archive.infolist())
    except (zipfile.BadZipFile, ValueError, OSError, NotImplementedError):
        return 0


def read_sheets(path: Path) -> list[Sheet]:
    """The sheets of a workbook; its library may end this process: see :func:`sheets_of`."""
    import python_calamine

    book = python_calamine.CalamineWorkbook.from_path(str(path))
    return [_sheet(str(title), book.get_sheet_by_name(title)) for title in book.sheet_names]


def _sheet(title: str, sheet: Any) -> Sheet:
    if sheet.height > MAX_ROWS or sheet.width > MAX_COLUMNS:
        return Sheet(title, too_large=True)
    cells = sheet.to_python(skip_empty_area=True)
    numeric = any(
        isinstance(cell, float | int) and not isinstance(cell, bool)
        for row in cells
        for cell in row
    )
    return Sheet(title, "\n".join(line for row in cells if (line := _line(row))), numeric)


def _line(row: Sequence[object]) -> str:
    cells = [
        repr(float(cell))
        if isinstance(cell, float | int)
        else str(cell).replace("\t", " ").replace("\n", " ").strip()
        for cell in row
    ]
    while cells and not cells[-1]:
        cells.pop()
    return "\t".join(cells)
