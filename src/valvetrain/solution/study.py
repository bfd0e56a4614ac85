"""Results of a study: solutions, springs at rest, comparisons and notes, read by terminal, JSON,
files and report.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.errors import InputError, UnknownNameError
from valvetrain.solution.critical import CriticalSpeeds
from valvetrain.solution.definition import definition_of, is_defined
from valvetrain.solution.display import Reported, value_text, verdict_first
from valvetrain.solution.modes import TrainModes
from valvetrain.solution.provenance import CaseRecord, Provenance
from valvetrain.solution.quantity import (
    Quantities,
    Quantity,
    known_speed,
    same_speed,
)
from valvetrain.solution.result import Solution
from valvetrain.solution.speed_curve import SpeedCurve
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import Fact
from valvetrain.solution.uncertainty import Comparison, ErrorBars, Finding
from valvetrain.units import Given

if TYPE_CHECKING:
    import pandas
    import xarray

#: What a gap of a study that was stopped begins with.
INTERRUPTED = "interrupted"
#: Commands whose study is a sweep over engine speed.
SWEEPS = ("sweep", "compare-springs")
#: Commands whose study is of springs at rest, which runs nothing.
AT_REST = ("static", "modes")


@dataclass(frozen=True, slots=True)
class LiftEvent:
    """Main lift event of the cam: from ``start`` to ``end`` (cam rad, end after start, within one
    revolution from zero).
    """

    start: float
    end: float


@dataclass(frozen=True, eq=False)
class Study(Reported):
    """Points times models -> solutions, with what follows from them.

    ``command``: ``run``, ``compare`` or ``sweep``. ``solutions``: one per run, reduced in a sweep.
    ``rest``: springs at rest. ``still``: quantities that belong to no run, by label (empty: of the
    case). ``comparisons`` and ``findings``: those with published numbers, empty for a case of one's
    own. ``critical_speeds``: those of a sweep of a train. ``lift_event``: None without lift or
    where it spans the cam's zero. ``facts``: what its numbers rest on; ``notes``: remarks of its source.
    ``gaps``: a sentence per part, of no single run, that failed.
    ``error_bars``: of the numbers of its runs, those that are stored
    beside a library case and those that were requested. ``between``: reduced runs between the speeds of a sweep, where cam orders meet a surge
    frequency; no points of its curves. ``train_modes``: those of a train with its springs, by pairs with the
    valve closed and at full lift, where modes were asked for. ``measured``: what a test gave over the speeds of a sweep.

    >>> study = Study(CaseRecord("own-spring"), still={"": {"preload": 301.5}})
    >>> study.quantities["preload"]
    301.5
    >>> study
    nothing moves: the case names no engine speed
      Study of own-spring (run): no runs
      quantities (1): preload 301.5 N
    """

    report_word = "study"

    record: CaseRecord
    command: str = "run"
    solutions: tuple[Solution, ...] = ()
    rest: tuple[SpringAtRest, ...] = ()
    still: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    comparisons: tuple[Comparison, ...] = ()
    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()
    facts: tuple[Fact, ...] = ()
    lift_event: LiftEvent | None = None
    provenance: Provenance = field(default_factory=lambda: Provenance("", ""))
    wall_time: float = field(default=0.0, compare=False)
    critical_speeds: CriticalSpeeds = field(default_factory=CriticalSpeeds)
    gaps: tuple[str, ...] = ()
    error_bars: ErrorBars = ErrorBars()
    between: tuple[Solution, ...] = ()
    train_modes: tuple[TrainModes, ...] = ()
    measured: SpeedCurve | None = None

    def __repr__(self) -> str:
        found = self.quantities
        lines = [
            f"Study of {self.record.name} ({self.command}): {len(self.solutions) or 'no'} run{'s' * (len(self.solutions) != 1)}"
        ]
        if self.solutions:
            speeds = [value_text(one, "rad/s") for one in self.engine_speeds]
            reach = (
                ", ".join(speeds)
                if len(speeds) < 4
                else f"{len(speeds)} engine speeds, {speeds[0]} to {speeds[-1]}"
            )
            lines.append(f"{', '.join(self.labels)}; {reach}")
        if found:
            first = [
                f"{key.name} {value_text(value, key.unit)}"
                for key, value in list(found.items())[:3]
            ]
            lines.append(
                f"quantities ({len(found)}): {', '.join(first)}{', ...' if len(found) > 3 else ''}"
            )
        if self.comparisons or self.findings:
            lines.append(
                f"{len(self.comparisons)} comparisons with published values, {len(self.findings)} findings"
            )
        if self.failures:
            lines.append(f"{len(self.failures)} not completed: {self.failures[0]}")
        lines += self._unsettled()
        if self.critical_speeds.rows:
            lines += repr(self.critical_speeds).splitlines()
        return verdict_first(self, lines)

    def _unsettled(self) -> list[str]:
        """A line per label on the runs of a sweep whose motion does not settle, which is a finding."""
        found: dict[str, list[str]] = {}
        for run in self.solutions if self.over_speed else ():
            if run.status.code == "not-converged":
                speed = f"{run.engine_speed * 30 / np.pi:.6g}"
                found.setdefault(run.label, []).append(speed)
        return [
            f"{label}: motion does not repeat at {', '.join(speeds)} rpm"
            for label, speeds in found.items()
        ]

    def to_pandas(self) -> pandas.DataFrame:
        """All named numbers (SI), one row each: quantity, label, engine_speed (rpm), value, unit."""
        return self.quantities.to_pandas()

    @property
    def engine_speeds(self) -> tuple[float, ...]:
        """Crank speeds (rad/s) that were run, ascending."""
        return tuple(sorted({solution.engine_speed for solution in self.solutions}))

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the runs in order of first appearance."""
        return tuple(dict.fromkeys(solution.label for solution in self.solutions))

    @property
    def quantities(self) -> Quantities:
        """All named numbers (SI): those of every run, and those that belong to none."""
        of_runs = [(run.label, run.engine_speed, run.quantities) for run in self.solutions]
        at_rest = [(label, None, values) for label, values in self.still.items()]
        return Quantities(
            {
                Quantity(name, speed, label): value
                for label, speed, values in (*at_rest, *of_runs)
                for name, value in values.items()
            }
        )

    def solution(self, label: str = "", engine_speed: Given | None = None) -> Solution:
        """The run of ``label`` at ``engine_speed`` (rad/s, "5600 rpm" or a pint quantity), both
        optional where one run fits.

        Raises :class:`InputError` when none or several runs fit.
        """
        speed = None if engine_speed is None else known_speed(engine_speed, self.engine_speeds)
        fits = [
            run
            for run in self.solutions
            if (not label or run.label == label)
            and (speed is None or same_speed(run.engine_speed, speed))
        ]
        if len(fits) != 1:
            known = "; ".join(
                f"{run.label} at {run.engine_speed * 30 / np.pi:.6g} rpm"
                for run in self.solutions[:8]
            )
            raise InputError(f"{len(fits) or 'no'} runs fit '{label}'; name one of: {known}")
        return fits[0]

    def runs(self, label: str) -> tuple[Solution, ...]:
        """The runs of one label by engine speed."""
        return tuple(
            sorted(
                (run for run in self.solutions if run.label == label),
                key=lambda run: run.engine_speed,
            )
        )

    def series(self, label: str, quantity: str) -> xarray.DataArray:
        """One quantity (SI) of a label over ``engine_speed`` (rpm of the crank), NaN where a run does not give it; its unit
        and that of the speeds are in ``attrs["units"]``.

        Raises :class:`InputError` for a label or a quantity that no run has, with the nearest.
        """
        runs = self.runs(label)
        if self.solutions and not runs:
            raise UnknownNameError(label, self.labels, "label")
        if (
            runs
            and not any(quantity in run.quantities for run in runs)
            and not is_defined(quantity)
        ):
            raise UnknownNameError(
                quantity, (name for run in runs for name in run.quantities), "quantity"
            )
        import xarray

        speeds = np.round([run.engine_speed * 30 / np.pi for run in runs], 6)
        axis = {
            "engine_speed": ("engine_speed", speeds, {"units": "rpm", "long_name": "engine speed"})
        }
        values = np.array([run.quantities.get(quantity, np.nan) for run in runs])
        row = definition_of(quantity)
        named = {"units": row.si_unit or "1", "long_name": row.label}
        return xarray.DataArray(values, axis, ("engine_speed",), quantity, named)

    def at_rest(self, model: str = "", spring: str = "") -> SpringAtRest | None:
        """The first spring at rest by ``model`` and name, either left out where it does not matter."""
        return next(
            (one for one in self.rest if model in ("", one.model) and spring in ("", one.spring)),
            None,
        )

    @property
    def over_speed(self) -> bool:
        """Whether its runs are points of curves over engine speed: a sweep, or the revolutions of a
        run-up.
        """
        return self.command in (*SWEEPS, "run-up")

    @property
    def at_rest_only(self) -> bool:
        """Whether it is of springs at rest: static curves, or modes."""
        return self.command in AT_REST

    @property
    def failures(self) -> tuple[str, ...]:
        """A sentence per part that did not complete; in a sweep motion that does not settle is a
        finding, not a failure.
        """
        accepted = ("completed", "not-converged") if self.over_speed else ("completed",)
        found = []
        for one in self.rest:
            for name, part in (("static curve", one.curve), ("modes", one.modes)):
                if part is not None and not part.status.completed:
                    found.append(f"{one.spring} by {one.model}, {name}: {part.status.sentence()}")
        ended: dict[tuple[str, str], list[str]] = {}
        missing: dict[tuple[str, str], list[str]] = {}
        for run in self.solutions:
            rpm = f"{run.engine_speed * 30 / np.pi:.6g}"
            if run.status.code not in accepted:
                ended.setdefault((run.label, run.status.sentence()), []).append(rpm)
            for gap in run.gaps:
                missing.setdefault((run.label, gap), []).append(rpm)
        parts = (
            f"{label} at {', '.join(speeds)} rpm, {gap}" for (label, gap), speeds in missing.items()
        )
        runs = (
            f"{label} at {', '.join(speeds)} rpm: {text}" for (label, text), speeds in ended.items()
        )
        return (*found, *parts, *self.gaps, *runs)
