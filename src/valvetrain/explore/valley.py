"""The valley of an optimum: how far each varied quantity may go while the objective stays within a
tolerance and every bound is met, the others following.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.measure import Measured
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.space import Values
from valvetrain.explore.trial import Array, Trial

#: Share of the best objective within which a design is as good; reserve of every bound (in shares of
#: it) and share of the tolerance at which the ends are aimed.
ALIKE, RESERVE, AIMED = 0.01, 1e-3, 0.9
#: A quantity is open where designs as good reach over this share of its range.
OPEN = 0.1
#: Lengths of the way to an end that are tried where objective and bounds bend; price of a move that
#: brings nothing.
LENGTHS, IDLE = (1.0, 0.5, 0.2), 0.01


@dataclass(frozen=True, eq=False)
class Step:
    """What a small step of one varied quantity does to a design: ``size`` (SI, with its sign),
    objectives (m,), bounds missed (c,) in shares of them, and feasibility there.
    """

    index: int
    size: float
    objectives: Array
    feasible: bool
    improves: bool
    failure: str = ""
    missed: Array | None = None


@dataclass(frozen=True, eq=False)
class Valley:
    """Designs ``values`` (n, d, SI) that meet every bound with a first objective (n, SI) within
    :data:`ALIKE` of the best one; ``spans`` (d): ranges of the varied quantities.
    """

    values: Array
    objectives: Array
    spans: Array

    @property
    def open(self) -> tuple[int, ...]:
        """Places of the quantities that designs as good leave open, the most open first."""
        reach = np.ptp(self.values, axis=0) / self.spans
        return tuple(int(k) for k in np.argsort(-reach, kind="stable") if reach[k] >= OPEN)

    def ends(self, place: int) -> tuple[int, int]:
        """Rows of the designs with the least and the most of a quantity."""
        column = self.values[:, place]
        return int(np.argmin(column)), int(np.argmax(column))


def valley_of(
    plan: OptimumPlan,
    best: Trial,
    steps: Sequence[Step],
    trials: Sequence[Trial],
    measure: Callable[[Sequence[Array]], list[Measured]],
) -> Valley:
    """The valley about the ``best`` trial: of the ``trials`` those as good, and at each end of each
    quantity a design that is computed, found by linear programming from what small ``steps`` do.
    """
    spans = np.array([_span(plan, place) for place in range(len(plan.varied))])
    rows = [
        best.values + length * way * spans
        for way in _ways(plan, best, steps, spans)
        for length in LENGTHS
    ]
    measured = measure(rows) if rows else []
    made = [Trial(-1, best.seed, row, one, plan) for row, one in zip(rows, measured, strict=True)]
    limit = ALIKE * abs(float(best.objectives[0]))
    good = [best] + [
        one
        for one in (*trials, *made)
        if one.feasible
        and np.all(np.isfinite(one.values))
        and abs(float(one.objectives[0] - best.objectives[0])) <= limit
    ]
    return Valley(
        np.array([one.values for one in good]),
        np.array([float(one.objectives[0]) for one in good]),
        spans,
    )


def _span(plan: OptimumPlan, place: int) -> float:
    low, high = (float(end) for end in plan.varied[place].distribution.at([0.0, 1.0]))
    return abs(high - low) or 1.0


def _ways(
    plan: OptimumPlan, best: Trial, steps: Sequence[Step], spans: Array
) -> list[NDArray[np.float64]]:
    """Moves (d, shares of the ranges) to the ends that linear objective and bounds allow."""
    from scipy.optimize import linprog

    count, bounds = len(plan.varied), len(plan.constraints)
    slopes, reach = np.zeros((1 + bounds, count)), np.zeros((count, 2))
    here = np.array([best.objectives[0], *best.missed[:bounds]])
    for place, one in enumerate(plan.varied):
        near = [
            (step.size / spans[place], np.array([step.objectives[0], *step.missed[:bounds]]) - here)
            for step in steps
            if step.index == place and step.missed is not None and not step.failure
        ]
        near = [(size, moved) for size, moved in near if np.all(np.isfinite(moved))]
        if not near or isinstance(one.distribution, Values):
            continue
        weight = sum(size**2 for size, _ in near)
        slopes[:, place] = sum(size * moved for size, moved in near) / weight
        low, high = one.distribution.low, one.distribution.high
        reach[place] = (
            (low - best.values[place]) / spans[place],
            (high - best.values[place]) / spans[place],
        )
    slopes[0] *= plan.objectives[0].sign
    room = np.array([AIMED * ALIKE * abs(here[0]), *(-here[1:] - RESERVE)])
    found = []
    for place in np.flatnonzero(np.ptp(reach, axis=1) > 0).tolist():
        for sign in (1.0, -1.0):
            aim = np.where(np.arange(count) == place, -sign, 0.0)
            cost = np.concatenate([aim + IDLE, IDLE - aim])  # moves up and moves down
            both = np.vstack([np.clip(reach, 0.0, None), np.clip(-reach[:, ::-1], 0.0, None)])
            end = linprog(cost, A_ub=np.hstack([slopes, -slopes]), b_ub=room, bounds=both)
            if end.status == 0 and abs(move := end.x[:count] - end.x[count:])[place] >= OPEN / 2:
                found.append(np.asarray(move))
    return found
