"""NetCDF of the classic kind."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from valvetrain.measurements.recording import Budget, Recording
from valvetrain.measurements.rig_formats.arrays import channels_of
from valvetrain.measurements.rig_formats.contract import RigFormat, plain_word, says_synthetic


def recognise(head: bytes, name: str) -> bool:
    """Whether the content begins as classic NetCDF does."""
    return head[:4] in (b"CDF\x01", b"CDF\x02")


def read(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Every variable of numbers; units from the attribute ``units``."""
    from scipy.io import netcdf_file

    budget = Budget(name, wanted)
    arrays, units = {}, {}
    with warnings.catch_warnings(action="ignore"), netcdf_file(str(path), "r", mmap=True) as file:
        words = [plain_word(value) for value in file._attributes.values()]
        for word, held in file.variables.items():
            if held.data.dtype.kind in "fiu":
                budget.take(int(held.data.size))
                arrays[str(word)] = np.array(held.data, dtype=float)
                units[str(word)] = plain_word(getattr(held, "units", ""))
            del held
    channels, scalars = channels_of(arrays, units, budget)
    return Recording("NetCDF", channels, scalars, says_synthetic(*words))


SPEC = RigFormat("NetCDF", recognise, read)
