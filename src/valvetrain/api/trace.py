"""A measured trace over the cam angle, next to the same channel of runs with other values of a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.units import Given, dimension_of, numbers_of, unit_factor

if TYPE_CHECKING:
    import xarray

    from valvetrain.explore.identified import Identified
    from valvetrain.explore.posterior import Datum
    from valvetrain.explore.space import Prior

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: Samples of a trace that are compared, evenly over the cycle; more say nothing new.
MAX_SAMPLES = 180


def channel_of(measured: Any) -> str:
    """The channel that a measured trace is of. Raises :class:`InputError` for what is no trace."""
    name = getattr(measured, "name", None)
    if not name or "cam_angle" not in getattr(measured, "coords", ()) or measured.ndim != 1:
        raise InputError(
            "a measured trace is an xarray.DataArray along cam_angle (rad) whose name is a channel, such as run['seat_force']",
            "measured",
        )
    return str(name)


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
    measured: xarray.DataArray,
    scatter: Given | None,
    ways: Mapping[str, Any],
    **options: Any,
) -> Identified:
    """Values of a case at the keys of ``priors`` with which its channel comes closest to a measured
    one; ``ways``: engine speed, model and spring set of the runs.

    Raises :class:`InputError` for what :meth:`Trace.of` and a run of the case refuse.
    """
    from valvetrain.explore.engine import with_case_units
    from valvetrain.explore.identify import identify
    from valvetrain.explore.space import Space

    channel, keys = channel_of(measured), list(priors)
    with_case_units(case.parameters, Space(priors))  # refuses units that do not fit
    own = case.run(outputs=[channel], **ways)  # what a run refuses is refused here
    trace = Trace.of(measured, scatter, own.unit(channel))
    return identify(
        priors, trace.data(), lambda points: trace.outcomes(case, keys, points, ways), **options
    )
