"""Results as NetCDF-4 files, one self-contained file each, read back without loss.

What a file holds is one tree of the fields of its classes (:mod:`valvetrain.solution.tree`) as text, and their arrays:
those of a run, a static curve or modes as variables with unit and label, all others as rows of bytes.
"""

from __future__ import annotations

import io
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution.atomic import checked_content, closing_line, write_bytes
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve

_PathLike = str | os.PathLike[str]
#: Most bytes that the best compression stores in one; variables of at most this size are always
#: read.
MAX_EXPANDED, SMALL = 1100, 65_536
#: Upper bound of the variables of a result.
MAX_VARIABLES = 5000
_DIMENSION = b"This is a netCDF dimension but not a netCDF variable"
#: Name of the variable with the tree, and number of its form.
TREE, FORMAT_VERSION = "valvetrain_result", 2
#: Arrays of a static curve and of a modal result: name -> dimensions, unit and label; the last ones
#: are coordinates.
_CURVE = {
    "force": (("step",), "N", "spring force"), "stiffness": (("step",), "N/m", "tangent stiffness"),
    "coil_gap": (("step", "coil_pair"), "m", "gap between a coil and the one below"),
    "coil_contact_force": (("step", "coil_pair"), "N", "coil contact force"),
    "axial_position": (("step", "wire_point"), "m", "height above the lower seat"),
    "compression": (("step",), "m", "compression from the free length"),
    "upper_coil": (("coil_pair",), "1", "coil number of the upper partner"),
    "coil_number": (("wire_point",), "1", "turns from the lower wire tip"),
}  # fmt: skip
_MODES = {
    "natural_frequency": (("mode",), "Hz", "natural frequency"), "shape": (("mode", "wire_point", "axis"), "1", "mode shape, x y z"),
    "axial_transmission": (("mode",), "1", "axial force transmission residue"),
    "coil_number": (("wire_point",), "1", "turns from the lower wire tip"),
}  # fmt: skip
LAYOUTS: dict[type, dict[str, tuple[tuple[str, ...], str, str]]] = {
    StaticCurve: _CURVE,
    ModalResult: _MODES,
}
_COORDINATES = ("compression", "upper_coil", "coil_number")


def write_arrays(target: Path | BinaryIO, arrays: ChannelArrays, texts: Mapping[str, str]) -> None:
    """Write channels, their coordinates and ``texts`` by name to a new file or into memory; no
    value is marked as missing.
    """
    import h5netcdf
    import h5py

    variables = {**arrays.variables, **arrays.coords}
    plain = {name: set(one.dims) for name, one in arrays.coords.items() if name not in one.dims}
    along = {  # the attribute ``coordinates`` of each channel, and of the file for those along which none is (CF 1.11, 5)
        label: sorted(name for name, dims in plain.items() if dims <= set(one.dims))
        for label, one in arrays.variables.items()
    }
    left = sorted(plain.keys() - {name for names in along.values() for name in names})
    on_file = {"coordinates": " ".join(left)} if left else {}
    with h5netcdf.File(target, "w", invalid_netcdf=None, decode_vlen_strings=True) as file:
        file.dimensions = {
            dim: size
            for one in variables.values()
            for dim, size in zip(one.dims, one.values.shape, strict=True)
        }
        file.attrs.update({**arrays.attributes, **on_file})
        for name, one in variables.items():
            values, truth = one.values, {}
            if values.dtype.kind == "b":  # the format has no truth values
                values, truth = values.astype(np.int8), {"dtype": "bool"}
            variable = file.create_variable(name, one.dims, values.dtype)
            variable.attrs.update({**one.attrs, **truth})
            if along.get(name):
                variable.attrs["coordinates"] = " ".join(along[name])
            variable[...] = values
        for name, text in texts.items():
            file.create_variable(name, (), h5py.string_dtype())[...] = text


def save_netcdf(item: Any, path: _PathLike) -> Path:
    """Write any result of this package, or a tuple, list or dict of results, to one file; whole or not at all.

    Parameters
    ----------
    item : a solution, whole or reduced, or any other result
    path : file to write; its folder is made if absent

    Returns
    -------
    Path of the file

    Raises
    ------
    InputError : what no file holds, such as a function; a path that cannot be written

    Examples
    --------
    >>> import valvetrain as vt
    >>> (run,) = vt.simulate("job-t", "2000 rpm", models=["massless"]).solutions
    >>> path = vt.solution.save_netcdf(run, "run.nc")
    >>> vt.solution.load_netcdf(path).quantities["peak_spring_force"] == run.quantities["peak_spring_force"]
    True
    """
    from valvetrain.solution.tree import Trunk

    labelled = _labelled(item)
    trunk = Trunk({**labelled.variables, **labelled.coords})
    tree = trunk.of(item)
    rows: dict[str, list[np.ndarray[Any, Any]]] = {}
    layout = []
    for array in trunk.arrays:
        # one row of bytes for each type of number, whatever the count of arrays
        row = rows.setdefault(array.dtype.str, [])
        layout.append([array.dtype.str, sum(map(len, row)), list(array.shape)])
        row.append(np.ascontiguousarray(array).reshape(-1).view(np.uint8))
    types = {f"bytes_{number}": name for number, name in enumerate(rows)}
    bytes_of = {
        name: Variable((f"place_{name}",), np.concatenate(rows[kind]), {"type": kind})
        for name, kind in types.items()
    }
    text = json.dumps(
        {"version": FORMAT_VERSION, "tree": tree, "layout": layout}, ensure_ascii=False
    )
    # from memory: a full disk then stops a plain write, not the library of the format
    memory = io.BytesIO()
    write_arrays(memory, labelled.assign(bytes_of), {TREE: text})
    image = memory.getvalue()
    return write_bytes(path, image + closing_line(image))


def load_netcdf(path: _PathLike) -> Solution:
    """Read a solution that :func:`save_netcdf` wrote, without loss.

    Parameters
    ----------
    path : the file

    Returns
    -------
    Solution with channels, events, status, statistics, quantities and provenance

    Raises
    ------
    InputError : no such file, a damaged one, one of another program, or one of another result

    Examples
    --------
    >>> import valvetrain as vt
    >>> (run,) = vt.simulate("job-t", "2000 rpm", models=["massless"]).solutions
    >>> vt.solution.load_netcdf(vt.solution.save_netcdf(run, "run.nc")).label
    'massless'
    """
    result = load_result(path)
    if not isinstance(result, Solution):
        raise InputError(
            f"holds a {type(result).__name__}, not a solution; read it by valvetrain.load",
            str(path),
        )
    return result


def save_result(item: Any, path: _PathLike) -> Path:
    """As :func:`save_netcdf`, to a file that ends in ``.nc``; a solution to a CSV file (``.csv``) as well."""
    target = Path(path)
    if isinstance(item, Solution) and target.suffix == ".csv":
        from valvetrain.solution.result import save_csv

        return save_csv(item, target)
    if target.suffix != ".nc":
        also = " or .csv" if isinstance(item, Solution) else ""
        raise InputError(
            f"a {type(item).__name__} is saved to a file that ends in .nc{also}; '{target.name[:60]}' does not"
        )
    return save_netcdf(item, target)


def load_result(path: _PathLike) -> Any:
    """Read what :func:`save_netcdf` wrote. Only a file that ends in the checksum of this package is opened by the
    library of the format; :class:`InputError` for any other.
    """
    import h5py

    from valvetrain.solution.tree import grown

    where = str(path)
    if not checked_content(Path(path))[1]:
        raise InputError(
            "is no result of valvetrain, or was rewritten by another program: its closing checksum is missing; "
            "give the file that this package wrote",
            where,
        )
    try:
        refuse_claims(Path(path))
        with h5py.File(path, "r") as file:
            if TREE not in file:
                raise InputError("holds no result; give a file of valvetrain.save", where)
            content = json.loads(file[TREE][()])
            if content["version"] != FORMAT_VERSION:
                raise InputError(
                    f"was written by another version of valvetrain (file version {content['version']}); read it with that version",
                    where,
                )
            variables = {name: np.asarray(one) for name, one in file.items() if name != TREE}
            bytes_of = {
                str(one.attrs.get("type", "")): variables[name]
                for name, one in file.items()
                if name != TREE
            }
        arrays = []
        for name, start, shape in content["layout"]:
            size = np.dtype(name).itemsize * math.prod(shape)
            part = bytes_of[name][start : start + size]
            arrays.append(np.frombuffer(part.tobytes(), dtype=name).reshape(shape).copy())
        return grown(content["tree"], arrays, variables)
    except InputError as error:
        raise InputError(error.reason, where) from None
    except Exception as error:  # the library raises many kinds for bytes that make no sense to it
        raise InputError(
            f"is damaged: its description cannot be read ({error}); write it again", where
        ) from error


def _labelled(item: Any) -> ChannelArrays:
    """The arrays of a run, a static curve or modes with their dimensions, units and labels; none of other results."""
    if isinstance(item, Solution):
        return item.arrays
    layout = LAYOUTS.get(type(item), {})
    named = {
        name: Variable(dims, getattr(item, name), {"units": unit, "long_name": label})
        for name, (dims, unit, label) in layout.items()
    }
    coords = {name: named.pop(name) for name in layout if name in _COORDINATES}
    return ChannelArrays(named, coords)


def refuse_claims(path: Path) -> None:
    """Raise :class:`InputError` for a NetCDF file whose variables claim more than is stored, are in
    another file or linked.

    Only the description in the file is read, so memory of the claimed size is not allocated. Errors of
    the library pass.
    """
    import h5py

    whole = path.stat().st_size
    with h5py.File(path, "r") as file:
        if len(file) > MAX_VARIABLES:
            raise InputError(
                f"claims {len(file)} variables, more than a result has; write it again", str(path)
            )
        for name in file:
            variable = (
                file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
            )
            if not isinstance(variable, h5py.Dataset) or variable.is_virtual or variable.external:
                raise InputError(
                    f"is damaged: '{name}' is no variable of its own; write it again", str(path)
                )
            label = variable.attrs.get("NAME", b"")
            if (label.encode() if isinstance(label, str) else bytes(label)).startswith(_DIMENSION):
                continue  # the length of a dimension, of which nothing is stored or read
            stored = variable.id.get_storage_size()
            chunk = math.prod(variable.chunks) if variable.chunks and stored else 0
            # one value of a chunk allocates all of it
            claimed = max(variable.nbytes, chunk * variable.dtype.itemsize)
            if stored > whole or claimed > max(SMALL, stored * MAX_EXPANDED):
                raise InputError(
                    f"is damaged: '{name}' claims {claimed:.3g} bytes and holds {stored}; write it again",
                    str(path),
                )
