"""Sobol's sequence, scrambled: fills the space evenly for any number of points; a power of two is
best (Owen 1998).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.studies.points.samplers.contract import (
    Array,
    CountedOptions,
    SamplerOptions,
    SamplerSpec,
    spread,
)
from valvetrain.studies.points.varied import Varied


def sequence(dimensions: int, count: int, seed: int) -> Array:
    """``count`` points (n, d) of the scrambled sequence in the unit cube."""
    from scipy.stats import qmc

    power = max(0, int(np.ceil(np.log2(count))))
    drawn = qmc.Sobol(dimensions, scramble=True, seed=np.random.default_rng(seed)).random_base2(
        power
    )
    return np.asarray(drawn[:count])


def _first(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    assert isinstance(options, CountedOptions)
    return spread(varied, sequence(len(varied), options.count, options.seed))


SPEC = SamplerSpec("sobol", "Sobol's sequence", CountedOptions, _first, independent=True)
