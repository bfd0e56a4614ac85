"""Compares a model with a test: runs a case at the speed of the test and judges its curve or numbers
by the measured ones. Begin with :func:`compare_with_test`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from valvetrain import registry
from valvetrain.compare_test.comparison import (
    ComparisonRequest,
    RunAgainstTest,
    Stage,
    against_cycles,
    against_values,
    read_shared,
)
from valvetrain.compare_test.reader import (
    AnyTest,
    at_speeds,
    check_unit,
    read_test,
    rpm_text,
    separate_cycles,
    whole_cycles,
)
from valvetrain.compare_test.request import CompareTest
from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.measured.value_table import ValueTable
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.quantities.signal import WINDOWS, window_bounds
from valvetrain.quantities.traces import Active, trace_of
from valvetrain.runs.api import simulate
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.workers import Progress
from valvetrain.solution.display import Reported, verdict_first
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.system.problem import Problem


@dataclass(frozen=True, eq=False)
class ModelAgainstTest(Reported):
    """Result of the comparison of a model with a test.

    ``runs`` are sorted, the nearest to the test first.
    ``study``: the computation; ``test``: as it was compared (whole cycles). ``notes``: what was
    found or assumed on the way; ``failures``: a sentence per run that did not complete. ``separate``: how many
    separate cycles successive ones that are alike are worth, NaN where they are not alike.

    >>> import numpy as np
    >>> import valvetrain as vt
    >>> angle = np.linspace(0.0, 2 * np.pi, 180, endpoint=False)
    >>> level = MeasuredCycles("valve_lift", "m", angle, np.full((1, 180), 1e-3), cam_speed=150.0)
    >>> found = vt.compare_test.compare_with_test("job-t", level, models=["massless"])
    >>> found.best.without
    'one cycle shows no scatter, so there is no F-test; give two or more repeats'
    """

    study: Study
    test: MeasuredCycles | ValueTable
    runs: tuple[RunAgainstTest, ...]
    notes: tuple[str, ...] = ()
    failures: tuple[str, ...] = ()
    separate: float = math.nan

    @property
    def best(self) -> RunAgainstTest:
        """The nearest run. Raises :class:`InputError` where none completed."""
        if not self.runs:
            raise InputError(
                f"no run completed, so there is nothing to compare; {'; '.join(self.failures)[:200]}"
            )
        return self.runs[0]

    @property
    def quantity(self) -> str:
        """What was measured, empty for a table of several."""
        return self.test.quantity if isinstance(self.test, MeasuredCycles) else ""

    def __repr__(self) -> str:
        lines = [f"ModelAgainstTest: {self.study.record.name} against {self.test!r}"]
        return verdict_first(self, [*lines, *(f"not completed: {one}" for one in self.failures)])


@shows_progress("compare with test")
def compare_with_test(
    case: AnyCase, test: AnyTest, *, progress: Progress | None = None, **options: Any
) -> ModelAgainstTest:
    """A case against measured cycles, or against a table of measured values: errors, bands
    and Fisher's test of adequacy.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file
    test : MeasuredCycles, ValueTable, or the file of either
    progress : called with the share done and a text
    options : further fields of :class:`valvetrain.compare_test.request.CompareTest`:
        ``quantity``, name of the curve of the model, where the file calls it otherwise;
        ``engine_speed``, of the crank where the test does not state it, "4200 rpm", rad/s or a pint quantity;
        ``sensor``, gauge of the test, through which the model is seen before it is compared;
        ``fitted``, number of parameters of the model that were found from this test;
        ``shared``, standard deviations of errors that all cycles share, "2 N, 0.5 %, 0.1 deg": of the zero, the
        calibration, the angle;
        ``models``, ``spring_sets``, ``workers``, ``limit`` and ``implausible`` as for :func:`simulate`

    Returns
    -------
    ModelAgainstTest

    Raises
    ------
    InputError : a file that cannot be read, a quantity that no run has, a unit that does not fit,
        no speed, one sentence each

    Examples
    --------
    >>> import numpy as np
    >>> import valvetrain as vt
    >>> angle = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)
    >>> forces = vt.simulate("job-t", "3000 rpm", models=["multi-mass"]).solutions[0]
    >>> last = np.interp(angle + forces.cam_angle[0], forces.cam_angle, forces.channel("seat_force"))
    >>> drawn = last + np.random.default_rng(1).normal(0.0, 5.0, (8, 360))
    >>> cycles = MeasuredCycles("spring_force", "N", angle, drawn, cam_speed=157.07963267948966, synthetic=True)
    >>> vt.compare_test.compare_with_test("job-t", cycles, models=["multi-mass"]).best.adequacy.adequate
    True
    """
    return against_test(CompareTest.read({"case": case, "test": test, **options}), progress)


def against_test(request: CompareTest, progress: Progress | None = None) -> ModelAgainstTest:
    """As :func:`compare_with_test`, of a request."""
    assert request.test is not None
    case, models, sets = request.case, request.models, request.spring_sets
    test = read_test(request.test, request.quantity)
    measured, speeds, notes = at_speeds(case, test, request.engine_speed)
    errors = read_shared(
        request.shared, measured.unit if isinstance(measured, MeasuredCycles) else ""
    )
    judged = ComparisonRequest(measured, speeds, notes, errors, request.gauge, request.fitted)
    study = simulate(
        case,
        tuple(f"{speed!r} rad/s" for speed in speeds),
        models=models,
        spring_sets=sets,
        workers=request.workers,
        progress=progress,
        limit=request.limit,
        implausible=request.implausible,
    )
    problem = build(case, spring_models=models, spring_set=sets)
    return judge_study(study, judged, active_wire(problem))


def compare_study_with_test(study: Study, case: AnyCase, test: AnyTest) -> ModelAgainstTest:
    """As :func:`compare_with_test`, with runs that are there already: those of ``study``, which
    were made from ``case``.

    Parameters
    ----------
    study : runs of the case, one of them at the speed of the test
    case, test : as for :func:`compare_with_test`

    Raises
    ------
    InputError : as :func:`compare_with_test`, and where no run is at the speed of the test

    Examples
    --------
    >>> import numpy as np
    >>> import valvetrain as vt
    >>> study = vt.simulate("job-t", "3000 rpm", models="multi-mass")
    >>> angle = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)
    >>> force = 430.0 + np.random.default_rng(1).normal(0.0, 5.0, (8, 360))
    >>> cycles = vt.measured.MeasuredCycles("spring_force", "N", angle, force, cam_speed=157.07963267948966)
    >>> vt.compare_test.compare_study_with_test(study, "job-t", cycles).best.adequacy.adequate
    False
    """
    chosen = case_of(case)
    request = ComparisonRequest(*at_speeds(chosen, read_test(test), None))
    near = tuple(
        run
        for run in study.solutions
        if any(same_speed(run.engine_speed, speed) for speed in request.engine_speeds)
    )
    if not near:
        speeds = ", ".join(rpm_text(speed) for speed in request.engine_speeds)
        raise InputError(
            f"the test is at {speeds}, and none of the runs is; run the case at that speed", "test"
        )
    problem = build(chosen)
    if not {run.label for run in near} <= {member.label for member in problem.members}:
        models, sets = (
            [*dict.fromkeys(word for run in near if (word := getattr(run, name)))]
            for name in ("model", "spring_set")
        )
        problem = build(chosen, spring_models=models, spring_set=sets)
    return judge_study(replace(study, solutions=near), request, active_wire(problem))


def judge_study(
    study: Study, request: ComparisonRequest, active: Mapping[str, Active]
) -> ModelAgainstTest:
    """The runs of ``study`` against the test of ``request``; ``active``: label -> active wire of each spring."""
    good = [run for run in study.solutions if run.status.completed and len(run.time) > 2]
    lost = [run for run in study.solutions if run not in good]
    judged = _with_values if isinstance(request.test, ValueTable) else _with_cycles
    return replace(
        judged(study, good, request, active),
        failures=tuple(
            f"{run.label} at {rpm_text(run.engine_speed)}: {run.status.sentence()}" for run in lost
        ),
    )


def active_wire(problem: Problem) -> dict[str, Active]:
    """Label of a run -> coil numbers between which the wire of each of its springs is active."""
    return {
        member.label: {
            spring.name: (
                wire.lower_end.inactive_coils,
                wire.total_coils - wire.upper_end.inactive_coils,
            )
            for spring in member.springs
            if (wire := spring.wire) is not None
        }
        for member in problem.members
    }


def _with_cycles(
    study: Study,
    runs: Sequence[Solution],
    request: ComparisonRequest,
    active: Mapping[str, Active],
) -> ModelAgainstTest:
    assert isinstance(request.test, MeasuredCycles)
    whole, stages = whole_cycles(request.test), _stages(study)
    judged = [
        against_cycles(run, whole, request, stages, active.get(run.label, {}))
        for run in _with_curve(runs, whole, active)
    ]
    judged.sort(key=lambda run: run.agreement.rms if run.agreement is not None else math.inf)
    notes = request.notes
    if request.shared:
        notes = (
            *notes,
            f"all cycles are taken to share errors of {request.shared.text(whole.unit)} (standard deviations), in addition to their scatter",
        )
    return ModelAgainstTest(
        study,
        whole,
        tuple(judged),
        (*notes, *whole.notes),
        separate=separate_cycles(whole),
    )


def _with_curve(
    runs: Sequence[Solution], test: MeasuredCycles, active: Mapping[str, Active]
) -> list[Solution]:
    """Runs that have the curve of the test. Raises :class:`InputError` where none does, or the unit differs."""
    runs_with_curve, refused = [], []
    for run in runs:
        try:
            trace = trace_of(run, test.quantity, active.get(run.label, {}))
        except InputError as error:
            refused.append(error)
            continue
        check_unit(trace, test)
        runs_with_curve.append(run)
    if refused and not runs_with_curve:
        raise refused[-1]
    return runs_with_curve


def _stages(study: Study) -> tuple[Stage, ...]:
    """Stages before, in and after the lift event, by the names that the study of the case gives
    them.
    """
    if study.lift_event is None:
        return ()
    event, names = study.lift_event, {}
    if study.record.study and study.record.study in registry.names("sources"):
        names = registry.find("sources", study.record.study).windows
    return tuple((names.get(word, word), *window_bounds(event, word)) for word in WINDOWS)


def _with_values(
    study: Study,
    runs: Sequence[Solution],
    request: ComparisonRequest,
    active: Mapping[str, Active],
) -> ModelAgainstTest:
    test = request.test
    assert isinstance(test, ValueTable)
    judged = []
    for label in dict.fromkeys(run.label for run in runs):
        mine = {
            speed: run
            for speed in request.engine_speeds
            for run in runs
            if run.label == label and same_speed(run.engine_speed, speed)
        }
        if any(value.engine_speed not in mine for value in test.values):
            continue
        spring_set = mine[test.values[0].engine_speed].spring_set
        still = {**study.still.get("", {}), **study.still.get(spring_set, {})}
        judged.append(against_values(mine, still, request, test.values, active.get(label, {})))
    judged.sort(key=lambda run: math.inf if run.adequacy is None else run.adequacy.ratio)
    notes = (*request.notes, *test.notes)
    return ModelAgainstTest(study, test, tuple(judged), notes)
