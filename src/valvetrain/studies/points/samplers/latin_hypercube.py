"""Latin hypercube: as many strata of equal probability as points, each quantity once in every
stratum (McKay, Beckman, Conover 1979).
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


def _first(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    from scipy.stats import qmc

    assert isinstance(options, CountedOptions)
    drawn = qmc.LatinHypercube(len(varied), seed=np.random.default_rng(options.seed)).random(
        options.count
    )
    return spread(varied, drawn)


SPEC = SamplerSpec("latin-hypercube", "Latin hypercube", CountedOptions, _first, independent=True)
