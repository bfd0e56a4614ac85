"""The last cam revolution of a run as a labelled dataset, by cam angle and coil number."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array

if TYPE_CHECKING:
    import xarray

TURN = 2 * np.pi
#: How channels of contacts with one coil number become one, by unit: the least gap, all of the
#: force; others (a status) the largest.
_JOINED = {"m": np.minimum, "N": np.add}


class Revolution(NamedTuple):
    """``samples`` of one cam revolution, its ``number`` (cam angle at its start over 2 pi), and
    whether it is ``whole``.
    """

    samples: slice
    number: int
    whole: bool


def last_revolution(cam_angle: Array) -> Revolution:
    """The last whole cam revolution of unwrapped angles (rad), or the unfinished one where none is
    whole; all samples where there are fewer than two.
    """
    if len(cam_angle) < 2:
        return Revolution(slice(0, len(cam_angle)), first_revolution(cam_angle), False)
    step = float(np.median(np.diff(cam_angle)))
    first_turn = first_revolution(cam_angle)
    last_turn = int(np.floor((cam_angle[-1] + step) / TURN + 1e-6)) - 1
    starts_whole = cam_angle[0] <= first_turn * TURN + step / 2
    whole = last_turn > first_turn or (last_turn == first_turn and starts_whole)
    turn = last_turn if whole else int(np.floor(cam_angle[-1] / TURN + 1e-9))
    first = int(np.searchsorted(cam_angle, turn * TURN - step * 1e-3))
    last = int(np.searchsorted(cam_angle, (turn + 1) * TURN - step * 1e-3))
    return Revolution(slice(first, last), turn, whole)


def first_revolution(cam_angle: Array) -> int:
    """Number of the revolution in which unwrapped angles (rad) begin; 0 where there is none."""
    return int(np.floor(cam_angle[0] / TURN + 1e-9)) if np.isfinite(cam_angle[:1]).any() else 0


def angle_within(cam_angle: Array, revolution: int) -> Array:
    """Unwrapped angles (rad) counted from the start of a revolution."""
    return np.maximum(cam_angle - revolution * TURN, 0.0)


def revolution_coordinate(number: int) -> tuple[tuple[str, ...], int, dict[str, str]]:
    """Coordinate ``revolution`` of a dataset: which revolution its cam angles count from."""
    label = "cam revolution of the run in which the cam angle is zero"
    return (), number, {"units": "1", "long_name": label}


class _Axis(NamedTuple):
    """A dimension of the dataset: ascending ``labels``; ``order`` of the entries stored, and the
    ``begin`` of each label's in that order.
    """

    name: str
    labels: NDArray[Any]
    attrs: dict[str, Any]
    order: NDArray[np.intp]
    begin: NDArray[np.intp]


def cycle_dataset(
    variables: Mapping[str, Any], coords: Mapping[str, Any], attributes: Mapping[str, Any]
) -> xarray.Dataset:
    """The last revolution of the parts of ``ChannelArrays``: dimension ``cam_angle`` (rad, from 0 to
    less than 2 pi) with the coordinate ``time``, along springs ``coil_number`` and ``upper_coil``,
    ascending.
    """
    import xarray

    angle, time = (coords[name] for name in ("cam_angle", "time"))
    part = last_revolution(np.asarray(angle.values))
    axes: dict[str, _Axis] = {}
    data: dict[str, Any] = {}
    for name, one in variables.items():
        values = one.values[part.samples]
        for place, dim in enumerate(one.dims[1:], start=1):
            axis = axes.setdefault(dim, _axis(dim, values.shape[place], coords))
            values = values.take(axis.order, place)
            if len(axis.labels) < len(axis.order):
                join = _JOINED.get(str(one.attrs["units"]), np.maximum)
                values = join.reduceat(values, axis.begin, place)
        data[name] = ("cam_angle", *(axes[dim].name for dim in one.dims[1:])), values, one.attrs
    labels: dict[str, Any] = {
        "cam_angle": (
            "cam_angle",
            angle_within(angle.values[part.samples], part.number),
            {"units": "rad", "long_name": "cam angle"},
        ),
        "time": (
            "cam_angle",
            time.values[part.samples],
            {"units": "s", "long_name": "time", **time.attrs},
        ),
        "revolution": revolution_coordinate(part.number),
    }
    labels |= {axis.name: (axis.name, axis.labels, axis.attrs) for axis in axes.values()}
    return xarray.Dataset(data, coords=labels, attrs=dict(attributes))


def _axis(dim: str, size: int, coords: Mapping[str, Any]) -> _Axis:
    """The labels that are stored along ``dim``, or its own numbers."""
    for name, one in coords.items():
        if one.dims == (dim,) and np.isfinite(one.values).all():
            order = np.argsort(one.values, kind="stable")
            labels, begin = np.unique(one.values[order], return_index=True)
            return _Axis(name, labels, dict(one.attrs), order, begin)
    index, unit = np.arange(size), {"units": "1"}
    if dim.endswith("subsample"):
        label = {"long_name": "share of the time to the next sample"}
        return _Axis(dim, index / max(size, 1), unit | label, index, index)
    label = {"long_name": f"{dim.replace('_', ' ')} number"}
    return _Axis(dim, index + 1, unit | label, index, index)
