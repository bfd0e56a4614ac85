"""A lift law that caches its last answers: the points of a study evaluate one law at the same
angles again and again.
"""

from __future__ import annotations

from collections import OrderedDict

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw

#: Number of cached answers, and the fewest angles of one that is worth caching.
MAX_ANSWERS, MIN_ANGLES = 24, 64


class RememberedLift:
    """The ``law`` itself, its last answers to long arrays cached; bit-identical, in arrays of the
    caller's own.
    """

    def __init__(self, law: LiftLaw) -> None:
        self._law = law
        self._answers: OrderedDict[tuple[int, int, float, float], tuple[Array, Array]] = (
            OrderedDict()
        )

    @property
    def continuity(self) -> int:
        return self._law.continuity

    @property
    def joints(self) -> tuple[float, ...]:
        return self._law.joints

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        angles = np.asarray(cam_angle, dtype=float)
        if angles.ndim != 1 or len(angles) < MIN_ANGLES:
            return self._law.lift(cam_angle, derivative)
        key = (derivative, len(angles), float(angles[0]), float(angles[-1]))
        if key in self._answers and np.array_equal(self._answers[key][0], angles):
            self._answers.move_to_end(key)
        else:
            self._answers[key] = (
                angles.copy(),
                np.array(self._law.lift(angles, derivative), dtype=float),
            )
            while len(self._answers) > MAX_ANSWERS:
                self._answers.popitem(last=False)
        return self._answers[key][1].copy()
