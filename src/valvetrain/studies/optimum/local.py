"""The end of a search for one objective: from the best design to the place where its bounds stop
it.

Straight models of objective and bounds over a shrinking neighbourhood need no slopes. Source: M. J.
D. Powell (1994), A direct search
optimization method that models the objective and constraint functions by linear interpolation
(COBYLA); scipy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from valvetrain.studies.optimum.trial import Trial

Array = np.ndarray[tuple[int], np.dtype[np.float64]]
Look = Callable[[Array], Trial]
#: First radius of the neighbourhood in shares of the ranges, what it shrinks by, and the radius at
#: which the search ends.
RADIUS, SHRINK, SMALLEST = 0.1, 0.3, 0.003
#: Bounds are kept with this much to spare, in shares of them, so that what ends on one does not end
#: beyond it.
TO_SPARE = 1e-4


class _Spent(Exception):
    """All trials are used."""


def local_search(start: Array, best: Trial, free: Sequence[int], look: Look, budget: int) -> None:
    """Look at up to ``budget`` designs about ``start`` (d, shares of the ranges), whose trial is
    ``best``; ``free``: places that may move.

    ``look(shares)`` computes a trial, all of its objectives included.
    """
    moving, centre, used = np.array(free, dtype=int), np.array(start, dtype=float), 0
    known: dict[bytes, Trial] = {centre[moving].tobytes(): best}
    sign = best.plan.objectives[0].sign
    scale = abs(float(best.objectives[0])) if np.isfinite(best.objectives[0]) else 1.0
    radius = RADIUS

    def trial_at(point: Array) -> Trial:
        nonlocal used
        inside = np.clip(point, 0.0, 1.0)
        key = inside.tobytes()
        if key not in known:
            if used >= budget:
                raise _Spent
            used += 1
            shares = centre.copy()
            shares[moving] = inside
            known[key] = look(shares)
        return known[key]

    def objective(point: Array) -> float:
        one = trial_at(point)
        value = (
            one.objectives[0]
            if not one.failure and np.isfinite(one.objectives[0])
            else best.objectives[0]
        )
        return float(sign * value / (scale or 1.0)) if np.isfinite(value) else 0.0

    def kept(point: Array) -> Array:
        one = trial_at(point)
        missed = (
            np.full(len(one.missed), 1.0) if one.failure else np.nan_to_num(one.missed, nan=1.0)
        )
        return np.concatenate(
            [
                -missed[: len(one.plan.constraints)] - TO_SPARE,
                -missed[len(one.plan.constraints) :],
                point,
                1.0 - point,
            ]
        )

    while used < budget and radius >= SMALLEST:
        before = best
        best, centre = _around(best, centre, moving, objective, kept, known, radius, budget - used)
        if best is before:
            radius *= SHRINK


def _around(
    best: Trial,
    centre: Array,
    moving: Array,
    objective: Callable[[Array], float],
    kept: Callable[[Array], Array],
    known: dict[bytes, Trial],
    radius: float,
    budget: int,
) -> tuple[Trial, Array]:
    """One search from the best design; the best of all looked at, and where it lies."""
    from scipy.optimize import minimize

    options = {"rhobeg": radius, "tol": radius / 20, "maxiter": max(budget, len(moving) + 3)}
    try:
        minimize(
            objective,
            centre[moving],
            method="COBYLA",
            constraints=[{"type": "ineq", "fun": kept}],
            options=options,
        )
    except _Spent:
        pass
    found = best
    place = centre
    for key, one in known.items():
        if one is not found and _before(one, found):
            found, place = one, centre.copy()
            place[moving] = np.frombuffer(key)
    return found, place


def _before(one: Trial, other: Trial) -> bool:
    """Whether a trial is better: feasible before infeasible, then by the objective, or by what is
    missed.
    """
    if one.failure or one.feasible != other.feasible:
        return bool(not one.failure and one.feasible)
    if one.feasible:
        sign = one.plan.objectives[0].sign
        return bool(sign * one.objectives[0] < sign * other.objectives[0])
    return one.total_missed < other.total_missed
