"""Measured cycles as NetCDF: a variable and a grid of cam angles a channel, the file closed by its checksum."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.measured_cycles import MeasuredCycles
from valvetrain.solution.arrays import ChannelArrays, Variable
from valvetrain.solution.checksum import checked_content
from valvetrain.solution.netcdf_layout import write_arrays
from valvetrain.solution.read_apart import tried_apart
from valvetrain.solution.rebuilt import refuse_claims

#: How an HDF5 file begins.
HDF5_MARK = b"\x89HDF\r\n\x1a\n"
#: A name that a variable may bear.
NETCDF_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,79}")
_KIND = "valvetrain measured cycles"
_GRID = "cam_angle_of_"
_UNREADABLE = "cannot be read as NetCDF; it is another kind of file or was cut short"


def netcdf_image(cycles: Sequence[MeasuredCycles]) -> bytes:
    """Bytes of a NetCDF file. A second channel of one quantity is named ``<quantity>_2``."""
    variables: dict[str, Variable] = {}
    coords: dict[str, Variable] = {}
    for one in cycles:
        name = one.quantity
        if not NETCDF_NAME.fullmatch(name):
            raise InputError(f"quantity '{name[:40]}' is no name of a variable; use letters, digits and underscores")
        count = sum(given.quantity == name for given in cycles[: len(variables)])
        label = f"{name}_{count + 1}" if count else name
        told = {
            "units": one.unit, "long_name": name.replace("_", " "), "quantity": name, "cam_speed": float(one.cam_speed),
            "cam_speed_units": "rad/s", "source": one.source, "synthetic": "yes" if one.synthetic else "no", "notes": "\n".join(one.notes),
        }  # fmt: skip
        dims = f"cycle_of_{label}", f"{_GRID}{label}"
        variables[label] = Variable(dims, np.asarray(one.values, dtype=float), told)
        coords[dims[1]] = Variable(dims[1:], np.asarray(one.cam_angle, dtype=float), {"units": "rad", "long_name": "cam angle"})
    with io.BytesIO() as memory:
        write_arrays(memory, ChannelArrays(variables, coords, {"title": _KIND}), {})
        return memory.getvalue()


def netcdf_cycles(path: Path) -> tuple[MeasuredCycles, ...]:
    """The channels of a NetCDF file of measured cycles. Raises :class:`InputError` for a damaged one or one of another kind."""
    checked_content(path)
    tried_apart(f"{__name__}:channels_of", path, path.name[:80], _UNREADABLE)
    try:
        return channels_of(path)
    except InputError:
        raise
    except Exception as error:  # the library raises many kinds for bytes that make no sense to it
        raise InputError(_UNREADABLE, path.name[:80]) from error


def channels_of(path: Path) -> tuple[MeasuredCycles, ...]:
    """The channels of a file of measured cycles; errors of the library pass. The file may come from anywhere: see :func:`netcdf_cycles`."""
    import h5py

    refuse_claims(path)
    with h5py.File(path, "r") as file:
        if _word(file.attrs.get("title", "")) != _KIND:
            raise InputError("holds no measured cycles; a recording of a rig is read by 'valvetrain rig'", path.name[:80])
        names = [name for name in file if not name.startswith((_GRID, "cycle_of_"))]
        return tuple(_channel(file, name, path.name[:80]) for name in names)


def _channel(file: Any, name: str, where: str) -> MeasuredCycles:
    held, grid = file[name], file.get(f"{_GRID}{name}")
    if grid is None or held.dtype.kind != "f" or grid.dtype.kind != "f" or grid.ndim != 1 or not np.isfinite(grid[()]).all():
        raise InputError(f"channel '{name[:40]}' lacks its cam angles or holds no numbers; write the file again", where)
    told = held.attrs
    speed = float(np.ravel(told.get("cam_speed", 0.0))[0])
    return MeasuredCycles(
        _word(told.get("quantity", name)), _word(told["units"]), np.asarray(grid[()], dtype=float), np.asarray(held[()], dtype=float),
        speed if np.isfinite(speed) else 0.0, _word(told.get("source", "")), _word(told.get("synthetic", "no")) == "yes",
        tuple(note for note in _word(told.get("notes", "")).split("\n") if note),
    )  # fmt: skip


def _word(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
