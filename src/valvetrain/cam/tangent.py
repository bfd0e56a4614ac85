"""Tangent lobe: straight flanks between base circle and nose arc, for a roller or dome; the acceleration jumps where they meet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.cam.arcs import Lobe
from valvetrain.cam.contract import Array, LiftSpec
from valvetrain.errors import InputError
from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength, guarded


@dataclass(frozen=True, slots=True, kw_only=True)
class Tangent(Lobe):
    """Lobe of straights tangent to base circle and nose: cos(half event) = (R_b - R_n) / d.

    A roller's lift is (R_b + r) (1 / cos(angle since opening) - 1) on the flank. A flat face would meet the whole flank at once.
    """

    def __post_init__(self) -> None:
        Lobe.__post_init__(self)
        if not self.follower_radius > 0:
            raise InputError(
                "a tangent lobe needs a roller or dome: a flat face would strike its whole flank at once; give follower_radius"
            )
        if not self.nose_radius < self.base_radius:
            raise InputError("nose_radius of a tangent lobe must be smaller than base_radius; correct it")

    @property
    def half_event(self) -> float:
        """Cam angle (rad) from the first lift to the nose."""
        return math.acos((self.base_radius - self.nose_radius) / self.nose_distance)

    @property
    def half_nose(self) -> float:
        """Cam angle (rad) from the end of the flank to the nose."""
        return self.half_event - math.atan2(self.nose_distance * math.sin(self.half_event), self.base_radius + self.follower_radius)

    def flank_height(self, since: Array, derivative: int) -> Array:
        """See :class:`Lobe`."""
        bounded = np.minimum(since, self.half_event - self.half_nose)
        secant, tangent = 1 / np.cos(bounded), np.tan(bounded)
        factors = (1.0, tangent, 1 + 2 * tangent**2, tangent * (5 + 6 * tangent**2))
        return np.asarray((self.base_radius + self.follower_radius) * secant * factors[derivative])


class TangentModel(LiftModel):
    """Straight flanks between base circle and nose arc, symmetric, under a roller or dome."""

    base_radius: PositiveLength
    nose_radius: PositiveLength
    maximum_lift: PositiveLength
    nose: Angle
    follower_radius: PositiveLength

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses a nose that is no smaller than the base circle."""
        own = super().values(folder)
        guarded(lambda: Tangent(**own))
        return own


SPEC = LiftSpec(Tangent, TangentModel)
