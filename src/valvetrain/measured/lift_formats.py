"""Forms of lift files: how each is recognised and read."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.tables import UNIT_NAMES, TextTable, read_text_table, text_of
from valvetrain.measured.workbooks import MARKS, MAX_COLUMNS, MAX_ROWS, sheets_of

#: What a column may be.
COLUMN_NAMES = (
    "angle",
    "lift",
    "intake",
    "exhaust",
    "radius",
    "velocity",
    "acceleration",
    "ignore",
)


@dataclass(frozen=True, eq=False)
class LiftColumns:
    """What a file holds, before any question is answered.

    ``form``: name of the format. ``rows`` (stations, columns) in the file's own units. ``columns``:
    a name of :data:`COLUMN_NAMES` per column, empty where the file gives none. ``units``: one per
    column, likewise. ``said``: questions that the file itself answers, such as ``{"angle_of": "crank"}``. ``headings``: its lines of text.
    ``contour``: polar angles (rad) and radii (m) of which the lift was made. ``changes``: what was assumed to make the columns.
    """

    form: str
    rows: Array
    columns: tuple[str, ...]
    units: tuple[str, ...]
    said: Mapping[str, str] = field(default_factory=dict)
    headings: tuple[str, ...] = ()
    contour: tuple[Array, Array] | None = None
    changes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LiftFormat:
    """A form of lift files. ``recognise(content, name)`` examines the content alone; the name is for messages."""

    label: str
    recognise: Callable[[bytes, str], bool]
    read: Callable[[bytes, str], LiftColumns]


#: Pattern of a heading without accents -> what the column is; the first that fits.
_MEANINGS = (
    (r"acc|beschl|mm/deg2|mm/deg\^2", "acceleration"), (r"vel|geschw|speed|vitesse|mm/deg|in/deg", "velocity"),
    (r"radius|\bradi|rayon|raggio", "radius"), (r"^x\b", "x"), (r"^y\b", "y"), (r"intake|inlet|einlass|admission|aspiraz", "intake"),
    (r"exhaust|auslass|outlet|echappement|escape|scarico", "exhaust"),
    (r"lift|hub|levee|alza|displacement|rise|\bweg\b", "lift"),
    (r"angle|deg|winkel|theta|crank|cam|°|rotation|angulo|angolo|vilebrequin|grad", "angle")
)  # fmt: skip


def recognise_columns(content: bytes, name: str) -> bool:
    """Whether it is text at all."""
    return b"\0" not in content or content[:2] in (b"\xff\xfe", b"\xfe\xff")


def read_columns(content: bytes, name: str) -> LiftColumns:
    """The columns of a text, with what its headings say of them."""
    return from_table(read_text_table(text_of(content, name), name), "columns")


def from_table(table: TextTable, form: str) -> LiftColumns:
    """Columns with the meaning that headings give them, and what the headings say of crank, cam,
    valve and tappet.
    """
    steps = np.diff(table.rows, axis=0)
    one_way = [bool(np.all(step > 0) or np.all(step < 0)) for step in steps.T]
    columns = tuple(map(_column, table.names, one_way))
    units = tuple(_unit(unit) for unit in table.units)
    if (
        table.rows.shape[1] == 2
        and not {"radius", "x", "y"} & set(columns)
        and ("angle" not in columns or not set(columns) & LIFTS)
    ):
        columns = ("lift", "angle") if one_way == [False, True] else ("angle", "lift")
        fitting = ANGLE_UNITS, LIFT_UNITS
        units = tuple(
            unit if unit in fitting[word == "lift"] else ""
            for unit, word in zip(units, columns, strict=True)
        )
    said: dict[str, str] = {}
    text = _plain(" ".join((*table.names, *table.units, *table.headings)))
    for question, choices in (("angle_of", ("crank", "cam")), ("lift_of", ("valve", "tappet"))):
        found = [word for word in choices if re.search(_CHOICES[word], text)]
        if len(found) == 1:
            said[question] = found[0]
    if "angle_of" not in said and "deg" in units and "angle" in columns:
        turn = float(np.ptp(table.rows[:, columns.index("angle")]))
        said |= {"angle_of": "crank"} if TWO_TURNS < turn <= 720 else {}
    return LiftColumns(form, table.rows, columns, units, said, table.headings)


#: Units that an angle and a lift can have; columns that are lifts; degrees that only a crank turns for one of the cam.
ANGLE_UNITS, LIFT_UNITS = ("deg", "rad"), ("mm", "inch", "thou", "m", "cm", "um")
LIFTS, TWO_TURNS = frozenset({"lift", "intake", "exhaust"}), 700
#: Words of headings, without accents, by which a question is answered; where both answers occur the heading does not
#: decide.
_CHOICES = {
    "crank": r"\bcrank\b|°\s*kw\b|\bkw\b|degca\b|\bca\b|crankshaft|kurbel|vilebrequin|ciguenal|manovella|motore",
    "cam": r"\bcam(shaft)?\s*(angle|deg|rotation|°)|°\s*nw\b|\bnw\b|°\s*cam\b|deg\s*cam|nockenw|\bcames\b|\blevas\b|\bcamme\b"
    r"|angle (de )?came\b|angolo camma",
    "valve": r"\bvalve\s*lift|ventil\w*hub|levee (de |des )?(la )?soupape|alzata (della )?valvola|alzada (de )?(la )?valvula",
    "tappet": r"\b(tappet|lobe|cam|follower|lifter)\s*lift|stossel\w*hub|nocken\w*hub|tassen\w*hub|levee (de |du )?(la )?(came|poussoir)"
    r"|alzata (della )?(camma|punteria)|alzada (de )?(la )?(leva|taque)"
}  # fmt: skip


def _plain(text: str) -> str:
    """Text without accents and capitals: what is looked for in headings."""
    parts = unicodedata.normalize("NFKD", text.casefold())
    return "".join(mark for mark in parts if not unicodedata.combining(mark))


def _column(name: str, one_way: bool) -> str:
    """What a column is by its heading; an angle runs one way, and a lift does not."""
    words = _plain(name)
    meaning = (
        next((word for pattern, word in _MEANINGS if re.search(pattern, words)), "") if name else ""
    )
    if meaning == "angle" and not one_way:
        return "lift"
    return (
        "angle" if one_way and meaning in LIFTS and re.search(_MEANINGS[-1][0], words) else meaning
    )


def _unit(unit: str) -> str:
    return UNIT_NAMES.get(unit.lower().strip(), "")


COLUMNS_SPEC = LiftFormat("columns of a text", recognise_columns, read_columns)


def _numbers(content: bytes, name: str) -> Array:
    """The rows of a text of numbers, none where it is no such text."""
    try:
        return read_text_table(text_of(content, name), name).rows
    except InputError:
        return np.zeros((0, 0))


def recognise_fractions(content: bytes, name: str) -> bool:
    """Whether two columns run from (0, 0) over a largest lift of 1 to (1, 0)."""
    rows = _numbers(content, name)
    if rows.shape[1] != 2 or len(rows) < 5:
        return False
    place, lift = rows.T
    ends = (
        abs(place[0]) < 1e-6
        and abs(place[-1] - 1) < 1e-6
        and abs(lift[0]) < 0.02
        and abs(lift[-1]) < 0.02
    )
    return bool(
        ends and np.all(np.diff(place) > 0) and abs(lift.max() - 1) < 1e-3 and lift.min() > -0.02
    )


def read_fractions(content: bytes, name: str) -> LiftColumns:
    """The fractions; peak lift, duration and opening angle must be specified by the user."""
    table = read_text_table(text_of(content, name), name)
    return LiftColumns(
        "fractions", table.rows, ("angle", "lift"), ("", ""), headings=table.headings
    )


FRACTIONS_SPEC = LiftFormat("fractions of lift", recognise_fractions, read_fractions)


TURN, REPEATED = 360, 36


def recognise_s96(content: bytes, name: str) -> bool:
    """Whether the text holds 396 rows of one number."""
    return _numbers(content, name).shape == (TURN + REPEATED, 1)


def read_s96(content: bytes, name: str) -> LiftColumns:
    """The 360 lifts at whole cam degrees; its unit is not in the file.

    Raises :class:`InputError` when the last 36 rows neither repeat the first ones nor rest where
    they do.
    """
    table = read_text_table(text_of(content, name), name)
    lifts, again = table.rows[:TURN, 0], table.rows[TURN:, 0]
    allowed = 0.01 * float(np.ptp(lifts)) + 1e-12
    repeats = np.all(np.abs(again - lifts[:REPEATED]) <= allowed)
    rests = np.all(np.abs(again - lifts[0]) <= allowed) and abs(lifts[0] - lifts[-1]) <= allowed
    if not (repeats or rests):
        raise InputError(
            f"the last {REPEATED} rows of {name} neither repeat its first ones nor are on the base circle; export it again"
        )
    rows = np.column_stack([np.arange(TURN, dtype=float), lifts])
    said = {"angle_unit": "deg", "angle_of": "cam"}
    return LiftColumns("s96", rows, ("angle", "lift"), ("deg", ""), said, table.headings)


S96_SPEC = LiftFormat("s96 of cam analysers", recognise_s96, read_s96)


def recognise_workbook(content: bytes, name: str) -> bool:
    """Whether the content begins as a workbook does."""
    return content.startswith(MARKS)


def read_workbook(content: bytes, name: str) -> LiftColumns:
    """Columns of the first sheet with numbers. Raises :class:`InputError` where the extra is
    missing or no sheet holds a table.
    """
    sheets, fault = sheets_of(content, name), None
    for sheet in (one for one in sheets if not one.too_large):
        where = f"sheet '{sheet.title[:40]}' of {name}"
        try:
            return from_table(read_text_table(sheet.text, where), "workbook")
        except InputError as error:
            fault = error
            if sheet.numeric:
                raise
    large = next((one.title for one in sheets if one.too_large), None)
    if large is not None:
        raise InputError(
            f"sheet '{large[:40]}' of '{name[:80]}' has more than {MAX_ROWS} rows or {MAX_COLUMNS} columns, so it is no table of "
            "lifts; delete cells far from the table, or export the table as text"
        )
    raise InputError(
        f"no sheet of '{name[:80]}' holds rows of numbers; put the table on a sheet of its own"
    ) from fault


WORKBOOK_SPEC = LiftFormat("workbook", recognise_workbook, read_workbook)
