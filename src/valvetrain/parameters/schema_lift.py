"""The [lift_law] table: one small model per kind of law, all in cam degrees and lengths at the door."""

from __future__ import annotations

import math
import re
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import PlainValidator

from valvetrain.parameters.changes import nearest
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.lift_table import event_of_table, read_lift_table
from valvetrain.parameters.schema_types import (
    Angle,
    Angles,
    Length,
    Lengths,
    Mass,
    Numbers,
    PositiveLength,
    Stiffness,
    StrictModel,
    guarded,
    problem,
    quantities,
    quantity,
    validate_as,
)

TURN = 2 * math.pi

NotNegativeSpeed = Annotated[float, quantity("angular speed", low=0.0)]
RampBlend = Annotated[float, quantity("ratio", low=0.01, high=1.0)]
NegativeAcceleration = Annotated[float, quantity("cam acceleration", high=0.0)]
OpenRampBlend = Annotated[float, quantity("ratio", low=0.01, high=0.99)]
CamVelocities = Annotated[tuple[float, ...], quantities("cam velocity")]
CamAccelerations = Annotated[tuple[float, ...], quantities("cam acceleration")]


def _read_exponents(raw: Any) -> tuple[int, ...]:
    """``"3-4-5"`` or ``[3, 4, 5]``."""
    if isinstance(raw, str) and re.fullmatch(r"\d{1,3}(-\d{1,3})*", raw):
        raw = [int(part) for part in raw.split("-")]
    if not isinstance(raw, list) or not all(isinstance(item, int) and not isinstance(item, bool) and 1 <= item <= 200 for item in raw):
        raise problem("exponents are whole numbers from 1 to 200, written as '3-4-5'")
    if raw != sorted(set(raw)) or not 2 <= len(raw) <= 12:
        raise problem("give 2 to 12 exponents in rising order, each once, as in '3-4-5'")
    return tuple(raw)


Exponents = Annotated[tuple[int, ...], PlainValidator(_read_exponents)]


class LiftModel(StrictModel):
    """What every law may say."""

    law: ClassVar[str] = ""
    kind: str
    lift_of: Literal["valve", "tappet"] = "valve"
    zero_of_angle: str = ""

    def parameters(self, folder: Path) -> LiftLawParameters:
        return LiftLawParameters(self.law or self.kind, self.values(folder), self.lift_of, self.zero_of_angle)

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; raises a located problem when the table contradicts itself."""
        own = {name: getattr(self, name) for name in type(self).model_fields if name not in LiftModel.model_fields}
        self._in_order(*(name for name in own if name.endswith(("_start", "_end"))))
        return own

    def _in_order(self, *names: str) -> None:
        for first, second in pairwise(names):
            early, late = getattr(self, first), getattr(self, second)
            # A dwell may have no length; a flank may not.
            if late < early or (late == early and (first, second) != ("opening_end", "closing_start")):
                raise problem(
                    f"{second} ({math.degrees(late):g} deg) must come after {first} ({math.degrees(early):g} deg); put the events in order",
                    (second,),
                )
        if names and getattr(self, names[-1]) - getattr(self, names[0]) > TURN + 1e-9:
            raise problem(f"the event from {names[0]} to {names[-1]} is longer than one cam revolution; shorten it", (names[-1],))


class ZeroModel(LiftModel):
    """No lift at all."""


class FlankModel(LiftModel):
    """Dwell, rise, dwell, return: cycloidal, modified sine, harmonic."""

    maximum_lift: PositiveLength
    opening_start: Angle
    opening_end: Angle
    closing_start: Angle
    closing_end: Angle


class PolynomialModel(FlankModel):
    """The same with a polynomial flank such as 3-4-5."""

    exponents: Exponents = (3, 4, 5)


class PolydyneModel(LiftModel):
    """Polydyne: the valve follows a nose-centred polynomial at the design speed, the cam adds the deflection of the train."""

    maximum_lift: PositiveLength
    opening_start: Angle
    closing_end: Angle
    exponents: Exponents = (2, 10, 18, 26, 34)
    effective_mass: Mass | None = None
    effective_stiffness: Stiffness | None = None
    design_engine_speed: NotNegativeSpeed | None = None

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses a deflection given in part."""
        own = super().values(folder)
        parts = (own.pop("effective_mass"), own.pop("effective_stiffness"), own.pop("design_engine_speed"))
        if any(part is None for part in parts):
            if any(part is not None for part in parts):
                raise problem("a polydyne law needs effective_mass, effective_stiffness and design_engine_speed together, or none of them")
            return own | {"dynamic_deflection": 0.0}
        mass, stiffness, engine_speed = parts
        return own | {"dynamic_deflection": mass / stiffness * (engine_speed / 2) ** 2}


class SinePowerModel(LiftModel):
    """``maximum_lift * sin(pi (angle - opening_start) / duration) ** power``."""

    maximum_lift: PositiveLength
    opening_start: Angle
    closing_end: Angle
    power: int = 4

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses a power out of range."""
        if not 2 <= self.power <= 40:
            raise problem("power must be a whole number from 2 to 40", ("power",))
        return super().values(folder)


class RampedModel(LiftModel):
    """Constant-velocity ramps on both sides of a quintic main event."""

    maximum_lift: PositiveLength
    ramp_lift: PositiveLength
    ramp_start: Angle
    event_start: Angle
    event_end: Angle
    ramp_end: Angle
    ramp_blend: RampBlend = 0.3
    nose_acceleration: NegativeAcceleration | None = None

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses ramps above the lift and events out of order."""
        self._in_order("ramp_start", "event_start", "event_end", "ramp_end")
        if self.ramp_lift >= self.maximum_lift:
            raise problem("ramp_lift is not below maximum_lift; lower it", ("ramp_lift",))
        return {name: getattr(self, name) for name in type(self).model_fields if name not in LiftModel.model_fields}


class ShapedModel(LiftModel):
    """Ramps and an event, symmetric about the nose, whose flank acceleration a few control values draw."""

    maximum_lift: PositiveLength
    ramp_lift: PositiveLength
    ramp_start: Angle
    event_start: Angle
    nose: Angle
    flank_shape: Numbers
    ramp_blend: OpenRampBlend = 0.3

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses events out of order."""
        self._in_order("ramp_start", "event_start", "nose")
        return {name: getattr(self, name) for name in type(self).model_fields if name not in LiftModel.model_fields}


class StationsModel(LiftModel):
    """Quintic pieces between stations at which lift, velocity and acceleration (per cam angle) are all given."""

    cam_angles: Angles
    lifts: Lengths
    velocities: CamVelocities
    accelerations: CamAccelerations

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses stations of unequal number or out of order."""
        own = super().values(folder)
        for name in ("lifts", "velocities", "accelerations"):
            if len(own[name]) != len(self.cam_angles):
                raise problem(f"{name} has {len(own[name])} entries but cam_angles {len(self.cam_angles)}; give one each", (name,))
        check_angles(self.cam_angles, ("cam_angles",))
        return own


class SplineModel(LiftModel):
    """A spline through a table of lifts; ``mirror_angle`` completes half a table."""

    law: ClassVar[str] = "spline"
    cam_angles: Angles | None = None
    lifts: Lengths | None = None
    file: str | None = None
    angle_unit: Literal["deg", "rad"] | None = None
    angle_of: Literal["cam", "crank"] | None = None
    lift_unit: str | None = None
    mirror_angle: Angle | None = None
    degree: Literal[5, 7] = 5
    smoothing: Length = 0.0

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses tables that contradict themselves."""
        angles, lifts = self._table(folder)
        if len(angles) != len(lifts):
            raise problem(f"lifts has {len(lifts)} entries but cam_angles {len(angles)}; give one lift per angle", ("lifts",))
        check_angles(angles, ("cam_angles",))
        if self.mirror_angle is not None:
            angles, lifts = _mirrored(angles, lifts, self.mirror_angle)
            check_angles(angles, ("mirror_angle",))
        if self.smoothing < 0:
            raise problem("smoothing is the allowed root-mean-square deviation from the table, zero or more", ("smoothing",))
        noise = max(self.smoothing, 1e-9)
        if min(lifts) < -10 * noise:
            raise problem("lifts must not be negative (beyond ten times the smoothing); correct the table", ("lifts",))
        angles, lifts = guarded(event_of_table, angles, lifts, noise, path=("lifts",))
        check_angles(angles, ("cam_angles",))
        return {"cam_angles": angles, "lifts": lifts, "degree": self.degree, "smoothing": self.smoothing}

    def _table(self, folder: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
        inline = self.cam_angles is not None or self.lifts is not None
        if inline == (self.file is not None):
            raise problem("a lift table is given either by cam_angles and lifts or by file; give one of them")
        if self.file is None:
            if self.cam_angles is None or self.lifts is None:
                raise problem("cam_angles and lifts belong together; add the missing one")
            return self.cam_angles, self.lifts
        for name in ("angle_unit", "angle_of", "lift_unit"):
            if getattr(self, name) is None:
                raise problem(f"{name} is missing: a lift file does not say it itself; add {name}", ())
        table: tuple[tuple[float, ...], tuple[float, ...]] = guarded(
            read_lift_table, folder / self.file, self.angle_unit, self.angle_of, self.lift_unit, path=("file",)
        )
        return table


def check_angles(cam_angles: tuple[float, ...], path: tuple[str, ...]) -> None:
    """Refuse stations that do not increase, are too few or span more than one revolution."""
    if len(cam_angles) < 4:
        raise problem(f"a lift table needs at least four stations; it has {len(cam_angles)}", path)
    for early, late in pairwise(cam_angles):
        if late - early < 1e-6:
            raise problem(f"the angles must increase; {math.degrees(late):g} deg follows {math.degrees(early):g} deg", path)
    if cam_angles[-1] - cam_angles[0] > TURN + 1e-9:
        raise problem("the lift table spans more than one cam revolution; cut it (or say angle_of = 'crank')", path)


def _mirrored(angles: tuple[float, ...], lifts: tuple[float, ...], about: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if abs(angles[-1] - about) > 1e-6:
        last, mirror = math.degrees(angles[-1]), math.degrees(about)
        raise problem(f"half a table must end at mirror_angle; it ends at {last:g} deg, not {mirror:g} deg", ("mirror_angle",))
    return (*angles[:-1], *(2 * about - angle for angle in angles[::-1])), (*lifts[:-1], *lifts[::-1])


MODELS: dict[str, type[LiftModel]] = {
    "zero": ZeroModel,
    "spline": SplineModel,
    "table": SplineModel,
    "stations": StationsModel,
    "polynomial": PolynomialModel,
    "polydyne": PolydyneModel,
    "cycloidal": FlankModel,
    "modified-sine": FlankModel,
    "harmonic": FlankModel,
    "sine-power": SinePowerModel,
    "ramped": RampedModel,
    "shaped": ShapedModel,
}


def read_lift_model(raw: Any) -> LiftModel:
    """Choose the model by ``kind`` and validate the table against it."""
    if not isinstance(raw, dict) or not isinstance(raw.get("kind"), str):
        raise problem(f"a lift law needs its kind, one of {', '.join(MODELS)}")
    kind = raw["kind"]
    if kind not in MODELS:
        raise problem(f"kind '{kind[:40]}' of a lift law is unknown; {nearest(kind, tuple(MODELS))}", ("kind",))
    return validate_as(MODELS[kind], raw)


LiftField = Annotated[LiftModel, PlainValidator(read_lift_model)]
