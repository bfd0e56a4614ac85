"""Record of the coil contacts inside the compiled loops, on a spacing of the steps, and the clashes that it shows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from valvetrain.integrate.clash import PairSeries, find_clashes
from valvetrain.solution.event import Event
from valvetrain.springs.contract import ContactWatch

Array = NDArray[np.float64]
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}


@njit(**OPTIONS)
def write_contacts(state, stretches, row):
    """Copy ``stretches`` (first entry, length) of a spring's state into one row of its record."""
    at = 0
    for r in range(stretches.shape[0]):
        first = stretches[r, 0]
        for i in range(stretches[r, 1]):
            row[at + i] = state[first + i]
        at += stretches[r, 1]


def steps_between(watch: ContactWatch | None, time_step: float) -> int:
    """Steps of ``time_step`` (s) from one row of the record to the next: the watch's interval, whatever samples are kept."""
    return max(1, round(watch.interval / time_step)) if watch is not None else 1


def recorded_clashes(
    watch: ContactWatch, record: Array, spacing: float, time_step: float, time: Array, cam_angle: Array, spring: str = "",
    closed: bool = False,
) -> tuple[Event, ...]:  # fmt: skip
    """Clashes in a record (n, entries) with its ``time`` (s) and ``cam_angle`` (rad, unwrapped), see :func:`find_clashes`."""
    places, force, energy = watch.read(record, spacing, time_step)
    return find_clashes(PairSeries(time, cam_angle, places, force, energy), spring, closed)
