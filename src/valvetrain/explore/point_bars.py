"""What is computed of single points of a study or a search besides their numbers: error bars, and doubtful values."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.explore.case_paths import vary
from valvetrain.explore.engine import Evaluation
from valvetrain.explore.outputs import Run
from valvetrain.explore.space import Varied
from valvetrain.parameters.case import Case
from valvetrain.runs.prepared import FAILURES
from valvetrain.runs.requests import Run as RunRequest
from valvetrain.runs.run import run_study
from valvetrain.solution.uncertainty import Uncertainty

#: Rows of a study that get error bars, and points whose cases are made again to be counted.
MAX_BARRED, MAX_POINTS = 4, 300


def bars_of(experiment: Evaluation, values: Iterable[float], run: Run) -> tuple[Uncertainty, ...]:
    """Error bars of the numbers of a point (SI, in the order of the space) at one of the runs; none of a function,
    of a spring at rest and of what cannot run.
    """
    if experiment.case is None:
        return ()
    point = experiment.point(values, run)
    if point.speed is None or not point.request.motion:
        return ()
    models, sets = ((word,) if word else () for word in (point.spring_model, point.spring_set))
    try:
        with warnings.catch_warnings(action="ignore", category=UnusualValueWarning):
            case = vary(point.case, dict(point.values))
        study = run_study(RunRequest(
            case=case, engine_speeds=(point.speed,), models=models, spring_sets=sets, workers=1, compute=("error_bars",),
        ))  # fmt: skip
    except FAILURES:
        return ()
    return study.error_bars.rows


def doubts(
    case: Case | None,
    varied: Sequence[Varied],
    draws: NDArray[np.float64] | Sequence[Sequence[float]],
) -> dict[int, str]:
    """Those of the first :data:`MAX_POINTS` ``draws`` (n, d; SI) that have doubtful values which the case itself has not:
    place -> its first warning. A function has none.

    >>> import valvetrain as vt
    >>> case, height = vt.load_case("vaz-ohc"), Varied("train.springs.nested-cards.0.rate", "N/mm")
    >>> doubts(case, (height,), [[17e3]])
    {}
    """
    own = list(draws)[:MAX_POINTS]
    found: dict[int, str] = {}
    for point, draw in enumerate(own if case is not None else ()):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                assert case is not None
                vary(case, dict(zip(varied, map(float, draw), strict=True)))
            except InputError:
                continue  # a point that cannot be built is reported as that
        texts = [str(one.message) for one in caught if one.category is UnusualValueWarning]
        if new := [text for text in texts if text.startswith("at ")]:
            found[point] = new[0]
    return found
