"""Lobes ground of circles and straights: the lift that an arc gives a flat face or a roller, and the frame of a symmetric lobe."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array, check_derivative
from valvetrain.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Lobe:
    """Symmetric lobe about ``nose`` (cam rad) on a base circle of ``base_radius`` with a nose arc of ``nose_radius``, all in m.

    ``maximum_lift``: of the lobe. ``follower_radius``: of a roller or dome on a line through the cam's centre, 0 for a flat face.
    """

    continuity: ClassVar[int] = 1

    base_radius: float
    nose_radius: float
    maximum_lift: float
    nose: float
    follower_radius: float = 0.0

    def __post_init__(self) -> None:
        if not (self.base_radius > 0 and self.nose_radius > 0 and self.maximum_lift > 0 and self.follower_radius >= 0):
            raise InputError("base_radius, nose_radius and maximum_lift of a lobe must be positive; correct them")
        if not self.nose_distance > 0:
            raise InputError("a nose_radius of base_radius plus maximum_lift is a circle and no lobe; make it smaller")

    @property
    def nose_distance(self) -> float:
        """Distance (m) of the nose arc's centre from the cam's."""
        return self.base_radius + self.maximum_lift - self.nose_radius

    @property
    def half_event(self) -> float:
        """Cam angle (rad) from the first lift to the nose."""
        raise NotImplementedError

    @property
    def half_nose(self) -> float:
        """Cam angle (rad) from the end of the flank to the nose."""
        raise NotImplementedError

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(self.nose + angle for angle in (-self.half_event, -self.half_nose, self.half_nose, self.half_event))

    def flank_height(self, since: Array, derivative: int) -> Array:
        """Distance (m) from the cam's centre to face or roller centre on the flank, ``since`` (rad) the first lift, or a derivative."""
        raise NotImplementedError

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        away = np.mod(np.asarray(cam_angle, dtype=float) - self.nose + TURN / 2, TURN) - TURN / 2
        side = np.where(away < 0, 1.0, -1.0)
        on_nose = arc_height(self.nose_distance, self.nose_radius, self.follower_radius, away, derivative)
        on_flank = side**derivative * self.flank_height(np.maximum(self.half_event - np.abs(away), 0.0), derivative)
        base = self.base_radius + self.follower_radius if derivative == 0 else 0.0
        nose, event = (away >= -self.half_nose) & (away < self.half_nose), (away >= -self.half_event) & (away < self.half_event)
        found: Array = np.select([nose, event], [on_nose - base, on_flank - base], 0.0)
        return found


def arc_height(distance: float, radius: float, follower_radius: float, away: Array, derivative: int) -> Array:
    """Distance (m) from the cam's centre to a flat face (``follower_radius`` 0) or to a roller's centre on an arc, or its derivative.

    ``distance`` (m) of the arc's centre from the cam's, negative beyond it; ``away`` (rad) from the direction of that centre. Flat:
    distance cos(away) + radius. Roller: the polar radius of a circle of radius + follower_radius.
    """
    turned = distance * np.cos(away + derivative * math.pi / 2)
    if follower_radius == 0:
        return np.asarray(turned + (radius if derivative == 0 else 0.0))
    sine = np.sin(2 * away)
    root = np.sqrt(np.maximum((radius + follower_radius) ** 2 - (distance * np.sin(away)) ** 2, 1e-12 * radius**2))
    first = -(distance**2) * sine / (2 * root)
    second = -(distance**2 * np.cos(2 * away) + first**2) / root
    third = (2 * distance**2 * sine - 3 * first * second) / root
    return np.asarray(turned + (root, first, second, third)[derivative])
