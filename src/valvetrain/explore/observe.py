"""Measurements of an identification file: values, natural frequencies and static curves -> data, and what a case gives in their
place: quantities, and forces over compression.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import vary
from valvetrain.explore.engine import Computation
from valvetrain.explore.evaluate import MODES, evaluate_case
from valvetrain.explore.files import Amount, Amounts, Names
from valvetrain.explore.outputs import Outcome, Run
from valvetrain.explore.posterior import Datum, Numbers
from valvetrain.explore.space import Space
from valvetrain.explore.store import versions_digest
from valvetrain.measured.force_height import column_meaning, column_scale, height_and_force
from valvetrain.measured.tables import read_content, read_text_table, text_of
from valvetrain.parameters.bounded_file import MAX_BYTES
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_types import Line, StrictModel, guarded, problem, validate_as
from valvetrain.quantities.request import PointRequest
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.statics import axial_frequencies, force_of
from valvetrain.solution.definition import definition_of, no_quantity
from valvetrain.solution.status import Status, reason
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.problem import Problem
from valvetrain.units import parse_quantities, parse_quantity
from valvetrain.units.text import split_quantity

#: Most data of one measurement.
MAX_DATA = 5000


@dataclass(frozen=True, slots=True)
class Target:
    """One number: a named ``quantity``; the ``force`` of a spring at a compression ``at`` (m from
    the free state) or its ``load`` at a height ``at`` (m between its seats), ``name`` being the
    spring (empty: the only one).
    """

    station: Run
    kind: Literal["quantity", "force", "load"]
    name: str = ""
    at: float = 0.0

    @property
    def key(self) -> str:
        """What data and outcomes know it by."""
        key = self.name
        if self.kind != "quantity":
            where = "a height of " if self.kind == "load" else ""
            key = f"{self.kind}{f' of {key}' if key else ''} at {where}{1e3 * self.at:.6g} mm"
        return ": ".join(filter(None, (self.station.label, key)))

    @property
    def unit(self) -> str:
        """Unit it is shown in; empty where it is not known."""
        return definition_of(self.name).shown_unit if self.kind == "quantity" else "N"


#: Targets, their measured values (SI), and the dimension of these.
Rows = tuple[list[Target], list[float], str | None]
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
        return [Target(self.station, "quantity", self.quantity)], [value], dimension


class _Frequencies(_Measurement):
    """Natural frequencies from the mode ``first_mode`` on."""

    natural_frequencies: Annotated[Amounts, Field(alias="frequencies")]
    first_mode: Annotated[int, Field(ge=1)] = 1

    def rows(self, folder: Path, any_name: bool) -> Rows:
        values = self.amounts("natural_frequencies", "frequency")
        modes = range(self.first_mode, self.first_mode + len(values))
        targets = [Target(self.station, "quantity", f"mode_{k}_frequency") for k in modes]
        return targets, values, "frequency"


class _Curve(_Measurement):
    """Static forces over compressions from the free state, or loads over heights between the seats,
    of a ``spring``; of a ``file`` in columns whose headings, or ``columns``, say what they are, as its headings or ``units``
    say in which unit.
    """

    file: str = ""
    columns: Names = Field(default_factory=list)
    units: Names = Field(default_factory=list)
    compressions: Amounts | None = None
    heights: Amounts | None = None
    forces: Amounts | None = None
    spring: str = ""

    def rows(self, folder: Path, any_name: bool) -> Rows:
        if self.file:
            heights, places, forces = guarded(self._of_file, folder / self.file, path=("file",))
        else:
            heights = self.heights is not None
            places = self.amounts("heights" if heights else "compressions", "length")
            forces = self.amounts("forces", "force")
        station = self.station._replace(engine_speed=None)
        kind: Literal["load", "force"] = "load" if heights else "force"
        return [Target(station, kind, self.spring, at) for at in places], forces, "force"

    def _of_file(self, path: Path) -> tuple[bool, list[float], list[float]]:
        """Whether its places are heights, the places (m) and forces (N). Raises :class:`InputError` where nothing
        distinguishes heights from compressions, and for wrong or missing units.
        """
        name = path.name[:60]
        table = read_text_table(text_of(read_content(path, MAX_BYTES, "table"), path.name), path.name)  # fmt: skip
        meanings = tuple(self.columns) or tuple(map(column_meaning, table.names))
        places = height_and_force(meanings, table.rows.shape[1], name)
        if meanings[places[0]] == "travel":
            raise InputError(
                f"'{name}' gives a travel from anywhere; give heights between the seats, or compressions from the free state"
            )
        units = dict(enumerate(self.units or table.units))
        if len(self.units) == 2 < table.rows.shape[1]:  # those of the two alone
            units = dict(zip(places, self.units, strict=True))
        lengths, forces = (
            table.rows[:, place] * column_scale(units.get(place, ""), dimension, "units", name)
            for place, dimension in zip(places, ("length", "force"), strict=True)
        )
        return meanings[places[0]] == "height", lengths.tolist(), forces.tolist()


#: What a measurement is known by: the key of its table that says so.
FORMS: dict[str, type[_Measurement]] = {
    "quantity": _Quantity, "frequencies": _Frequencies, "compressions": _Curve, "heights": _Curve, "file": _Curve,
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
    targets, values, dimension = model.rows(folder, any_name)
    if not 0 < len(targets) <= MAX_DATA:
        raise problem(f"holds {len(targets)} numbers; give 1 to {MAX_DATA}")
    if len(targets) != len(values):
        raise problem(f"has {len(targets)} places and {len(values)} values; give as many of each")
    if len(set(targets)) != len(targets):
        raise problem("names a place twice; give each once, with the mean of its values")
    return [
        (one, guarded(Datum, one.key, value, model.spread(value, dimension), name, model.fit, model.source, one.unit))
        for one, value in zip(targets, values, strict=True)
    ]  # fmt: skip


#: Status of a point of which a run does not complete.
IMPOSSIBLE = Status("refused", "the point cannot be computed")
#: What computes a spring at rest where no model is named: of a wire, of a card.
WIRE, CARD = "finite-element", "massless"
#: Preload and frequencies of the only spring, which a model alone gives in a fraction of the time that all numbers take.
_BY_MODEL = re.compile(r"preload|mode_(\d+)_frequency")


@dataclass(frozen=True, eq=False)
class Observed(Computation):
    """A ``case``, the ``space`` of what is varied and the ``targets`` to compute."""

    case: Case
    space: Space
    targets: tuple[Target, ...]

    @cached_property
    def tasks(self) -> tuple[Run, ...]:
        """Conditions of the targets, each once."""
        return tuple(dict.fromkeys(one.station for one in self.targets))

    @property
    def subject(self) -> Any:
        """Case, keys, targets and versions."""
        return [self.case.record().digest, self.space.identity, self.targets, versions_digest()]

    def evaluate(self, values: Iterable[float], task: Sequence[Any]) -> Outcome:
        """Values of the targets under the conditions of a task, by key."""
        try:
            case = vary(self.case, dict(zip(self.space, values, strict=True)))
            numbers = numbers_of(case, Run(*task), self.targets)
        except FAILURES as error:
            return Outcome(Status("refused", reason(error)))
        return Outcome(IMPOSSIBLE) if numbers is None else Outcome(values=numbers)


@dataclass(frozen=True, eq=False)
class FunctionPoints(Computation):
    """Points that a ``function`` computes from their values (SI); ``subject``: all that they depend on besides."""

    function: Callable[[Sequence[float]], Numbers]
    subject: Any = ""

    def evaluate(self, values: Iterable[float], task: Any) -> Outcome:
        """The outcome of one point."""
        numbers = self.function(tuple(values))
        return Outcome(IMPOSSIBLE) if numbers is None else Outcome(values=numbers)


def numbers_of(case: Case, station: Run, targets: Sequence[Target]) -> Numbers:
    """Values of those of the ``targets`` that belong to a ``station``, by key; None where it does not run. Raises as building
    and running do.
    """
    rest = station.spring_model if station.engine_speed is None else ""
    alone = rest not in ("", WIRE)
    here = [one for one in targets if one.station == station]
    whole = [
        one for one in here if one.kind == "quantity" and not (alone and _BY_MODEL.fullmatch(one.name))
    ]  # fmt: skip
    numbers = dict[str, float]()
    if whole:
        request = PointRequest(tuple(one.name for one in whole), rest)
        outcome = evaluate_case(case, station, request)
        if not outcome.status.completed:
            return None
        numbers = {one.key: outcome.values.get(one.name, np.nan) for one in whole}
    if len(whole) < len(here):
        problem = build(case, spring_set=station.spring_sets)
        rows = {one.key: _at_rest(problem, station, one) for one in here if one not in whole}
        numbers |= rows
    return numbers


def _at_rest(problem: Problem, station: Run, one: Target) -> float:
    """The number of a target that a spring model gives by itself."""
    spring = _spring(problem, "" if one.kind == "quantity" else one.name)
    word = station.spring_model or (WIRE if spring.wire is not None else CARD)
    if reason := spring_model(word).why_not(spring):
        raise InputError(reason, "spring_model")
    model, at = problem.model_of(word, spring), one.at
    if one.kind == "quantity":
        mode = _BY_MODEL.fullmatch(one.name)
        if mode is not None and mode[1]:
            frequencies = axial_frequencies(model, MODES).tolist()
            return float(dict(enumerate(frequencies, 1)).get(int(mode[1]), np.nan))
        at = spring.precompression
    if one.kind == "load":
        if spring.installed_height is None:
            raise InputError(
                f"the card of spring '{spring.name}' has no installed_height, so heights are not known; give compressions",
                "heights",
            )
        at = spring.installed_height + spring.precompression - at
    return float(force_of(spring, model, at))


def _spring(problem: Problem, name: str) -> InstalledSpring:
    springs = tuple(dict.fromkeys(problem.springs))  # variants of a train share them
    fits = [spring for spring in springs if name in ("", spring.name)]
    if len(fits) != 1:
        names = ", ".join(dict.fromkeys(f"'{spring.name}'" for spring in springs))
        called = f"are called '{name[:40]}'" if name else "could be meant"
        raise InputError(
            f"{len(fits) or 'no'} springs of the case {called}; give spring, one of {names}, and spring_set of a train",
            "spring",
        )
    return fits[0]
