"""Channels from named arrays: which of them is the time of which, what is a rate."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.recording import Budget, RigChannel
from valvetrain.measurements.rig_formats.contract import plain_word

#: A table of more columns is no table of channels.
MOST_COLUMNS = 64
#: Units of times -> seconds; files of arrays may count them since a date, which tells nothing here.
SECONDS = {
    "s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "": 1.0, "ms": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6,
    "microseconds": 1e-6, "ns": 1e-9, "nanoseconds": 1e-9, "min": 60.0, "minutes": 60.0,
}  # fmt: skip
_TIME = re.compile(r"(?:.*[/_. ])?(time|times|t|zeit|timestamps?)", re.I)


def is_time(name: str, unit: str = "") -> bool:
    """Whether a channel holds times by its name; ``t`` in a ``unit`` that is none of time is a temperature or whatever else."""
    found = _TIME.fullmatch(name.strip())
    return found is not None and (found[1].lower() != "t" or _word(unit) in SECONDS)


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
    times = {
        len(values): values * seconds_of(units.get(name, ""))
        for name, values in reversed(rows.items())
        if is_time(name, units.get(name, ""))
    }
    channels = [
        RigChannel(plain_word(name), plain_word(units.get(name, "")), values, times=times.get(len(values)))
        for name, values in rows.items()
        if not is_time(name, units.get(name, "")) and budget.wants(plain_word(name))
    ]
    return tuple(channels), {plain_word(name): value for name, value in scalars.items()}


def seconds_of(unit: str) -> float:
    """Seconds in a unit of times. Raises :class:`InputError` for one that is none of them."""
    word = _word(unit)
    if word not in SECONDS:
        raise InputError(f"the times have the unit '{word[:20]}', which is none of time; write s, ms or us")
    return SECONDS[word]


def _word(unit: str) -> str:
    return unit.partition(" since ")[0].strip()
