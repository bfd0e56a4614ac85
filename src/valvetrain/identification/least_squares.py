"""The most probable point by bounded Levenberg-Marquardt steps, several trial steps of different
damping at once.

Differences and trials are batches of points, so they run side by side; the path does not depend on
how many do. Sources: K. Levenberg,
Quarterly of Applied Mathematics 2 (1944) 164; D. Marquardt, SIAM Journal on Applied Mathematics 11
(1963) 431.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.identification.posterior import Outcome, Posterior

Array = NDArray[np.float64]
#: Step of a difference in standard deviations of the prior where nothing is known yet, and of what
#: the data leave once it is.
FIRST_STEP, LATER_STEP, LEAST_STEP = 0.03, 0.1, 1e-5
#: Search ends when a step gains less than this share of the misfit, or of one standard deviation
#: squared.
GAIN = 1e-3
#: Dampings that are tried at once, over the last that was best; and the damping at which the search
#: gives up.
TRIALS, LEAST_DAMPING, LARGEST_DAMPING = (-2, -1, 0, 1), 1e-9, 1e8
#: A misfit below this is none.
NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class Peak:
    """A (local) peak of the posterior: ``work`` (quantities), ``outcome``, ``misfit`` (sum of
    squared scaled misses, priors included),
    ``jacobian`` (data, quantities) of the scaled misses by standard deviations of the prior,
    ``covariance`` of the working coordinates
    from it, and the ``iterations`` it took."""

    work: Array
    outcome: Outcome
    misfit: float
    jacobian: Array
    covariance: Array
    iterations: int


def least_squares(
    posterior: Posterior,
    begin: Array,
    *,
    iterations: int = 30,
    free: Array | None = None,
    step: float | None = None,
    report: Callable[[str], None] = lambda text: None,
) -> Peak:
    """Search from ``begin`` (working coordinates) over the quantities that are ``free`` (all by
    default).

    ``step``: that of the differences in standard deviations of the prior, fixed; by default it
    follows what the data leave open.
    Raises :class:`InputError` when the start itself cannot be computed.
    """
    low, high = posterior.bounds
    spread, work = posterior.spread, np.clip(begin, low, high)
    chosen = np.ones(len(work), dtype=bool) if free is None else free
    outcome = posterior.at(work[None, :]).outcomes[0]
    misses = _misses(posterior, outcome, work)
    if misses is None:
        raise InputError(
            "the start of the identification is no possible spring; choose other starting values"
        )
    damping, done, steps = 1.0, 0, np.full(len(work), step or FIRST_STEP)
    for done in range(1, iterations + 1):
        jacobian = differences(posterior, work, outcome, steps, chosen)
        whole = np.vstack([jacobian, _prior_rows(posterior)])[:, chosen]
        normal, gradient = whole.T @ whole, whole.T @ misses
        tried = [max(damping, LEAST_DAMPING) * 10.0**power for power in TRIALS]
        places = np.tile(work, (len(tried), 1))
        for row, one in zip(places, tried, strict=True):
            row[chosen] -= spread[chosen] * np.linalg.solve(
                normal + one * np.eye(len(gradient)), gradient
            )
        places = np.clip(places, low, high)
        best: tuple[Array, Outcome, Array] | None = None
        least = float(misses @ misses)
        for one, place, found in zip(tried, places, posterior.at(places).outcomes, strict=True):
            off = _misses(posterior, found, place)
            if off is not None and off @ off < (least if best is None else best[2] @ best[2]):
                best, damping = (place, found, off), one
        if best is None:
            damping *= 100.0
            if damping > LARGEST_DAMPING or least < NOTHING:
                break
            continue
        work, outcome, misses = best
        now = float(misses @ misses)
        report(f"iteration {done}: misfit {now:.4f}, damping {damping:.1e}")
        if step is None:
            steps = _steps(jacobian, posterior, chosen)
        if least - now < GAIN * min(now, 1.0) or now < NOTHING:
            break
    jacobian = differences(posterior, work, outcome, steps, chosen)
    return Peak(
        work, outcome, float(misses @ misses), jacobian, covariance_of(posterior, jacobian), done
    )


def covariance_of(posterior: Posterior, jacobian: Array) -> Array:
    """Covariance of the working coordinates: inverse of the data's and the priors' information (a
    flat prior by its spread).
    """
    information = jacobian.T @ jacobian + np.eye(jacobian.shape[1])
    return np.asarray(np.linalg.inv(information) * np.outer(posterior.spread, posterior.spread))


def differences(
    posterior: Posterior, work: Array, outcome: Outcome, steps: Array, chosen: Array
) -> Array:
    """Slopes (data, quantities) of the scaled misses by quantities in standard deviations of their
    priors, from one-sided differences.

    Zero for quantities that are not ``chosen``. Backward where a step up leaves the bounds, and
    where what lies there cannot be computed;
    zero where neither side can.
    """
    high = posterior.bounds[1]
    free = np.flatnonzero(chosen)
    base = posterior.residuals(outcome)
    assert base is not None
    jacobian = np.zeros((len(base), len(work)))
    signs = np.where(work + steps * posterior.spread > high, -1.0, 1.0)
    for turn in (1.0, -1.0):  # the second time for those that had no answer
        shifted = np.tile(work, (len(free), 1))
        shifted[np.arange(len(free)), free] += turn * (signs * steps * posterior.spread)[free]
        left = []
        for place, found in zip(free, posterior.at(shifted).outcomes, strict=True):
            off = posterior.residuals(found)
            if off is None:
                left.append(place)
            else:
                jacobian[:, place] = (off - base) / (turn * signs[place] * steps[place])
        free = np.array(left, dtype=int)
        if not left:
            break
    return jacobian


def _misses(posterior: Posterior, outcome: Outcome, work: Array) -> Array | None:
    off = posterior.residuals(outcome)
    return None if off is None else np.concatenate([off, posterior.pulls(work)])


def _prior_rows(posterior: Posterior) -> Array:
    """Slopes of :meth:`Posterior.pulls` by quantities in standard deviations of their priors."""
    return np.diag([0.0 if one.prior.flat else 1.0 for one in posterior.unknowns])


def _steps(jacobian: Array, posterior: Posterior, chosen: Array) -> Array:
    """A tenth of what the data leave open of each quantity were the others known, in standard
    deviations of the prior.
    """
    told = np.sqrt(np.sum(jacobian**2, axis=0) + 1.0)
    return np.where(chosen, np.clip(LATER_STEP / told, LEAST_STEP, FIRST_STEP), FIRST_STEP)
