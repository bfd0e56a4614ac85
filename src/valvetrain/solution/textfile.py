"""Solutions as CSV files: a description, a header with units, one row per sample and a checksum;
read back without loss.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution import metadata
from valvetrain.solution.atomic import atomic_path, checked_content, close_file
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.metadata import DAMAGED, solution_of
from valvetrain.solution.result import Solution

if TYPE_CHECKING:
    import xarray

_MARK = "# valvetrain solution as CSV; the next line describes it, the one after names the columns with their units"


def save_csv(solution: Solution, path: str | os.PathLike[str]) -> Path:
    """Write a solution as one wide table of text; whole or not at all.

    Channels with a second dimension take one column per wire point or coil pair, named with its
    coil number. Floats are written with as many digits as it takes to read the same number back.

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
    >>> (run,) = vt.simulate("job-t", "2000 rpm", spring_models=["massless"]).solutions
    >>> path = vt.solution.save_csv(run, "run.csv")
    >>> path.read_text().splitlines()[2].split(",")[0]
    'time [s]'
    """
    arrays = solution.arrays
    every = {**arrays.coords, **arrays.variables}
    rows = {name: one for name, one in every.items() if one.dims[:1] == ("sample",)}
    layout = [
        _described(one)
        | {"name": name, "shape": list(one.values.shape[1:]), "coord": name in arrays.coords}
        for name, one in rows.items()
    ]
    constants = {
        name: _described(one) | {"values": one.values.tolist()}
        for name, one in every.items()
        if name not in rows
    }
    text = metadata.pack(
        "solution",
        status=solution.status,
        provenance=solution.provenance,
        events=solution.events,
        statistics=dict(solution.statistics),
        quantities=dict(solution.quantities),
        columns=layout,
        constants=constants,
        attributes=dict(arrays.attributes),
        **({"gaps": list(solution.gaps)} if solution.gaps else {}),
    )
    header = [label for name in rows for label in _column_labels(arrays, name)]
    blocks = [
        one.values.reshape(len(one.values), int(np.prod(one.values.shape[1:])))
        for one in rows.values()
    ]
    count = len(solution.time)
    with (
        atomic_path(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.write(f"{_MARK}\n# {_no_formula(text)}\n{','.join(header)}\n")
        stream.writelines(f"{_row(blocks, row)}\n" for row in range(count))
        stream.write(f"# end of {count} rows\n")
        stream.close()
        close_file(temporary)
    return Path(path)


def load_csv(path: str | os.PathLike[str]) -> Solution:
    """Read what :func:`save_csv` wrote, without loss.

    Parameters
    ----------
    path : the file

    Returns
    -------
    Solution with channels, events, status, statistics, quantities and provenance

    Raises
    ------
    InputError : no such file, another file, or one that is truncated

    Examples
    --------
    >>> import valvetrain as vt
    >>> (run,) = vt.simulate("job-t", "2000 rpm", spring_models=["massless"]).solutions
    >>> vt.solution.load_csv(vt.solution.save_csv(run, "run.csv")).channels.equals(run.channels)
    True
    """
    where = str(path)
    try:
        body, closed = checked_content(Path(path))
        lines = body.decode("utf-8").split("\n")
    except UnicodeDecodeError as error:
        raise InputError(
            "is not a text file; give a CSV file that this package wrote", where
        ) from error
    if lines[0] != _MARK or len(lines) < 5:
        raise InputError(
            "is not a valvetrain solution in CSV; give one that this package wrote", where
        )
    if lines[-1] != "" or lines[-2] != f"# end of {len(lines) - 5} rows":
        raise InputError("was cut short: its closing line is missing; write it again", where)
    content = metadata.unpack(lines[1][2:], "solution", where, closed)
    try:
        dataset = _dataset(content, lines[3:-2])
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, MemoryError) as error:
        raise InputError(
            f"{DAMAGED} its rows do not fit its description ({error}); write it again", where
        ) from error
    return solution_of(dataset, content, where)


def _no_formula(text: str) -> str:
    """Equal JSON, in which no cell of a spreadsheet begins with the sign of a formula."""
    return re.sub(r",([=+@-])", lambda found: f",\\u{ord(found[1]):04x}", text)


def _row(blocks: list[np.ndarray[Any, Any]], row: int) -> str:
    """One row of all blocks; the list writes its numbers as ``repr`` does, faster than one by one."""
    return repr([value for block in blocks for value in block[row].tolist()])[1:-1].replace(
        ", ", ","
    )


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


def _described(one: Variable) -> dict[str, Any]:
    return {"dims": list(one.dims), "type": str(one.values.dtype), "attributes": dict(one.attrs)}


def _number_type(name: object) -> np.dtype[Any]:
    """The number type of that name; ValueError for types of text or any length, whose size a file
    could claim.
    """
    found = np.dtype(name if isinstance(name, str) else "")
    if found.kind not in "biuf":
        raise ValueError(f"'{found}' is not a type of numbers")
    return found


def _dataset(content: dict[str, Any], lines: list[str]) -> xarray.Dataset:
    import xarray

    columns = content["columns"]
    widths = [int(np.prod(column["shape"])) for column in columns]
    table = np.array(",".join(lines).split(",") if lines else [], dtype=float).reshape(
        len(lines), sum(widths)
    )
    variables: dict[str, tuple[object, ...]] = {}
    coords: dict[str, tuple[object, ...]] = {}
    for column, block in zip(columns, np.split(table, np.cumsum(widths)[:-1], axis=1), strict=True):
        array = block.reshape(len(lines), *column["shape"]).astype(_number_type(column["type"]))
        (coords if column["coord"] else variables)[column["name"]] = (
            column["dims"],
            array,
            column["attributes"],
        )
    for name, entry in content["constants"].items():
        coords[name] = (
            entry["dims"],
            np.array(entry["values"], dtype=_number_type(entry["type"])),
            entry["attributes"],
        )
    return xarray.Dataset(variables, coords=coords, attrs=content["attributes"])
