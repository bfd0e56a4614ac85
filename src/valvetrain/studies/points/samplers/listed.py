"""Points as they stand in a list: the first value of every quantity together, the second of every
quantity together, and so on.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.errors import InputError
from valvetrain.studies.points.distributions import Values
from valvetrain.studies.points.samplers.contract import Array, SamplerOptions, SamplerSpec
from valvetrain.studies.points.varied import Varied


def _first(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    columns = []
    for one in varied:
        if not isinstance(one.distribution, Values):
            raise InputError(
                "stands in a list of points, so it needs its values one by one; give 'values'",
                one.name,
            )
        columns.append(one.distribution.values)
    if len({len(column) for column in columns}) > 1:
        lengths = ", ".join(
            f"{one.name} {len(column)}" for one, column in zip(varied, columns, strict=True)
        )
        raise InputError(
            f"in a list of points every quantity has as many values; here are {lengths}", "points"
        )
    return np.array(columns, dtype=float).T


SPEC = SamplerSpec("list", "points as listed", SamplerOptions, _first)
