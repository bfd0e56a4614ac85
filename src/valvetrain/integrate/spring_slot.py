"""What compiled loops know of a spring: the type of its kernel, one for every model, and how its
coil contacts are written down.
"""

from __future__ import annotations

import threading
import warnings
from typing import Any

from numba import types
from numba.core.errors import NumbaExperimentalFeatureWarning

from valvetrain.compiled import njit

# Spring kernels enter as first-class functions; numba calls that experimental each time it compiles
# a loop.
warnings.filterwarnings("ignore", category=NumbaExperimentalFeatureWarning)

_vector, _f8 = types.Array(types.float64, 1, "C"), types.float64
SPRING_SIGNATURE = types.Tuple((_f8, _f8))(
    _vector, types.Array(types.int64, 1, "C"), _vector, _f8, _f8, _f8
)
SPRING_FUNCTION = types.FunctionType(SPRING_SIGNATURE)
_READY = threading.Lock()
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}


def compiled_once(kernel: Any, signature: Any) -> Any:
    """A loop compiled (or read from its cache) for spring kernels as first-class functions, and for nothing else."""
    with _READY:  # a thread that came second would compile what the first has closed
        if not kernel.signatures:
            kernel.compile(signature)
            kernel.disable_compile()
    return kernel


@njit(**OPTIONS)
def write_contacts(state, stretches, row):
    """Copy ``stretches`` (first entry, length) of a spring's state into one row of its record
    (``ContactWatch``).
    """
    at = 0
    for r in range(stretches.shape[0]):
        first = stretches[r, 0]
        for i in range(stretches[r, 1]):
            row[at + i] = state[first + i]
        at += stretches[r, 1]


@njit(cache=True)
def no_spring(parameters, integers, state, retainer_displacement, retainer_velocity, time_step):
    """Zero force at both ends (N)."""
    return 0.0, 0.0
