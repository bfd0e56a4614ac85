"""Measurements of an identification file: tables of values, curves, frequencies, events and
traces -> data and the targets that are computed for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from valvetrain.errors import InputError
from valvetrain.explore.files import Amount, Amounts, Names
from valvetrain.explore.outputs import Run
from valvetrain.explore.posterior import Datum
from valvetrain.measured.force_height import column_meaning, column_scale
from valvetrain.measured.tables import TextTable, read_content, read_text_table, text_of
from valvetrain.parameters.bounded_file import MAX_BYTES
from valvetrain.parameters.schema_types import Line, StrictModel, guarded, problem, validate_as
from valvetrain.solution.definition import definition_of, no_quantity
from valvetrain.units import format_quantity, parse_quantities, parse_quantity, unit_factor
from valvetrain.units.text import split_quantity

#: What a column of a measured curve is.
CURVE = ("height", "compression", "force", "ignore")
#: Most data of one measurement.
MAX_DATA = 5000


@dataclass(frozen=True, slots=True)
class Target:
    """One number: a named ``quantity``; the ``force`` of a spring at a compression ``at`` (m from
    the free state) or its ``load`` at a height ``at`` (m between its seats), ``name`` being the
    spring (empty: the only one); the cam angle of the event number ``at`` (from 1) of the kind
    ``name``; the channel ``name`` at the cam angle ``at`` (rad).
    """

    station: Run
    kind: Literal["quantity", "force", "load", "event", "channel"]
    name: str = ""
    at: float = 0.0

    @property
    def key(self) -> str:
        """What data and outcomes know it by."""
        of = f" of {self.name}" if self.name else ""
        match self.kind:
            case "quantity":
                key = self.name
            case "force":
                key = f"force{of} at {1e3 * self.at:.6g} mm"
            case "load":
                key = f"load{of} at a height of {1e3 * self.at:.6g} mm"
            case "event":
                key = f"{self.name} {self.at:.0f} cam angle"
            case "channel":
                key = f"{self.name} at {format_quantity(self.at, 'deg')}"
        return ": ".join(filter(None, (self.station.label, key)))

    @property
    def unit(self) -> str:
        """Unit it is shown in; empty where it is not known."""
        if self.kind in ("force", "load"):
            return "N"
        return "deg" if self.kind == "event" else definition_of(self.name).shown_unit


#: A target, its measured value (SI) and the standard deviation (SI) of its errors.
Rows = list[tuple[Target, float, float]]
TargetData = list[tuple[Target, Datum]]


class StationModel(StrictModel):
    """Where something is measured or predicted."""

    engine_speed: Amount | None = None
    spring_model: str = ""
    spring_set: str = ""

    @property
    def station(self) -> Run:
        """The same in SI. Raises a located problem for a speed that is not positive."""
        speed = None
        if self.engine_speed is not None:
            speed = self.amount("engine_speed", "angular speed")
            if not speed > 0:
                raise problem(
                    "is not positive; give the speed of the crank, such as '4200 rpm'",
                    ("engine_speed",),
                )
        return Run(speed, self.spring_model, self.spring_set)

    def amount(self, key: str, dimension: str | None) -> float:
        """The value (SI) of a key."""
        return float(guarded(parse_quantity, getattr(self, key), dimension, path=(key,)))

    def amounts(self, key: str, dimension: str | None) -> list[float]:
        """The values (SI) of a key."""
        path = (type(self).model_fields[key].alias or key,)
        return list(guarded(parse_quantities, getattr(self, key), dimension, path=path))


class PredictionModel(StationModel):
    """A ``[predictions.NAME]`` table: a number that is computed for the draws without having been
    measured.
    """

    quantity: str

    @property
    def target(self) -> Target:
        """What is computed. Raises a located problem for a name that is no quantity's."""
        if not definition_of(self.quantity).dimension:
            raise problem(no_quantity(self.quantity), ("quantity",))
        return Target(self.station, "quantity", self.quantity)


class _Measurement(StationModel):
    """What all ``[measurements.NAME]`` tables share: ``scatter``, the standard deviation of the
    errors (an amount, or a share of the value in per cent), and whether they ``fit``.
    """

    scatter: Amount | None = None
    fit: bool = True
    source: Line = ""

    def rows(self, folder: Path, any_name: bool) -> Rows:
        """What was measured. ``folder``: of the files it names; ``any_name``: quantities are those
        of an evaluator, of any name. Raises problems with their key.
        """
        raise NotImplementedError

    def spread(self, value: float, dimension: str | None) -> float:
        """Standard deviation (SI) of a measured value (SI)."""
        key, given = "scatter", self.scatter
        if given is None:
            raise problem(
                "is missing; give the standard deviation of the errors, such as '2 N' or '1 %'",
                (key,),
            )
        share = isinstance(given, str) and given.strip().endswith("%")
        found = self.amount(key, "ratio" if share else dimension) * (abs(value) if share else 1.0)
        if not found > 0:
            raise problem(f"is {given!s:.40}; a standard deviation is positive", (key,))
        return found

    def moving(self) -> Run:
        """The station of what has no value at rest."""
        if self.engine_speed is None:
            raise problem("was measured in motion; give its engine_speed")
        return self.station

    def paired(self, targets: Sequence[Target], values: Sequence[float], unit: str) -> Rows:
        """Rows of a curve or a trace."""
        if len(targets) != len(values):
            raise problem(
                f"has {len(targets)} places and {len(values)} values; give as many of each"
            )
        if len(set(targets)) != len(targets):
            raise problem("names a place twice; give each once, with the mean of its values")
        return [
            (one, value, self.spread(value, unit))
            for one, value in zip(targets, values, strict=True)
        ]


class _Quantity(_Measurement):
    """A named quantity."""

    quantity: str
    value: Amount

    def rows(self, folder: Path, any_name: bool) -> Rows:
        dimension = definition_of(self.quantity).dimension or None
        if dimension is None and not any_name:
            raise problem(no_quantity(self.quantity))
        value = self.amount("value", dimension)
        if dimension is None:  # that of an evaluator has the dimension of its unit
            dimension = split_quantity(str(self.value), None, "value")[1]
        target = Target(self.station, "quantity", self.quantity)
        return [(target, value, self.spread(value, dimension))]


class _Frequencies(_Measurement):
    """Natural frequencies from the mode ``first_mode`` on."""

    natural_frequencies: Annotated[Amounts, Field(alias="frequencies")]
    first_mode: Annotated[int, Field(ge=1)] = 1

    def rows(self, folder: Path, any_name: bool) -> Rows:
        return [
            (
                Target(self.station, "quantity", f"mode_{number}_frequency"),
                value,
                self.spread(value, "frequency"),
            )
            for number, value in enumerate(
                self.amounts("natural_frequencies", "frequency"), self.first_mode
            )
        ]


class _Event(_Measurement):
    """The event of a kind, by its ``number`` in order of angle."""

    event: str
    number: Annotated[int, Field(ge=1)] = 1
    cam_angle: Amount

    def rows(self, folder: Path, any_name: bool) -> Rows:
        angle = self.amount("cam_angle", "angle") % (2 * np.pi)
        target = Target(self.moving(), "event", self.event, float(self.number))
        return [(target, angle, self.spread(angle, "angle"))]


class _Table(_Measurement):
    """What may be given as a ``file``, with the ``units`` of its columns where its headings have
    none.
    """

    file: str = ""
    units: Names = Field(default_factory=list)

    def table(self, folder: Path) -> TextTable:
        """The table of the file."""
        path = folder / self.file
        found = read_text_table(
            text_of(read_content(path, MAX_BYTES, "table"), path.name), path.name
        )
        if found.rows.shape[1] < 2:
            raise InputError(
                f"'{path.name[:60]}' has one column; give places and values side by side"
            )
        return found

    def units_of(self, table: TextTable, places: tuple[int, int], example: str) -> tuple[str, str]:
        """Units of two columns: those of the headings, or ``units``, a text for every column of the
        file or for the two alone.
        """
        if len(self.units) == 2 and table.rows.shape[1] > 2:
            return self.units[0], self.units[1]
        units = self.units or table.units
        if len(units) <= max(places) or not all(units[place] for place in places):
            raise InputError(
                f"'{self.file[:60]}' has no units; write them in its headings, or units = {example}"
            )
        return units[places[0]], units[places[1]]


class _Trace(_Table):
    """A channel over the cam angle."""

    channel: str
    cam_angles: Amounts | None = None
    values: Amounts | None = None

    def rows(self, folder: Path, any_name: bool) -> Rows:
        station = self.moving()
        if self.file:
            angles, values, unit = guarded(self._of_file, folder, path=("file",))
        else:
            angles, values = self.amounts("cam_angles", "angle"), self.amounts("values", None)
            last = self.values[-1] if isinstance(self.values, list) and self.values else self.values
            unit = split_quantity(str(last).split(",")[-1].strip(), None, "values")[1]
        return self.paired(
            [Target(station, "channel", self.channel, at) for at in angles], values, unit
        )

    def _of_file(self, folder: Path) -> tuple[list[float], list[float], str]:
        """Cam angles (rad), values (SI) and their unit, from the first two columns."""
        table = self.table(folder)
        units = self.units_of(table, (0, 1), '["deg", "N"]')
        if "crank" in table.names[0].lower():
            raise InputError(
                f"'{self.file[:60]}' calls its angles '{table.names[0][:40]}'; a trace is over the cam angle, so halve them"
            )
        parse_quantity(f"1 {units[0]}", "angle")
        angles, values = (table.rows[:, k] * unit_factor(units[k]) for k in (0, 1))
        return angles.tolist(), values.tolist(), units[1]


class _Curve(_Table):
    """Static forces over compressions from the free state, or loads over heights between the seats,
    of a ``spring``; of a file in columns whose headings, or ``columns``, say what they are.
    """

    compressions: Amounts | None = None
    heights: Amounts | None = None
    forces: Amounts | None = None
    columns: Names = Field(default_factory=list)
    spring: str = ""

    def rows(self, folder: Path, any_name: bool) -> Rows:
        station = Run(None, self.spring_model, self.spring_set)
        if self.file:
            kind, places, forces = guarded(self._of_file, folder, path=("file",))
        else:
            kind = "force" if self.heights is None else "load"
            places = self.amounts("compressions" if kind == "force" else "heights", "length")
            forces = self.amounts("forces", "force")
        targets = [Target(station, kind, self.spring, at) for at in places]
        return self.paired(targets, forces, "force")

    def _of_file(self, folder: Path) -> tuple[str, list[float], list[float]]:
        """Kind of target, places (m) and forces (N). Raises :class:`InputError` where nothing
        distinguishes heights from compressions, and for wrong or missing units.
        """
        table, name = self.table(folder), self.file[:60]
        meant = tuple(self.columns) or tuple(column_meaning(word) for word in table.names)
        if unknown := next((word for word in self.columns if word not in CURVE), ""):
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
        kind = "load" if "height" in meant else "force"
        places = (meant.index("height" if kind == "load" else "compression"), meant.index("force"))
        units = self.units_of(table, places, '["mm", "N"]')
        lengths, forces = (
            table.rows[:, place] * column_scale(unit, dimension, "units", name)
            for place, unit, dimension in zip(places, units, ("length", "force"), strict=True)
        )
        return kind, lengths.tolist(), forces.tolist()


#: What a measurement is known by: the key of its table that says so.
FORMS: dict[str, type[_Measurement]] = {
    "quantity": _Quantity, "frequencies": _Frequencies, "event": _Event, "channel": _Trace,
    "compressions": _Curve, "heights": _Curve, "file": _Curve,
}  # fmt: skip


def read_measurement(name: str, table: Any, folder: Path, any_name: bool = False) -> TargetData:
    """The data of the table of the measurement ``name``; arguments as
    the ``rows`` of a form.

    Raises :class:`InputError`, or a problem with its key, for what is missing, unknown, of a wrong
    unit or without a scatter.
    """
    form = next((FORMS[one] for one in FORMS if isinstance(table, dict) and one in table), None)
    if form is None:
        raise problem(f"gives nothing that was measured; give one of {', '.join(FORMS)}")
    model = validate_as(form, table)
    rows = model.rows(folder, any_name)
    if not 0 < len(rows) <= MAX_DATA:
        raise problem(f"holds {len(rows)} numbers; give 1 to {MAX_DATA}")
    return [
        (one, guarded(Datum, one.key, value, scatter, name, model.fit, model.source, one.unit))
        for one, value, scatter in rows
    ]  # fmt: skip
