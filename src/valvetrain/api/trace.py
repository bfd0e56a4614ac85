"""A measured trace over the cam angle, next to the same channel of runs with other values of a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.units import DIMENSIONS, Given, dimension_of, numbers_of, unit_factor

if TYPE_CHECKING:
    import xarray

    from valvetrain.explore.distributions import Prior
    from valvetrain.explore.identified import Identified
    from valvetrain.explore.posterior import Datum

TURN = 2 * np.pi
#: Samples of a trace that are compared, evenly over the cycle; more say nothing new.
MAX_SAMPLES = 180


#: What identifications accept as measured.
ACCEPTED = (
    "give {quantity: (value, standard deviation)}, or a trace over the cam angle (rad): an xarray.DataArray along "
    "cam_angle or a pandas.Series over it whose name is a channel, such as run['seat_force'], a pandas.DataFrame "
    "with the columns cam_angle and seat_force, or {'seat_force': [(cam angle, force), ...]}"
)


def is_trace(measured: Any) -> bool:
    """Whether what was measured is no number for each quantity, ``{quantity: (value, scatter)}``."""
    if not isinstance(measured, Mapping):
        return True
    return any(
        _is_row(item) or hasattr(item, "to_xarray") or hasattr(item, "dims")
        for item in measured.values()
    )


def labelled(measured: Any) -> xarray.DataArray:
    """A measured trace as an array along ``cam_angle`` whose name is its channel, of any of the forms of
    :data:`ACCEPTED`. Raises :class:`InputError` for what is none.
    """
    import xarray

    name = ""
    if isinstance(measured, Mapping) and len(measured) == 1:
        ((name, measured),) = measured.items()
    if hasattr(measured, "columns") or (
        hasattr(measured, "index") and hasattr(measured, "to_frame")
    ):
        measured = _of_table(measured)
    elif _is_row(measured):
        measured = _of_pairs(measured, name)
    if not isinstance(measured, xarray.DataArray):
        raise InputError(f"{type(measured).__name__} is no trace; {ACCEPTED}", "measured")
    found = measured.rename(name) if name else measured
    if not found.name or "cam_angle" not in found.coords or found.ndim != 1 or not found.size:
        raise InputError(f"the trace has no name or no cam angle; {ACCEPTED}", "measured")
    return found


def _is_row(item: Any) -> bool:
    """Whether these are pairs of numbers, one behind the other."""
    if isinstance(item, np.ndarray):
        return item.ndim == 2 and item.shape[1] == 2
    return (
        isinstance(item, (list, tuple))
        and bool(item)
        and all(isinstance(one, (list, tuple, np.ndarray)) and len(one) == 2 for one in item)
    )


def _of_pairs(pairs: Any, name: str) -> xarray.DataArray:
    import xarray

    angles, _ = numbers_of(*(one for one, _ in pairs), dimension="angle")
    values, dimension = numbers_of(*(one for _, one in pairs))
    units = {} if dimension is None else {"units": DIMENSIONS[dimension].si_unit}
    return xarray.DataArray(list(values), {"cam_angle": list(angles)}, "cam_angle", name, units)


def _of_table(table: Any) -> xarray.DataArray | None:
    """The one column of a table of pandas over its cam angle, with the units in their ``attrs``."""
    import xarray

    frame = table if hasattr(table, "columns") else table.to_frame()
    if "cam_angle" not in frame.columns:
        frame = frame.reset_index()
    columns = [one for one in frame.columns if one != "cam_angle"]
    if "cam_angle" not in frame.columns or len(columns) != 1:
        return None
    angle, value = frame["cam_angle"], frame[columns[0]]
    units = getattr(table, "attrs", {}) | value.attrs
    angles = xarray.DataArray(angle.to_numpy(), dims="cam_angle", attrs=angle.attrs)
    return xarray.DataArray(value.to_numpy(), {"cam_angle": angles}, "cam_angle", columns[0], units)


@dataclass(frozen=True, eq=False)
class Trace:
    """``values`` (SI) of a ``channel`` at ``cam_angles`` (rad), each known to ``scatter``."""

    channel: str
    cam_angles: Array
    values: Array
    scatter: float

    @classmethod
    def of(cls, measured: xarray.DataArray, scatter: Given | None, unit: str) -> Trace:
        """The trace of a labelled array: its name is the channel, of ``unit`` (SI) in a run, and
        ``cam_angle`` its coordinate; both are read in the units that their ``attrs`` give, else SI.

        ``scatter``: standard deviation, SI or text with a unit; a hundredth of the span without.
        Raises :class:`InputError` for an array without a cam angle, units that do not fit, and angles
        that can only be degrees.
        """
        given = str(measured.attrs.get("units", unit))
        if dimension_of(given) != dimension_of(unit):
            raise InputError(
                f"the trace of {measured.name} is in {given}, the channel in {unit}; correct attrs['units']",
                "measured",
            )
        angle = measured.coords["cam_angle"]
        angles = np.asarray(angle.values, dtype=float) * unit_factor(
            str(angle.attrs.get("units", "rad"))
        )
        if np.max(np.abs(angles)) > 2 * TURN:
            raise InputError(
                "the cam angles of a trace are in rad over one revolution; those given can only be degrees: say attrs['units'] = 'deg'",
                "measured",
            )
        every = max(1, int(np.ceil(len(measured) / MAX_SAMPLES)))
        values = np.asarray(measured.values, dtype=float)[::every] * unit_factor(given)
        spread = 0.01 * float(np.ptp(values))
        if scatter is not None:
            (spread,), _ = numbers_of(scatter, dimension=dimension_of(unit))
        return cls(str(measured.name), angles[::every], values, spread)

    @property
    def names(self) -> list[str]:
        """A name for every sample."""
        return [f"{self.channel} at {np.degrees(one):.2f} deg" for one in self.cam_angles]

    def data(self) -> tuple[Datum, ...]:
        """The samples as data of an identification."""
        from valvetrain.explore.posterior import Datum

        pairs = zip(self.names, self.values, strict=True)
        return tuple(Datum(name, float(value), self.scatter) for name, value in pairs)

    def outcomes(
        self, case: Any, keys: Sequence[str], points: Array, options: Mapping[str, Any]
    ) -> list[dict[str, float] | None]:
        """The samples by runs of a case with the values of each point at ``keys``; None where it
        cannot be computed.
        """
        return [
            self._outcome(case, dict(zip(keys, map(float, point), strict=True)), options)
            for point in points
        ]

    def _outcome(
        self, case: Any, values: Mapping[str, float], options: Mapping[str, Any]
    ) -> dict[str, float] | None:
        try:
            found = case.set(values).run(outputs=[self.channel], **options)
        except InputError:
            return None
        if not found.status.completed:
            return None
        run = found[self.channel]
        at_angles = np.interp(self.cam_angles, run["cam_angle"], run.values, period=TURN)
        return dict(zip(self.names, map(float, at_angles), strict=True))


def identify_by_trace(
    case: Any,
    priors: Mapping[str, Prior],
    measured: Any,
    scatter: Given | None,
    ways: Mapping[str, Any],
    **options: Any,
) -> Identified:
    """Values of a case at the keys of ``priors`` with which its channel comes closest to a measured
    one; ``ways``: engine speed, model and spring set of the runs.

    Raises :class:`InputError` for what :func:`labelled`, :meth:`Trace.of` and a run of the case refuse.
    """
    from valvetrain.explore.engine import with_case_units
    from valvetrain.explore.requests import identify
    from valvetrain.explore.space import Space

    measured = labelled(measured)
    channel, keys = str(measured.name), list(priors)
    with_case_units(case.parameters, Space(priors))  # refuses units that do not fit
    own = case.run(outputs=[channel], **ways)  # what a run refuses is refused here
    trace = Trace.of(measured, scatter, own.unit(channel))
    return identify(
        priors, trace.data(), lambda points: trace.outcomes(case, keys, points, ways), **options
    )
