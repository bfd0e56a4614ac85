"""A published study as data: its names, how it read numbers, and what it claims."""

from __future__ import annotations

import math
import tomllib
from dataclasses import field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as table

from valvetrain import registry
from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.schema_types import AngularSpeed, first_problem
from valvetrain.quantities.compare import compare
from valvetrain.quantities.cycle import Cycle, Frame, reported_cycle
from valvetrain.quantities.signal import Window
from valvetrain.solution.display import value_text
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import Quantities, Quantity, same_speed, unit_of
from valvetrain.solution.result import Solution
from valvetrain.solution.study import LiftEvent, Study
from valvetrain.solution.uncertainty import Finding
from valvetrain.sources.reader import Reader, Sampling
from valvetrain.sources.readings import KNOWN_KEYS, Reading
from valvetrain.sources.rows import NAMES, SOURCES

#: Parts of the open valve over which two runs are compared.
Part = Literal["", "opening", "closing"]


@table(frozen=True, config=KNOWN_KEYS)
class Term:
    """One side of a claim: a ``value`` (SI), or ``times`` a ``quantity`` of the ``run`` of that label.

    With ``beside``, the label of another run, ``quantity`` is a channel: the root mean square of the
    difference of both runs while the rigid valve is open, or over a ``part`` of that.
    """

    run: str = ""
    quantity: str = ""
    value: float = math.nan
    times: float = 1.0
    beside: str = ""
    part: Part = ""

    def number(self, study: Study, engine_speed: float | None) -> float | None:
        """The SI value; None without such a run, NaN where the run has no such number."""
        if not self.run:
            return self.value
        pair = [run_of(study, label, engine_speed) for label in (self.run, self.beside) if label]
        if pair[0] is None or pair[-1] is None:
            return None
        if self.beside:
            return self.times * departure(pair[0], pair[-1], self.quantity, self.part)
        return self.times * pair[0].quantities.get(self.quantity, math.nan)

    def text(self, number: float, like: str = "") -> str:
        """A number of this side with its unit and its runs; a plain value in the unit of a quantity ``like`` it."""
        unit = "N" if self.beside else unit_of(self.quantity or like)
        if not self.run:
            return value_text(number, unit, 4)
        times = f"{self.times:g} times " if self.times != 1 else ""
        runs = f"{self.run} less {self.beside}" if self.beside else self.run
        return f"{value_text(number, unit, 4)} ({times}{runs})"


@table(frozen=True, config=KNOWN_KEYS)
class Claim:
    """A ``statement`` of a study at a ``place`` in it: ``left`` is greater than ``right``, or equal to it
    within a share.

    ``engine_speed`` in rad/s of the crank; None for the only one of each label.
    """

    place: str
    statement: str
    left: Term
    right: Term
    relation: Literal["greater", "equal"] = "greater"
    within: float = 0.0
    engine_speed: AngularSpeed | None = None

    def finding(self, study: Study) -> Finding | None:
        """The claim with the computed numbers; None where the study lacks one of the runs.

        A run without the number does not show what is claimed.
        """
        left, right = (one.number(study, self.engine_speed) for one in (self.left, self.right))
        if left is None or right is None:
            return None
        if math.isnan(left) or math.isnan(right):
            return Finding(self.place, self.statement, "no such number", "not seen")
        greater = self.relation == "greater"
        holds = left > right if greater else abs(left - right) <= self.within * abs(right)
        computed = f"{self.left.text(left)}, against {self.right.text(right, self.left.quantity)}"
        return Finding(self.place, self.statement, computed, "agrees" if holds else "not seen")


def run_of(study: Study, label: str, engine_speed: float | None) -> Solution | None:
    """The run of a label at an engine speed (rad/s; None: its first) that has numbers."""
    return next(
        (
            run
            for run in study.runs(label)
            if run.quantities
            and (engine_speed is None or same_speed(run.engine_speed, engine_speed))
        ),
        None,
    )


def departure(run: Solution, other: Solution, channel: str, part: Part = "") -> float:
    """Root mean square (SI) of a channel less that of another run over the open valve or a part of it;
    NaN where a run has no such channel.
    """
    if not (run.has(channel, "rigid_valve_lift") and other.has(channel)):
        return math.nan
    lift, mine, theirs = (
        run.channel("rigid_valve_lift"),
        run.channel(channel),
        other.channel(channel),
    )
    if len(theirs) != len(mine):
        theirs = np.interp(run.cam_angle, other.cam_angle, theirs, period=2 * np.pi)
    late = np.arange(len(lift)) > int(np.argmax(lift))
    parts = {"": lift > 0, "opening": (lift > 0) & ~late, "closing": (lift > 0) & late}
    return float(np.sqrt(np.mean((mine - theirs)[parts[part]] ** 2)))


@table(frozen=True, config=KNOWN_KEYS)
class Origin:
    """What produced a published value: its short ``sign``, and the label of the ``run`` to compare with."""

    sign: str
    run: str = ""


@table(frozen=True, config=KNOWN_KEYS)
class SourceStudy:
    """One published study; ``key``: its citation key and its name in the registry.

    ``description``: what it is, and what its names mean. ``case``: the library case that holds what it
    publishes. ``origins``: what produced a published value -> mark and run. ``counted``: words of its
    angles that are counted through a cycle. ``windows``: its names of the windows about the lift event;
    ``points``: coil number of each of its points on the wire. ``readings``: how it read numbers;
    ``sampling``: the samples that it stored. ``claims``: what it says of them.
    """

    key: str
    description: str = ""
    case: str = ""
    origins: dict[str, Origin] = field(default_factory=dict)
    counted: tuple[str, ...] = ()
    windows: dict[Window, str] = field(default_factory=dict)
    points: dict[str, float] = field(default_factory=dict)
    sampling: Sampling | None = None
    readings: tuple[Reading, ...] = ()
    claims: tuple[Claim, ...] = ()

    def reader(
        self, cycle: Cycle, event: LiftEvent | None, surge_frequency: float | None, **coils: float
    ) -> Reader:
        """What takes its readings of a cycle; ``surge_frequency`` in Hz, ``coils`` of points that the case moves."""
        speed = cycle.solution.engine_speed / 2
        period = speed / surge_frequency if surge_frequency else None
        return Reader(cycle, event, period, {**self.points, **coils}, self.sampling)

    def quantities(self, solution: Solution, frame: Frame) -> dict[str, float]:
        """Numbers of a run (SI) by the names of the study; what the run does not cover is absent."""
        if len(solution.time) < 3 or all(one.runs for one in self.readings):
            return {}
        coils = dict(frame.points)
        cycle = reported_cycle(solution)
        reader = self.reader(cycle, frame.lift_event, frame.surge_frequency, **coils)
        return reader.read(self.readings)

    def by_phase(self, study: Study) -> dict[Quantity, Array]:
        """Numbers of the runs that are compared, once for each phase of the samples that it stored."""
        found = dict[Quantity, Array]()
        sampled = [one for one in self.readings if one.sampled or one.kind == "difference"]
        labels = {origin.run for origin in self.origins.values()} if sampled else set()
        surge_frequency = study.still.get("", {}).get("mode_1_frequency")
        for run in study.solutions:
            if run.label in labels and len(run.time) > 2:
                reader = self.reader(reported_cycle(run), study.lift_event, surge_frequency)
                reader.read(sampled)
                for name, values in reader.phases.items():
                    found[Quantity(name, run.engine_speed, run.label)] = values
        return found

    def of_runs(self, study: Study) -> dict[Quantity, float]:
        """Quantities of one labelled run or of two at every engine speed at which they ran: the value, the
        share by which the first is above the second, or the difference.
        """
        found = dict[Quantity, float]()
        for reading in self.readings if study.solutions else ():
            for speed in study.engine_speeds if reading.runs else ():
                runs = [run_of(study, label, speed) for label in reading.runs]
                values = [run.quantities.get(reading.of[0], np.nan) for run in runs if run]
                if len(values) == len(runs):
                    first, second = values[0], values[-1]
                    rise = first / second - 1 if second > 0 else np.nan
                    kinds = {"run": first, "rise": rise, "difference": first - second}
                    found[Quantity(reading.names[0], speed)] = float(kinds[reading.kind])
        return {key: value for key, value in found.items() if np.isfinite(value)}


def published_by(key: str) -> tuple[PublishedValue, ...]:
    """The values that the study of that key publishes, for a case of one's own that names it.

    All are checks there: what such a case was fitted to is not known here. Nothing for a study
    without a library case. Raises :class:`InputError` for an unknown source.
    """
    source: SourceStudy = registry.find("sources", key)
    if not source.case:
        return ()
    return tuple(
        replace(one, role="check", used_for="") for one in load_case(source.case).published
    )


def against_source(study: Study) -> Study:
    """The study with comparisons and findings of the published study that its case re-runs.

    A study of a case of one's own, or of a changed one, is returned as it is. Raises
    :class:`InputError` for an unknown source.
    """
    record = study.record
    if record.changed or not (record.study or record.published):
        return study
    source: SourceStudy = (
        registry.find("sources", record.study) if record.study else SourceStudy("")
    )
    quantities = dict(study.quantities.items()) | source.of_runs(study)
    runs = {name: origin.run for name, origin in source.origins.items()}
    findings = filter(None, (claim.finding(study) for claim in source.claims))
    return replace(
        study,
        comparisons=compare(
            record.published,
            Quantities(quantities),
            runs if record.study else None,
            source.counted,
            source.by_phase(study),
        ),
        findings=(*study.findings, *findings),
    )


def read_source(path: Path) -> SourceStudy:
    """The study of a file; its name without ending is the key.

    Raises :class:`InputError` for a key that no table has, and for a value without its unit.

    >>> read_source(SOURCES / "gu2021.source").windows["event"]
    'Stage II'
    """
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    tables = {key: value for key, value in tree.items() if key not in NAMES}
    try:
        return TypeAdapter(SourceStudy).validate_python({"key": path.stem, **tables})
    except ValidationError as error:
        place, reason = first_problem(error)
        raise InputError(reason, f"{path.name}: {'.'.join(map(str, place))}") from error


GU2021, MULTIBODY4B17, VASILYEV2016 = (
    read_source(SOURCES / f"{key}.source") for key in ("gu2021", "multibody4b17", "vasilyev2016")
)
