"""Channels from named arrays: which of them is the time of which, what is a rate."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from valvetrain.measurements.recording import Budget, RigChannel
from valvetrain.measurements.rig_formats.contract import plain_word

#: A table of more columns is no table of channels.
MOST_COLUMNS = 64
_TIME = re.compile(r"(?:.*[/_. ])?(?:time|times|t|zeit|timestamps?)", re.I)


def is_time(name: str) -> bool:
    """Whether a channel's name says that it holds times."""
    return _TIME.fullmatch(name.strip()) is not None


def channels_of(arrays: Mapping[str, Any], units: Mapping[str, str], budget: Budget) -> tuple[tuple[RigChannel, ...], dict[str, float]]:
    """Channels of rows and tables, each with the array of times that is as long as it is, and the single numbers by name."""
    rows: dict[str, Any] = {}
    scalars: dict[str, float] = {}
    for name, values in arrays.items():
        if values.size == 1:
            scalars[name] = float(np.ravel(values)[0])
        elif values.ndim == 1 or (values.ndim == 2 and 1 in values.shape):
            rows[name] = np.ravel(values).astype(float)
        elif values.ndim == 2 and min(values.shape) <= MOST_COLUMNS:
            table = values if values.shape[0] > values.shape[1] else values.T
            rows |= {f"{name}_{place + 1}": table[:, place].astype(float) for place in range(table.shape[1])}
    # times are stored in seconds, or in what their unit says
    times = {len(values): values * _seconds(units.get(name, "")) for name, values in reversed(rows.items()) if is_time(name)}
    channels = [
        RigChannel(plain_word(name), plain_word(units.get(name, "")), values, times=times.get(len(values)))
        for name, values in rows.items()
        if not is_time(name) and budget.wants(plain_word(name))
    ]
    return tuple(channels), {plain_word(name): value for name, value in scalars.items()}


def _seconds(unit: str) -> float:
    return {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0}.get(unit.strip(), 1.0)
