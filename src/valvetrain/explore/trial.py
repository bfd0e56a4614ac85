"""One design of a search with its numbers, and the order of designs: feasible first, then by the
objectives.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.limit_speed import BELOW
from valvetrain.explore.measure import Measure, Measured
from valvetrain.explore.objective import OptimumPlan

Array = NDArray[np.float64]
#: Penalty of a bound without a number, as a share of the bound: beyond any that is
#: computed.
UNKNOWN = 1e6
#: Seed of the case, which belongs to no search.
CASE_SEED = -1


@dataclass(frozen=True, eq=False)
class Trial:
    """``number`` counts from 0, the case itself; ``values`` (d, SI) of the varied quantities;
    ``measured``: its numbers; ``seed`` of the
    search that requested it. ``plan`` holds bounds and directions.
    """

    number: int
    seed: int
    values: Array
    measured: Measured
    plan: OptimumPlan

    @property
    def failure(self) -> str:
        """Why it could not be computed, empty where it was."""
        return self.measured.failure

    @cached_property
    def objectives(self) -> Array:
        """Objectives (m,) in SI, nan where they were not computed."""
        return np.array([self._number(one.measure) for one in self.plan.objectives])

    @cached_property
    def constraints(self) -> Array:
        """Values (c,) in SI of what is bounded."""
        return np.array([self._number(one.measure) for one in self.plan.constraints])

    def _number(self, measure: Measure) -> float:
        """The number (SI) of a measure, nan where it was not computed."""
        if measure.varied is None:
            return self.measured.values.get(measure, np.nan)
        return float(self.values[tuple(self.plan.varied).index(measure.varied)])

    @cached_property
    def missed(self) -> Array:
        """By how much (c + m,) each bound is missed, in shares of it, negative inside, and of a contact
        force of zero by the share of the cycle without contact in addition; then 0 for
        each objective, more where a limit speed
        is below the lowest one searched."""
        bounds = [
            one.missed(value) + (self.lost if one.measure.is_contact_force and value <= 0 else 0.0)
            for one, value in zip(self.plan.constraints, self.constraints, strict=True)
        ]
        begins = [
            max(
                (
                    1e-9 + bracket.missed
                    for bracket in self.measured.limits.get(one.measure, ())
                    if bracket.kind == BELOW
                ),
                default=0.0,
            )
            for one in self.plan.objectives
        ]
        return np.array([*bounds, *begins])

    @cached_property
    def losses(self) -> tuple[float, ...]:
        """Time without contact (s), loft (m) and negative rigid margin (N), 0 where they were not computed."""
        values = ((one, self.measured.values.get(one, 0.0)) for one in self.plan.losses)
        return tuple(
            float(np.nan_to_num(value if one.largest_is_worst else -value)) for one, value in values
        )

    @property
    def lost(self) -> float:
        """Share of the cycle without contact, at the highest speed."""
        speeds = [run[0] or 0.0 for one in self.plan.losses for run in one.runs]
        return self.losses[0] * max(speeds) / (4 * np.pi) if speeds else 0.0

    @property
    def floating(self) -> Measure | None:
        """The first contact force that a bound keeps above zero and that is zero; None where none is."""
        pairs = zip(self.plan.constraints, self.constraints, self.missed, strict=False)
        return next(
            (
                one.measure
                for one, value, miss in pairs
                if one.measure.is_contact_force and value <= 0 < miss
            ),
            None,
        )

    @property
    def rank(self) -> tuple[float, ...]:
        """Order of designs that miss a bound, the nearest first: by what is missed, then by the loss of
        contact."""
        return (self.total_missed, *self.losses[1:], self.number)

    @property
    def feasible(self) -> bool:
        """Whether it was computed, all bounds are met and all objectives are there."""
        return (
            not self.failure
            and bool(np.all(self.missed <= 0.0))
            and bool(np.all(np.isfinite(self.objectives)))
        )

    @property
    def penalties(self) -> list[float]:
        """Missed shares of the bounds for a search, large where a design could not be computed."""
        if self.failure:
            return [UNKNOWN] * max(1, len(self.missed))
        known = [float(one) if np.isfinite(one) else UNKNOWN for one in self.missed]
        return known or [0.0]

    @property
    def state(self) -> str:
        """Its end in a word."""
        if self.failure:
            return self.measured.code
        return "feasible" if self.feasible else "infeasible"

    @property
    def total_missed(self) -> float:
        """Sum of what is missed, in shares of the bounds."""
        return float(sum(max(0.0, one) for one in self.penalties))


def beats(one: Trial, other: Trial) -> bool:
    """Whether a feasible trial is no worse in any objective, and better in one (both feasible)."""
    signs = np.array([goal.sign for goal in one.plan.objectives])
    apart = signs * (one.objectives - other.objectives)
    return bool(np.all(apart <= 0.0) and np.any(apart < 0.0))


def best_of(trials: list[Trial]) -> Trial | None:
    """The feasible trial with the best first objective, of equals the one that loses contact least,
    then the first; None where there is none.
    """
    feasible = [one for one in trials if one.feasible]
    return min(
        feasible,
        key=lambda one: (one.plan.objectives[0].sign * one.objectives[0], *one.losses, one.number),
        default=None,
    )


def front_of(trials: list[Trial]) -> list[Trial]:
    """Feasible trials that no other beats, each set of objectives once, by the first objective."""
    feasible = [one for one in trials if one.feasible]
    if not feasible:
        return []
    signs = np.array([goal.sign for goal in feasible[0].plan.objectives])
    costs = np.array([signs * one.objectives for one in feasible])
    retained: list[Trial] = []
    seen: set[bytes] = set()
    for index, one in enumerate(feasible):
        beaten = np.any(
            np.all(costs <= costs[index], axis=1) & np.any(costs < costs[index], axis=1)
        )
        key = costs[index].tobytes()
        if not beaten and key not in seen:
            seen.add(key)
            retained.append(one)
    return sorted(retained, key=lambda one: (*(signs * one.objectives), one.number))
