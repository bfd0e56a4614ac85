"""What lies about an optimum: small steps of each varied quantity, and the valley of designs as good."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from valvetrain.explore.measure import Measured
from valvetrain.explore.space import Values, Varied
from valvetrain.explore.trial import Array, Trial

#: A small step, as a share of the range of a quantity.
STEP = 0.01
#: Share of the best objective within which a design is as good; reserve of every bound (in shares of
#: it) and share of the tolerance at which the ends are aimed.
ALIKE, RESERVE, AIMED = 0.01, 1e-3, 0.9
#: A quantity is open where designs as good reach over this share of its range.
OPEN = 0.1
#: Lengths of the way to an end that are tried where objective and bounds bend; price of a move that
#: brings nothing.
LENGTHS, IDLE = (1.0, 0.5, 0.2), 0.01
#: Computes designs (d, SI).
Compute = Callable[[Sequence[Array]], list[Measured]]


@dataclass(frozen=True, eq=False)
class Step:
    """What a small step of one varied quantity does to a design: ``size`` (SI, with its sign), and the
    design there.
    """

    index: int
    size: float
    trial: Trial
    improves: bool


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


def ends_of(one: Varied) -> tuple[float, float]:
    """Least and most (SI) of the range or list of a varied quantity."""
    low, high = one.distribution.at([0.0, 1.0]).tolist()
    return low, high


def steps_of(best: Trial, compute: Compute) -> tuple[Step, ...]:
    """What a step of a hundredth of its range, or to the next value, of each varied quantity alone
    does to a design.
    """
    rows = list(_neighbours(best))
    measured = compute([row for _, row in rows]) if rows else []
    steps = []
    for (place, row), numbers in zip(rows, measured, strict=True):
        there = Trial(-1, best.seed, row, numbers, best.plan)
        improves = there.feasible and there.beats(best)
        steps.append(Step(place, float(row[place] - best.values[place]), there, improves))
    return tuple(steps)


def _neighbours(best: Trial) -> Iterator[tuple[int, Array]]:
    """(place, design) with one quantity a step lower and higher, or at the next of its values,
    those inside the range.
    """
    for place, one in enumerate(best.plan.varied):
        levels, (low, high), value = one.distribution, ends_of(one), best.values[place]
        if isinstance(levels, Values):
            at = levels.values.index(float(value))
            near = [levels.values[k] for k in (at - 1, at + 1) if 0 <= k < len(levels.values)]
        else:
            near = [float(value) + sign * STEP * (high - low) for sign in (-1, 1)]
        for moved in near:
            if low <= moved <= high:
                row = best.values.copy()
                row[place] = moved
                yield place, row


def valley_of(
    best: Trial, steps: Sequence[Step], trials: Sequence[Trial], compute: Compute
) -> Valley:
    """The valley about the ``best`` trial: of the ``trials`` those as good, and at each end of each
    quantity a design that is computed, found by linear programming from what small ``steps`` do.
    """
    spans = np.array([abs(np.subtract(*ends_of(one))) or 1.0 for one in best.plan.varied])
    ways = list(_ways(best, steps, spans))
    rows = [best.values + length * way * spans for way in ways for length in LENGTHS]
    measured = compute(rows) if rows else []
    made = [Trial(-1, best.seed, row, one, best.plan) for row, one in zip(rows, measured, strict=True)]  # fmt: skip
    limit = ALIKE * abs(float(best.objectives[0]))
    good = [best]
    for one in (*trials, *made):
        if one.feasible and np.all(np.isfinite(one.values)) and abs(one.costs[0] - best.costs[0]) <= limit:  # fmt: skip
            good.append(one)
    heights = np.array([float(one.objectives[0]) for one in good])
    return Valley(np.array([one.values for one in good]), heights, spans)


def _ways(best: Trial, steps: Sequence[Step], spans: Array) -> Iterator[Array]:
    """Moves (d, shares of the ranges) to the ends that linear objective and bounds allow."""
    from scipy.optimize import linprog

    count, bounds = len(spans), len(best.plan.constraints)
    slopes, reach = np.zeros((1 + bounds, count)), np.zeros((count, 2))
    here = np.array([best.costs[0], *best.missed[:bounds]])
    for place, one in enumerate(best.plan.varied):
        near = [
            (step.size / spans[place], np.array([step.trial.costs[0], *step.trial.missed[:bounds]]) - here)
            for step in steps if step.index == place and not step.trial.failure
        ]  # fmt: skip
        near = [(size, moved) for size, moved in near if np.all(np.isfinite(moved))]
        if near and not isinstance(one.distribution, Values):
            weight = sum(size**2 for size, _ in near)
            slopes[:, place] = sum(size * moved for size, moved in near) / weight
            reach[place] = (np.array(ends_of(one)) - best.values[place]) / spans[place]
    room = np.array([AIMED * ALIKE * abs(here[0]), *(-here[1:] - RESERVE)])
    # moves up and moves down are variables of their own, so that an idle move has a price
    both = np.vstack([np.clip(reach, 0.0, None), np.clip(-reach[:, ::-1], 0.0, None)])
    for place in np.flatnonzero(np.ptp(reach, axis=1) > 0).tolist():
        for sign in (1.0, -1.0):
            aim = np.where(np.arange(count) == place, -sign, 0.0)
            cost = np.concatenate([aim + IDLE, IDLE - aim])
            end = linprog(cost, A_ub=np.hstack([slopes, -slopes]), b_ub=room, bounds=both)
            if end.status == 0 and abs(move := end.x[:count] - end.x[count:])[place] >= OPEN / 2:
                yield np.asarray(move)
