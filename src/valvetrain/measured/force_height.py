"""Tables of a spring tester: force over height, or over compression, as loaded and unloaded."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measured.ranges import refuse_beyond
from valvetrain.measured.tables import TextTable, read_content, read_text_table, text_of
from valvetrain.units import dimension_of, unit_factor

Array = NDArray[np.float64]
#: Larger files, and more lines, are no tables of a spring tester.
MAX_BYTES, MAX_LINES = 20_000_000, 200_000
#: Pattern of a heading -> what the column is; the first that fits.
_MEANINGS = (
    (r"force|load|kraft|last\b|\bf\b", "force"), (r"height|length|höhe|hoehe|länge|laenge|\bh\b|\bl\b", "height"),
    (r"compression|deflection|travel|weg|stroke|displacement|position", "compression")
)  # fmt: skip
#: What a column may be.
COLUMNS = ("height", "compression", "force", "ignore")
#: Stations of a table that gives more than two loads, at least.
MIN_STATIONS = 6


@dataclass(frozen=True, eq=False)
class ForceHeight:
    """Stations of a spring tester by falling height; SI, shapes (n,).

    ``heights`` (m) and ``forces`` (N) as loaded, mean of loading and unloading where both are
    there; ``hysteresis`` (N) the largest half difference between them, 0 where only one is;
    ``notes`` what was found in the table.

    >>> import numpy as np
    >>> ForceHeight(np.array([40e-3, 36e-3]), np.array([100.0, 260.0]))
    ForceHeight: 2 stations, 40 to 36 mm, 100 to 260 N
    """

    heights: Array
    forces: Array
    hysteresis: float = 0.0
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        reach = f"{1e3 * self.heights[0]:.4g} to {1e3 * self.heights[-1]:.4g} mm, {self.forces[0]:.4g} to {self.forces[-1]:.4g} N"
        return f"ForceHeight: {len(self.heights)} stations, {reach}"


def read_force_height(
    file: str | Path,
    *,
    columns: tuple[str, ...] = (),
    length_unit: str = "",
    force_unit: str = "",
    free_length: float | None = None,
) -> ForceHeight:
    """The table of a spring tester.

    Parameters
    ----------
    file : text of columns in any form: height (or compression from the free length) and force
    columns : what each column is, of height, compression, force and ignore; where the headings do
        not give it
    length_unit, force_unit : units of the columns, such as "mm" and "N"; where the headings do not
        give them
    free_length : m; needed where the table holds compressions

    Returns
    -------
    ForceHeight by falling height

    Raises
    ------
    InputError : a file that cannot be read, open questions in one sentence, a table that is no
        spring's

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp(), "tester.txt")
    >>> rows = [f"{height}; {40 * (50 - height)}" for height in range(48, 34, -1)]
    >>> _ = file.write_text(chr(10).join(["height [mm]; force [N]", *rows]))
    >>> read_force_height(file)
    ForceHeight: 14 stations, 48 to 35 mm, 80 to 600 N
    """
    path = Path(file)
    table = read_text_table(
        text_of(read_content(path, MAX_BYTES, "table of a spring tester"), path.name),
        path.name,
        max_lines=MAX_LINES,
    )
    return force_height_in(table, path.name[:80], columns, length_unit, force_unit, free_length)


def force_height_in(
    table: TextTable,
    name: str,
    columns: tuple[str, ...],
    length_unit: str,
    force_unit: str,
    free_length: float | None,
) -> ForceHeight:
    """The stations in a table of numbers; as :func:`read_force_height`."""
    width, notes = table.rows.shape[1], []
    known = columns or tuple(column_meaning(word) for word in table.names)
    _check_columns(known, width, name)
    along = known.index("height" if "height" in known else "compression")
    length = column_scale(length_unit or table.units[along], "length", "length_unit", name)
    force = column_scale(
        force_unit or table.units[known.index("force")], "force", "force_unit", name
    )
    heights, forces = table.rows[:, along] * length, table.rows[:, known.index("force")] * force
    if known[along] == "compression":
        if free_length is None:
            raise InputError(
                f"{name} holds compressions, so the free length is needed; give it", "free_length"
            )
        heights = free_length - heights
    refuse_beyond(heights, "m", f"the height in {name}")
    refuse_beyond(forces, "N", f"the force in {name}")
    if heights.min() <= 0:
        raise InputError(
            f"a height in {name} is not above zero; correct it, or say which column is what"
        )
    if np.mean(forces) < 0:
        forces = -forces
        notes.append(
            "the forces of the table are negative where the spring presses; their sign was turned"
        )
    if "ignore" in known:
        notes.append(
            f"left out as requested: column {', '.join(str(k + 1) for k, word in enumerate(known) if word == 'ignore')}"
        )
    return _branches(heights, forces, name, notes)


def _check_columns(known: tuple[str, ...], width: int, name: str) -> None:
    for word in known:
        if word and word not in COLUMNS:
            raise InputError(
                f"a column is one of {', '.join(COLUMNS)}, not '{word[:40]}'; correct the list",
                "columns",
            )
    if len(known) != width:
        raise InputError(
            f"{name} has {width} columns and {len(known)} are given; say what each is", "columns"
        )
    if (
        "" in known
        or known.count("force") != 1
        or known.count("height") + known.count("compression") != 1
    ):
        raise InputError(
            f"{name} does not say which of its {width} columns is what; give it, such as 'height, force' ({', '.join(COLUMNS)})",
            "columns",
        )


def column_meaning(name: str) -> str:
    """What a column is by its heading: ``height``, ``compression`` or ``force``; empty where the
    heading does not give it.

    >>> column_meaning("Kraft"), column_meaning("deflection")
    ('force', 'compression')
    """
    return next((word for pattern, word in _MEANINGS if re.search(pattern, name.lower())), "")


def column_scale(unit: str, dimension: str, question: str, name: str) -> float:
    """SI value of a column's unit, as testers write it (in, kg, kp and lb too); :class:`InputError`
    at ``question`` where it is none.
    """
    standard = {"in": "inch", "kp": "kgf", "kg": "kgf", "lb": "lbf", "lbs": "lbf"}.get(
        unit.lower(), unit
    )
    if not standard:
        raise InputError(
            f"{name} does not say the unit of its {dimension} ({question}), such as {'mm' if dimension == 'length' else 'N'}; "
            "answer it",
            question,
        )
    try:
        fits = dimension_of(standard) == dimension
    except InputError:
        fits = False
    if not fits:
        raise InputError(
            f"'{unit[:40]}' is no unit of {dimension}; use one such as {'mm' if dimension == 'length' else 'N'}",
            question,
        )
    return unit_factor(standard)


def _branches(heights: Array, forces: Array, name: str, notes: list[str]) -> ForceHeight:
    """Loading and unloading, separated at the smallest height; their mean where they overlap."""
    if len(heights) < MIN_STATIONS:
        raise InputError(
            f"{name} holds {len(heights)} stations; {MIN_STATIONS} or more are needed for the curve of a spring (a card needs two loads only)"
        )
    turn = int(np.argmin(heights))
    down, up = np.arange(turn + 1), np.arange(turn, len(heights))[::-1]
    if len(down) < len(up):
        down, up = up, down
    order = down[np.argsort(-heights[down], kind="stable")]
    loaded, force = _unique(heights[order], forces[order])
    hysteresis = 0.0
    if len(up) >= MIN_STATIONS:
        back = up[np.argsort(-heights[up], kind="stable")]
        other, returned = _unique(heights[back], forces[back])
        inside = (loaded <= other[0]) & (loaded >= other[-1])
        half = (force[inside] - np.interp(loaded[inside], other[::-1], returned[::-1])) / 2
        force = force.copy()
        force[inside] -= half
        hysteresis = float(np.max(np.abs(half))) if half.size else 0.0
        notes.append(
            f"loading and unloading are both there: their mean is taken, they differ by up to {2 * hysteresis:.3g} N"
        )
    if (
        len(loaded) < MIN_STATIONS
        or force[-1] <= force[0]
        or np.corrcoef(loaded, force)[0, 1] > -0.8
    ):
        raise InputError(
            f"the force in {name} does not rise as the height falls; check which column is what and the units"
        )
    return ForceHeight(loaded, force, hysteresis, tuple(notes))


def _unique(heights: Array, forces: Array) -> tuple[Array, Array]:
    """Falling heights, the mean force where a height, to a picometre, occurs more than once."""
    places, index = np.unique(np.round(-heights, 12), return_inverse=True)
    return -places, np.bincount(index, forces) / np.bincount(index)
