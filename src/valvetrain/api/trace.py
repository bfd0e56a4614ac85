"""A measured trace over the cam angle, beside the same channel of runs with other values of a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.units import Given, dimension_of, numbers_of

if TYPE_CHECKING:
    import xarray

    from valvetrain.explore.posterior import Datum

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: Samples of a trace that are compared, evenly over the cycle; more say nothing new.
MAX_SAMPLES = 180


@dataclass(frozen=True, eq=False)
class Trace:
    """``values`` (SI) of a ``channel`` at ``cam_angles`` (rad), each known to ``scatter``."""

    channel: str
    cam_angles: Array
    values: Array
    scatter: float

    @classmethod
    def of(cls, measured: xarray.DataArray, scatter: Given | None) -> Trace:
        """The trace of a labelled array: its name is the channel, ``cam_angle`` (rad) its coordinate.

        ``scatter``: standard deviation, SI or text with a unit; a hundredth of the span without.
        Raises :class:`InputError` for an array without name or cam angle.
        """
        if not measured.name or "cam_angle" not in measured.coords or measured.ndim != 1:
            raise InputError(
                "a measured trace is an xarray.DataArray along cam_angle (rad) whose name is a channel, such as run['seat_force']",
                "measured",
            )
        every = max(1, int(np.ceil(len(measured) / MAX_SAMPLES)))
        values = np.asarray(measured.values, dtype=float)[::every]
        spread = 0.01 * float(np.ptp(values))
        if scatter is not None:
            unit = str(measured.attrs.get("units", ""))
            (spread,), _ = numbers_of(scatter, dimension=dimension_of(unit) if unit else None)
        angles = np.asarray(measured.coords["cam_angle"].values, dtype=float)[::every]
        return cls(str(measured.name), angles, values, spread)

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
