"""Sheets of a workbook as text. The library ends its process where a sheet claims more than there is
memory for, so a workbook is read in a process of its own, within bounds.
"""

from __future__ import annotations

import io
import json
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from valvetrain.errors import InputError
from valvetrain.solution.read_apart import apart_environment, bound_process, no_interpreter

#: How files of workbooks begin: a zip archive, an OLE container.
MARKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
#: A sheet beyond these is no table of lifts; a workbook that unpacks to more (bytes) holds one.
MAX_ROWS, MAX_COLUMNS, MAX_UNPACKED = 50_000, 60, 100_000_000
#: Address space (bytes), seconds of the processor and of the clock for reading one workbook.
MAX_MEMORY, MAX_SECONDS, MAX_WAIT = 1_000_000_000, 20, 60
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
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", f"from {__name__} import serve; serve()"],
            input=content,
            capture_output=True,
            timeout=MAX_WAIT,
            env=apart_environment(),
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(
            f"'{shown}' was not read within {MAX_WAIT} s; export the table as text"
        ) from error
    except (OSError, TypeError) as error:
        raise InputError(
            f"'{shown}' is not read, for workbooks are read in a process of their own, and {no_interpreter()}"
        ) from error
    if done.returncode:
        raise InputError(
            f"'{shown}' claims more cells than can be read within {MAX_MEMORY / 1e9:g} GB and {MAX_SECONDS} s; {_REMEDY}"
        )
    found = json.loads(done.stdout)
    if found is None:
        raise InputError(
            f"'{shown}' is no workbook that can be read; save it again or export the table as text"
        )
    return [Sheet(*entry) for entry in found]


def _unpacked(content: bytes) -> int:
    """Bytes that a zip archive states for all it holds; 0 of anything else."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return sum(member.file_size for member in archive.infolist())
    except (zipfile.BadZipFile, ValueError, OSError, NotImplementedError):
        return 0


def serve() -> None:
    """The child's side of :func:`sheets_of`: a workbook on standard input, its sheets as JSON on
    standard output, null for one that cannot be read.
    """
    import python_calamine

    content = sys.stdin.buffer.read()
    bound_process(MAX_MEMORY, MAX_SECONDS)
    found: list[tuple[str, str, bool, bool]] | None = []
    try:
        book = python_calamine.CalamineWorkbook.from_filelike(io.BytesIO(content))
        for title in book.sheet_names:
            found.append(_sheet(str(title), book.get_sheet_by_name(title)))  # type: ignore[union-attr]
    except (python_calamine.CalamineError, ValueError, OSError):
        found = None
    json.dump(found, sys.stdout)


def _sheet(title: str, sheet: Any) -> tuple[str, str, bool, bool]:
    if sheet.height > MAX_ROWS or sheet.width > MAX_COLUMNS:
        return title, "", False, True
    cells = sheet.to_python(skip_empty_area=True)
    numeric = any(
        isinstance(cell, float | int) and not isinstance(cell, bool)
        for row in cells
        for cell in row
    )
    return title, "\n".join(line for row in cells if (line := _line(row))), numeric, False


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
