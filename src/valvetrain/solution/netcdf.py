"""Results as NetCDF-4 files, one self-contained file each, read back without loss."""

from __future__ import annotations

import io
import os
from collections.abc import Hashable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.solution import metadata
from valvetrain.solution.atomic import write_bytes
from valvetrain.solution.modal import ModalResult
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
    return _write(solution.channels, text, path)


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
    return _write(static_dataset(curve), text, path)


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
    return _write(modal_dataset(result), text, path)


def load_modal_result(path: _PathLike) -> ModalResult:
    """Read what :func:`save_modal_result` wrote; :class:`InputError` for any other file."""
    dataset, content = _read(path, "modal-result")
    names = ("natural_frequency", "shape", "coil_number", "axial_transmission")
    arrays = {name: np.asarray(dataset[name].values) for name in names}
    return ModalResult(compression=content["compression"], **arrays, axial_modes=tuple(content["axial_modes"]), status=content["status"],
        attached_mass=content.get("attached_mass"),
    )  # fmt: skip


def static_dataset(curve: StaticCurve) -> xarray.Dataset:
    """A static curve as labelled arrays with units."""
    import xarray

    return xarray.Dataset(
        {
            "force": (("step",), curve.force, {"units": "N", "long_name": "spring force"}),
            "stiffness": (("step",), curve.stiffness, {"units": "N/m", "long_name": "tangent stiffness"}),
            "coil_gap": (("step", "coil_pair"), curve.coil_gap, {"units": "m", "long_name": "gap between a coil and the one below"}),
            "coil_contact_force": (("step", "coil_pair"), curve.coil_contact_force, {"units": "N", "long_name": "coil contact force"}),
            "axial_position": (("step", "wire_point"), curve.axial_position, {"units": "m", "long_name": "height above the lower seat"}),
        },
        coords={
            "compression": (("step",), curve.compression, {"units": "m", "long_name": "compression from the free length"}),
            "upper_coil": (("coil_pair",), curve.upper_coil, {"units": "1", "long_name": "coil number of the upper partner"}),
            "coil_number": (("wire_point",), curve.coil_number, {"units": "1", "long_name": "turns from the lower wire tip"}),
        },
    )


def modal_dataset(result: ModalResult) -> xarray.Dataset:
    """A modal result as labelled arrays with units."""
    import xarray

    return xarray.Dataset(
        {
            "natural_frequency": (("mode",), result.natural_frequency, {"units": "Hz", "long_name": "natural frequency"}),
            "shape": (("mode", "wire_point", "axis"), result.shape, {"units": "1", "long_name": "mode shape, x y z"}),
            "axial_transmission": (("mode",), result.axial_transmission, {"units": "1", "long_name": "axial force transmission residue"}),
        },
        coords={"coil_number": (("wire_point",), result.coil_number, {"units": "1", "long_name": "turns from the lower wire tip"})},
    )


def _write(dataset: xarray.Dataset, text: str, path: _PathLike) -> Path:
    import xarray

    stored = dataset.assign({_METADATA: xarray.DataArray(np.array(text, dtype=object))})
    # A fill value would turn one legal number into "missing"; every number is data here.
    encoding = {name: {"_FillValue": None} for name in stored.variables if stored[name].dtype.kind == "f"}
    return write_bytes(path, _image(stored, encoding))


def _image(dataset: xarray.Dataset, encoding: dict[Hashable, dict[str, Any]]) -> bytes:
    """The bytes of a NetCDF-4 file, made in memory: a disk that is full then stops a plain write, not the library of the format."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    with io.BytesIO() as memory:
        with h5netcdf.File(memory, "w") as file:
            dataset.dump_to_store(H5NetCDFStore(file), encoding=encoding)
        return memory.getvalue()


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
