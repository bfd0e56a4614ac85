"""The profile of a quantity: the best that all others can do when it is set to a value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.identification.least_squares import Peak, least_squares
from valvetrain.identification.posterior import Posterior

Array = NDArray[np.float64]
#: Values of a profile on either side of the best, and how far it reaches in standard deviations of
#: what is left open.
SIDE, REACH = 4, 2.5


@dataclass(frozen=True, eq=False)
class Profile:
    """``values`` (n) in SI and ``misfit`` (n): least sum of squared scaled misses with the quantity
    at each; NaN where none is possible.
    """

    name: str
    values: Array
    misfit: Array


def profile(
    posterior: Posterior,
    peak: Peak,
    name: str,
    *,
    iterations: int = 10,
    report: Callable[[str], None] = lambda text: None,
) -> Profile:
    """Profile of the quantity ``name`` about a ``peak``. Raises :class:`InputError` for a name that
    is not looked for.
    """
    if name not in posterior.names:
        raise InputError(
            f"there is no quantity '{name[:60]}' to profile; choose from {', '.join(posterior.names)}",
            "profile",
        )
    place = posterior.names.index(name)
    low, high = posterior.bounds[0][place], posterior.bounds[1][place]
    reach = REACH * np.sqrt(peak.covariance[place, place])
    free = np.arange(len(posterior.names)) != place
    found = {float(peak.work[place]): peak.misfit}
    for side in (-1.0, 1.0):
        end = np.clip(peak.work[place] + side * reach, low, high)
        last = peak.work
        for at in np.linspace(peak.work[place], end, SIDE + 1)[1:]:
            begin = last.copy()
            begin[place] = at
            try:
                if free.any():
                    one = least_squares(posterior, begin, iterations=iterations, free=free)
                    last, found[float(at)] = one.work, one.misfit
                else:
                    found[float(at)] = _misfit(posterior, begin)
            except InputError:
                found[float(at)] = np.nan
            report(f"profile of {name}")
    work = np.array(sorted(found))
    return Profile(
        name,
        np.asarray(posterior.unknowns[place].prior.value(work)),
        np.array([found[float(at)] for at in work]),
    )


def _misfit(posterior: Posterior, work: Array) -> float:
    off = posterior.residuals(posterior.at(work[None, :]).outcomes[0])
    pulls = posterior.pulls(work)
    return np.nan if off is None else float(off @ off + pulls @ pulls)
