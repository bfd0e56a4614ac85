"""The bodies of a valvetrain, one table of [train] each, in SI. Plane of motion x-y, cam centre at
the origin.
"""

from __future__ import annotations

import math
from dataclasses import InitVar
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationInfo

from valvetrain.parameters.schema_types import (
    FOLLOWS,
    MAX_MASS,
    Angle,
    Angles,
    Density,
    Lash,
    Length,
    Mass,
    Modulus,
    PositiveLength,
    Ratio,
    Stiffness,
    Table,
    problem,
    quantities,
    quantity,
    table,
)
from valvetrain.units import warn_unusual

#: Moments of inertia (kg m2) beyond this are slips, as masses beyond theirs.
MAX_INERTIA = 1e2
#: Least and largest value (SI) of what is common in engines, ships' among them, and its unit.
_MASS, _LENGTH, _ARC = (1e-5, 20.0, "g"), (1e-4, 1.0, "mm"), (1e-4, 20.0, "mm")


def _two(numbers: Any, info: ValidationInfo) -> Any:
    if len(numbers) != 2:
        raise problem(
            f"{info.field_name} is a point in the plane of motion, two lengths (x, y) from the cam centre; it has {len(numbers)}"
        )
    return numbers


Damping = Annotated[float, quantity("damping", low=0.0)]
Inertia = Annotated[float, quantity("moment of inertia", low=0.0, high=MAX_INERTIA, open_low=True)]
NotNegativeMass = Annotated[float, quantity("mass", low=0.0, high=MAX_MASS)]
Friction = Annotated[float, quantity("force", low=0.0)]
Velocity = Annotated[float, quantity("velocity", low=0.0, open_low=True)]
Torque = Annotated[float, quantity("moment", low=0.0)]
LeverRatio = Annotated[float, quantity("ratio", low=0.1, high=10.0)]
Forces = Annotated[tuple[float, ...], quantities("force")]
Point = Annotated[tuple[float, float], BeforeValidator(_two), quantities("length")]


@table("the cam")
class CamParameters(Table):
    """The cam: lengths in m; elastic data for Hertz pressure (Pa)."""

    base_radius: PositiveLength
    width: PositiveLength = Field(default=0.012, description="face width")
    rotation: Literal[1, -1] = Field(default=1, description="1 counter-clockwise, -1 clockwise")
    youngs_modulus: Modulus = Field(default=206e9, description="for the pressure of the contact")
    poisson_ratio: Ratio = Field(default=0.3, description="for the pressure of the contact")

    def __post_init__(self) -> None:
        warn_unusual(self, "the cam", base_radius=_LENGTH, width=_LENGTH)


@table("the follower")
class FollowerParameters(Table):
    """What touches the cam, with its arc ``radius`` (m; 0 for flat and knife), and what slides with it."""

    shape: Literal["flat", "domed", "roller", "knife"] = Field(
        default="flat", description="what touches the cam"
    )
    radius: Length = Field(default=0.0, description="of its arc; none of a flat or knife")
    mass: NotNegativeMass = Field(default=0.0, description="of a sliding follower")
    offset: Length = Field(default=0.0, description="of its axis from the cam centre")
    tilt: Angle = Field(default=0.0, description="lean of a flat face")
    damping: Damping = Field(default=0.0, description="in its guide")
    friction: Friction = Field(default=0.0, description="in its guide")
    face_diameter: PositiveLength | None = Field(
        default=None,
        description="of a flat face, on which the contact must stay; without it not looked at",
    )

    def __post_init__(self) -> None:
        if self.shape in ("domed", "roller") and not self.radius > 0:
            raise problem(
                f"a {self.shape} follower needs a positive radius; it is {self.radius:g} m"
            )
        if self.shape in ("flat", "knife") and self.radius != 0:
            raise problem(f"a {self.shape} follower has no radius; remove it or use a domed one")
        if not abs(self.tilt) < math.radians(30):
            raise problem("the tilt of a flat follower must stay below 30 degrees")
        warn_unusual(self, "the follower", radius=_ARC, mass=_MASS)


@table("the lever")
class LeverParameters(Table):
    """A finger follower or rocker turning about ``pivot`` (m).

    ``drive_arm`` (m): pivot to the centre of the cam pad's arc, or to the pushrod ball;
    ``valve_arm``: pivot to the centre of the tip's arc. ``drive_angle`` None lets the base circle
    decide (cam-driven levers), ``drive_side`` then picks one of the two solutions. ``stiffness``
    None: rigid. ``holding_torque`` (N m) of a hairpin spring keeps the lever from floating in the lash.
    """

    pivot: Point
    drive_arm: PositiveLength
    valve_arm: PositiveLength = Field(
        default=FOLLOWS, description="without it drive_arm times ratio"
    )
    inertia: Inertia = Field(kw_only=True)
    valve_angle: Angle = Field(
        default=0.0, description="polar direction from the pivot to the tip, valve closed"
    )
    drive_angle: Angle | None = Field(
        default=None,
        description="polar direction of the drive end; without it the base circle decides",
    )
    drive_side: Literal[1, -1] = Field(
        default=1, description="which of the two positions on the base circle"
    )
    mass: NotNegativeMass = Field(default=0.0, description="that moves with the support")
    stiffness: Stiffness | None = Field(
        default=None, description="at the valve tip; without it rigid"
    )
    damping: Damping = Field(default=0.0, description="at the valve tip")
    holding_torque: Torque = Field(
        default=0.0, description="that presses the lever towards its drive"
    )
    tip_radius: Lash = Field(default=0.0, description="of the arc on the stem, for friction")
    ratio: InitVar[LeverRatio | None] = Field(
        default=None,
        description="valve_arm over drive_arm, as cards give it; without it from valve_arm",
    )

    def __post_init__(self, ratio: float | None) -> None:
        if self.valve_arm is None and ratio is None:
            raise problem(
                "the lever needs valve_arm, or ratio (valve_arm over drive_arm); add one",
                ("valve_arm",),
            )
        if self.valve_arm is None and ratio is not None:
            object.__setattr__(self, "valve_arm", self.drive_arm * ratio)
        made = self.valve_arm / self.drive_arm
        if ratio is not None and abs(made / ratio - 1) > 0.005:
            raise problem(
                f"ratio {ratio:g} contradicts the arms, whose ratio is {made:.4g}; drop one of the three",
                ("ratio",),
            )
        warn_unusual(self, "the lever", drive_arm=_LENGTH, valve_arm=_LENGTH, mass=_MASS)


@table("the pushrod")
class PushrodParameters(Table):
    """A pushrod; ``lower_end`` (m) is its ball in the tappet at zero lift. A value given goes before that
    of the tube.

    ``stiffness`` None: rigid. The length moves nothing, for the motion has that between both balls;
    with ``youngs_modulus`` and ``density`` it judges mass and stiffness.
    """

    mass: Mass = Field(default=FOLLOWS, description="without it that of the tube")
    lower_end: Point = Field(kw_only=True)
    stiffness: Stiffness | None = Field(
        default=None, description="of the bar; without it that of the tube, without a tube rigid"
    )
    damping: Damping = Field(default=0.0, description="of the bar")
    length: PositiveLength | None = Field(default=None, description="of the tube")
    youngs_modulus: Modulus = Field(default=206e9, description="of the tube; without it of steel")
    density: Density = Field(default=7850.0, description="of the tube; without it of steel")
    outer_diameter: InitVar[PositiveLength | None] = Field(default=None, description="of the tube")
    wall_thickness: InitVar[PositiveLength | None] = Field(default=None, description="of the tube")

    def __post_init__(self, outer_diameter: float | None, wall_thickness: float | None) -> None:
        tube = {
            "length": self.length, "outer_diameter": outer_diameter, "wall_thickness": wall_thickness,
        }  # fmt: skip
        missing = [key for key, value in tube.items() if value is None]
        if self.length is not None and outer_diameter is not None and wall_thickness is not None:
            if not 2 * wall_thickness <= outer_diameter:
                raise problem(
                    f"a wall of {wall_thickness * 1e3:.4g} mm does not fit into an outer diameter of {outer_diameter * 1e3:.4g} mm",
                    ("wall_thickness",),
                )
            area = math.pi * wall_thickness * (outer_diameter - wall_thickness)
            if self.mass is None:
                object.__setattr__(self, "mass", self.density * area * self.length)
            if self.stiffness is None:
                stiffness = self.youngs_modulus * area / self.length
                object.__setattr__(self, "stiffness", stiffness)
        elif self.mass is None or outer_diameter is not None or wall_thickness is not None:
            raise problem(
                f"the pushrod needs its mass, or length, outer_diameter and wall_thickness of its tube; add {', '.join(missing)}",
                (missing[0],) if len(missing) < len(tube) else ("mass",),
            )
        warn_unusual(self, "the pushrod", mass=_MASS)


@table("the support")
class SupportParameters(Table):
    """Elastic pivot or rocker shaft, with the mass (kg) that moves in its direction."""

    stiffness: Stiffness
    mass: Mass
    damping: Damping = Field(default=0.0, description="along its direction")
    direction: Angle = Field(default=math.pi / 2, description="polar angle of its motion")


@table("the valve")
class ValveParameters(Table):
    """The valve, which a stem with ``stem_stiffness`` (None: rigid) divides into head and tip.

    ``permitted_seating_velocity`` judges results and changes no motion.
    """

    mass: Mass = Field(description="valve, retainer, locks")
    opening_direction: Angle = Field(
        default=-math.pi / 2, description="polar angle of the opening motion"
    )
    head_fraction: Ratio = Field(default=0.5, description="share of the mass below an elastic stem")
    stem_stiffness: Stiffness | None = Field(
        default=None, description="of the stem; without it rigid"
    )
    stem_damping: Damping = Field(default=0.0, description="of the stem")
    damping: Damping = Field(default=0.0, description="in the guide")
    friction: Friction = Field(default=0.0, description="in the guide")
    permitted_seating_velocity: Velocity | None = Field(
        default=None,
        description="limit of the results alone; without it 0.52 m/s, published as smooth (docs/limits.md)",
    )

    def __post_init__(self) -> None:
        if not 0 < self.head_fraction < 1:
            raise problem(
                f"head_fraction of the valve must be between 0 and 1; it is {self.head_fraction:g}"
            )
        warn_unusual(self, "the valve", mass=_MASS)


@table("the gas load")
class GasLoad(Table):
    """Force (N, opening positive) on the valve over the cam angle (rad), joined by monotone curves
    and periodic in one cam revolution.
    """

    cam_angles: Angles
    forces: Forces

    def __post_init__(self) -> None:
        angles = self.cam_angles
        if len(angles) != len(self.forces) or len(self.forces) < 3:
            raise problem("a gas load needs at least three cam angles and as many forces")
        if any(late <= early for early, late in pairwise(angles)):
            raise problem(
                "the cam angles of a gas load must increase; sort them and remove repeats"
            )
        if angles[-1] - angles[0] >= 2 * math.pi:
            raise problem(
                "a gas load spans less than one cam revolution; drop the repeated last point"
            )


@table("the crank")
class CrankParameters(Table):
    """Crank slider on the 2:1 drive; ``clearance`` (m): piston crown to the closed valve along the
    cylinder at top dead centre.
    """

    radius: PositiveLength
    rod_length: PositiveLength
    clearance: PositiveLength
    top_dead_centre: Angle | None = Field(
        default=None, description="cam angle of it; without it by lobe_centre or the cam card"
    )
    valve_inclination: Angle = Field(default=0.0, description="of the valve to the cylinder axis")
    offset: Length = Field(default=0.0, description="of the cylinder axis from the crank")
    lobe_centre: Angle | None = Field(
        default=None,
        description="crank angle from top dead centre to the nose, negative before it",
    )

    def __post_init__(self) -> None:
        if self.top_dead_centre is None and self.lobe_centre is None:
            raise problem(
                "the crank needs lobe_centre, crank degrees from top dead centre to the nose such as '106 deg' (before it, an exhaust lobe: "
                "'-110 deg'), or top_dead_centre in cam degrees; give one"
            )
        if self.rod_length <= self.radius + abs(self.offset):
            raise problem(
                "the connecting rod must be longer than crank radius plus offset, or the crank cannot turn"
            )
