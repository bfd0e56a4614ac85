"""The most probable point by an evolution strategy that learns the shape of the valley (CMA-ES).

It needs no slopes, so contact and other kinks do not stop it. Sources: N. Hansen and A. Ostermeier,
Evolutionary Computation 9 (2001) 159;
the library cmaes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.identification.draws import Report, extra, silent
from valvetrain.identification.posterior import Posterior
from valvetrain.studies.stopping import Stopped

Array = NDArray[np.float64]
#: What stands for an impossible point, over the worst possible one of its generation.
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
    """The best point found from ``begin`` (working coordinates) and whether it ended by itself or
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
            asked = [strategy.ask() for _ in range(size)]
            work = np.clip(
                posterior.centre + posterior.spread * np.array(asked)[:, :count], low, high
            )
            scores = -posterior.at(work).log_posterior
            used += size
            possible = np.isfinite(scores)
            worst = float(scores[possible].max()) if possible.any() else 0.0
            strategy.tell(
                [
                    (one, float(score) if good else worst + WORSE)
                    for one, score, good in zip(asked, scores, possible, strict=True)
                ]
            )
            place = int(np.argmin(np.where(possible, scores, np.inf)))
            if possible[place] and scores[place] < least:
                best, least = work[place], float(scores[place])
            report(min(used / evaluations, 0.99), f"{used} evaluations, log posterior {-least:.3f}")
    except Stopped:
        return best, False
    return best, True
