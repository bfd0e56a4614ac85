"""The [train] table of a case file: one model per part, in SI from there on, :class:`TrainParameters` out."""

from __future__ import annotations

import math
from typing import Literal

from valvetrain.parameters.schema_contact import ContactField
from valvetrain.parameters.schema_installed import RubbingModel, SpringField
from valvetrain.parameters.schema_types import (
    Angle,
    Angles,
    Length,
    Mass,
    Modulus,
    PositiveLength,
    Ratio,
    Stiffness,
    StrictModel,
    guarded,
    placed,
    problem,
)
from valvetrain.parameters.train import (
    CamParameters,
    CrankParameters,
    FollowerParameters,
    GasLoad,
    LeverParameters,
    PushrodParameters,
    SupportParameters,
    TrainParameters,
    TrainVariant,
    ValveParameters,
)
from valvetrain.parameters.train_units import Damping, Forces, Friction, Gravity, Inertia, NotNegativeMass, Pair, Torque


def _pair(numbers: tuple[float, ...], key: str) -> tuple[float, float]:
    if len(numbers) != 2:
        raise problem(f"{key} is a point in the plane of motion, two lengths (x, y) from the cam centre; it has {len(numbers)}", (key,))
    return numbers[0], numbers[1]


class CamModel(StrictModel):
    """The [train.cam] table."""

    base_radius: PositiveLength
    width: PositiveLength = 0.012
    rotation: Literal[1, -1] = 1
    youngs_modulus: Modulus = 206e9
    poisson_ratio: Ratio = 0.3

    def build(self) -> CamParameters:
        """The cam of this table."""
        return CamParameters(**self.model_dump())


class FollowerModel(StrictModel):
    """The [train.follower] table."""

    shape: Literal["flat", "domed", "roller", "knife"] = "flat"
    radius: Length = 0.0
    mass: NotNegativeMass = 0.0
    offset: Length = 0.0
    tilt: Angle = 0.0
    damping: Damping = 0.0
    friction: Friction = 0.0

    def build(self) -> FollowerParameters:
        """The follower of this table."""
        return FollowerParameters(**self.model_dump())


class LeverModel(StrictModel):
    """The [train.lever] table."""

    pivot: Pair
    drive_arm: PositiveLength
    valve_arm: PositiveLength
    inertia: Inertia
    valve_angle: Angle = 0.0
    drive_angle: Angle | None = None
    drive_side: Literal[1, -1] = 1
    mass: NotNegativeMass = 0.0
    stiffness: Stiffness | None = None
    damping: Damping = 0.0
    holding_torque: Torque = 0.0
    tip_radius: Length = 0.0

    def build(self) -> LeverParameters:
        """The lever of this table."""
        return LeverParameters(**(self.model_dump() | {"pivot": _pair(self.pivot, "pivot")}))


class PushrodModel(StrictModel):
    """The [train.pushrod] table."""

    mass: Mass
    lower_end: Pair
    stiffness: Stiffness | None = None
    damping: Damping = 0.0

    def build(self) -> PushrodParameters:
        """The pushrod of this table."""
        return PushrodParameters(**(self.model_dump() | {"lower_end": _pair(self.lower_end, "lower_end")}))


class SupportModel(StrictModel):
    """The [train.support] table."""

    stiffness: Stiffness
    mass: Mass
    damping: Damping = 0.0
    direction: Angle = math.pi / 2

    def build(self) -> SupportParameters:
        """The support of this table."""
        return SupportParameters(**self.model_dump())


class ValveModel(StrictModel):
    """The [train.valve] table."""

    mass: Mass
    opening_direction: Angle = -math.pi / 2
    head_fraction: Ratio = 0.5
    stem_stiffness: Stiffness | None = None
    stem_damping: Damping = 0.0
    damping: Damping = 0.0
    friction: Friction = 0.0

    def build(self) -> ValveParameters:
        """The valve of this table."""
        return ValveParameters(**self.model_dump())


class GasModel(StrictModel):
    """The [train.gas] table."""

    cam_angles: Angles
    forces: Forces

    def build(self) -> GasLoad:
        """The gas load of this table."""
        return GasLoad(self.cam_angles, self.forces)


class CrankModel(StrictModel):
    """The [train.crank] table."""

    radius: PositiveLength
    rod_length: PositiveLength
    clearance: PositiveLength
    top_dead_centre: Angle
    valve_inclination: Angle = 0.0
    offset: Length = 0.0

    def build(self) -> CrankParameters:
        """The crank of this table."""
        return CrankParameters(**self.model_dump())


class VariantModel(StrictModel):
    """One [[train.variants]] table."""

    label: str
    spring_set: str = ""
    spring_model: str = ""
    lash: Length | None = None
    valve_damping: Damping | None = None
    without_preload: bool = False
    note: str = ""

    def build(self) -> TrainVariant:
        """The variant of this table."""
        return TrainVariant(**self.model_dump())


class TrainModel(StrictModel):
    """The whole [train] table."""

    kind: Literal["direct", "finger", "rocker", "pushrod"]
    model: Literal["planar", "lumped", "single-mass"] = "planar"
    cam: CamModel
    follower: FollowerModel = FollowerModel()
    valve: ValveModel
    lever: LeverModel | None = None
    pushrod: PushrodModel | None = None
    support: SupportModel | None = None
    crank: CrankModel | None = None
    gas: GasModel | None = None
    contacts: dict[str, ContactField]
    springs: dict[str, SpringField]
    spring_set: str = ""
    spring_model: str = "multi-mass"
    rubbing: RubbingModel = RubbingModel()
    lash: Length = 0.0
    gravity: Gravity = (0.0, -9.80665)
    variants: list[VariantModel] = []  # noqa: RUF012 (pydantic copies it)
    cycles: int | None = None

    def build(self) -> TrainParameters:
        """The frozen parameters; raises a located problem."""
        parts = {
            name: guarded(part.build, path=(name,))
            for name in ("cam", "follower", "valve", "lever", "pushrod", "support", "crank", "gas")
            if (part := getattr(self, name)) is not None
        }
        if len(self.gravity) != 2:
            raise problem("gravity is a vector in the plane of motion, two accelerations", ("gravity",))
        names = ("kind", "model", "spring_set", "spring_model", "lash", "gravity", "cycles")
        plain = {name: getattr(self, name) for name in names} | {"rubbing": self.rubbing.build()}
        springs = {name: placed(("springs", name), blocks.build, "spring") for name, blocks in self.springs.items()}
        variants = tuple(variant.build() for variant in self.variants)
        for place, variant in enumerate(variants):
            if variant.spring_set and variant.spring_set not in self.springs:
                raise problem(
                    f"spring set '{variant.spring_set}' is unknown; the case holds {', '.join(self.springs)}",
                    ("variants", place, "spring_set"),
                )
        built: TrainParameters = guarded(
            lambda: TrainParameters(contacts=self.contacts, springs=springs, variants=variants, **parts, **plain)
        )
        return built
