"""Channels of a run: names, dimensions, units and labels, as plain arrays and as an xarray dataset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.errors import InputError
from valvetrain.solution.cycle_view import (
    TURN,
    angle_within,
    cycle_dataset,
    first_revolution,
    revolution_coordinate,
)

if TYPE_CHECKING:
    import xarray

#: Label of the stored cam angle, which counts on over the revolutions of a run.
CAM_ANGLE_LABEL = "cam angle, unwrapped"


class Variable(NamedTuple):
    """Dimensions, values (SI) and attributes (``units``, ``long_name``) of one channel or
    coordinate.
    """

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class ChannelArrays:
    """``variables`` and ``coords``: name -> :class:`Variable`, those of a run first dimension
    ``sample``; ``attributes`` of the whole.
    """

    variables: Mapping[str, Variable]
    coords: Mapping[str, Variable]
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def stored(self) -> xarray.Dataset:
        """The same, labelled; the arrays are shared, not copied."""
        import xarray

        return xarray.Dataset(
            dict(self.variables), coords=dict(self.coords), attrs=dict(self.attributes)
        )

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """As :attr:`stored`, with ``cam_angle`` counted from the start of the revolution in which
        the samples begin, which is the scalar coordinate ``revolution``.
        """
        if "cam_angle" not in self.coords:
            return self.stored
        angle = self.coords["cam_angle"]
        number = first_revolution(angle.values)
        if number:
            values = angle_within(angle.values, number)
            attrs = {**angle.attrs, "long_name": "cam angle from the start of the revolution"}
            counted = self.stored.assign_coords(cam_angle=(angle.dims, values, attrs))
        else:
            counted = self.stored
        return counted.assign_coords(revolution=revolution_coordinate(number))

    @cached_property
    def cycle(self) -> xarray.Dataset:
        """The last cam revolution by cam angle and coil number."""
        return cycle_dataset(self.variables, self.coords, self.attributes)

    def __reduce__(self) -> tuple[object, ...]:
        return ChannelArrays, (dict(self.variables), dict(self.coords), dict(self.attributes))

    def only(self, names: Iterable[str]) -> ChannelArrays:
        """The channels ``names`` with the coordinates along them."""
        variables = {name: self.variables[name] for name in names}
        dims = {dim for one in variables.values() for dim in one.dims} | {"sample"}
        chosen = {name: one for name, one in self.coords.items() if set(one.dims) <= dims}
        return ChannelArrays(variables, chosen, self.attributes)

    def __getitem__(self, name: str) -> Variable:
        return self.variables[name]

    def assign(self, added: Mapping[str, Variable]) -> ChannelArrays:
        """A copy with ``added`` channels."""
        return ChannelArrays({**self.variables, **added}, self.coords, self.attributes)

    def at(self, places: Mapping[str, Sequence[int]]) -> ChannelArrays:
        """A copy with the entries at ``places`` (dimension -> indices) only."""

        def cut(variable: Variable) -> Variable:
            values = variable.values
            for axis, dim in enumerate(variable.dims):
                values = values.take(places[dim], axis) if dim in places else values
            return variable._replace(values=values)

        variables, coords = (
            {name: cut(one) for name, one in group.items()}
            for group in (self.variables, self.coords)
        )
        return ChannelArrays(variables, coords, self.attributes)

    def along(self, name: str) -> NDArray[Any] | None:
        """Labels of the second dimension of channel ``name``, such as coil numbers; None where it
        has none.
        """
        dims = self.variables[name].dims[1:]
        return next(
            (axis.values for axis in self.coords.values() if dims and axis.dims == dims), None
        )


def arrays_of(channels: xarray.Dataset | ChannelArrays) -> ChannelArrays:
    """Plain arrays of a labelled dataset, which stays their dataset where it has ``revolution``."""
    if isinstance(channels, ChannelArrays):
        return channels
    named = {
        str(name): Variable(tuple(map(str, one.dims)), one.values, one.attrs)
        for name, one in channels.variables.items()
    }
    coords = {str(name): named.pop(str(name)) for name in channels.coords}
    if (revolution := coords.pop("revolution", None)) is not None and "cam_angle" in coords:
        angle = coords["cam_angle"]
        if number := int(revolution.values):
            attrs = {**angle.attrs, "long_name": CAM_ANGLE_LABEL}
            coords["cam_angle"] = Variable(angle.dims, angle.values + number * TURN, attrs)
    made = ChannelArrays(named, coords, channels.attrs)
    if revolution is not None:
        made.__dict__["dataset"] = channels
    return made


def empty_channels() -> ChannelArrays:
    """Channels of a run without any."""
    return ChannelArrays(
        {}, {name: Variable(("sample",), np.zeros(0), {}) for name in ("time", "cam_angle")}
    )


class DatasetField:
    """Field of a solution that takes a dataset or plain arrays, stores the arrays and returns the
    dataset.
    """

    def __get__(self, owner: Any, kind: type) -> xarray.Dataset:
        if owner is None:
            raise AttributeError("channels belong to a solution, not to its class")
        found: xarray.Dataset = owner.arrays.dataset
        return found

    def __set__(self, owner: Any, channels: xarray.Dataset | ChannelArrays) -> None:
        arrays = arrays_of(channels)
        for name in ("time", "cam_angle"):
            if name not in arrays.coords or arrays.coords[name].dims != ("sample",):
                raise InputError(
                    f"a solution needs the coordinate '{name}' along its dimension 'sample'; add it"
                )
        for label, variable in arrays.variables.items():
            if variable.dims[:1] != ("sample",):
                raise InputError(
                    f"channel '{label}' of a solution must have 'sample' as its first dimension; it has {variable.dims}"
                )
            for key in ("units", "long_name"):
                if key not in variable.attrs:
                    raise InputError(
                        f"channel '{label}' of a solution lacks the attribute '{key}'; give it"
                    )
        owner.__dict__["_arrays"] = arrays


#: channel -> (dimension after ``sample`` or None, SI unit, label)
SPRING_CHANNELS: dict[str, tuple[str | None, str, str]] = {
    "valve_lift": (None, "m", "valve lift"),
    "retainer_velocity": (None, "m/s", "retainer velocity, opening positive"),
    "retainer_acceleration": (None, "m/s2", "retainer acceleration, opening positive"),
    "seat_force": (None, "N", "force on the lower seat, compressive positive"),
    "retainer_force": (None, "N", "force on the retainer, compressive positive"),
    "axial_displacement": (
        "wire_point",
        "m",
        "axial displacement from the installed state, seat to retainer positive",
    ),
    "axial_velocity": ("wire_point", "m/s", "axial velocity, seat to retainer positive"),
    "axial_acceleration": ("wire_point", "m/s2", "axial acceleration, seat to retainer positive"),
    "axial_position": ("wire_point", "m", "height of the wire axis above the lower seat"),
    "torsional_moment": ("wire_point", "N m", "torsional moment of the wire"),
    "bending_moment": ("wire_point", "N m", "bending moment of the wire about its outward normal"),
    "binormal_moment": (
        "wire_point",
        "N m",
        "bending moment of the wire about the binormal, in the coil plane",
    ),
    "normal_force": ("wire_point", "N", "normal force of the wire, tension positive"),
    "shear_force": ("wire_point", "N", "shear force of the wire"),
    "coil_gap": (
        "coil_pair",
        "m",
        "gap between a coil and the one below, negative when pressed together",
    ),
    "coil_contact_force": ("coil_pair", "N", "contact force between a coil and the one below"),
    "guide_force": (None, "N", "sum of the normal forces between the wire and its guide"),
    "contact_status": ("coil_pair", "1", "0 open, 1 near, 2 touching, 3 sliding"),
    "kinetic_energy": (None, "J", "kinetic energy of the wire"),
    "elastic_energy": (None, "J", "elastic energy of the wire"),
    "contact_energy": (None, "J", "energy stored in contacts"),
    "work_done": (None, "J", "work done on the spring by the retainer since the start"),
    "energy_dissipated": (None, "J", "energy turned to heat since the start"),
}


#: Channels between the samples, on the steps of the integrator.
FINE: dict[str, tuple[tuple[str, ...], str, str]] = {
    "seat_force_fine": (("subsample",), "N", "seat force at even substeps after each sample"),
    "seat_force_finest": (
        ("fine_subsample",),
        "N",
        "seat force at fifty even places up to the next sample",
    ),
    "retainer_force_fine": (
        ("subsample",),
        "N",
        "retainer force at even substeps after each sample",
    ),
    "seat_force_highest": ((), "N", "largest seat force on any step up to the next sample"),
    "seat_force_highest_time": ((), "s", "time of the largest seat force up to the next sample"),
    "seat_force_lowest": ((), "N", "minimum seat force on any step up to the next sample"),
    "seat_force_lowest_time": ((), "s", "time of the minimum seat force up to the next sample"),
    "retainer_force_highest": ((), "N", "largest retainer force on any step up to the next sample"),
    "retainer_force_highest_time": (
        (),
        "s",
        "time of the largest retainer force up to the next sample",
    ),
    "retainer_force_lowest": ((), "N", "minimum retainer force on any step up to the next sample"),
    "retainer_force_lowest_time": (
        (),
        "s",
        "time of the minimum retainer force up to the next sample",
    ),
    "coil_contact_peak_force": (("coil_pair",), "N", "largest contact force since the last sample"),
    "coil_line_force": (
        ("coil_point",),
        "N/m",
        "largest force per length on the coil below since the last sample",
    ),
    "seat_line_force": (
        ("seat_point",),
        "N/m",
        "largest force per length of free wire on the seat since the last sample",
    ),
    "retainer_line_force": (
        ("retainer_point",),
        "N/m",
        "largest force per length of free wire on the retainer since the last sample",
    ),
    "surface_equivalent_stress": (
        ("surface_point",),
        "Pa",
        "von Mises stress on the surface of the wire, of each place from the outer fibre upward",
    ),
}

#: Suffixes of the channels of an end force on every step: value and time of the largest and of the
#: least up to the next sample.
EXTREMES = ("highest", "highest_time", "lowest", "lowest_time")


def spring_channels(
    time: ArrayLike,
    cam_angle: ArrayLike,
    values: Mapping[str, ArrayLike],
    *,
    coil_number: ArrayLike | None = None,
    upper_coil: ArrayLike | None = None,
    extra: Mapping[str, tuple[tuple[str, ...], str, str]] | None = None,
    point_coils: Mapping[str, ArrayLike] | None = None,
) -> ChannelArrays:
    """The channels of a spring run from plain arrays.

    ``values``: channel name -> array (sample,) or (sample, wire_point / coil_pair), SI. ``extra``
    declares further channels as name -> (dims after ``sample``, unit, label); ``point_coils``: dimension
    of points of contact -> their coil numbers. Raises :class:`InputError` for an undeclared name.
    """
    declared: dict[str, tuple[tuple[str, ...], str, str]] = {
        name: ((second,) if second else (), unit, label)
        for name, (second, unit, label) in SPRING_CHANNELS.items()
    }
    declared.update(extra or {})
    variables = {}
    for name, array in values.items():
        if name not in declared:
            raise InputError(
                f"channel '{name}' is not declared; name it in SPRING_CHANNELS or pass it in extra"
            )
        dims, unit, long_name = declared[name]
        kind = np.int64 if name == "contact_status" else np.float64
        variables[name] = Variable(
            ("sample", *dims),
            np.asarray(array, dtype=kind),
            {"units": unit, "long_name": long_name},
        )
    axes = (
        ("time", "sample", time, "s", "time"),
        ("cam_angle", "sample", cam_angle, "rad", CAM_ANGLE_LABEL),
        ("coil_number", "wire_point", coil_number, "1", "turns from the lower wire tip"),
        ("upper_coil", "coil_pair", upper_coil, "1", "coil number of the upper partner"),
        *(
            (f"{dim}_coil", dim, coil, "1", "turns from the lower wire tip")
            for dim, coil in (point_coils or {}).items()
        ),
    )
    coords = {
        name: Variable((dim,), np.asarray(values, dtype=float), {"units": unit, "long_name": label})
        for name, dim, values, unit, label in axes
        if values is not None
    }
    return ChannelArrays(variables, coords)
