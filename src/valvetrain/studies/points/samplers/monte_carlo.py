"""Independent random draws."""

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
    assert isinstance(options, CountedOptions)
    return spread(varied, np.random.default_rng(options.seed).random((options.count, len(varied))))


SPEC = SamplerSpec("monte-carlo", "random draws", CountedOptions, _first, independent=True)
