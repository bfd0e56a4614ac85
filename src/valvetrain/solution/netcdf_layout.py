"""How channels lie in a NetCDF-4 file: written without xarray, whose import costs a run more than all its files; laid out as it would."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from valvetrain.solution.arrays import ChannelArrays, Variable


def write_arrays(target: Path | BinaryIO, arrays: ChannelArrays, texts: Mapping[str, str]) -> None:
    """Write channels, their coordinates and ``texts`` (name -> words) to a new file or into memory; no value is marked as missing."""
    import h5netcdf
    import h5py

    variables = {**arrays.variables, **arrays.coords}
    on_variables, on_file = _coordinate_words(arrays)
    with h5netcdf.File(target, "w", invalid_netcdf=None, decode_vlen_strings=True) as file:
        file.dimensions = {dim: size for one in variables.values() for dim, size in zip(one.dims, one.values.shape, strict=True)}
        for key, words in {**arrays.attributes, **on_file}.items():
            file.attrs[key] = words
        for name, one in variables.items():
            values, attributes = _stored(one)
            made = file.create_variable(name, one.dims, values.dtype)
            for key, words in {**attributes, **on_variables.get(name, {})}.items():
                made.attrs[key] = words
            made[...] = values
        for name, text in texts.items():
            file.create_variable(name, (), h5py.string_dtype())[...] = text


def _coordinate_words(arrays: ChannelArrays) -> tuple[dict[str, dict[str, str]], dict[str, str]]:
    """The attribute ``coordinates`` of each channel, and that of the file for coordinates along which no channel lies (CF 1.11, 5)."""
    plain = {name: set(one.dims) for name, one in arrays.coords.items() if name not in one.dims}
    found = {label: sorted(name for name, dims in plain.items() if dims <= set(one.dims)) for label, one in arrays.variables.items()}
    left = sorted(plain.keys() - {name for names in found.values() for name in names})
    on_file = {"coordinates": " ".join(left)} if left else {}
    return {label: {"coordinates": " ".join(names)} for label, names in found.items() if names}, on_file


def _stored(one: Variable) -> tuple[np.ndarray[Any, Any], Mapping[str, Any]]:
    """Values and attributes as the format has them: it knows no truth values."""
    if one.values.dtype.kind == "b":
        return one.values.astype(np.int8), {**one.attrs, "dtype": "bool"}
    return one.values, one.attrs
