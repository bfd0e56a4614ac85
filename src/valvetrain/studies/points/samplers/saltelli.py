"""The design behind Sobol indices: two samples A and B, and A with one column of B at a time
(Saltelli et al. 2010, table 2).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from valvetrain.studies.points.samplers.contract import (
    MOST_POINTS,
    Array,
    CountedOptions,
    SamplerOptions,
    SamplerSpec,
    spread,
)
from valvetrain.studies.points.samplers.sobol import sequence
from valvetrain.studies.points.varied import Varied


class SaltelliOptions(CountedOptions):
    """Options of the design; ``count`` is that of all points, of which the largest power of two of
    base rows is made.
    """

    count: int = Field(
        default=1024,
        ge=8,
        le=MOST_POINTS,
        description="points at most: base rows times (quantities + 2)",
    )


def base_rows(count: int, dimensions: int) -> int:
    """Base rows of a design of ``count`` points at most: a power of two, for then the sequence is
    balanced; at least 2.
    """
    return int(max(2, 2 ** int(np.floor(np.log2(max(2, count // (dimensions + 2)))))))


def _first(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    """Rows: A, B, then for every quantity A with its column of B."""
    assert isinstance(options, SaltelliOptions)
    size, rows = len(varied), base_rows(options.count, len(varied))
    both = sequence(2 * size, rows, options.seed)
    a, b = both[:, :size], both[:, size:]
    mixed = [np.where(np.arange(size) == place, b, a) for place in range(size)]
    return spread(varied, np.concatenate([a, b, *mixed]))


SPEC = SamplerSpec(
    "saltelli", "Saltelli's design for Sobol indices", SaltelliOptions, _first, independent=True
)
