"""Crank slider on the 2:1 drive: piston travel over the cam angle and the clearance between piston and valve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.parameters.train import CrankParameters

Array = NDArray[np.float64]


def piston_travel(crank: CrankParameters, cam_angle: ArrayLike) -> Array:
    """Distance (m) of the piston below its top dead centre; the crank turns twice per cam turn.

    Exact slider: s = top - (r cos a + sqrt(l**2 - (r sin a - e)**2)), with offset e and top dead centre at ``top_dead_centre``
    (of the centred crank; an offset shifts the true highest point by a fraction of a degree).
    """
    angle = 2 * (np.asarray(cam_angle, dtype=float) - crank.top_dead_centre)
    reach = crank.radius * np.cos(angle) + np.sqrt(crank.rod_length**2 - (crank.radius * np.sin(angle) - crank.offset) ** 2)
    top = np.sqrt((crank.radius + crank.rod_length) ** 2 - crank.offset**2)
    found: Array = top - reach
    return found


def piston_clearance(crank: CrankParameters, cam_angle: ArrayLike, valve_lift: ArrayLike) -> Array:
    """Gap (m) between piston crown and valve along the cylinder; negative where they would meet."""
    found: Array = crank.clearance + piston_travel(crank, cam_angle) - np.asarray(valve_lift) * np.cos(crank.valve_inclination)
    return found
