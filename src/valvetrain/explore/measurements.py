"""Measurements of an identification file: tables of values, curves, frequencies, peaks, events and
traces -> data and the targets that are computed for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.part import Part
from valvetrain.explore.posterior import Datum
from valvetrain.measured.force_height import column_meaning, column_scale
from valvetrain.measured.tables import TextTable, read_content, read_text_table, text_of
from valvetrain.parameters.bounded_file import MAX_BYTES
from valvetrain.solution.definition import angle_name, definition_of, no_quantity
from valvetrain.units import format_quantity, parse_quantity, unit_factor
from valvetrain.units.text import split_quantity

Array = NDArray[np.float64]
Along = Literal["height", "compression"]
CURVE = ("height", "compression", "force", "ignore")


@dataclass(frozen=True, slots=True)
class Station:
    """Where something was measured: ``engine_speed`` (rad/s of the crank; None at rest), name of
    the spring model and set (empty: the
    case's own)."""

    engine_speed: float | None = None
    spring_model: str = ""
    spring_set: str = ""

    @property
    def shown_name(self) -> str:
        """How keys begin, empty at rest by the case's own model."""
        speed = (
            [] if self.engine_speed is None else [f"{format_quantity(self.engine_speed, 'rpm')}"]
        )
        return ", ".join([*speed, *filter(None, (self.spring_model, self.spring_set))])


@dataclass(frozen=True, slots=True)
class Target:
    """One number: a named ``quantity``; the ``force`` of a spring at a compression ``at`` (m from
    the free state) or its ``load`` at a
    height ``at`` (m between its seats), ``name`` being the spring (empty: the only one); the cam
    angle of the event number ``at`` (from 1)
    of the kind ``name``; the channel ``name`` at the cam angle ``at`` (rad)."""

    station: Station
    kind: Literal["quantity", "force", "load", "event", "channel"]
    name: str = ""
    at: float = 0.0

    @property
    def key(self) -> str:
        """What data and outcomes know it by."""
        if self.kind == "quantity":
            own = self.name
        elif self.kind == "force":
            own = f"force{' of ' + self.name if self.name else ''} at {1e3 * self.at:.6g} mm"
        elif self.kind == "load":
            own = f"load{' of ' + self.name if self.name else ''} at a height of {1e3 * self.at:.6g} mm"
        elif self.kind == "event":
            own = f"{self.name} {self.at:.0f} cam angle"
        else:
            own = f"{self.name} at {format_quantity(self.at, 'deg')}"
        return f"{self.station.shown_name}: {own}" if self.station.shown_name else own

    @property
    def unit(self) -> str:
        """Unit it is shown in; empty where it is not known."""
        if self.kind in ("force", "load"):
            return "N"
        return "deg" if self.kind == "event" else definition_of(self.name).shown_unit


def trace_file(part: Part, folder: Path) -> tuple[Array, Array, str]:
    """Cam angles (rad), values (SI) and their unit from the first two columns of the part's
    ``file``.

    Units are in the headings, or in ``units``. Raises :class:`InputError` for a column without a
    unit, and for a first one that is no
    angle or is called a crank angle.
    """
    try:
        table, name = _table(part, folder)
        units = _units(part, table, (0, 1), name, '["deg", "N"]')
        if "crank" in table.names[0].lower():
            raise InputError(
                f"'{name}' calls its angles '{table.names[0][:40]}'; a trace is over the cam angle, so halve them"
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
    neither distinguishes heights from compressions,
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
        read_text_table(text_of(read_content(path, MAX_BYTES, "table"), path.name), path.name),
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


#: What a measurement is known by: the key of its table that says so.
FORMS = ("quantity", "frequencies", "peak", "event", "channel", "compressions", "heights", "file")
LAWS = ("normal", "student")
#: Most data of one measurement.
MAX_DATA = 5000
TargetData = list[tuple[Target, Datum]]


def read_measurement(name: str, part: Part, folder: Path, own_names: bool = False) -> TargetData:
    """The data of one table. ``folder``: of the files that it names; ``own_names``: quantities are
    those of an evaluator, of any name.

    Raises :class:`InputError` with the place, for what is missing, unknown, of a wrong unit or
    without a scatter.
    """
    form = next((one for one in FORMS if part.has(one)), None)
    if form is None:
        raise InputError(
            f"gives nothing that was measured; give one of {', '.join(FORMS)}", part.where
        )
    station = read_station(part)
    rows = _READERS[form](part, station, folder, own_names)
    if not 0 < len(rows) <= MAX_DATA:
        raise InputError(f"holds {len(rows)} numbers; give 1 to {MAX_DATA}", part.where)
    law = part.text("errors", "normal", LAWS)
    freedom = part.plain("freedom", 4.0)
    used, source = part.truth("fit", True), part.text("source", "")
    part.finish()
    try:
        return [
            (one, Datum(one.key, value, scatter, name, law, freedom, used, source, one.unit))  # type: ignore[arg-type]
            for one, value, scatter in rows
        ]
    except InputError as error:
        raise InputError(error.reason, part.where) from None


def read_station(part: Part) -> Station:
    """Where something is measured or predicted. Raises :class:`InputError` for a speed that is not
    positive.
    """
    speed = part.amount("engine_speed", "angular speed")[0] if part.has("engine_speed") else None
    if speed is not None and not speed > 0:
        raise InputError(
            "is not positive; give the speed of the crank, such as '4200 rpm'",
            part.place("engine_speed"),
        )
    return Station(speed, part.text("spring_model", ""), part.text("spring_set", ""))


Rows = list[tuple[Target, float, float]]


def _quantity(part: Part, station: Station, folder: Path, own_names: bool) -> Rows:
    name = part.text("quantity")
    dimension = _dimension(name, part, own_names)
    value, unit = part.amount("value", dimension)
    return [
        (
            Target(station, "quantity", name),
            value,
            _scatter(part, "scatter", value, dimension if dimension is not None else unit),
        )
    ]


def _frequencies(part: Part, station: Station, folder: Path, own_names: bool) -> Rows:
    values = part.amounts("frequencies", "frequency")
    first = part.plain("first_mode", 1.0)
    if first < 1 or first != int(first):
        raise InputError("is no number of a mode; give 1, 2 ...", part.place("first_mode"))
    return [
        (
            Target(station, "quantity", f"mode_{number}_frequency"),
            value,
            _scatter(part, "scatter", value, "frequency"),
        )
        for number, value in enumerate(values, start=int(first))
    ]


def _peak(part: Part, station: Station, folder: Path, own_names: bool) -> Rows:
    name = part.text("peak")
    dimension = _dimension(name, part, own_names)
    value, unit = part.amount("value", dimension)
    angle = part.amount("cam_angle", "angle")[0]
    try:
        place = angle_name(name)
    except InputError as error:
        raise InputError(error.reason, part.place("peak")) from None
    return [
        (
            Target(station, "quantity", name),
            value,
            _scatter(part, "scatter", value, dimension if dimension is not None else unit),
        ),
        (
            Target(station, "quantity", place),
            angle,
            _scatter(part, "angle_scatter", angle, "angle"),
        ),
    ]


def _event(part: Part, station: Station, folder: Path, own_names: bool) -> Rows:
    _moving(part, station)
    kind, number = part.text("event"), part.plain("number", 1.0)
    if number < 1 or number != int(number):
        raise InputError("is no number of an event; count from 1", part.place("number"))
    angle = part.amount("cam_angle", "angle")[0] % (2 * np.pi)
    return [
        (Target(station, "event", kind, number), angle, _scatter(part, "scatter", angle, "angle"))
    ]


def _channel(part: Part, station: Station, folder: Path, own_names: bool) -> Rows:
    _moving(part, station)
    name = part.text("channel")
    if part.has("file"):
        angles, values, unit = trace_file(part, folder)
    else:
        angles, values = (
            np.array(part.amounts("cam_angles", "angle")),
            np.array(part.amounts("values")),
        )
        unit = str(part.table.get("values"))
        unit = split_quantity(unit.split(",")[-1].strip(), None, "")[1]
    return [
        (
            Target(station, "channel", name, float(angle)),
            float(value),
            _scatter(part, "scatter", float(value), unit),
        )
        for angle, value in _pairs(part, angles, values)
    ]


def _curve(part: Part, station: Station, folder: Path, own_names: bool) -> Rows:
    spring = part.text("spring", "")
    if part.has("file"):
        along, places, forces = curve_file(part, folder)
    else:
        along = "height" if part.has("heights") else "compression"
        places, forces = (
            np.array(part.amounts(f"{along}s", "length")),
            np.array(part.amounts("forces", "force")),
        )
    at_rest = Station(None, station.spring_model, station.spring_set)
    return [
        (
            Target(at_rest, "load" if along == "height" else "force", spring, place),
            force,
            _scatter(part, "scatter", force, "force"),
        )
        for place, force in _pairs(part, places, forces)
    ]


_READERS = {
    "quantity": _quantity, "frequencies": _frequencies, "peak": _peak, "event": _event, "channel": _channel, "compressions": _curve,
    "heights": _curve,
    "file": _curve,
}  # fmt: skip


def _dimension(name: str, part: Part, own_names: bool) -> str | None:
    """Dimension of a quantity, None where its name does not show it. Raises :class:`InputError` for a
    name that is no quantity's.
    """
    row = definition_of(name)
    if not row.dimension and not own_names:
        raise InputError(no_quantity(name), part.where)
    return row.dimension or None


def _scatter(part: Part, key: str, value: float, unit: str) -> float:
    """Standard deviation (SI): an amount, or a share of the value in per cent."""
    given = part.take(key)
    if given is None:
        raise InputError(
            "is missing; give the standard deviation of the errors, such as '2 N' or '1 %'",
            part.place(key),
        )
    if isinstance(given, str) and given.strip().endswith("%"):
        found = abs(value) * parse_quantity(given, "ratio", part.place(key))
    else:
        text = (
            str(given) if isinstance(given, (int, float)) and not isinstance(given, bool) else given
        )
        found = parse_quantity(text, unit, part.place(key))
    if not found > 0:
        raise InputError(f"is {given!s:.40}; a standard deviation is positive", part.place(key))
    return found


def _moving(part: Part, station: Station) -> None:
    if station.engine_speed is None:
        raise InputError("was measured in motion; give its engine_speed", part.where)


def _pairs(part: Part, places: Array, values: Array) -> list[tuple[float, float]]:
    if len(places) != len(values):
        raise InputError(
            f"has {len(places)} places and {len(values)} values; give as many of each", part.where
        )
    if len(set(places.tolist())) != len(places):
        raise InputError(
            "names a place twice; give each once, with the mean of its values", part.where
        )
    return list(zip(places.tolist(), values.tolist(), strict=True))
