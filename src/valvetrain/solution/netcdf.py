"""Results as NetCDF-4 files, one self-contained file each, read back without loss."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError
from valvetrain.solution import metadata
from valvetrain.solution.arrays import ChannelArrays, Variable
from valvetrain.solution.atomic import write_bytes
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.netcdf_layout import write_arrays
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import Buckling, Leaning, StaticCurve

if TYPE_CHECKING:
    import xarray

_METADATA = "valvetrain_metadata"
_PathLike = str | os.PathLike[str]


def save_netcdf(solution: Solution, path: _PathLike) -> Path:
    """Write a solution with its events, status, statistics, quantities and provenance; whole or not at all.

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
    >>> path = vt.save_netcdf(run, "run.nc")
    >>> vt.load_netcdf(path).quantities["peak_spring_force"] == run.quantities["peak_spring_force"]
    True
    """
    text = metadata.pack(
        "solution", status=solution.status, provenance=solution.provenance, events=solution.events, statistics=dict(solution.statistics),
        quantities=dict(solution.quantities), **({"gaps": list(solution.gaps)} if solution.gaps else {}),
    )  # fmt: skip
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
    >>> vt.load_netcdf(vt.save_netcdf(run, "run.nc")).label
    'massless'
    """
    dataset, content = _read(path, "solution")
    words = content["events"], content["status"], content["statistics"], content["provenance"] or Provenance("", "")
    return Solution(dataset, *words, content.get("quantities", {}), tuple(content.get("gaps", ())))


def save_static_curve(curve: StaticCurve, path: _PathLike, provenance: Provenance | None = None) -> Path:
    """Write a static curve; whole or not at all."""
    buckling = None if curve.buckling is None else (curve.buckling.compression, curve.buckling.height, curve.buckling.force)
    leaning = None if curve.leaning is None else (curve.leaning.compression, curve.leaning.force)
    text = metadata.pack("static-curve", status=curve.status, provenance=provenance, buckling=buckling, leaning=leaning)
    return _write(_static_arrays(curve), text, path)


def load_static_curve(path: _PathLike) -> StaticCurve:
    """Read what :func:`save_static_curve` wrote; :class:`InputError` for any other file."""
    dataset, content = _read(path, "static-curve")
    names = ("compression", "force", "stiffness", "coil_gap", "coil_contact_force", "upper_coil", "axial_position", "coil_number")
    arrays: dict[str, Any] = {name: np.asarray(dataset[name].values) for name in names}
    buckling, leaning = content.get("buckling"), content.get("leaning")
    return StaticCurve(
        **arrays, status=content["status"], buckling=None if buckling is None else Buckling(*buckling),
        leaning=None if leaning is None else Leaning(*leaning),
    )  # fmt: skip


def save_modal_result(result: ModalResult, path: _PathLike, provenance: Provenance | None = None) -> Path:
    """Write a modal result; whole or not at all."""
    text = metadata.pack(
        "modal-result",
        status=result.status,
        provenance=provenance,
        compression=result.compression,
        axial_modes=result.axial_modes,
        attached_mass=result.attached_mass,
    )
    return _write(_modal_arrays(result), text, path)


def load_modal_result(path: _PathLike) -> ModalResult:
    """Read what :func:`save_modal_result` wrote; :class:`InputError` for any other file."""
    dataset, content = _read(path, "modal-result")
    names = ("natural_frequency", "shape", "coil_number", "axial_transmission")
    arrays = {name: np.asarray(dataset[name].values) for name in names}
    return ModalResult(compression=content["compression"], **arrays, axial_modes=tuple(content["axial_modes"]), status=content["status"],
        attached_mass=content.get("attached_mass"),
    )  # fmt: skip


def _static_arrays(curve: StaticCurve) -> ChannelArrays:
    return ChannelArrays(
        {
            "force": _labelled(("step",), curve.force, "N", "spring force"),
            "stiffness": _labelled(("step",), curve.stiffness, "N/m", "tangent stiffness"),
            "coil_gap": _labelled(("step", "coil_pair"), curve.coil_gap, "m", "gap between a coil and the one below"),
            "coil_contact_force": _labelled(("step", "coil_pair"), curve.coil_contact_force, "N", "coil contact force"),
            "axial_position": _labelled(("step", "wire_point"), curve.axial_position, "m", "height above the lower seat"),
        },
        {
            "compression": _labelled(("step",), curve.compression, "m", "compression from the free length"),
            "upper_coil": _labelled(("coil_pair",), curve.upper_coil, "1", "coil number of the upper partner"),
            "coil_number": _labelled(("wire_point",), curve.coil_number, "1", "turns from the lower wire tip"),
        },
    )


def _modal_arrays(result: ModalResult) -> ChannelArrays:
    return ChannelArrays(
        {
            "natural_frequency": _labelled(("mode",), result.natural_frequency, "Hz", "natural frequency"),
            "shape": _labelled(("mode", "wire_point", "axis"), result.shape, "1", "mode shape, x y z"),
            "axial_transmission": _labelled(("mode",), result.axial_transmission, "1", "axial force transmission residue"),
        },
        {"coil_number": _labelled(("wire_point",), result.coil_number, "1", "turns from the lower wire tip")},
    )


def _labelled(dims: tuple[str, ...], values: ArrayLike, unit: str, words: str) -> Variable:
    return Variable(dims, np.asarray(values), {"units": unit, "long_name": words})


def _write(arrays: ChannelArrays, text: str, path: _PathLike) -> Path:
    """Made in memory first: a disk that is full then stops a plain write, not the library of the format."""
    with io.BytesIO() as memory:
        write_arrays(memory, arrays, {_METADATA: text})
        return write_bytes(path, memory.getvalue())


def _read(path: _PathLike, kind: str) -> tuple[xarray.Dataset, dict[str, Any]]:
    import xarray

    where = str(path)
    if not Path(path).is_file():
        raise InputError("no such file; check the path", where)
    try:
        with xarray.open_dataset(path, engine="h5netcdf", decode_cf=False) as opened:
            dataset = opened.load()
    except (OSError, ValueError, KeyError, RuntimeError, EOFError) as error:
        raise InputError("cannot be read as NetCDF, it is another kind of file or was cut short; write it again", where) from error
    if _METADATA not in dataset.variables:
        raise InputError(f"is not a valvetrain {kind} file; give one that this package wrote", where)
    text = dataset[_METADATA].values.item()
    content = metadata.unpack(text if isinstance(text, str) else bytes(text).decode(), kind, where)
    return _plain_attributes(dataset.drop_vars(_METADATA)), content


def _plain_attributes(dataset: xarray.Dataset) -> xarray.Dataset:
    """With decoding off the list of coordinates stays an attribute; make them coordinates again."""
    named = str(dataset.attrs.pop("coordinates", "")).split()
    for variable in dataset.variables.values():
        named += str(variable.attrs.pop("coordinates", "")).split()
    return dataset.set_coords([name for name in dict.fromkeys(named) if name in dataset.variables])
