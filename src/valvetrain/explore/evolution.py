"""The best point by evolution of a population (CMA-ES), of the library cmaes.

Source: N. Hansen and A. Ostermeier, Evolutionary Computation 9 (2001) 159.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.draws import Report, extra, silent
from valvetrain.explore.posterior import Posterior
from valvetrain.runs.stopping import Stopped

Array = NDArray[np.float64]
#: Score of an impossible point above the worst possible one of its generation.
WORSE = 1e6
EVALUATIONS, FIRST_SPREAD = 2000, 0.5


def evolution(
    posterior: Posterior,
    begin: Array,
    *,
    seed: int = 1,
    evaluations: int = EVALUATIONS,
    population: int = 0,
    report: Report = silent,
) -> tuple[Array, bool]:
    """The best point found from ``begin`` (working coordinates) and whether it converged or ended
    at ``evaluations``, not by a stop.

    ``population``: points of a generation, all computed at once. Raises :class:`MissingExtraError`
    without the library.
    """
    try:
        import cmaes
    except ImportError as error:
        raise extra("cmaes") from error
    low, high = posterior.bounds
    box = np.column_stack(
        [(low - posterior.centre) / posterior.spread, (high - posterior.centre) / posterior.spread]
    )
    start = np.clip((begin - posterior.centre) / posterior.spread, box[:, 0], box[:, 1])
    count = len(start)
    size = population or 4 + int(3 * np.log(count)) + count % 2
    if (
        count == 1
    ):  # the library's strategy knows two quantities or more; the second one of these has no effect
        box, start = np.vstack([box, [-1.0, 1.0]]), np.append(start, 0.0)
    strategy = cmaes.CMA(
        mean=start, sigma=FIRST_SPREAD, bounds=box, seed=seed, population_size=size
    )
    best, least, used = begin, np.inf, 0
    try:
        first = float(posterior.at(np.clip(begin, low, high)[None, :]).log_posterior[0])
        least = (
            -first if np.isfinite(first) else np.inf
        )  # a search ends no worse than where it began
        while used < evaluations and not strategy.should_stop():
            requested = [strategy.ask() for _ in range(size)]
            work = np.clip(
                posterior.centre + posterior.spread * np.array(requested)[:, :count], low, high
            )
            scores = -posterior.at(work).log_posterior
            used += size
            possible = np.isfinite(scores)
            worst = float(scores[possible].max()) if possible.any() else 0.0
            strategy.tell(
                [
                    (one, float(score) if good else worst + WORSE)
                    for one, score, good in zip(requested, scores, possible, strict=True)
                ]
            )
            index = int(np.argmin(np.where(possible, scores, np.inf)))
            if possible[index] and scores[index] < least:
                best, least = work[index], float(scores[index])
            report(min(used / evaluations, 0.99), f"{used} evaluations, log posterior {-least:.3f}")
    except Stopped:
        return best, False
    return best, True
