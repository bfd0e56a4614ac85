"""One measured quantity over the cam angle, cycle by cycle: what rig data become and what a model is compared with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MeasuredCycles:
    """Repeats of one quantity on a common grid of cam angles.

    Parameters
    ----------
    quantity : what was measured, a name of the table of quantities' traces such as "spring_force" or "valve_lift"
    unit : unit of ``values``, SI ("N", "m", "Pa", "m/s", "m/s^2", "1")
    cam_angle : rad of cam, rising by equal steps over one cycle, 2 pi not included, shape (angles,)
    values : shape (cycles, angles); a repeat that was not measured at an angle holds NaN there
    cam_speed : rad/s, mean over the cycles; 0 where it is not known
    source : where the values come from, such as a file's name
    synthetic : made by computation, not measured; every page says so
    notes : what was found or done on the way, a sentence each

    Raises
    ------
    InputError : shapes that do not agree, angles that do not rise, no cycle at all

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)
    >>> MeasuredCycles("spring_force", "N", angle, 500 + np.outer([1.0, -1.0], np.sin(angle)))
    MeasuredCycles: spring_force, 2 cycles of 360 angles, 499 to 501 N
    """

    quantity: str
    unit: str
    cam_angle: Array
    values: Array
    cam_speed: float = 0.0
    source: str = ""
    synthetic: bool = False
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.values.ndim != 2 or self.values.shape[1] != len(self.cam_angle) or not len(self.values):
            shape = f"values of shape {self.values.shape} for {len(self.cam_angle)} cam angles"
            raise InputError(f"{self.source or self.quantity}: {shape}; one row a cycle is needed")
        if len(self.cam_angle) < 8 or not (np.diff(self.cam_angle) > 0.0).all():
            raise InputError(f"{self.source or self.quantity}: the cam angles must rise and be 8 at least")

    @property
    def mean(self) -> Array:
        """Mean over the cycles, shape (angles,)."""
        mean: Array = np.nanmean(self.values, axis=0)
        return mean

    def __repr__(self) -> str:
        reach = f"{np.nanmin(self.values):.4g} to {np.nanmax(self.values):.4g} {self.unit}"
        return f"MeasuredCycles: {self.quantity}, {len(self.values)} cycles of {len(self.cam_angle)} angles, {reach}"
