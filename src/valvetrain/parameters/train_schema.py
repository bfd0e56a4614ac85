"""The [train] table of a case file: one model per part, units at the door, :class:`TrainParameters` out."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import PlainValidator

from valvetrain.errors import InputError
from valvetrain.parameters.schema_spring import SpringCardModel, SpringModel
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
    problem,
    validate_as,
)
from valvetrain.parameters.train import (
    CamParameters,
    ContactParameters,
    CrankParameters,
    FollowerParameters,
    GasLoad,
    InstalledSpring,
    LeverParameters,
    PushrodParameters,
    SupportParameters,
    TrainParameters,
    TrainVariant,
    ValveParameters,
)
from valvetrain.parameters.train_units import Damping, Forces, Friction, Gravity, Inertia, NotNegativeMass, Pair, Torque
from valvetrain.units import dimension_powers, parse_quantity

#: Dimension of the values of contact laws and spring options, by name; a name that is missing is a plain number.
VALUE_DIMENSIONS: dict[str, str | None] = {
    "contact_stiffness": None, "damping": "damping", "full_damping_depth": "length", "mass_damping": "damping rate",
    "stiffness_damping": "time", "contact_damping_time": "time", "inactive_mass": "mass", "hysteresis_damping": None,
    "length": "length", "modulus": "modulus", "radius": "length", "damping_factor": None, "rubbing_force": "force",
    "friction_velocity": "velocity", "reference_force": "force", "reference_velocity": "velocity",
}  # fmt: skip


def _read_values(raw: Any) -> dict[str, Any]:
    """A table of named numbers with units, of which only the names differ from law to law."""
    if not isinstance(raw, dict):
        raise problem("a table of values is needed here")
    special = {"damping": None} if "law" in raw else {}  # N s/m or s/m: the unit tells which, whatever the law named
    return {key: _read_value(key, value, special.get(key, VALUE_DIMENSIONS.get(key, "ratio"))) for key, value in raw.items()}


def _read_value(key: str, value: Any, dimension: str | None) -> Any:
    if isinstance(value, bool | int) or key == "law":
        return value
    return float(guarded(parse_quantity, value, dimension, path=(key,)))


Values = Annotated[dict[str, Any], PlainValidator(_read_values)]


def _read_contact(raw: Any) -> ContactParameters:
    values = _read_values(raw)
    law = values.pop("law", None)
    if not isinstance(law, str):
        raise problem("a contact needs its law, such as law = 'impact'")
    friction = {key: values.pop(key) for key in ("friction_coefficient", "friction_velocity") if key in values}
    units = guarded(_written_for, raw)
    built: ContactParameters = guarded(lambda: ContactParameters(law, values, **friction, **units))
    return built


def _written_for(raw: dict[str, Any]) -> dict[str, Any]:
    """The exponent of the stiffness and the kind of damping that the units of a contact table tell; refuses other units."""
    found: dict[str, Any] = {}
    if isinstance(text := raw.get("contact_stiffness"), str):
        powers = dimension_powers(text)
        exponent = 1 - powers.pop("[length]", 0.0)
        if powers != {"[mass]": 1.0, "[time]": -2.0} or not 0.99 <= exponent <= 3:
            raise InputError(f"'{text[:40]}' is no contact stiffness; write a force over a length, such as '100 kN/mm' or '1e5 N/mm^1.5'")
        found["stiffness_exponent"] = exponent
    if isinstance(text := raw.get("damping"), str):
        powers = dimension_powers(text)
        names: dict[tuple[tuple[str, float], ...], str] = {
            (("[mass]", 1.0), ("[time]", -1.0)): "N s/m",
            (("[length]", -1.0), ("[time]", 1.0)): "s/m",
        }
        unit = names.get(tuple(sorted(powers.items())))
        if unit is None:
            raise InputError(
                f"'{text[:40]}' is no damping of a contact; write such as '300 N s/m', or '2 s/m' as factor of the elastic force"
            )
        found["damping_unit"] = unit
    return found


def _read_spring_set(raw: Any) -> tuple[Any, ...]:
    """One spring or a list of up to two (outer first): a catalogue card (with a preload) or a wire definition."""
    entries = raw if isinstance(raw, list) else [raw]
    if not 1 <= len(entries) <= 2 or not all(isinstance(entry, dict) for entry in entries):
        raise problem("a spring set holds one or two springs, outer first")
    return tuple(_read_spring(entry, place if isinstance(raw, list) else None) for place, entry in enumerate(entries))


def _read_spring(entry: dict[str, Any], place: int | None) -> Any:
    path = () if place is None else (place,)
    if "wire_diameter" in entry:
        wire = {key: value for key, value in entry.items() if key != "installed_height"}
        definition = guarded(validate_as(SpringModel, wire, path).build, str(entry.get("name", "spring")), path=path)
        height = guarded(parse_quantity, entry.get("installed_height"), "length", path=(*path, "installed_height"))
        return guarded(InstalledSpring, definition, height, path=(*path, "installed_height"))
    return guarded(validate_as(SpringCardModel, entry, path).build, path=path)


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
    contacts: dict[str, Annotated[Any, PlainValidator(_read_contact)]]
    springs: dict[str, Annotated[Any, PlainValidator(_read_spring_set)]]
    spring_set: str = ""
    spring_model: str = "multi-mass"
    spring_options: Values = {}  # noqa: RUF012 (pydantic copies it)
    lash: Length = 0.0
    gravity: Gravity = (0.0, -9.80665)
    variants: list[VariantModel] = []  # noqa: RUF012
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
        names = ("kind", "model", "spring_set", "spring_model", "spring_options", "lash", "gravity", "cycles")
        plain = {name: getattr(self, name) for name in names}
        variants = tuple(variant.build() for variant in self.variants)
        for place, variant in enumerate(variants):
            if variant.spring_set and variant.spring_set not in self.springs:
                raise problem(
                    f"spring set '{variant.spring_set}' is unknown; the case holds {', '.join(self.springs)}",
                    ("variants", place, "spring_set"),
                )
        built: TrainParameters = guarded(
            lambda: TrainParameters(contacts=self.contacts, springs=self.springs, variants=variants, **parts, **plain)
        )
        return built
