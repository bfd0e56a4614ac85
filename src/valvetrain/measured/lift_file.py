"""Reads tables of lifts: recognises the form by content, answers what the file leaves open, parts it into the
events it holds, and compares velocity columns with the lift.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from valvetrain import registry
from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.contours import Follower, lift_of_contour
from valvetrain.measured.door import refuse_beyond
from valvetrain.measured.lift_formats import COLUMN_NAMES, LIFTS, LiftColumns
from valvetrain.measured.stations import Dust, base_of, dust_of, events_of, turned
from valvetrain.measured.tables import read_content
from valvetrain.solution.display import Shown
from valvetrain.units import dimension_of, unit_factor

#: Source of an answer: the file itself, the user (``asked``), or an assumption, which is reported.
Teller = Literal["file", "asked", "assumed"]


@dataclass(frozen=True, slots=True)
class Answer:
    """One question that every table of lifts raises, its answer and who gave it."""

    question: str
    answer: str
    by: Teller


@dataclass(frozen=True, eq=False)
class MeasuredLift(Shown):
    """Lifts (m) of one lobe at cam angles (rad), both (stations,), rising in angle, before any
    smoothing.

    ``name``: lift, intake or exhaust, with a number where there are more. ``lift_of``: valve or tappet. ``form``: name of the format
    the file had. ``answers``: what the stations mean and who said so. ``notes``: sentences on columns
    that were left out. ``misfits``: column of velocity or acceleration -> root mean square of its difference from the
    derivative of the lift as a share of its peak, infinite for one of the other sign. ``dust``: bumps that no lift has, and
    whether they were ``mended``, which takes their stations out. ``changes``: what was turned to make a lift of the table.
    ``contour``: polar angles (rad) and radii (m), where the lift was made of them.

    >>> lift = MeasuredLift("lift", np.radians([100.0, 101.0]), np.array([0.0, 1e-4]), "valve", "columns")
    >>> lift
    MeasuredLift 'lift' of the valve: 2 stations, 100 to 101 cam deg, largest station 0.1000 mm
    """

    name: str
    cam_angles: Array
    lifts: Array
    lift_of: str
    form: str
    zero: str = ""
    answers: tuple[Answer, ...] = ()
    notes: tuple[str, ...] = ()
    misfits: Mapping[str, float] = field(default_factory=dict)
    dust: tuple[Dust, ...] = ()
    mended: bool = False
    changes: tuple[str, ...] = ()
    contour: tuple[Array, Array] | None = None

    def __repr__(self) -> str:
        first, last = np.degrees(self.cam_angles[[0, -1]])
        return (
            f"MeasuredLift '{self.name}' of the {self.lift_of}: {len(self.lifts)} stations, {first:g} to {last:g} cam deg, "
            f"largest station {1e3 * self.lifts.max():.4f} mm"
        )


#: Question -> its possible answers; angles and lengths are specified by ``lift_unit`` and the like.
CHOICES = {
    "angle_of": ("cam", "crank"), "lift_of": ("valve", "tappet"), "angle_unit": ("deg", "rad"), "zero": ("file", "nose"),
    "direction": ("forward", "reversed")
}  # fmt: skip
#: Assumed where the question is open, and reported as such.
ASSUMED = {"angle_unit": "deg", "zero": "file", "direction": "forward"}
#: Questions of a table of fractions.
FRACTIONS = ("peak_lift", "duration", "opening")
#: Question -> how it reads in a refusal.
QUESTIONS = {
    "angle_of": "whether its angles are of the cam or the crank", "lift_of": "lift measured at the valve or the tappet",
    "lift_unit": "the unit of its lifts, such as mm or inch", "peak_lift": "the largest lift that its fractions mean",
    "duration": "the angle from the first to the last of its fractions", "opening": "the angle at which it begins"
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class LiftAnswers:
    """Answers to what a table of lifts leaves open; empty ones are left to the file.

    Parameters
    ----------
    angle_of : ``cam`` or ``crank``; two crank revolutions are one of the cam
    lift_of : ``valve`` or ``tappet``
    angle_unit : ``deg`` (assumed) or ``rad``
    lift_unit : any unit of length, such as ``mm``, ``inch``, ``thou``
    zero : ``file`` (assumed) leaves the angles of the table, ``nose`` puts zero at the place of
        largest lift
    direction : ``forward`` (assumed): the cam rotates with rising angle; ``reversed``: against it, so
        the table is mirrored
    columns : what each column is, of angle, lift, intake, exhaust, velocity, acceleration and
        ignore; needed beyond two columns
        that the headings do not name
    peak_lift, duration, opening : of a table of fractions: m; rad of the angle meant by
        ``angle_of``, length of the event and its begin

    >>> LiftAnswers(angle_of="cam", lift_of="tappet", lift_unit="inch").lift_unit
    'inch'
    """

    angle_of: str = ""
    lift_of: str = ""
    angle_unit: str = ""
    lift_unit: str = ""
    zero: str = ""
    direction: str = ""
    columns: tuple[str, ...] = field(default=())
    peak_lift: float | None = None
    duration: float | None = None
    opening: float | None = None
    mend: bool = False
    follower: str = ""

    def __post_init__(self) -> None:
        for question, choices in CHOICES.items():
            given = getattr(self, question)
            if given and given not in choices:
                raise InputError(
                    f"{question} is {' or '.join(choices)}, not '{given[:40]}'; give one of them",
                    question,
                )
        if self.lift_unit and dimension_of(self.lift_unit) != "length":
            raise InputError(
                f"lift_unit '{self.lift_unit[:40]}' is no length; use one such as mm or inch",
                "lift_unit",
            )
        for word in self.columns:
            if word not in COLUMN_NAMES:
                raise InputError(
                    f"a column is one of {', '.join(COLUMN_NAMES)}, not '{word[:40]}'; correct the list",
                    "columns",
                )


#: Larger files are no tables of lifts.
MAX_BYTES = 5_000_000
TURN = 2 * np.pi
#: Stations closer than this (rad) are one.
STEP = 1e-9
#: Level (m) of a base circle from which a table holds no lift, if it does not rise above twice that level.
CONTOUR = 6e-3


def read_lift(file: str | Path, answers: LiftAnswers | None = None) -> tuple[MeasuredLift, ...]:
    """The lobes in a file of lifts, as measured.

    Parameters
    ----------
    file : text of columns, s96, fractions of lift, a workbook, or a drawing of the cam (DXF); the content decides, not the name
    answers : what the file does not say itself, such as
        ``LiftAnswers(angle_of="cam", lift_of="tappet", lift_unit="mm")``

    Returns
    -------
    One MeasuredLift per lobe, cam rad and m, with every answer and who gave it

    Raises
    ------
    InputError : a file that cannot be read, a line that is no row, and one sentence with all
        questions that are left open

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp(), "own.txt")
    >>> rows = [f"{angle}; {max(0, 9 - angle * angle / 400)}" for angle in range(-80, 81)]
    >>> _ = file.write_text(chr(10).join(["crank angle [deg]; valve lift [mm]", *rows]))
    >>> read_lift(file)[0]
    MeasuredLift 'lift' of the valve: 161 stations, -40 to 40 cam deg, largest station 9.0000 mm
    """
    path = Path(file)
    return lifts_in(
        read_content(path, MAX_BYTES, "table of lifts"), path.name, answers or LiftAnswers()
    )


def lifts_in(content: bytes, name: str, answers: LiftAnswers) -> tuple[MeasuredLift, ...]:
    """The lobes in the ``content`` of a file called ``name``; as :func:`read_lift`."""
    formats = registry.names("lift_formats")
    forms = (registry.find("lift_formats", word) for word in formats)
    form = next((one for one in forms if one.recognise(content, name)), None)
    if form is None:
        raise InputError(
            f"'{name[:80]}' is neither text, a workbook nor a drawing; export the table of lifts as text (CSV) or XLSX, a contour as DXF"
        )
    found = form.read(content, name)
    if {"radius", "x", "y"} & set(answers.columns or found.columns):
        found, answers = _lifted(found, answers, name), replace(answers, columns=())
    elif found.form == "fractions":
        found, answers = _of_fractions(found, answers)
    columns = _columns(found, answers, name)
    known = _answered(found, columns, answers, name)
    notes, lobes = [], []
    if "ignore" in columns:
        notes.append(
            f"left out as requested: column {', '.join(str(place + 1) for place, word in enumerate(columns) if word == 'ignore')}"
        )
    turn = unit_factor(known["angle_unit"].answer) * (
        0.5 if known["angle_of"].answer == "crank" else 1.0
    )
    for place, word in enumerate(columns):
        if word not in LIFTS:
            continue
        turns = [at for at, before in enumerate(columns) if before == "angle" and at < place]
        angles = found.rows[:, turns[-1] if turns else columns.index("angle")] * turn
        rows = found.rows
        _check_angles(angles, name)
        if angles[0] > angles[-1]:
            angles, rows = angles[::-1], rows[::-1]
        lifts = rows[:, place] * unit_factor(known["lift_unit"].answer)
        refuse_beyond(lifts, "m", f"the {word} in {name[:80]}")
        misfits = {
            other: _misfit(rows[:, at], other, angles, lifts)
            for at, other in enumerate(columns)
            if other in ("velocity", "acceleration")
        }
        lobe = MeasuredLift(
            word, angles, lifts, known["lift_of"].answer, found.form, answers=tuple(known.values()), notes=tuple(notes),
            misfits=misfits, changes=found.changes, contour=found.contour
        )  # fmt: skip
        lobes += _events(lobe, answers.mend, name)
    names = [lobe.name for lobe in lobes]
    return tuple(
        replace(lobe, name=f"{lobe.name}-{names[: at + 1].count(lobe.name)}")
        if names.count(lobe.name) > 1
        else lobe
        for at, lobe in enumerate(lobes)
    )


def chosen_lobe(lobes: tuple[MeasuredLift, ...], name: str, file: str) -> MeasuredLift:
    """The lobe of a file that is called ``name``, which may be empty where there is one. Raises :class:`InputError`
    with the names that there are.
    """
    fits = [lobe for lobe in lobes if name in ("", lobe.name)]
    if len(fits) != 1:
        words = " and ".join(
            f"{lobe.name} ({np.degrees(_nose(lobe.cam_angles, lobe.lifts)):.0f} cam deg)"
            for lobe in lobes
        )
        raise InputError(
            f"{file[:80]} holds {words}, and a lift has one event; name one of them as lobe", "lobe"
        )
    return fits[0]


def _lifted(found: LiftColumns, answers: LiftAnswers, name: str) -> LiftColumns:
    """The lift that a contour of polar radii, or of x and y, gives the follower."""
    if not answers.follower:
        raise InputError(
            f"{name[:80]} holds the contour of a cam and no lift; say what it lifts as follower, such as 'flat' or 'roller 10 mm'",
            "follower",
        )
    columns = answers.columns or found.columns
    at = {word: place for place, word in enumerate(columns)}
    unit = (
        next((found.units[at[word]] for word in ("radius", "x") if word in at), "")
        or answers.lift_unit
    )
    if not unit or not ({"angle", "radius"} <= set(at) or {"x", "y"} <= set(at)):
        raise InputError(
            f"the contour in {name[:80]} needs angle and radius, or x and y, and the unit of its lengths (lift_unit)",
            "lift_unit",
        )
    if "radius" in at:
        size = unit_factor(answers.angle_unit or found.units[at["angle"]] or "deg")
        angles, radii = found.rows[:, at["angle"]] * size, found.rows[:, at["radius"]]
    else:
        x, y = found.rows[:, at["x"]], found.rows[:, at["y"]]
        angles, radii = np.mod(np.arctan2(y, x), TURN), np.hypot(x, y)
    refuse_beyond(angles, "rad", f"the angle in {name[:80]}")
    angles, places = np.unique(np.round(angles, 12), return_index=True)
    radii = radii[places] * unit_factor(unit)
    refuse_beyond(radii, "m", f"the radius in {name[:80]}")
    cam, lifts = lift_of_contour(angles, radii, Follower.of(answers.follower))
    said = {"angle_of": "cam", "lift_of": "tappet"}
    return replace(
        found,
        rows=np.column_stack([np.degrees(cam), 1e3 * lifts]),
        columns=("angle", "lift"),
        units=("deg", "mm"),
        said=said,
        contour=(angles, radii),
    )


def _of_fractions(found: LiftColumns, answers: LiftAnswers) -> tuple[LiftColumns, LiftAnswers]:
    """Fractions as angles (rad) and lifts (m), not numbers where an answer is missing, which is refused later."""
    opening, duration, peak = (
        math.nan if one is None else one
        for one in (answers.opening, answers.duration, answers.peak_lift)
    )
    rows = found.rows * (duration, peak) + (opening, 0.0)
    units = replace(answers, angle_unit="", lift_unit="")
    return replace(found, rows=rows, units=("rad", "m")), units


def _answered(
    found: LiftColumns, columns: tuple[str, ...], given: LiftAnswers, name: str
) -> dict[str, Answer]:
    """Question -> its answer: the user's, else the file's, else an assumption.

    Raises :class:`InputError` for an answer against the file, and one sentence with all questions that are left open.
    """
    units = [unit for unit, word in zip(found.units, columns, strict=True) if word in LIFTS and unit]  # fmt: skip
    said = {"lift_unit": "".join(units[:1]), "angle_unit": found.units[columns.index("angle")]}
    said |= found.said
    known: dict[str, Answer] = {}
    for question in ("lift_of", "lift_unit", "angle_of", "angle_unit", "zero", "direction"):
        asked, stated = getattr(given, question), said.get(question, "")
        if asked and stated and asked != stated:
            if not question.endswith("unit") or unit_factor(asked) != unit_factor(stated):
                raise InputError(
                    f"{question} is {asked} as requested, but the file says {stated}; leave the answer out or correct the file",
                    question,
                )
        by: Teller = "asked" if asked else "file" if stated else "assumed"
        known[question] = Answer(question, asked or stated or ASSUMED.get(question, ""), by)
    missing = [question for question, one in known.items() if not one.answer]
    if found.form == "fractions":
        missing += [one for one in FRACTIONS if getattr(given, one) is None]
    if missing:
        listed = "; ".join(f"{QUESTIONS[question]} ({question})" for question in missing)
        raise InputError(f"{name[:80]} does not say {listed}; answer it", missing[0])
    return known


def _columns(found: LiftColumns, answers: LiftAnswers, name: str) -> tuple[str, ...]:
    """What each column is. Raises :class:`InputError` for unnamed columns."""
    count = found.rows.shape[1]
    columns = answers.columns or found.columns
    if len(columns) != count:
        raise InputError(
            f"{name[:80]} has {count} columns, but columns names {len(columns)}; name each, with 'ignore' for others",
            "columns",
        )
    unknown = [str(place + 1) for place, word in enumerate(columns) if not word]
    if unknown:
        raise InputError(
            f"{name[:80]} has {count} columns and does not say what column {', '.join(unknown)} is; name all of them as columns, such as "
            "'angle, lift, velocity' (or ignore)",
            "columns",
        )
    if "angle" not in columns or not set(columns) & LIFTS:
        raise InputError(
            f"{name[:80]} needs a column of angles and one of lifts; name them as columns",
            "columns",
        )
    return columns


def _check_angles(angles: Array, name: str) -> None:
    if len(angles) < 8:
        raise InputError(
            f"{name[:80]} holds {len(angles)} stations; a table of lifts needs eight or more"
        )
    steps = np.diff(angles) * np.sign(angles[-1] - angles[0])
    if np.min(steps) <= STEP:
        place = int(np.argmin(steps))
        raise InputError(
            f"the angles of {name[:80]} do not run one way at row {place + 2} ({np.degrees(angles[place + 1]):g} cam deg); correct it"
        )
    if abs(angles[-1] - angles[0]) > TURN * (1 + 1e-9):
        raise InputError(
            f"{name[:80]} spans more than one cam revolution; say angle_of = 'crank' or cut it",
            "angle_of",
        )


def _misfit(values: Array, word: str, angles: Array, lifts: Array) -> float:
    """How far a velocity or acceleration column is off the derivative of the lift; it is not used otherwise."""
    slope = np.gradient(lifts, angles)
    if word == "acceleration":
        slope = np.gradient(slope, angles)
    size = float(np.dot(slope, slope))
    values = values / max(float(np.abs(values).max()), 1e-300)
    scale = float(np.dot(values, slope)) / size if size else 0.0
    apart = float(np.sqrt(np.mean((values - scale * slope) ** 2)))
    return apart if scale > 0 else math.inf


def _nose(angles: Array, lifts: Array) -> float:
    """Middle of what lifts nine tenths of the peak, which noise moves least (cam rad)."""
    high = angles[lifts >= lifts.min() + 0.9 * np.ptp(lifts)]
    return float((high[0] + high[-1]) / 2)


def _events(column: MeasuredLift, mend: bool, name: str) -> list[MeasuredLift]:
    """The events of one column, each as a lift that rises."""
    known = {one.question: one.answer for one in column.answers}
    angles, lifts, changes = column.cam_angles, column.lifts, list(column.changes)
    ends, near = float(np.median(lifts[[0, 1, -2, -1]])), float(np.ptp(lifts)) / 20
    whole = angles[-1] - angles[0] > TURN - 1.5 * float(np.median(np.diff(angles)))
    above, below = np.sum(lifts > lifts.max() - near), np.sum(lifts < lifts.min() + near)
    if above > 1.5 * below if whole else 2 * ends > lifts.max() + lifts.min():
        lifts = -lifts
        changes.append("falling lifts were turned to rise")
    base = base_of(lifts)
    if abs(base) > CONTOUR and lifts.max() - base < 2 * abs(base):
        raise InputError(
            f"{name[:80]} rests at {1e3 * base:.2f} mm, which is the radius of a base circle or a gauge far from zero; take that off, "
            "or head the columns of a contour angle and radius"
        )
    if known["direction"] == "reversed":
        angles, lifts = -angles[::-1], lifts[::-1]
    first = angles[0]
    angles, lifts = turned(angles, lifts)
    if angles[0] != first:
        changes.append("the table was begun on its base circle")
    nose, found = known["zero"] == "nose", []
    for event in events_of(angles, lifts):
        theta, lift = angles[event], lifts[event]
        dust = dust_of(theta, lift)
        if mend:
            clean = np.ones(len(theta), dtype=bool)
            for bump in dust:
                clean &= (theta < bump.first) | (theta > bump.last)
            theta, lift = theta[clean], lift[clean]
        if nose:
            theta = theta - _nose(theta, lift)
        found.append(
            replace(
                column, cam_angles=np.ascontiguousarray(theta), lifts=np.ascontiguousarray(lift),
                zero="at the nose of the lobe" if nose else "as in the file", dust=dust, mended=mend and bool(dust),
                changes=tuple(changes)
            )
        )  # fmt: skip
    return found
