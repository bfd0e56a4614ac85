"""Designs as points of the unit cube, in which a search moves, and back."""

from __future__ import annotations

import numpy as np

from valvetrain.studies.optimum.plan import OptimumPlan
from valvetrain.studies.optimum.trial import Array
from valvetrain.studies.points.distributions import Uniform, Values


def values_of(plan: OptimumPlan, shares: Array) -> Array:
    """Values (d, SI) of a point (d,) of the unit cube; a quantity with a list of values takes them
    in rising order.
    """
    found = []
    for one, share in zip(plan.varied, np.clip(shares, 0.0, 1.0), strict=True):
        levels = one.distribution
        if isinstance(levels, Values):
            order = sorted(set(levels.values))
            found.append(order[min(int(share * len(order)), len(order) - 1)])
        else:
            found.append(float(levels.at(float(share))))
    return np.array(found)


def shares_of(plan: OptimumPlan, values: Array) -> Array | None:
    """The point (d,) of the unit cube of a design (d, SI); None where it lies outside."""
    found = []
    for one, value in zip(plan.varied, values, strict=True):
        levels = one.distribution
        if isinstance(levels, Values):
            order = sorted(set(levels.values))
            if value not in order:
                return None
            found.append((order.index(value) + 0.5) / len(order))
        else:
            assert isinstance(levels, Uniform)
            share = (value - levels.low) / (levels.high - levels.low)
            if not 0.0 <= share <= 1.0:
                return None
            found.append(share)
    return np.array(found)


def neighbours(plan: OptimumPlan, values: Array, place: int, share: float) -> list[Array]:
    """The design with one quantity a ``share`` of its range lower and higher, or at the next of its
    values, those inside the range.
    """
    levels = plan.varied[place].distribution
    if isinstance(levels, Values):
        order = sorted(set(levels.values))
        at = order.index(min(order, key=lambda one: abs(one - values[place])))
        near = [order[one] for one in (at - 1, at + 1) if 0 <= one < len(order)]
    else:
        assert isinstance(levels, Uniform)
        step = share * (levels.high - levels.low)
        near = [
            one
            for one in (values[place] - step, values[place] + step)
            if levels.low <= one <= levels.high
        ]
    found = []
    for value in near:
        row = values.copy()
        row[place] = value
        found.append(row)
    return found
