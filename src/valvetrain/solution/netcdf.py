"""Results as NetCDF-4 files, one self-contained file each, read back without loss."""

from __future__ import annotations

import io
import json
import math
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution import metadata
from valvetrain.solution.atomic import checked_content, closing_line, write_bytes
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.metadata import DAMAGED, refuse_claims, solution_of
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.read_apart import tried_apart
from valvetrain.solution.result import Solution
from valvetrain.solution.static import Buckling, Leaning, StaticCurve
from valvetrain.solution.status import COMPLETED

if TYPE_CHECKING:
    import xarray


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


_METADATA = "valvetrain_metadata"
_UNREADABLE = (
    "cannot be read as NetCDF, it is another kind of file or was cut short; write it again"
)
_PathLike = str | os.PathLike[str]


def save_netcdf(solution: Solution, path: _PathLike) -> Path:
    """Write a solution with its events, status, statistics, quantities and provenance; whole or not
    at all.

    Parameters
    ----------
    solution : one run, whole or reduced
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
    >>> path = vt.solution.save_netcdf(run, "run.nc")
    >>> vt.solution.load_netcdf(path).quantities["peak_spring_force"] == run.quantities["peak_spring_force"]
    True
    """
    text = metadata.pack(
        "solution",
        status=solution.status,
        provenance=solution.provenance,
        events=solution.events,
        statistics=dict(solution.statistics),
        quantities=dict(solution.quantities),
        **({"gaps": list(solution.gaps)} if solution.gaps else {}),
    )
    return _write(solution.arrays, text, path)


def load_netcdf(path: _PathLike) -> Solution:
    """Read what :func:`save_netcdf` wrote, without loss.

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
    >>> vt.solution.load_netcdf(vt.solution.save_netcdf(run, "run.nc")).label
    'massless'
    """
    dataset, content = _read(path, "solution")
    return solution_of(dataset, content, str(path))


def save_static_curve(
    curve: StaticCurve, path: _PathLike, provenance: Provenance | None = None
) -> Path:
    """Write a static curve; whole or not at all."""
    buckling = (
        None
        if curve.buckling is None
        else (curve.buckling.compression, curve.buckling.height, curve.buckling.force)
    )
    leaning = None if curve.leaning is None else (curve.leaning.compression, curve.leaning.force)
    text = metadata.pack(
        "static-curve",
        status=curve.status,
        provenance=provenance,
        buckling=buckling,
        leaning=leaning,
    )
    return _write(_labelled(curve, _CURVE), text, path)


def load_static_curve(path: _PathLike) -> StaticCurve:
    """Read what :func:`save_static_curve` wrote; :class:`InputError` for any other file."""
    dataset, content = _read(path, "static-curve")
    arrays = _arrays(dataset, _CURVE, str(path))
    buckling, leaning = (
        _numbers(content, name, count, str(path))
        for name, count in (("buckling", 3), ("leaning", 2))
    )
    return StaticCurve(
        **arrays,
        status=content["status"],
        buckling=None if buckling is None else Buckling(*buckling),
        leaning=None if leaning is None else Leaning(*leaning),
    )


def save_modal_result(
    result: ModalResult, path: _PathLike, provenance: Provenance | None = None
) -> Path:
    """Write a modal result; whole or not at all."""
    text = metadata.pack(
        "modal-result",
        status=result.status,
        provenance=provenance,
        compression=result.compression,
        axial_modes=result.axial_modes,
        attached_mass=result.attached_mass,
    )
    return _write(_labelled(result, _MODES), text, path)


def load_modal_result(path: _PathLike) -> ModalResult:
    """Read what :func:`save_modal_result` wrote; :class:`InputError` for any other file."""
    dataset, content = _read(path, "modal-result")
    where, arrays = str(path), _arrays(dataset, _MODES, str(path))
    modes = _numbers(content, "axial_modes", None, where) or ()
    if not all(
        isinstance(mode, int) and 0 <= mode < len(arrays["natural_frequency"]) for mode in modes
    ):
        raise InputError(
            f"{DAMAGED} 'axial_modes' names modes that it does not have; write it again", where
        )
    for name in ("compression", "attached_mass"):
        if (value := content.get(name)) is not None:
            _numbers({name: [value]}, name, 1, where)
    if content.get("compression") is None:
        raise InputError(f"{DAMAGED} 'compression' is missing; write it again", where)
    return ModalResult(
        compression=content["compression"],
        **arrays,
        axial_modes=tuple(modes),
        status=content["status"],
        attached_mass=content.get("attached_mass"),
    )


#: Arrays of a static curve and of a modal result: name -> dimensions, unit and label; the last ones
#: are coordinates.
_Layout = dict[str, tuple[tuple[str, ...], str, str]]
_CURVE: _Layout = {
    "force": (("step",), "N", "spring force"), "stiffness": (("step",), "N/m", "tangent stiffness"),
    "coil_gap": (("step", "coil_pair"), "m", "gap between a coil and the one below"),
    "coil_contact_force": (("step", "coil_pair"), "N", "coil contact force"),
    "axial_position": (("step", "wire_point"), "m", "height above the lower seat"),
    "compression": (("step",), "m", "compression from the free length"),
    "upper_coil": (("coil_pair",), "1", "coil number of the upper partner"),
    "coil_number": (("wire_point",), "1", "turns from the lower wire tip"),
}  # fmt: skip
_MODES: _Layout = {
    "natural_frequency": (("mode",), "Hz", "natural frequency"), "shape": (("mode", "wire_point", "axis"), "1", "mode shape, x y z"),
    "axial_transmission": (("mode",), "1", "axial force transmission residue"),
    "coil_number": (("wire_point",), "1", "turns from the lower wire tip"),
}  # fmt: skip
_COORDINATES = ("compression", "upper_coil", "coil_number")


def _labelled(result: StaticCurve | ModalResult, layout: _Layout) -> ChannelArrays:
    """The arrays of a result with their dimensions, units and labels."""
    named = {
        name: Variable(dims, np.asarray(getattr(result, name)), {"units": unit, "long_name": label})
        for name, (dims, unit, label) in layout.items()
    }
    coords = {name: named.pop(name) for name in layout if name in _COORDINATES}
    return ChannelArrays(named, coords)


def _write(arrays: ChannelArrays, text: str, path: _PathLike) -> Path:
    return write_image(arrays, {_METADATA: text}, path)


def write_image(arrays: ChannelArrays, texts: Mapping[str, str], path: _PathLike) -> Path:
    """Write a file with a checksum from memory: a full disk then stops a plain write, not the library
    of the format.
    """
    with io.BytesIO() as memory:
        write_arrays(memory, arrays, texts)
        image = memory.getvalue()
    return write_bytes(path, image + closing_line(image))


def save_result(item: Any, path: _PathLike) -> Path:
    """Write any result of this package, or a tuple, list or dict of results, to one NetCDF file
    (``.nc``), whole or not at all; a solution to a CSV file (``.csv``) as well.

    Raises :class:`InputError` for what no file holds, such as a function, and a path that cannot be
    written.
    """
    target = Path(path)
    if isinstance(item, Solution) and target.suffix == ".csv":
        from valvetrain.solution.textfile import save_csv

        return save_csv(item, target)
    if target.suffix != ".nc":
        also = " or .csv" if isinstance(item, Solution) else ""
        raise InputError(
            f"a {type(item).__name__} is saved to a file that ends in .nc{also}; '{target.name[:60]}' does not"
        )
    if isinstance(item, Solution):
        return save_netcdf(item, target)
    from valvetrain.solution.tree import Trunk

    trunk = Trunk()
    tree = trunk.of(item)
    rows: dict[str, list[np.ndarray[Any, Any]]] = {}
    layout = []
    for array in trunk.arrays:
        # one row of bytes for each type of number, whatever the count of arrays
        row = rows.setdefault(array.dtype.str, [])
        start = sum(map(len, row))
        row.append(np.ascontiguousarray(array).reshape(-1).view(np.uint8))
        layout.append([array.dtype.str, start, list(array.shape)])
    variables = {
        f"array_{number}": Variable((f"byte_{number}",), np.concatenate(row), {"type": name})
        for number, (name, row) in enumerate(rows.items())
    }
    text = metadata.pack("result", status=COMPLETED, tree=tree, layout=layout, types=list(rows))
    return _write(ChannelArrays(variables, {}), text, target)


def load_result(path: _PathLike) -> Any:
    """Read what :func:`save_result` and the other functions here wrote; :class:`InputError` for any
    other file.
    """
    kind = _kind_of(Path(path))
    others = {
        "solution": load_netcdf, "static-curve": load_static_curve, "modal-result": load_modal_result,
    }  # fmt: skip
    if kind in others:
        return others[kind](path)
    from valvetrain.solution.tree import grown

    dataset, content = _read(path, "result")
    try:
        bytes_of = {
            name: np.asarray(dataset[f"array_{number}"].values)
            for number, name in enumerate(content["types"])
        }
        arrays = []
        for name, start, shape in content["layout"]:
            size = np.dtype(name).itemsize * math.prod(shape)
            part = bytes_of[name][start : start + size]
            arrays.append(np.frombuffer(part.tobytes(), dtype=name).reshape(shape).copy())
        return grown(content["tree"], arrays)
    except InputError as error:
        raise InputError(error.reason, str(path)) from None
    except (KeyError, TypeError, ValueError, IndexError, RecursionError) as error:
        raise InputError(
            f"{DAMAGED} its description cannot be read ({error}); write it again", str(path)
        ) from error


def _kind_of(path: Path) -> str:
    """The kind of result that a file says it holds; ``result`` where it says none."""
    text = _content(path)[1]
    try:
        found = json.loads(text or "")["format"]
        return str(found).removeprefix("valvetrain ")
    except (ValueError, KeyError, TypeError, RecursionError):
        return "result"


def _content(path: _PathLike) -> tuple[xarray.Dataset, str | None, bool]:
    """Variables and description of a file, and whether its closing checksum is right."""
    where = str(path)
    _, closed = checked_content(Path(path))
    if not closed:
        tried_apart(f"{__name__}:dataset_of", Path(path), where, _UNREADABLE)
    try:
        dataset = dataset_of(Path(path))
        text = dataset[_METADATA].values.item() if _METADATA in dataset.variables else None
        text = text.decode() if isinstance(text, bytes) else text
        dataset = dataset if text is None else _plain_attributes(dataset.drop_vars(_METADATA))
    except InputError:
        raise
    except (
        Exception
    ) as error:  # the libraries below raise many kinds for bytes that make no sense to them
        raise InputError(_UNREADABLE, where) from error
    return dataset, text if isinstance(text, str) else None, closed


def _read(path: _PathLike, kind: str) -> tuple[xarray.Dataset, dict[str, Any]]:
    dataset, text, closed = _content(path)
    if text is None:
        raise InputError(
            f"is not a valvetrain {kind} file; give one that this package wrote", str(path)
        )
    return dataset, metadata.unpack(text, kind, str(path), closed)


def dataset_of(path: Path) -> xarray.Dataset:
    """Everything in a NetCDF file, as it is stored; errors of the library pass."""
    import xarray

    refuse_claims(path)
    with (
        warnings.catch_warnings(action="ignore"),
        xarray.open_dataset(path, engine="h5netcdf", decode_cf=False) as opened,
    ):
        return opened.load()


def _arrays(dataset: xarray.Dataset, layout: _Layout, where: str) -> dict[str, Any]:
    """The arrays of a layout; :class:`InputError` where one is missing, has other dimensions or no
    numbers.
    """
    for name, (dims, _, _) in layout.items():
        if (
            name not in dataset.variables
            or dataset[name].dims != dims
            or dataset[name].dtype.kind != "f"
        ):
            raise InputError(
                f"{DAMAGED} '{name}' is missing or is no row of numbers; write it again", where
            )
    return {name: np.asarray(dataset[name].values) for name in layout}


def _numbers(content: dict[str, Any], name: str, count: int | None, where: str) -> list[Any] | None:
    """A stored list of numbers, ``count`` of them where given; None where there is none."""
    found = content.get(name)
    if found is None:
        return None
    if (
        not isinstance(found, list)
        or count not in (None, len(found))
        or not all(type(one) in (int, float) for one in found)
    ):
        raise InputError(f"{DAMAGED} '{name}' is no row of numbers; write it again", where)
    return found


def _plain_attributes(dataset: xarray.Dataset) -> xarray.Dataset:
    """With decoding off the list of coordinates stays an attribute; make them coordinates again."""
    named = str(dataset.attrs.pop("coordinates", "")).split()
    for variable in dataset.variables.values():
        named += str(variable.attrs.pop("coordinates", "")).split()
    return dataset.set_coords([name for name in dict.fromkeys(named) if name in dataset.variables])
