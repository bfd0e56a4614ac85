"""Every combination of the levels of all varied quantities."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pydantic import Field

from valvetrain.errors import InputError
from valvetrain.studies.points.samplers.contract import (
    LEVELS,
    MOST_POINTS,
    Array,
    SamplerOptions,
    SamplerSpec,
)
from valvetrain.studies.points.varied import Varied


class GridOptions(SamplerOptions):
    """Options of a grid."""

    levels: int = Field(
        default=LEVELS,
        ge=1,
        le=100_000,
        description="levels of each quantity that lists none of its own",
    )


def _first(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, GridOptions)
    levels = [one.distribution.levels(options.levels) for one in varied]
    count = math.prod(map(len, levels))
    if count > MOST_POINTS:
        raise InputError(
            f"a grid of {' x '.join(str(len(one)) for one in levels)} has {count:.3g} points; take fewer levels",
            "points.levels",
        )
    return np.stack([axis.ravel() for axis in np.meshgrid(*levels, indexing="ij")], axis=1)


SPEC = SamplerSpec("grid", "every combination of levels", GridOptions, _first)
