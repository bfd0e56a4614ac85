"""The [lift_law] table of a cam card: crank or cam degrees, any unit of length, lobe or valve lift."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import Angle, Length, PositiveLength, problem, quantity

#: Lifts (m) of the lobe at which cards tell durations unless they say so: 0.050, 0.006 and 0.200 in.
DURATION_LIFT, ADVERTISED_LIFT, UPPER_LIFT = (round(inches * 25.4e-3, 9) for inches in (0.050, 0.006, 0.200))
#: A ramp without a lift of its own ends this far (m) above the lash.
RAMP_ABOVE_LASH = 1e-4
#: 0.0005 in per cam degree.
RAMP_VELOCITY = 0.0005 * 25.4e-3 / math.radians(1.0)

RockerRatio = Annotated[float, quantity("ratio", low=0.2, high=5.0)]
PositiveAngle = Annotated[float, quantity("angle", low=0.0, open_low=True)]
CamVelocity = Annotated[float, quantity("cam velocity", low=0.0, open_low=True)]
Blend = Annotated[float, quantity("ratio", low=0.01, high=1.0)]


class CamCardModel(LiftModel):
    """A symmetric lobe by the values of its cam card; every duration told is met."""

    lift_of: Literal["valve", "tappet"] = Field(default="tappet", description="whose lift it is: a card gives that of the lobe")
    angle_of: Literal["crank", "cam"]
    lobe_lift: PositiveLength | None = Field(default=None, description="without it valve_lift over rocker_ratio")
    valve_lift: PositiveLength | None = Field(default=None, description="gross, without lash; without it from lobe_lift")
    rocker_ratio: RockerRatio | None = Field(default=None, description="also of the lever in [train.lever] that gives none")
    lash: Length | None = Field(default=None, description="at the valve; also of the [train] that gives none")
    duration: PositiveAngle
    duration_lift: PositiveLength = Field(default=DURATION_LIFT, description="lobe lift at which duration is given")
    advertised_duration: PositiveAngle | None = Field(default=None, description="without it the flank has its usual shape")
    advertised_lift: PositiveLength = Field(default=ADVERTISED_LIFT, description="lobe lift at which advertised_duration is given")
    upper_duration: PositiveAngle | None = Field(default=None, description="without it the nose has its usual shape")
    upper_lift: PositiveLength = Field(default=UPPER_LIFT, description="lobe lift at which upper_duration is given")
    valve: Literal["intake", "exhaust"] = Field(default="intake", description="which valve: lobe_centre after or before top dead centre")
    lobe_centre: PositiveAngle | None = Field(default=None, description="of the nose from top dead centre; without it nose at 180 deg")
    top_dead_centre: Angle = Field(default=math.pi, description="cam angle of top dead centre of gas exchange")
    ramp_lift: PositiveLength | None = Field(default=None, description="of the lobe where ramps end; without it lash over ratio and 0.1 mm")
    ramp_velocity: CamVelocity | None = Field(
        default=None, description="per cam angle; without it 0.0005 in/deg, or that of an advertised_duration given on the ramp"
    )
    ramp_blend: Blend = Field(default=0.3, description="share of the ramp over which its velocity is built up")

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class, in cam rad; refuses a lift told twice that disagrees, or none."""
        turn = 0.5 if self.angle_of == "crank" else 1.0
        away = None if self.lobe_centre is None else self.lobe_centre * turn * (1 if self.valve == "intake" else -1)
        own: dict[str, Any] = {
            "maximum_lift": self._lobe_lift(), "nose": math.pi if away is None else self.top_dead_centre + away,
            "duration": self.duration * turn, "duration_lift": self.duration_lift,
            "ramp_lift": self._ramp_lift(), "ramp_velocity": self.ramp_velocity, "ramp_blend": self.ramp_blend,
        }  # fmt: skip
        for name in ("advertised", "upper"):
            if (told := getattr(self, f"{name}_duration")) is not None:
                own |= {f"{name}_duration": told * turn, f"{name}_lift": getattr(self, f"{name}_lift")}
        return own

    def _lobe_lift(self) -> float:
        if self.lobe_lift is None and (self.valve_lift is None or self.rocker_ratio is None):
            raise problem("a cam card needs lobe_lift, or valve_lift and rocker_ratio; add it")
        if self.lobe_lift is None:
            assert self.valve_lift is not None and self.rocker_ratio is not None
            return self.valve_lift / self.rocker_ratio
        if self.valve_lift is not None and self.rocker_ratio is not None:
            valve = self.lobe_lift * self.rocker_ratio
            if abs(valve / self.valve_lift - 1) > 0.01:
                raise problem(
                    f"lobe_lift times rocker_ratio is {valve * 1e3:.4g} mm, but valve_lift {self.valve_lift * 1e3:.4g} mm; correct one",
                    ("valve_lift",),
                )
        return self.lobe_lift

    def _ramp_lift(self) -> float:
        if self.ramp_lift is not None:
            return self.ramp_lift
        if self.lash and self.rocker_ratio is None and self.lift_of == "tappet":
            raise problem(
                "the ramp over the lash needs rocker_ratio: lash is given at the valve; add it, 1 where the cam moves the valve itself, "
                "or give ramp_lift",
                ("lash",),
            )
        ratio = self.rocker_ratio if self.lift_of == "tappet" and self.rocker_ratio else 1.0
        return (self.lash or 0.0) / ratio + RAMP_ABOVE_LASH
