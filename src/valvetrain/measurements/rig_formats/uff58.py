"""Universal files, data set 58: functions of time as text or in binary."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.recording import Budget, Recording, RigChannel
from valvetrain.measurements.rig_formats.contract import RigFormat, missing_library, plain_word, says_synthetic

#: Kinds of functions that are records over time: general, time response.
_OVER_TIME = (0, 1)


def recognise(head: bytes, name: str) -> bool:
    """Whether the first data set begins as universal files do: a line of -1, then the number of a data set."""
    return re.match(rb"\s*-1\s*\r?\n\s*(?:58b?|151|164|15|18|55|82|1858|24\d\d)\b", head) is not None


def read(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Every function of time of the file."""
    try:
        import pyuff
    except ImportError as error:
        raise missing_library(name, "a universal file (UFF58)", "pyuff") from error
    budget, notes = Budget(name, wanted), []
    channels: list[RigChannel] = []
    words: list[str] = []
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(max(0, size - 200))
        if stream.read().split()[-1:] != [b"-1"]:
            raise InputError(f"'{name[:80]}' was cut short: its last data set has no end; export it again")
    with warnings.catch_warnings(action="ignore"):
        file = pyuff.UFF(str(path))
        for place, kind in enumerate(file.get_set_types()):
            if int(kind) != 58:
                continue
            header = file.read_sets(place, header_only=True)
            if not 0 <= int(header.get("num_pts", 0)) <= size:
                raise InputError(f"'{name[:80]}' is damaged: data set {place + 1} claims more samples than it has bytes")
            held = file.read_sets(place)
            words += [str(held.get(f"id{line}", "")) for line in range(1, 6)]
            if held.get("data") is not None and len(held["data"]) != int(header["num_pts"]):
                raise InputError(f"'{name[:80]}' was cut short: data set {place + 1} holds fewer samples than it claims")
            channel = _channel(held, place, budget)
            if channel is None:
                notes.append(f"data set {place + 1} is left out: it is no row of real numbers over time")
            elif budget.wants(channel.name):
                channels.append(channel)
    return Recording("universal file 58", tuple(channels), synthetic=says_synthetic(*words), notes=tuple(notes))


def _channel(held: dict[str, Any], place: int, budget: Budget) -> RigChannel | None:
    values = np.asarray(held["data"])
    if int(held.get("func_type", 0)) not in _OVER_TIME or values.dtype.kind != "f" or values.ndim != 1:
        return None
    budget.take(len(values))
    label = plain_word(held.get("ordinate_axis_lab", ""))
    name = label if label and label.upper() != "NONE" else plain_word(held.get("id1", "")) or f"data set {place + 1}"
    unit = plain_word(held.get("ordinate_axis_units_lab", ""))
    times = np.asarray(held["x"], dtype=float)
    even = int(held.get("abscissa_spacing", 1)) == 1
    step = float(held.get("abscissa_inc", 0.0))
    return RigChannel(
        name, "" if unit.upper() == "NONE" else unit, values.astype(float),
        float(held.get("abscissa_min", 0.0)), step if even and step > 0 else 0.0, None if even or len(times) != len(values) else times,
    )  # fmt: skip


SPEC = RigFormat("universal file 58", recognise, read)
