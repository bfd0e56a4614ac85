"""What the noise of a measured lift does to forces and critical speeds: the same case with laws
that the stations allow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from valvetrain.cam.measured import MAX_DRAWS
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.runs.api import Speeds, simulate, sweep
from valvetrain.runs.cost import Cost, Limits, RunRequest, array_cost, refuse_cost
from valvetrain.runs.request_fields import read_limit
from valvetrain.runs.stopping import shows_progress
from valvetrain.runs.workers import Progress, map_points, worker_count
from valvetrain.solution.critical import KINDS
from valvetrain.solution.display import Shown
from valvetrain.solution.study import Study
from valvetrain.units import as_names, known_arguments, si_speeds

#: Default number of draws: their standard deviation is known to 18 %.
DRAWS = 16
#: A case, its speeds, those between which critical ones are searched, and the options of its runs.
Shared = tuple[Case, Speeds | None, Speeds | None, dict[str, Any]]
#: Bounds of one law, whose study was counted with the others, and what makes such a request large.
WHOLE, FEWER_LAWS = "10000 d, 1000 TB", "laws, speeds or unknowns"


@dataclass(frozen=True, slots=True)
class CarriedSpread:
    """One quantity with the mean law, ``value``, and the standard deviation over the draws,
    ``spread`` (both SI).

    ``draws``: how many of the draws gave the quantity; ``engine_speed`` in rad/s of the crank, None
    where it belongs to none.
    """

    quantity: str
    label: str
    engine_speed: float | None
    value: float
    spread: float
    draws: int


@dataclass(frozen=True, eq=False)
class LiftBandStudy(Shown):
    """``mean``: the study of the mean law; ``spreads`` of all its quantities; ``failures``: a
    sentence per draw that did not complete.
    """

    mean: Study
    spreads: tuple[CarriedSpread, ...]
    failures: tuple[str, ...] = ()

    def spread(
        self, quantity: str, label: str = "", engine_speed: float | None = None
    ) -> CarriedSpread:
        """The one of ``quantity``; ``label`` and ``engine_speed`` (rad/s) where needed. Raises
        :class:`InputError` unless one fits.
        """
        fits = [
            one
            for one in self.spreads
            if one.quantity == quantity
            and label in ("", one.label)
            and engine_speed in (None, one.engine_speed)
        ]
        if len(fits) != 1:
            raise InputError(
                f"{len(fits) or 'no'} values of '{quantity[:60]}' fit; name its label and engine speed"
            )
        return fits[0]


@known_arguments
@shows_progress("laws of a lift")
def lift_band_study(
    case: AnyCase,
    engine_speeds: Speeds | None = None,
    *,
    draws: int = DRAWS,
    search: Speeds | None = None,
    models: Sequence[str] | str = (),
    spring_sets: Sequence[str] | str = (),
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str | Limits = "",
) -> LiftBandStudy:
    """Run a case by the mean of its measured lift and by laws drawn from what the stations allow.

    Parameters
    ----------
    case : Case, name or path; its lift law is ``measured``
    engine_speeds : speeds of the crank, "4000 rpm", rad/s or pint quantities; the case's own by
        default
    draws : number of laws drawn, 4 or more
    search : engine speeds between which a train's critical speeds are searched too, such as
        "3000:9000:500 rpm"
    models, spring_sets : as for :func:`valvetrain.simulate`
    workers : draws at a time; results do not depend on it
    progress : called with the share done and what was done
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default

    Returns
    -------
    LiftBandStudy with the mean's study and the standard deviation of every quantity

    Raises
    ------
    InputError : as :func:`valvetrain.simulate`, for a case whose lift was not measured, and for a
        request beyond the bounds of ``limit``

    Examples
    --------
    >>> import valvetrain as vt
    >>> angles = np.radians(np.arange(90.0, 271.0))
    >>> stations = 9e-3 * np.clip(1 - ((angles - np.pi) / np.radians(60)) ** 2, 0, None) ** 3
    >>> values = {"cam_angles": tuple(angles), "lifts": tuple(stations), "noise": 3e-6, "band": 0.0, "draw": 0}
    >>> case = vt.load_case("job-t")
    >>> case = case.replace(lift_law=type(case.lift_law)("measured", values))
    >>> found = lift_band_study(case, "2000 rpm", draws=4, models="massless", workers=1)
    >>> found.spread("peak_spring_force").draws
    4
    """
    known, models, sets = case_of(case), as_names(models), as_names(spring_sets)
    if known.lift_law is None or known.lift_law.kind != "measured":
        raise InputError(
            f"the lift of case '{known.name}' is not measured, so it has no band; give it a [lift_law] of kind 'measured'",
            "lift_law",
        )
    if not 4 <= draws <= MAX_DRAWS:
        raise InputError(f"draws is a number from 4 to {MAX_DRAWS}; it is {draws}", "draws")
    speeds, searched = (None if one is None else si_speeds(one) for one in (engine_speeds, search))
    run_request = RunRequest("run", known, speeds, models, sets, worker_count(workers))
    refuse_cost(
        band_cost(run_request, draws, searched), read_limit(limit, "limit"), "limit=", FEWER_LAWS
    )
    options = {"models": models, "spring_sets": sets, "workers": 1, "limit": WHOLE}
    shared = known, engine_speeds, search, options

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress(done / total, f"law {done} of {total}")

    results = map_points(_study_of, shared, range(draws + 1), workers, processes=True, tell=tell)
    mean, found = results[0], [dict(result.quantities) for result in results]
    failures = tuple(
        f"draw {place}: {sentence}"
        for place, result in enumerate(results)
        if place
        for sentence in result.failures
    )
    spreads = []
    for key, value in found[0].items():
        drawn = [other[key] for other in found[1:] if key in other and np.isfinite(other[key])]
        spread = float(np.std(drawn, ddof=1)) if len(drawn) > 1 else float("nan")
        spreads.append(
            CarriedSpread(key.name, key.label, key.engine_speed, float(value), spread, len(drawn))
        )
    return LiftBandStudy(mean, tuple(spreads), failures)


def band_cost(run_request: RunRequest, draws: int, search: Sequence[float] | None) -> Cost:
    """Estimated cost of ``request`` with the mean law and ``draws`` many draws, critical speeds searched
    at ``search`` (rad/s of the crank).
    """
    alone = replace(run_request, workers=1)
    once = array_cost(alone, whole=True)
    if search is not None:
        once += array_cost(
            replace(alone, command="sweep", engine_speeds=tuple(search)), whole=False, searches=True
        )
    at_a_time = max(1, min(run_request.workers, draws + 1))
    return Cost(once.seconds * math.ceil((draws + 1) / at_a_time), once.bytes * (draws + 1))


def _study_of(shared: Shared, draw: int) -> Study:
    """The study of one draw, its channels left behind but for the mean."""
    nominal, engine_speeds, search, options = shared
    law = nominal.lift_law
    assert law is not None
    case = nominal.replace(lift_law=law.replace(draw=draw)) if draw else nominal
    study = simulate(case, engine_speeds, **options)
    if search is None:
        return study
    # of every drawn law the nominal speed alone
    critical = sweep(case, search, ranges=False, **options)
    keep = {
        label: {**study.still.get(label, {}), **_critical(critical, label)}
        for label in {*study.still, *critical.labels}
    }
    return replace(study, still=keep, critical_speeds=critical.critical_speeds)


def _critical(study: Study, label: str) -> dict[str, float]:
    """Critical speeds (rad/s) of one label by quantity."""
    return {
        KINDS[one.kind]: one.engine_speed
        for one in study.critical_speeds
        if one.label == label and np.isfinite(one.engine_speed)
    }
