"""Numbers that a test gave over engine speed, and where a curve over speed passes a limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class SpeedCurve:
    """Measured numbers over engine speed, such as bounce and loft of a spin rig.

    ``engine_speeds``: rad/s of the crank, ascending. ``values``: name of a quantity -> its numbers (SI), NaN where none was
    measured. ``source``: the file.

    >>> SpeedCurve((500.0, 600.0), {"bounce_height": (0.0, 2e-4)}).values["bounce_height"][1]
    0.0002
    """

    engine_speeds: tuple[float, ...]
    values: Mapping[str, tuple[float, ...]]
    source: str = ""


class Passing(NamedTuple):
    """Where a curve first passes a limit: at ``engine_speed`` by a straight line, between the points at ``low`` and ``high``."""

    engine_speed: float
    low: float
    high: float


def passing(engine_speeds: ArrayLike, values: ArrayLike, limit: float) -> Passing | None:
    """Where ``values`` over ascending ``engine_speeds`` first exceed a ``limit``; None where they stay within it. Points without a
    number are left out.

    >>> passing([1.0, 2.0, 3.0], [0.0, 1.0, 3.0], 2.0)
    Passing(engine_speed=2.5, low=2.0, high=3.0)
    """
    at, curve = np.asarray(engine_speeds, float), np.asarray(values, float)
    at, curve = at[np.isfinite(curve)], curve[np.isfinite(curve)]
    above = np.flatnonzero(curve > limit)
    if not above.size:
        return None
    high = int(above[0])
    low = max(high - 1, 0)
    share = 0.0 if high == low else (limit - curve[low]) / (curve[high] - curve[low])
    speed = at[low] + share * (at[high] - at[low])
    return Passing(float(speed), float(at[low]), float(at[high]))
