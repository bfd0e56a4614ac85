"""The type of a spring kernel as compiled loops take it: one signature for every spring model."""

from __future__ import annotations

import warnings

from numba import types
from numba.core.errors import NumbaExperimentalFeatureWarning

# Spring kernels enter as first-class functions; numba calls that experimental each time it compiles a loop.
warnings.filterwarnings("ignore", category=NumbaExperimentalFeatureWarning)

_vector, _f8 = types.Array(types.float64, 1, "C"), types.float64
SPRING_SIGNATURE = types.Tuple((_f8, _f8))(_vector, types.Array(types.int64, 1, "C"), _vector, _f8, _f8, _f8)
SPRING_FUNCTION = types.FunctionType(SPRING_SIGNATURE)
