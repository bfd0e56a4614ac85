"""Tables of a spring tester: force over height, or over travel from anywhere, as loaded and unloaded."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.stats import spearmanr

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError
from valvetrain.measured.door import Doubt, refuse_beyond
from valvetrain.measured.force_curve import Estimate, ForceCurve, force_curve
from valvetrain.measured.tables import UNIT_NAMES, TextTable, read_content, read_text_table, text_of
from valvetrain.units import dimension_of, unit_factor

#: Larger files, and more lines, are no tables of a spring tester.
MAX_BYTES, MAX_LINES = 20_000_000, 200_000
#: Pattern of a heading -> what the column is; the first that fits.
_MEANINGS = (
    (r"time|zeit|temps\b|tiempo|tempo\b|datum|date\b", "ignore"),
    (r"force|load|kraft|last\b|fuerza|carga|charge|effort|forza|carico|poids|weight|gewicht|peso\b|scale|waage|balance|mass[ea]?\b|\bf\b",
     "force"),
    (r"height|length|höhe|hoehe|länge|laenge|hauteur|longueur|altura|longitud|altezza|lunghezza|\bh\b|\bl\b", "height"),
    (r"compr|deflection|federweg|einfeder|stauch|écras|ecras|flèche|fleche|deflexi", "compression"),
    (r"travel|weg\b|stroke|hub\b|displacement|position|extension|crosshead|course|d[ée]placement|desplaz|recorrido|carrera|"
     r"posici|posizione|spostamento|corsa|messuhr|dial|\bs\b|\bx\b", "travel"),
)  # fmt: skip
#: What a column may be.
COLUMNS = ("height", "compression", "travel", "force", "ignore")
#: Units of force as testers and scales write them -> units of the package; masses mean their weight.
FORCE_UNITS = {
    "kg": "kgf", "kilograms": "kgf", "g": "gf", "p": "gf", "gram": "gf", "grams": "gf", "lb": "lbf", "lbs": "lbf", "pounds": "lbf",
    "oz": "ozf", "dan": "daN", "newton": "N", "newtons": "N", "n": "N", "kn": "kN", "mn": "mN"
}  # fmt: skip
#: Fewest stations of a table, and those from which on the shape of the curve is known.
FEWEST, MIN_STATIONS = 3, 6
#: Standard deviation of the spring's own force in the loop, over half its width: friction may act on
#: either stroke, or the loop be that of one of them.
FRICTION = 0.55
#: Reversals of the travel (share of its range) that part strokes, and most strokes of a test.
REVERSAL, MAX_STROKES = 0.03, 60


@dataclass(frozen=True, eq=False)
class ForceHeight:
    """Stations of a spring tester by falling height; SI, shapes (n,).

    ``heights`` (m) and ``forces`` (N) as loaded, mean of loading and unloading where both are
    there; ``loop`` (N) half of their difference, without stations where only one is there; ``notes``
    what was found in the table, ``doubts`` why it can hardly be. ``scatter`` (N): the least that the
    digits of the table leave; ``digit`` (m): the last of its heights. ``measured_from``: ``seat`` for
    heights that were read, ``zero`` and ``contact`` for the given ``free_length`` (m) less the travel
    from its zero or from contact on, ``travel`` where no free length was given, so that heights are
    negative travels.

    >>> import numpy as np
    >>> ForceHeight(np.array([40e-3, 36e-3]), np.array([100.0, 260.0]))
    ForceHeight: 2 stations, 40 to 36 mm, 100 to 260 N
    """

    heights: Array
    forces: Array
    loop: Array = field(default_factory=lambda: np.zeros(0))
    notes: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    scatter: float = 0.0
    digit: float = 0.0
    measured_from: Literal["seat", "zero", "contact", "travel"] = "seat"
    free_length: float | None = None

    def __repr__(self) -> str:
        reach = f"{1e3 * self.heights[0]:.4g} to {1e3 * self.heights[-1]:.4g} mm, {self.forces[0]:.4g} to {self.forces[-1]:.4g} N"
        return f"ForceHeight: {len(self.heights)} stations, {reach}"

    @property
    def hysteresis(self) -> float:
        """Largest half difference (N) between loading and unloading, 0 where only one is there."""
        return float(np.max(np.abs(self.loop), initial=0.0))

    @cached_property
    def curve(self) -> ForceCurve:
        """The curve over the travel, which is the negative height."""
        return force_curve(-self.heights, self.forces, self.scatter, self.digit)

    def force_at(self, height: float) -> Estimate:
        """Force (N) at a height (m). Where the free length makes the heights, it counts from contact."""
        value, deviation = self.curve.force_at(-height, self.measured_from == "contact")
        place = self.rate_at(height).value * self.place_deviation
        loop = FRICTION * self._loop_at(height)[1]
        return Estimate(value, float(np.linalg.norm([deviation, loop, place])))

    @property
    def place_deviation(self) -> float:
        """Standard deviation (m) that all heights share: of their last digit, where they were read."""
        return self.digit / 4 if self.measured_from in ("seat", "zero") else 0.0

    def bind(self) -> Estimate | None:
        """Height (m) at which the coils are bound; None where the stations end before, or have no heights."""
        bind = self.curve.bind()
        if bind is None or self.measured_from == "travel":
            return None
        contact = self.curve.contact().deviation if self.measured_from == "contact" else 0.0
        return Estimate(-bind.value, float(np.hypot(bind.deviation, contact)))

    def contact(self) -> Estimate:
        """Height (m) at which the spring begins to press."""
        contact = self.curve.contact()
        return Estimate(-contact.value, float(np.hypot(contact.deviation, self.place_deviation)))

    def rate_at(self, height: float) -> Estimate:
        """Rate (N/m) at a height (m)."""
        value, deviation = self.curve.rate_at(-height)
        return Estimate(value, float(np.hypot(deviation, FRICTION * self._loop_at(height)[0])))

    def _loop_at(self, height: float) -> tuple[float, float]:
        """Slope (N/m) and size (N) of half the loop about a height; 0 and 0 where none is there."""
        if not self.loop.size:
            return 0.0, 0.0
        away = np.abs(self.heights - height)
        near = away <= max(float(np.ptp(self.heights)) / 5, float(np.partition(away, 5)[5]))
        slope, level = np.polyfit(self.heights[near] - height, self.loop[near], 1)
        return float(slope), float(level)


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
    file : text of columns in any form: height (or compression, or travel from anywhere) and force
    columns : what each column is, of height, compression, travel, force and ignore; where the
        headings do not give it
    length_unit, force_unit : units of the columns, such as "mm" and "N"; where the headings do not
        give them
    free_length : m; makes heights of a travel, and is compared with the contact that heights show

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
    meanings = columns or tuple(column_meaning(word) for word in table.names)
    along, pressed = height_and_force(meanings, width, name)
    kind = meanings[along]
    length = column_scale(length_unit or table.units[along], "length", "length_unit", name)
    force = column_scale(force_unit or table.units[pressed], "force", "force_unit", name)
    with np.errstate(over="ignore"):  # what is too large is refused below
        places, forces = table.rows[:, along] * length, table.rows[:, pressed] * force
    refuse_beyond(places, "m", f"the {kind} in {name}")
    refuse_beyond(forces, "N", f"the force in {name}")
    if kind == "height" and places.min() <= 0:
        raise InputError(
            f"a height in {name} is not above zero; correct it, or say which column is what"
        )
    if -forces.min() > forces.max():
        forces = -forces
        notes.append(
            "the forces of the table are negative where the spring presses; their sign was turned"
        )
    if len(left_out := [str(k + 1) for k in range(width) if k not in (along, pressed)]):
        notes.append(f"column {', '.join(left_out)} is left out")
    falls = (
        kind == "height" or float(np.sum((places - places.mean()) * (forces - forces.mean()))) < 0
    )
    steps = table.last_digit(pressed) * force, table.last_digit(along) * length
    read = _branches(-places if falls else places, forces, name, notes)
    read = replace(read, scatter=_rounding(read, *steps), digit=steps[1])
    read = _tared(read) if kind == "height" else _from_contact(read, kind, free_length)
    if read.forces.max() <= 0:
        raise InputError(
            f"the spring of {name} presses at no station; check which column is the force and its zero"
        )
    read = replace(read, free_length=free_length)
    return replace(read, doubts=tuple(_doubts(read, name)))


def _rounding(read: ForceHeight, force_step: float, length_step: float) -> float:
    """Standard deviation (N) that rounding leaves in a station; neighbours that are rounded alike
    count together. Where stations are few, their places are not truer than their last digit.
    """
    rate = float(np.ptp(read.forces) / np.ptp(read.heights))
    spacing = float(np.ptp(read.heights)) / (len(read.heights) - 1)
    alike = max(1.0, force_step / (rate * spacing))
    places = rate * length_step if len(read.heights) < 12 and length_step < spacing else 0.0
    return float(np.hypot(force_step * np.sqrt(alike), places) / np.sqrt(12))


def _tared(read: ForceHeight) -> ForceHeight:
    """The same without the force that the tester shows before contact."""
    if not (quiet := read.curve.quiet_force):
        return read
    said = f"the tester shows {quiet:.3g} N before contact, which was taken off"
    return replace(read, forces=read.forces - quiet, notes=(*read.notes, said))


def _from_contact(read: ForceHeight, kind: str, free_length: float | None) -> ForceHeight:
    """Travels (negative heights so far) as heights: their zero is where the spring begins to press.

    The zero of a column of compressions is believed unless stations before contact, or a curve that
    one parabola describes down to contact, show another.
    """
    read = _tared(read)
    contact, start = read.curve.contact(), -float(read.heights[0])
    away = abs(contact.value) > max(4 * contact.deviation, 1e-3 * float(np.ptp(read.heights)))
    plain = read.curve.first > 0 or read.curve.near(start).share > 0.9
    zero = contact.value if kind == "travel" or (away and plain) else 0.0
    notes = read.notes
    if zero and away:
        where = "above" if zero > 0 else "below"
        notes = (*notes, f"the travel counts from {abs(zero) * 1e3:.3f} mm {where} the unloaded spring, which was taken off")  # fmt: skip
    source: Literal["zero", "contact", "travel"] = "contact" if zero else "zero"
    source = "travel" if free_length is None else source
    return replace(
        read, heights=read.heights + zero + (free_length or 0.0), notes=notes, measured_from=source
    )


def _doubts(read: ForceHeight, name: str) -> list[Doubt]:
    """What a spring and the given free length do not allow."""
    curve, doubts, free_length = read.curve, [], read.free_length
    travel, force = curve.elastic
    top = float(np.max(read.forces))
    half = len(travel) // 2
    if len(travel) >= 4:
        soft, stiff = (
            np.polyfit(travel[part], force[part], 1)[0] for part in (slice(0, half + 1), slice(half, None))
        )  # fmt: skip
        unsure = 4 * curve.scatter / float(np.ptp(travel)) * np.sqrt(48 / len(travel))
        if soft - stiff > 0.08 * soft + unsure:
            doubts.append(
                Doubt("Z104", f"the rate falls from {soft / 1e3:.3g} to {stiff / 1e3:.3g} N/mm as the spring is pressed, which no coil spring does",
                      name, "check the zero of the scale and of the travel, and that the spring stands square")
            )  # fmt: skip
    if read.measured_from == "seat" and free_length is not None:
        contact = read.contact()
        off = contact.value - free_length
        if abs(off) > max(4 * contact.deviation, 0.01 * free_length):
            doubts.append(
                Doubt("Z105", f"the spring begins to press at {contact.value * 1e3:.4g} mm, not at the free length of {free_length * 1e3:.4g} mm",
                      name, "measure the free length, or check the zero of the heights")
            )  # fmt: skip
    if free_length is not None and float(read.heights[-1]) <= 0.15 * free_length:
        doubts.append(
            Doubt("Z105", f"the table presses a free length of {free_length * 1e3:.4g} mm down to {read.heights[-1] * 1e3:.3g} mm",
                  name, "check the free length and the unit of the travel")
        )  # fmt: skip
    if read.hysteresis > 0.1 * top:
        doubts.append(
            Doubt("Z106", f"loading and unloading differ by up to {200 * read.hysteresis / top:.2g} % of the largest force",
                  name, "look for friction in the tester, and for a spring that rubs on a guide")
        )  # fmt: skip
    fall = float(np.max(np.maximum.accumulate(read.forces) - read.forces))
    if fall > 8 * curve.scatter + 0.01 * top:
        doubts.append(
            Doubt("Z107", f"the force falls by {fall:.2g} N while the spring is pressed further", name,
                  "look for a station whose travel or force is off, then correct or delete it")
        )  # fmt: skip
    if len(travel) >= 8 and curve.scatter > 0.02 * top:
        doubts.append(
            Doubt("Z107", f"a station scatters by {curve.scatter:.2g} N, {100 * curve.scatter / top:.2g} % of the largest force",
                  name, "measure again with a finer or steadier load cell")
        )  # fmt: skip
    return doubts


def height_and_force(meanings: tuple[str, ...], width: int, name: str) -> tuple[int, int]:
    """Numbers of the columns of height or travel and of force."""
    for word in meanings:
        if word and word not in COLUMNS:
            raise InputError(
                f"a column is one of {', '.join(COLUMNS)}, not '{word[:40]}'; correct the list",
                "columns",
            )
    if len(meanings) != width:
        raise InputError(
            f"{name} has {width} columns and {len(meanings)} are given; say what each is", "columns"
        )
    along = [k for k, word in enumerate(meanings) if word in ("height", "compression", "travel")]
    pressed = [k for k, word in enumerate(meanings) if word == "force"]
    if len(along) != 1 or len(pressed) != 1:
        raise InputError(
            f"{name} does not say which of its {width} columns is what; give it, such as 'height, force' ({', '.join(COLUMNS)})",
            "columns",
        )
    return along[0], pressed[0]


def column_meaning(name: str) -> str:
    """What a column is by its heading (English, German, French, Spanish, Italian); empty where the
    heading does not give it.

    >>> column_meaning("Kraft"), column_meaning("deflection"), column_meaning("Course")
    ('force', 'compression', 'travel')
    """
    return next((word for pattern, word in _MEANINGS if re.search(pattern, name.lower())), "")


def column_scale(unit: str, dimension: str, question: str, name: str) -> float:
    """SI value of a column's unit, as testers and scales write it; :class:`InputError`
    at ``question`` where it is none.
    """
    unit = unit.strip().rstrip(".")
    words = FORCE_UNITS if dimension == "force" else UNIT_NAMES
    standard = words.get(unit.lower(), unit.lower() if unit.isupper() else unit)
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


def _branches(travel: Array, forces: Array, name: str, notes: list[str]) -> ForceHeight:
    """Loading and unloading, separated where the travel turns; their mean where they overlap."""
    if len(travel) < FEWEST:
        raise InputError(
            f"{name} holds {len(travel)} stations; {FEWEST} or more make a curve (a card needs two loads only)"
        )
    pressing = _pressing(travel)
    down, up = np.flatnonzero(pressing), np.flatnonzero(~pressing)
    if len(down) < len(up):
        down, up = up, down
    loaded, force = _unique(travel[down], forces[down])
    loop = np.zeros(0)
    if len(up) >= MIN_STATIONS:
        other, returned = _unique(travel[up], forces[up])
        inside = (loaded >= other[0]) & (loaded <= other[-1])
        loop = np.where(inside, (force - np.interp(loaded, other, returned)) / 2, 0.0)
        force = force - loop
        notes.append(
            f"loading and unloading are both there: their mean is taken, they differ by up to {2 * np.max(np.abs(loop)):.3g} N"
        )
    if len(loaded) < FEWEST or force[-1] <= force[0] or spearmanr(loaded, force).statistic < 0.8:
        raise InputError(
            f"the force in {name} does not rise as the height falls; check which column is what and the units"
        )
    return ForceHeight(-loaded, force, loop, tuple(notes))


def _pressing(travel: Array) -> Flags:
    """Which stations are on a stroke of rising travel; all where their order is none of strokes."""
    reversal = REVERSAL * float(np.ptp(travel))
    turns, rising, extreme = [0], bool(travel[min(len(travel) - 1, 1)] >= travel[0]), 0
    for number, place in enumerate(travel.tolist()):
        back = (travel[extreme] - place) if rising else (place - travel[extreme])
        if back <= 0:
            extreme = number
        elif back > reversal:
            turns.append(extreme)
            rising, extreme = not rising, number
    pressing = np.ones(len(travel), dtype=bool)
    if len(turns) > min(MAX_STROKES, max(len(travel) / 6, 2)):
        return pressing
    rising = rising if len(turns) % 2 else not rising
    for start, end in zip(turns, [*turns[1:], len(travel)], strict=True):
        pressing[start:end] = rising
        rising = not rising
    return pressing


def _unique(travel: Array, forces: Array) -> tuple[Array, Array]:
    """Rising travels, the mean force where a travel, to a picometre, occurs more than once."""
    places, index = np.unique(np.round(travel, 12), return_inverse=True)
    return places, np.bincount(index, forces) / np.bincount(index)
