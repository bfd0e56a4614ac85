"""Channels of a run as plain arrays; the labelled dataset is made of them when it is asked for, so that most runs need no xarray."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

if TYPE_CHECKING:
    import xarray


class Variable(NamedTuple):
    """Dimensions, values (SI) and attributes (``units``, ``long_name``) of one channel or coordinate."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class ChannelArrays:
    """``variables`` and ``coords``: name -> :class:`Variable`, those of a run first dimension ``sample``; ``attributes`` of the whole."""

    variables: Mapping[str, Variable]
    coords: Mapping[str, Variable]
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """The same, labelled; the arrays are shared, not copied."""
        import xarray

        return xarray.Dataset(dict(self.variables), coords=dict(self.coords), attrs=dict(self.attributes))

    def __reduce__(self) -> tuple[object, ...]:
        return ChannelArrays, (dict(self.variables), dict(self.coords), dict(self.attributes))

    def __getitem__(self, name: str) -> Variable:
        return self.variables[name]

    def assign(self, added: Mapping[str, Variable]) -> ChannelArrays:
        """A copy with ``added`` channels."""
        return ChannelArrays({**self.variables, **added}, self.coords, self.attributes)

    def at(self, places: Mapping[str, Sequence[int]]) -> ChannelArrays:
        """A copy with the entries at ``places`` (dimension -> indices) only."""

        def cut(one: Variable) -> Variable:
            values = one.values
            for axis, dim in enumerate(one.dims):
                values = values.take(places[dim], axis) if dim in places else values
            return one._replace(values=values)

        variables, coords = ({name: cut(one) for name, one in group.items()} for group in (self.variables, self.coords))
        return ChannelArrays(variables, coords, self.attributes)

    def along(self, name: str) -> NDArray[Any] | None:
        """Labels of the second dimension of channel ``name``, such as coil numbers; None where it has none."""
        dims = self.variables[name].dims[1:]
        return next((axis.values for axis in self.coords.values() if dims and axis.dims == dims), None)


def arrays_of(channels: xarray.Dataset | ChannelArrays) -> ChannelArrays:
    """Plain arrays of a labelled dataset, which stays their dataset."""
    if isinstance(channels, ChannelArrays):
        return channels
    named = {str(name): Variable(tuple(map(str, one.dims)), one.values, one.attrs) for name, one in channels.variables.items()}
    coords = {str(name): named.pop(str(name)) for name in channels.coords}
    made = ChannelArrays(named, coords, channels.attrs)
    made.__dict__["dataset"] = channels
    return made


def empty_channels() -> ChannelArrays:
    """Channels of a run that kept none."""
    return ChannelArrays({}, {name: Variable(("sample",), np.zeros(0), {}) for name in ("time", "cam_angle")})


class DatasetField:
    """Field of a solution that takes a dataset or plain arrays, keeps the arrays as ``arrays`` and gives the dataset."""

    def __get__(self, owner: Any, kind: type) -> xarray.Dataset:
        if owner is None:
            raise AttributeError("channels belong to a solution, not to its class")
        found: xarray.Dataset = owner.arrays.dataset
        return found

    def __set__(self, owner: Any, channels: xarray.Dataset | ChannelArrays) -> None:
        arrays = arrays_of(channels)
        _check(arrays)
        owner.__dict__["_arrays"] = arrays


def _check(arrays: ChannelArrays) -> None:
    for name in ("time", "cam_angle"):
        if name not in arrays.coords or arrays.coords[name].dims != ("sample",):
            raise InputError(f"a solution needs the coordinate '{name}' along its dimension 'sample'; add it")
    for label, variable in arrays.variables.items():
        if not variable.dims or variable.dims[0] != "sample":
            raise InputError(f"channel '{label}' of a solution must have 'sample' as its first dimension; it has {variable.dims}")
        for key in ("units", "long_name"):
            if key not in variable.attrs:
                raise InputError(f"channel '{label}' of a solution lacks the attribute '{key}'; give it")
