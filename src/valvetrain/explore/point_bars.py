"""Error bars of single points of a study or a search: each runs on other grids too."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

from valvetrain.errors import UnusualValueWarning
from valvetrain.explore.case_paths import vary
from valvetrain.explore.engine import Evaluation
from valvetrain.explore.outputs import Run
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.run import run_study
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import Uncertainty

#: Rows of a study that get error bars.
MAX_BARRED = 4


def bars_of(experiment: Evaluation, values: Iterable[float], run: Run) -> tuple[Uncertainty, ...]:
    """Error bars of the numbers of a point (SI, in the order of the space) at one of the runs; none of a function,
    of a spring at rest and of what cannot run.
    """
    study = study_of(experiment, values, run, True)
    return () if study is None else study.error_bars.rows


def study_of(
    experiment: Evaluation, values: Iterable[float], run: Run, error_bars: bool
) -> Study | None:
    """The study of a point (SI, in the order of the space) at one of the runs, with or without its error bars; None of a
    function, of a spring at rest and of what cannot run.
    """
    if experiment.case is None:
        return None
    point = experiment.point(values, run)
    if point.speed is None or not point.request.motion:
        return None
    models, sets = ((word,) if word else () for word in (point.spring_model, point.spring_set))
    try:
        with warnings.catch_warnings(action="ignore", category=UnusualValueWarning):
            case = vary(point.case, dict(point.values))
        return run_study(
            case, engine_speeds=(point.speed,), spring_models=models, spring_sets=sets, workers=1, error_bars=error_bars,
        )  # fmt: skip
    except FAILURES:
        return None
