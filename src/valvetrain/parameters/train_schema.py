"""The [train] table of a case file: one model per part, in SI from there on,
:class:`TrainParameters` out.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from valvetrain.parameters.schema_blocks import SpringField
from valvetrain.parameters.schema_contact import ContactsField
from valvetrain.parameters.schema_installed import RubbingModel
from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import (
    MAX_MASS,
    Angle,
    Angles,
    Density,
    Lash,
    Length,
    Mass,
    Modulus,
    Name,
    PositiveLength,
    Prose,
    Ratio,
    Stiffness,
    StrictModel,
    guarded,
    placed,
    problem,
    quantities,
    quantity,
)
from valvetrain.parameters.steel_contacts import with_steel
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
    check_kind,
)
from valvetrain.parameters.train_names import choice_of
from valvetrain.registry import names as registered_names

#: Moments of inertia (kg m2) beyond this are slips, as masses beyond theirs.
MAX_INERTIA = 1e2
Damping = Annotated[float, quantity("damping", low=0.0)]
Inertia = Annotated[float, quantity("moment of inertia", low=0.0, high=MAX_INERTIA, open_low=True)]
NotNegativeMass = Annotated[float, quantity("mass", low=0.0, high=MAX_MASS)]
Friction = Annotated[float, quantity("force", low=0.0)]
Velocity = Annotated[float, quantity("velocity", low=0.0, open_low=True)]
Torque = Annotated[float, quantity("moment", low=0.0)]
LeverRatio = Annotated[float, quantity("ratio", low=0.1, high=10.0)]
Pair = Annotated[tuple[float, ...], quantities("length")]
Gravity = Annotated[tuple[float, ...], quantities("acceleration")]
Forces = Annotated[tuple[float, ...], quantities("force")]


def _pair(numbers: tuple[float, ...], key: str) -> tuple[float, float]:
    if len(numbers) != 2:
        raise problem(
            f"{key} is a point in the plane of motion, two lengths (x, y) from the cam centre; it has {len(numbers)}",
            (key,),
        )
    return numbers[0], numbers[1]


class CamModel(StrictModel):
    """The [train.cam] table."""

    base_radius: PositiveLength
    width: PositiveLength = Field(default=0.012, description="face width")
    rotation: Literal[1, -1] = Field(default=1, description="1 counter-clockwise, -1 clockwise")
    youngs_modulus: Modulus = Field(default=206e9, description="for the pressure of the contact")
    poisson_ratio: Ratio = Field(default=0.3, description="for the pressure of the contact")

    def build(self) -> CamParameters:
        """The cam of this table."""
        return CamParameters(**self.model_dump())


class FollowerModel(StrictModel):
    """The [train.follower] table."""

    shape: Literal["flat", "domed", "roller", "knife"] = Field(
        default="flat", description="what touches the cam"
    )
    radius: Length = Field(default=0.0, description="of its arc; none of a flat or knife")
    mass: NotNegativeMass = Field(default=0.0, description="of a sliding follower")
    offset: Length = Field(default=0.0, description="of its axis from the cam centre")
    tilt: Angle = Field(default=0.0, description="lean of a flat face")
    face_diameter: PositiveLength | None = Field(
        default=None,
        description="of a flat face, on which the contact must stay; without it not looked at",
    )
    damping: Damping = Field(default=0.0, description="in its guide")
    friction: Friction = Field(default=0.0, description="in its guide")

    def build(self) -> FollowerParameters:
        """The follower of this table."""
        return FollowerParameters(**self.model_dump())


class LeverModel(StrictModel):
    """The [train.lever] table."""

    pivot: Pair
    drive_arm: PositiveLength
    valve_arm: PositiveLength | None = Field(
        default=None, description="without it drive_arm times ratio"
    )
    ratio: LeverRatio | None = Field(
        default=None,
        description="valve_arm over drive_arm, as cards give it; without it from valve_arm",
    )
    inertia: Inertia
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
    tip_radius: Length = Field(default=0.0, description="of the arc on the stem, for friction")

    def build(self) -> LeverParameters:
        """The lever of this table; refuses arms without a ratio, or with another one."""
        own = self.model_dump() | {"pivot": _pair(self.pivot, "pivot")}
        ratio, arm = own.pop("ratio"), self.valve_arm
        if arm is None and ratio is None:
            raise problem(
                "the lever needs valve_arm, or ratio (valve_arm over drive_arm); add one",
                ("valve_arm",),
            )
        if arm is not None and ratio is not None and abs(arm / self.drive_arm / ratio - 1) > 0.005:
            made = arm / self.drive_arm
            raise problem(
                f"ratio {ratio:g} contradicts the arms, whose ratio is {made:.4g}; drop one of the three",
                ("ratio",),
            )
        own["valve_arm"] = self.drive_arm * ratio if arm is None else arm
        return LeverParameters(**own)


class PushrodModel(StrictModel):
    """The [train.pushrod] table; a value given goes before that of the tube."""

    mass: Mass | None = Field(default=None, description="without it that of the tube")
    lower_end: Pair
    stiffness: Stiffness | None = Field(
        default=None, description="of the bar; without it that of the tube, without a tube rigid"
    )
    damping: Damping = Field(default=0.0, description="of the bar")
    length: PositiveLength | None = Field(default=None, description="of the tube")
    outer_diameter: PositiveLength | None = Field(default=None, description="of the tube")
    wall_thickness: PositiveLength | None = Field(default=None, description="of the tube")
    youngs_modulus: Modulus = Field(default=206e9, description="of the tube; without it of steel")
    density: Density = Field(default=7850.0, description="of the tube; without it of steel")

    def build(self) -> PushrodParameters:
        """The pushrod of this table; refuses half a tube, and one without a mass."""
        mass, stiffness, length = self.mass, self.stiffness, self.length
        keys = ("length", "outer_diameter", "wall_thickness")
        missing = [key for key in keys if getattr(self, key) is None]
        outer, wall = self.outer_diameter, self.wall_thickness
        if length is None or outer is None or wall is None:
            if mass is None or len(missing) < len(keys):
                raise problem(
                    f"the pushrod needs its mass, or length, outer_diameter and wall_thickness of its tube; add {', '.join(missing)}",
                    (missing[0],) if len(missing) < len(keys) else ("mass",),
                )
        else:
            if not 2 * wall <= outer:
                raise problem(
                    f"a wall of {wall * 1e3:.4g} mm does not fit into an outer diameter of {outer * 1e3:.4g} mm",
                    ("wall_thickness",),
                )
            area = math.pi * wall * (outer - wall)
            mass = self.density * area * length if mass is None else mass
            stiffness = self.youngs_modulus * area / length if stiffness is None else stiffness
        return PushrodParameters(
            mass, _pair(self.lower_end, "lower_end"), stiffness, self.damping, length, self.youngs_modulus, self.density
        )  # fmt: skip


class SupportModel(StrictModel):
    """The [train.support] table."""

    stiffness: Stiffness
    mass: Mass
    damping: Damping = Field(default=0.0, description="along its direction")
    direction: Angle = Field(default=math.pi / 2, description="polar angle of its motion")

    def build(self) -> SupportParameters:
        """The support of this table."""
        return SupportParameters(**self.model_dump())


class ValveModel(StrictModel):
    """The [train.valve] table."""

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
    top_dead_centre: Angle | None = Field(
        default=None, description="cam angle of it; without it by lobe_centre or the cam card"
    )
    lobe_centre: Angle | None = Field(
        default=None,
        description="crank angle from top dead centre to the nose, negative before it",
    )
    valve_inclination: Angle = Field(default=0.0, description="of the valve to the cylinder axis")
    offset: Length = Field(default=0.0, description="of the cylinder axis from the crank")

    def build(self) -> CrankParameters:
        """The crank of this table."""
        return CrankParameters(**self.model_dump())


class VariantModel(StrictModel):
    """One [[train.variants]] table."""

    label: Name
    spring_set: Name = Field(default="", description="without it the train's own")
    spring_model: str = Field(default="", description="without it the train's own")
    lash: Lash | None = Field(default=None, description="without it the train's own")
    valve_damping: Damping | None = Field(default=None, description="added to the valve's own")
    without_preload: bool = Field(
        default=False, description="springs at rest with the valve closed"
    )
    replica: Name | None = Field(
        default=None,
        description="name of what a source does and physics does not; the run is made where the name is given as a spring set",
    )
    note: Prose = Field(default="", description="printed next to the results")

    def build(self) -> TrainVariant:
        """The variant of this table."""
        return TrainVariant(**self.model_dump())


class TrainModel(StrictModel):
    """The whole [train] table."""

    kind: str
    model: Literal["planar", "lumped", "single-mass"] = Field(
        default="planar", description="planar bodies, ratios or one mass"
    )
    cam: CamModel
    follower: FollowerModel = FollowerModel()
    valve: ValveModel
    lever: LeverModel | None = None
    pushrod: PushrodModel | None = None
    support: SupportModel | None = None
    crank: CrankModel | None = None
    gas: GasModel | None = None
    contacts: ContactsField
    springs: dict[Name, SpringField]
    spring_set: Name = Field(default="", description="set in use; without it the first")
    spring_model: str = Field(
        default="",
        description="name of the spring model; without it modal-uniform for cards, reduced-rod for wires",
    )
    rubbing: RubbingModel = RubbingModel()
    lash: Lash = Field(default=0.0, description="play at the valve")
    gravity: Gravity = Field(default=(0.0, -9.80665), description="vector in the plane of motion")
    variants: list[VariantModel] = []  # noqa: RUF012 (pydantic copies it)
    cycles: int | None = Field(
        default=None,
        description="maximum of cam revolutions: 60, in sweeps 30, with finite elements 4 to 10, by their damping",
    )

    @model_validator(mode="before")
    @classmethod
    def _name_kinds(cls, raw: Any) -> Any:
        """Refuse a train without its kind by naming the kinds there are."""
        if isinstance(raw, dict) and "kind" not in raw:
            choice = choice_of(tuple(registered_names("mechanisms")))
            raise problem(f"'kind' is missing; add it: {choice}", ("kind",))
        return raw

    def build(self) -> TrainParameters:
        """The frozen parameters; raises a located problem."""
        guarded(lambda: check_kind(self.kind), path=("kind",))
        parts = {
            name: placed(name, part.build)
            for name in ("cam", "follower", "valve", "lever", "pushrod", "support", "crank", "gas")
            if (part := getattr(self, name)) is not None
        }
        if len(self.gravity) != 2:
            raise problem(
                "gravity is a vector in the plane of motion, two accelerations", ("gravity",)
            )
        names = ("kind", "model", "spring_set", "spring_model", "lash", "gravity", "cycles")
        plain = {name: getattr(self, name) for name in names} | {"rubbing": self.rubbing.build()}
        if self.rubbing.model_fields_set and all(
            len(blocks.blocks) < 2 for blocks in self.springs.values()
        ):
            raise problem(
                "rubbing acts between two nested springs, and no set has two; remove it",
                ("rubbing",),
            )
        springs = {
            name: placed(("springs", name), blocks.build, "spring", name)
            for name, blocks in self.springs.items()
        }
        variants = tuple(variant.build() for variant in self.variants)
        for place, variant in enumerate(variants):
            if variant.spring_set and variant.spring_set not in self.springs:
                raise problem(
                    f"spring set '{variant.spring_set}' is unknown; the case holds {', '.join(self.springs)}",
                    ("variants", place, "spring_set"),
                )
        contacts = placed("contacts", with_steel, self.contacts, self.kind, parts["cam"])
        built: TrainParameters = guarded(
            lambda: TrainParameters(
                contacts=contacts, springs=springs, variants=variants, **parts, **plain
            )
        )
        return built


#: Name of the table below [train] -> model; [[train.variants]] is a list.
PARTS: dict[str, type[StrictModel]] = {
    "cam": CamModel, "follower": FollowerModel, "lever": LeverModel, "pushrod": PushrodModel, "support": SupportModel, "valve": ValveModel,
    "gas": GasModel, "crank": CrankModel, "variants": VariantModel,
}  # fmt: skip


def of_bucket(train: TrainModel | None, law: LiftModel | None) -> LiftModel | None:
    """``law``; a cam card over a bucket tappet, which moves the valve itself, has ``rocker_ratio`` 1.

    A card that gives another one is refused with its own place.
    """
    if train is None or law is None or train.kind != "direct":
        return law
    if "rocker_ratio" not in type(law).model_fields:
        return law
    ratio = getattr(law, "rocker_ratio", None)
    if ratio not in (None, 1.0):
        raise problem(
            f"a bucket tappet has no rocker, but rocker_ratio is {ratio:g}; leave it out",
            ("lift_law", "rocker_ratio"),
        )
    return law.model_copy(update={"rocker_ratio": 1.0})


def with_cam_card(train: TrainModel, law: LiftModel | None) -> TrainModel:
    """``train`` with the ``lash`` and ``rocker_ratio`` of its lift law where it gives none; refuses
    others with the law's own place.
    """
    changes: dict[str, Any] = {}
    lash, ratio = getattr(law, "lash", None), getattr(law, "rocker_ratio", None)
    if lash is not None:
        if "lash" not in train.model_fields_set:
            changes["lash"] = lash
        elif abs(train.lash - lash) > 1e-6:
            raise problem(
                f"lash is {lash * 1e3:.4g} mm here and {train.lash * 1e3:.4g} mm in [train]; correct one, or leave it out of [train]",
                ("lift_law", "lash"),
            )
    crank, top = train.crank, None if law is None else getattr(law, "dead_centre", None)
    if top is not None and crank is not None:
        if crank.top_dead_centre is None and crank.lobe_centre is None:
            changes["crank"] = crank.model_copy(update={"top_dead_centre": top})
    lever = train.lever
    if ratio is not None and lever is not None:
        if lever.ratio is None and lever.valve_arm is None:
            changes["lever"] = lever.model_copy(update={"ratio": ratio})
        else:
            own = (
                lever.ratio
                if lever.ratio is not None
                else (lever.valve_arm or 0.0) / lever.drive_arm
            )
            if abs(own / ratio - 1) > 0.02:
                raise problem(
                    f"rocker_ratio is {ratio:g} here, but the lever's arms make {own:.4g}; correct one, or leave valve_arm out",
                    ("lift_law", "rocker_ratio"),
                )
    return train.model_copy(update=changes) if changes else train
