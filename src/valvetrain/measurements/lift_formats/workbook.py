"""Workbooks (XLSX, XLS, ODS): the first sheet that holds columns of numbers."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.lift_formats.columns import from_table
from valvetrain.measurements.lift_formats.contract import LiftColumns, LiftFormat, LiftTable
from valvetrain.measurements.text_table import read_text_table

#: How files of workbooks begin: a zip archive, an OLE container.
_MARKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
#: A sheet beyond these is no table of lifts.
MOST_ROWS, MOST_COLUMNS = 200_000, 60
_EXTRA = "install the extra 'measure' (pip install 'valvetrain[measure]')"


def recognise(content: bytes, name: str) -> bool:
    """Whether the content begins as a workbook does."""
    return content.startswith(_MARKS)


def read(content: bytes, name: str) -> LiftColumns:
    """Columns of the first sheet with numbers. Raises :class:`InputError` where the extra is missing or no sheet holds a table."""
    try:
        from python_calamine import CalamineError, CalamineWorkbook
    except ImportError as error:
        raise InputError(f"'{name[:80]}' is a workbook, which needs python-calamine; {_EXTRA}") from error
    try:
        book = CalamineWorkbook.from_filelike(io.BytesIO(content))
        sheets = [(title, book.get_sheet_by_name(title)) for title in book.sheet_names]
        tables = [(title, sheet.to_python(skip_empty_area=True)) for title, sheet in sheets if _fits(sheet)]
    except (CalamineError, ValueError, OSError) as error:
        raise InputError(f"'{name[:80]}' is no workbook that can be read; save it again or export the table as text") from error
    for title, cells in tables:
        text = "\n".join(line for row in cells if (line := _line(row)))
        try:
            return from_table(read_text_table(text, f"sheet '{str(title)[:40]}' of {name}"), "workbook")
        except InputError as error:
            fault = error
            if any(isinstance(cell, float | int) and not isinstance(cell, bool) for row in cells for cell in row):
                raise
    raise InputError(f"no sheet of '{name[:80]}' holds rows of numbers; put the table on a sheet of its own") from (
        fault if tables else None
    )


def _fits(sheet: object) -> bool:
    return getattr(sheet, "height", 0) <= MOST_ROWS and getattr(sheet, "width", 0) <= MOST_COLUMNS


def _line(row: Sequence[object]) -> str:
    cells = [
        repr(float(cell)) if isinstance(cell, float | int) else str(cell).replace("\t", " ").replace("\n", " ").strip() for cell in row
    ]
    while cells and not cells[-1]:
        cells.pop()
    return "\t".join(cells)


def write(table: LiftTable) -> bytes:
    """One sheet with headings: cam degrees and mm. Raises :class:`InputError` where the extra is missing."""
    try:
        import xlsxwriter
    except ImportError as error:
        raise InputError(f"writing a workbook needs xlsxwriter; {_EXTRA}") from error
    out = io.BytesIO()
    with xlsxwriter.Workbook(out, {"in_memory": True}) as book:
        sheet = book.add_worksheet("lift")
        sheet.write_row(0, 0, ["cam angle [deg]", *(f"{name} {table.lift_of} lift [mm]".strip() for name in table.names)])
        for place, row in enumerate(np.column_stack([np.degrees(table.cam_angles), 1e3 * table.lifts]), start=1):
            sheet.write_row(place, 0, [float(value) for value in row])
    return out.getvalue()


SPEC = LiftFormat("workbook", recognise, read, write)
