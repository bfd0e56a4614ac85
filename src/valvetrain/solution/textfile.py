"""Channels of a solution as a CSV file for spreadsheets: a header with units, one row per sample."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from valvetrain.solution.atomic import atomic_path
from valvetrain.solution.channels import ChannelArrays
from valvetrain.solution.result import Solution


def save_csv(solution: Solution, path: str | os.PathLike[str]) -> Path:
    """Write the channels of a solution as one wide table of text; whole or not at all.

    Channels with a second dimension take one column per wire point or coil pair, named with its
    coil number. The NetCDF file (:func:`save_netcdf`) is the one that is read back.

    Parameters
    ----------
    solution : one run
    path : file to write; its folder is made if absent

    Returns
    -------
    Path of the file

    Raises
    ------
    InputError : a path that cannot be written

    Examples
    --------
    >>> import valvetrain as vt
    >>> (run,) = vt.simulate("job-t", "2000 rpm", models=["massless"]).solutions
    >>> path = vt.solution.save_csv(run, "run.csv")
    >>> path.read_text().splitlines()[0].split(",")[0]
    'time [s]'
    """
    arrays = solution.arrays
    every = {**arrays.coords, **arrays.variables}
    rows = {name: one.values for name, one in every.items() if one.dims[:1] == ("sample",)}
    header = [label for name in rows for label in _column_labels(arrays, name)]
    blocks = [one.reshape(len(one), int(np.prod(one.shape[1:]))) for one in rows.values()]
    with (
        atomic_path(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.write(f"{','.join(header)}\n")
        for row in range(len(solution.time)):
            # the list writes its numbers as ``repr`` does, faster than one by one
            cells = repr([value for block in blocks for value in block[row].tolist()])[1:-1]
            stream.write(f"{cells.replace(', ', ',')}\n")
    return Path(path)


def _column_labels(arrays: ChannelArrays, name: str) -> list[str]:
    """Column names of one channel or coordinate, with unit and coil number where there is a second
    dimension.
    """
    one = arrays.coords.get(name) or arrays.variables[name]
    unit = one.attrs.get("units", "1")
    if len(one.dims) == 1:
        return [f"{name} [{unit}]"]
    dimension = one.dims[1]
    along = (coord.values for coord in arrays.coords.values() if coord.dims == one.dims[1:])
    places = next(along, np.arange(one.values.shape[1]))
    return [f"{name} at {dimension.replace('_', ' ')} {place:.6g} [{unit}]" for place in places]
