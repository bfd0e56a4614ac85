"""Points where the first output changes most: halfway between near neighbours that differ, round by
round up to a bound.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from pydantic import Field

from valvetrain.errors import InputError
from valvetrain.studies.points.distributions import Uniform
from valvetrain.studies.points.samplers.contract import (
    Array,
    CountedOptions,
    SamplerOptions,
    SamplerSpec,
    spread,
)
from valvetrain.studies.points.samplers.sobol import sequence
from valvetrain.studies.points.varied import Varied


class AdaptiveOptions(CountedOptions):
    """Options of the refinement."""

    first: int = Field(default=16, ge=2, le=10_000, description="points of the first round")
    per_round: int = Field(default=8, ge=1, le=1000, description="points added in each round")


def _first(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, AdaptiveOptions)
    for one in varied:
        if not isinstance(one.distribution, Uniform):
            raise InputError(
                "is refined where an output changes, so it needs a range; give low and high",
                one.name,
            )
    if len(varied) == 1:  # ends included, so that every place lies between two points
        return spread(varied, np.linspace(0.0, 1.0, min(options.first, options.count))[:, None])
    size = len(varied)
    corners = (
        np.array(np.meshgrid(*([[0.0, 1.0]] * size), indexing="ij")).reshape(size, -1).T
        if size <= 4
        else np.zeros((0, size))
    )
    inner = sequence(size, max(1, options.first - len(corners)), options.seed)
    return spread(varied, np.concatenate([corners, inner])[: options.count])


def _more(varied: Sequence[Varied], options: SamplerOptions, points: Array, values: Array) -> Array:
    """Middles between neighbours, the largest change over distance weighed by the distance first;
    none at the bound or without change.
    """
    assert isinstance(options, AdaptiveOptions)
    from scipy.spatial import cKDTree

    room = min(options.per_round, options.count - len(points))
    known = np.isfinite(values)
    if room < 1 or np.count_nonzero(known) < 2:
        return np.zeros((0, len(varied)))
    low, span = (
        np.array([getattr(one.distribution, name) for one in varied]) for name in ("low", "high")
    )
    span = span - low
    cube, found = ((points - low) / span)[known], values[known]
    near = min(2 * len(varied), len(cube) - 1)
    distances, neighbours = cKDTree(cube).query(cube, k=near + 1)
    pairs = {
        (min(i, int(j)), max(i, int(j))): float(d)
        for i, row in enumerate(neighbours)
        for j, d in zip(row[1:], distances[i, 1:], strict=True)
    }
    if len(varied) == 1:  # the neighbours on either side, however far
        order = np.argsort(cube[:, 0], kind="stable").tolist()
        pairs = {(a, b): float(abs(cube[b, 0] - cube[a, 0])) for a, b in itertools.pairwise(order)}
    scored = sorted(
        ((-abs(found[b] - found[a]) * d, a, b) for (a, b), d in pairs.items() if d > 1e-6),
        key=lambda one: one,
    )
    chosen: list[Array] = []
    for score, a, b in scored:
        middle = 0.5 * (cube[a] + cube[b])
        if score < 0 and all(np.max(np.abs(middle - other)) > 1e-9 for other in (*chosen, *cube)):
            chosen.append(middle)
        if len(chosen) == room:
            break
    return low + span * np.array(chosen) if chosen else np.zeros((0, len(varied)))


SPEC = SamplerSpec(
    "adaptive", "refined where an output changes most", AdaptiveOptions, _first, _more
)
