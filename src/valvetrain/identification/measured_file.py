"""Files of an identification's measurements: static curves and traces as columns of a text."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.identification.part import Part
from valvetrain.measured.force_height import column_meaning, column_scale
from valvetrain.measured.tables import TextTable, read_content, read_text_table, text_of
from valvetrain.parameters.bounded_file import MOST_BYTES
from valvetrain.units import parse_quantity, unit_factor

Array = NDArray[np.float64]
Along = Literal["height", "compression"]
CURVE = ("height", "compression", "force", "ignore")


def trace_file(part: Part, folder: Path) -> tuple[Array, Array, str]:
    """Cam angles (rad), values (SI) and their unit from the first two columns of the part's
    ``file``.

    Units stand in the headings, or in ``units``. Raises :class:`InputError` for a column without a
    unit, and for a first one that is no
    angle or is called a crank angle.
    """
    try:
        table, name = _table(part, folder)
        units = _units(part, table, (0, 1), name, '["deg", "N"]')
        if "crank" in table.names[0].lower():
            raise InputError(
                f"'{name}' calls its angles '{table.names[0][:40]}'; a trace stands over the cam angle, so halve them"
            )
        parse_quantity(f"1 {units[0]}", "angle")
        return (
            table.rows[:, 0] * unit_factor(units[0]),
            table.rows[:, 1] * unit_factor(units[1]),
            units[1],
        )
    except InputError as error:
        raise InputError(error.reason, part.place("file")) from None


def curve_file(part: Part, folder: Path) -> tuple[Along, Array, Array]:
    """What the places of a static curve are, the places (m) and the forces (N), from columns of the
    part's ``file`` in any order.

    Headings say which column is which, or ``columns`` does. Raises :class:`InputError` where
    neither tells heights from compressions,
    and for wrong or missing units.
    """
    try:
        table, name = _table(part, folder)
        given = part.texts("columns")
        meant = given or tuple(column_meaning(word) for word in table.names)
        unknown = next((word for word in given if word not in CURVE), "")
        if unknown:
            raise InputError(
                f"a column is one of {', '.join(CURVE)}, not '{unknown[:40]}'; correct columns"
            )
        if len(meant) != table.rows.shape[1]:
            raise InputError(
                f"'{name}' has {table.rows.shape[1]} columns and columns names {len(meant)}; say what each is"
            )
        if meant.count("force") != 1 or meant.count("height") + meant.count("compression") != 1:
            raise InputError(
                f"'{name}' does not say which of its columns is force and which height, or compression from the free state; write it "
                'in its headings, or columns = ["height", "force"]'
            )
        along: Along = "height" if "height" in meant else "compression"
        places = (meant.index(along), meant.index("force"))
        units = _units(part, table, places, name, '["mm", "N"]')
        length, force = (
            column_scale(units[0], "length", "units", name),
            column_scale(units[1], "force", "units", name),
        )
        return along, table.rows[:, places[0]] * length, table.rows[:, places[1]] * force
    except InputError as error:
        raise InputError(error.reason, part.place("file")) from None


def _table(part: Part, folder: Path) -> tuple[TextTable, str]:
    path = folder / part.text("file")
    table, name = (
        read_text_table(text_of(read_content(path, MOST_BYTES, "table"), path.name), path.name),
        path.name[:60],
    )
    if table.rows.shape[1] < 2:
        raise InputError(f"'{name}' has one column; give places and values side by side")
    return table, name


def _units(
    part: Part, table: TextTable, places: tuple[int, int], name: str, example: str
) -> tuple[str, str]:
    """Units of two columns: those of the headings, or ``units``, a text for every column of the
    file or for the two alone.
    """
    given = part.texts("units")
    if len(given) == 2 and table.rows.shape[1] > 2:
        return given[0], given[1]
    units = given or table.units
    if len(units) <= max(places) or not all(units[place] for place in places):
        raise InputError(f"'{name}' has no units; write them in its headings, or units = {example}")
    return units[places[0]], units[places[1]]
