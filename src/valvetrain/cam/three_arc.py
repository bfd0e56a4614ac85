"""Three-arc lobe: base circle, flank arc and nose arc, each tangent to the next; the acceleration jumps where they meet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from valvetrain.cam.arcs import Lobe, arc_height
from valvetrain.cam.contract import Array, LiftSpec
from valvetrain.errors import InputError
from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength, guarded, problem


@dataclass(frozen=True, slots=True, kw_only=True)
class ThreeArc(Lobe):
    """Lobe of a flank arc between base circle and nose arc; ``opening_start`` (cam rad): where the first lift is, which gives its radius.

    With e the distance of the flank's centre, beyond the cam's, and d that of the nose's: (R_f - R_n)^2 = d^2 + e^2 + 2 d e cos a,
    e = R_f - R_b, a the half event. Lift of a flat face: e (1 - cos(angle since opening)) and d cos(angle from nose) + R_n - R_b.
    """

    opening_start: float

    def __post_init__(self) -> None:
        Lobe.__post_init__(self)
        if not 0 < self.half_event < math.pi:
            raise InputError("opening_start must come less than half a cam revolution before nose; correct them")
        room = self.base_radius - self.nose_radius - self.nose_distance * math.cos(self.half_event)
        if not (room > 0 and self.flank_radius > self.base_radius and 0 < self.half_nose < self.half_event):
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
        return (d**2 + base**2 - self.nose_radius**2 - 2 * d * base * cosine) / (2 * (base - self.nose_radius - d * cosine))

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
        return arc_height(self.base_radius - self.flank_radius, self.flank_radius, self.follower_radius, np.asarray(since), derivative)


def half_event(base_radius: float, nose_radius: float, maximum_lift: float, flank_radius: float) -> float:
    """Cam angle (rad) from first lift to nose of the lobe with this ``flank_radius`` (m). Raises :class:`InputError` where none exists."""
    d, beyond = base_radius + maximum_lift - nose_radius, flank_radius - base_radius
    cosine = ((flank_radius - nose_radius) ** 2 - d**2 - beyond**2) / (2 * d * beyond) if d * beyond > 0 else 2.0
    if not -1 < cosine < 1:
        raise InputError(f"a flank arc of {flank_radius * 1e3:g} mm cannot touch both base circle and nose; choose another radius")
    return math.acos(cosine)


class ThreeArcModel(LiftModel):
    """Arcs of base circle, flank and nose, symmetric; one of ``opening_start`` and ``flank_radius`` tells the other."""

    base_radius: PositiveLength
    nose_radius: PositiveLength
    maximum_lift: PositiveLength
    nose: Angle
    opening_start: Angle | None = Field(default=None, description="without it from flank_radius")
    flank_radius: PositiveLength | None = Field(default=None, description="without it from opening_start")
    follower_radius: PositiveLength | None = Field(default=None, description="of the roller that is lifted; without it a flat face")

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses arcs that do not meet."""
        if (self.opening_start is None) == (self.flank_radius is None):
            raise problem("a three-arc lobe is defined by opening_start or by flank_radius; give one of them")
        start = self.opening_start
        if start is None:
            start = self.nose - guarded(
                half_event, self.base_radius, self.nose_radius, self.maximum_lift, self.flank_radius, path=("flank_radius",)
            )
        own = {"base_radius": self.base_radius, "nose_radius": self.nose_radius, "maximum_lift": self.maximum_lift, "nose": self.nose}
        own |= {"opening_start": start, "follower_radius": self.follower_radius or 0.0}
        guarded(lambda: ThreeArc(**own))
        return own


SPEC = LiftSpec(ThreeArc, ThreeArcModel)
