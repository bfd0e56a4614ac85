"""One design of a search with its numbers, and the order of designs: feasible ones first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.limit_speed import BELOW
from valvetrain.explore.measure import Measured
from valvetrain.explore.objective import OptimumPlan

Array = NDArray[np.float64]
#: Penalty of a bound without a number, as a share of the bound: beyond any that is
#: computed.
UNKNOWN = 1e6


@dataclass(frozen=True, eq=False)
class Trial:
    """``number`` counts from 0, the case itself; ``values`` (d, SI) of the varied quantities;
    ``measured``: its numbers. ``plan`` holds bounds and directions.
    """

    number: int
    values: Array
    measured: Measured
    plan: OptimumPlan

    def to_dict(self) -> dict[str, Any]:
        """Its numbers (SI), its end in a word, and the brackets of its limit speeds."""
        names = (
            "number",
            "values",
            "objectives",
            "constraints",
            "missed",
            "state",
            "failure",
        )
        limits = [one for every in self.measured.limits.values() for one in every]
        return {name: getattr(self, name) for name in names} | {"limits": limits}

    @property
    def failure(self) -> str:
        """Why it could not be computed, empty where it was."""
        return self.measured.failure

    @cached_property
    def objectives(self) -> Array:
        """Objectives (m,) in SI, nan where they were not computed."""
        return np.array(
            [self.measured.values.get(one.measure, np.nan) for one in self.plan.objectives]
        )

    @cached_property
    def costs(self) -> Array:
        """Objectives (m,) with the sign that makes less better."""
        return self.objectives * [one.sign for one in self.plan.objectives]

    @cached_property
    def constraints(self) -> Array:
        """Values (c,) in SI of what is bounded."""
        return np.array(
            [self.measured.values.get(one.measure, np.nan) for one in self.plan.constraints]
        )

    @cached_property
    def missed(self) -> Array:
        """By how much (c + m,) each bound is missed, in shares of it, negative inside.

        A contact force of zero misses its bound by the share of the cycle without contact in addition. The last
        m are of the objectives: 0, or more where a limit speed is below the lowest one searched.
        """
        missed = [
            one.missed(value) + (self.lost if one.measure.is_contact_force and value <= 0 else 0.0)
            for one, value in zip(self.plan.constraints, self.constraints, strict=True)
        ]
        for goal in self.plan.objectives:
            brackets = self.measured.limits.get(goal.measure, ())
            below = [1e-9 + one.missed for one in brackets if one.kind == BELOW]
            missed.append(max(below, default=0.0))
        return np.array(missed)

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

    @cached_property
    def feasible(self) -> bool:
        """Whether it was computed, all bounds are met and all objectives are there."""
        met = bool(np.all(self.missed <= 0.0)) and bool(np.all(np.isfinite(self.objectives)))
        return met and not self.failure

    @cached_property
    def rank(self) -> tuple[float, ...]:
        """Order of designs: feasible ones by the first objective, then by what is missed, then those that failed.

        Of equals the one that loses contact least goes first, then the first.
        """
        if self.feasible:
            return (0.0, float(self.costs[0]), *self.losses, self.number)
        if self.failure:
            return (2.0, self.number)
        missed = sum(max(0.0, one) for one in self.penalties)
        return (1.0, missed, *self.losses[1:], self.number)

    @property
    def penalties(self) -> list[float]:
        """Missed shares (c + m) of the bounds, large where there is no number."""
        missed = np.full(len(self.missed), UNKNOWN) if self.failure else self.missed
        return [float(one) for one in np.nan_to_num(missed, nan=UNKNOWN)]

    @property
    def state(self) -> str:
        """Its end in a word."""
        return self.measured.code if self.failure else "feasible" if self.feasible else "infeasible"

    def beats(self, other: Trial) -> bool:
        """Whether it is no worse in any objective, and better in one (both feasible)."""
        return bool(np.all(self.costs <= other.costs) and np.any(self.costs < other.costs))


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """The first of the feasible trials by their rank; None where there is none."""
    first = min(trials, key=lambda one: one.rank)
    return first if first.feasible else None


def front_of(trials: Sequence[Trial]) -> list[Trial]:
    """Feasible trials that no other beats, each set of objectives once, by the first objective."""
    by_costs = dict[bytes, Trial]()
    for one in trials:
        if one.feasible:
            by_costs.setdefault(one.costs.tobytes(), one)
    costs = np.array([one.costs for one in by_costs.values()])
    front = [
        one
        for one in by_costs.values()
        if not np.any(np.all(costs <= one.costs, axis=1) & np.any(costs < one.costs, axis=1))
    ]
    return sorted(front, key=lambda one: (*one.costs, one.number))
