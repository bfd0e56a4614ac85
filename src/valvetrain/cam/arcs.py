"""Lobes ground of circles and straights: the lift that an arc gives a flat face or a roller, and
the frame of a symmetric lobe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.cam.contract import TURN, LiftSpec, check_derivative
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength, guarded, problem


@dataclass(frozen=True, slots=True, kw_only=True)
class Lobe:
    """Symmetric lobe about ``nose`` (cam rad) on a base circle of ``base_radius`` with a nose arc
    of ``nose_radius``, all in m.

    ``maximum_lift``: of the lobe. ``follower_radius``: of a roller or dome on a line through the
    cam's centre, 0 for a flat face.
    """

    continuity: ClassVar[int] = 1

    base_radius: float
    nose_radius: float
    maximum_lift: float
    nose: float
    follower_radius: float = 0.0

    def __post_init__(self) -> None:
        if not (
            self.base_radius > 0
            and self.nose_radius > 0
            and self.maximum_lift > 0
            and self.follower_radius >= 0
        ):
            raise InputError(
                "base_radius, nose_radius and maximum_lift of a lobe must be positive; correct them"
            )
        if not self.nose_distance > 0:
            raise InputError(
                "a nose_radius of base_radius plus maximum_lift is a circle and no lobe; make it smaller"
            )

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
        return tuple(
            self.nose + angle
            for angle in (-self.half_event, -self.half_nose, self.half_nose, self.half_event)
        )

    def flank_height(self, since: Array, derivative: int) -> Array:
        """Distance (m) from the cam's centre to face or roller centre on the flank, ``since`` (rad)
        the first lift, or a derivative.
        """
        raise NotImplementedError

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        away = np.mod(np.asarray(cam_angle, dtype=float) - self.nose + TURN / 2, TURN) - TURN / 2
        side = np.where(away < 0, 1.0, -1.0)
        on_nose = arc_height(
            self.nose_distance, self.nose_radius, self.follower_radius, away, derivative
        )
        on_flank = side**derivative * self.flank_height(
            np.maximum(self.half_event - np.abs(away), 0.0), derivative
        )
        base = self.base_radius + self.follower_radius if derivative == 0 else 0.0
        nose, event = (
            (away >= -self.half_nose) & (away < self.half_nose),
            (away >= -self.half_event) & (away < self.half_event),
        )
        found: Array = np.select([nose, event], [on_nose - base, on_flank - base], 0.0)
        return found


def arc_height(
    distance: float, radius: float, follower_radius: float, away: Array, derivative: int
) -> Array:
    """Distance (m) from the cam's centre to a flat face (``follower_radius`` 0) or to a roller's
    centre on an arc, or its derivative.

    ``distance`` (m) of the arc's centre from the cam's, negative beyond it; ``away`` (rad) from the
    direction of that centre. Flat: distance cos(away) + radius. Roller: the polar radius of a
    circle of radius + follower_radius.
    """
    turned = distance * np.cos(away + derivative * math.pi / 2)
    if follower_radius == 0:
        return np.asarray(turned + (radius if derivative == 0 else 0.0))
    sine = np.sin(2 * away)
    root = np.sqrt(
        np.maximum(
            (radius + follower_radius) ** 2 - (distance * np.sin(away)) ** 2, 1e-12 * radius**2
        )
    )
    first = -(distance**2) * sine / (2 * root)
    second = -(distance**2 * np.cos(2 * away) + first**2) / root
    third = (2 * distance**2 * sine - 3 * first * second) / root
    return np.asarray(turned + (root, first, second, third)[derivative])


@dataclass(frozen=True, slots=True, kw_only=True)
class Tangent(Lobe):
    """Lobe of straights tangent to base circle and nose: cos(half event) = (R_b - R_n) / d.

    A roller's lift is (R_b + r) (1 / cos(angle since opening) - 1) on the flank. A flat face would
    meet the whole flank at once.
    """

    def __post_init__(self) -> None:
        Lobe.__post_init__(self)
        if not self.follower_radius > 0:
            raise InputError(
                "a tangent lobe needs a roller or dome: a flat face would strike its whole flank at once; give follower_radius"
            )
        if not self.nose_radius < self.base_radius:
            raise InputError(
                "nose_radius of a tangent lobe must be smaller than base_radius; correct it"
            )

    @property
    def half_event(self) -> float:
        """Cam angle (rad) from the first lift to the nose."""
        return math.acos((self.base_radius - self.nose_radius) / self.nose_distance)

    @property
    def half_nose(self) -> float:
        """Cam angle (rad) from the end of the flank to the nose."""
        return self.half_event - math.atan2(
            self.nose_distance * math.sin(self.half_event), self.base_radius + self.follower_radius
        )

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
        """Keyword arguments of the law's class; refuses a nose that is no smaller than the base
        circle.
        """
        own = super().values(folder)
        guarded(lambda: Tangent(**own))
        return own


TANGENT_SPEC = LiftSpec(Tangent, TangentModel)


@dataclass(frozen=True, slots=True, kw_only=True)
class ThreeArc(Lobe):
    """Lobe of a flank arc between base circle and nose arc; ``opening_start`` (cam rad): where the
    first lift is, which gives its radius.

    With e the distance of the flank's centre, beyond the cam's, and d that of the nose's: (R_f -
    R_n)^2 = d^2 + e^2 + 2 d e cos a, e = R_f - R_b, a the half event. Lift of a flat face: e (1 -
    cos(angle since opening)) and d cos(angle from nose) + R_n - R_b.
    """

    opening_start: float

    def __post_init__(self) -> None:
        Lobe.__post_init__(self)
        if not 0 < self.half_event < math.pi:
            raise InputError(
                "opening_start must come less than half a cam revolution before nose; correct them"
            )
        room = self.base_radius - self.nose_radius - self.nose_distance * math.cos(self.half_event)
        if not (
            room > 0
            and self.flank_radius > self.base_radius
            and 0 < self.half_nose < self.half_event
        ):
            raise InputError(
                "no convex flank arc is tangent to this base circle and this nose; open earlier, or lower nose_radius or maximum_lift"
            )

    @property
    def half_event(self) -> float:
        """Cam angle (rad) from the first lift to the nose."""
        return self.nose - self.opening_start

    @property
    def flank_radius(self) -> float:
        """Radius (m) of the flank arc."""
        d, base, cosine = self.nose_distance, self.base_radius, math.cos(self.half_event)
        return (d**2 + base**2 - self.nose_radius**2 - 2 * d * base * cosine) / (
            2 * (base - self.nose_radius - d * cosine)
        )

    @property
    def half_nose(self) -> float:
        """Cam angle (rad) from the end of the flank to the nose."""
        beyond, arc = self.flank_radius - self.base_radius, self.half_event
        normal = math.atan2(beyond * math.sin(arc), self.nose_distance + beyond * math.cos(arc))
        if self.follower_radius == 0:
            return normal
        reach = self.nose_radius + self.follower_radius
        return math.atan2(reach * math.sin(normal), self.nose_distance + reach * math.cos(normal))

    def flank_height(self, since: Array, derivative: int) -> Array:
        """See :class:`Lobe`."""
        return arc_height(
            self.base_radius - self.flank_radius,
            self.flank_radius,
            self.follower_radius,
            np.asarray(since),
            derivative,
        )


def half_event(
    base_radius: float, nose_radius: float, maximum_lift: float, flank_radius: float
) -> float:
    """Cam angle (rad) from first lift to nose of the lobe with this ``flank_radius`` (m). Raises
    :class:`InputError` where none exists.
    """
    d, beyond = base_radius + maximum_lift - nose_radius, flank_radius - base_radius
    cosine = (
        ((flank_radius - nose_radius) ** 2 - d**2 - beyond**2) / (2 * d * beyond)
        if d * beyond > 0
        else 2.0
    )
    if not -1 < cosine < 1:
        raise InputError(
            f"a flank arc of {flank_radius * 1e3:g} mm cannot touch both base circle and nose; choose another radius"
        )
    return math.acos(cosine)


class ThreeArcModel(LiftModel):
    """Arcs of base circle, flank and nose, symmetric; one of ``opening_start`` and ``flank_radius``
    gives the other.
    """

    base_radius: PositiveLength
    nose_radius: PositiveLength
    maximum_lift: PositiveLength
    nose: Angle
    opening_start: Angle | None = Field(default=None, description="without it from flank_radius")
    flank_radius: PositiveLength | None = Field(
        default=None, description="without it from opening_start"
    )
    follower_radius: PositiveLength | None = Field(
        default=None, description="of the roller that is lifted; without it a flat face"
    )

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses arcs that do not meet."""
        if (self.opening_start is None) == (self.flank_radius is None):
            raise problem(
                "a three-arc lobe is defined by opening_start or by flank_radius; give one of them"
            )
        start = self.opening_start
        if start is None:
            start = self.nose - guarded(
                half_event,
                self.base_radius,
                self.nose_radius,
                self.maximum_lift,
                self.flank_radius,
                path=("flank_radius",),
            )
        own = {
            "base_radius": self.base_radius,
            "nose_radius": self.nose_radius,
            "maximum_lift": self.maximum_lift,
            "nose": self.nose,
        }
        own |= {"opening_start": start, "follower_radius": self.follower_radius or 0.0}
        guarded(lambda: ThreeArc(**own))
        return own


THREE_ARC_SPEC = LiftSpec(ThreeArc, ThreeArcModel)
