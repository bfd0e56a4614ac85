"""Which numbers each key of a case file takes: every key stands once below, tried at its bounds and
just beyond.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, get_args

import pytest
from pydantic import PydanticUserError, TypeAdapter, ValidationError

from valvetrain import registry
from valvetrain.parameters import lift_law, schema_contact
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.case import Operation
from valvetrain.parameters.installed_spring import (
    CoilContact,
    DampingParameters,
    Guide,
    InstalledSpring,
    Rubbing,
)
from valvetrain.parameters.material import Material
from valvetrain.parameters.schema_types import Quantity
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.train import PARTS, TrainParameters
from valvetrain.parameters.winding import EndCoil
from valvetrain.units import DIMENSIONS

TABLES = {
    "spring": SpringDefinition, "installed": InstalledSpring, "card": SpringCard, "end": EndCoil,
    "material": Material, "spring.damping": DampingParameters, "guide": Guide,
    "spring.contact": CoilContact, "rubbing": Rubbing, "operation": Operation,
    "lift_law": lift_law.LiftModel, "train": TrainParameters, "contacts": schema_contact.ContactTable,
}  # fmt: skip
TABLES |= {
    f"options.{word}": registry.find("springs", word).options
    for word in registry.BUILT_IN["springs"]
}
TABLES |= {f"train.{name}": table for name, table in PARTS.items()}
TABLES |= {f"{kind}": registry.find("lifts", kind).table for kind in registry.BUILT_IN["lifts"]}
TRIED = (-1e12, -2.0, -1.0, -1e-9, 0.0, 1e-9, 1.0, 2.0, 1e12)


def parts(annotation: Any) -> Iterator[Any]:
    """An annotation and all that it is made of."""
    yield annotation
    for inner in get_args(annotation):
        yield from parts(inner)


def adapter(field: Any) -> tuple[TypeAdapter | None, str]:
    """What reads a key, and the unit in which a number is written for it; None where the key holds
    a table.
    """
    kind = Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
    dimension = next(
        (item.dimension for item in parts(kind) if isinstance(item, Quantity) and item.dimension),
        None,
    )
    try:
        return TypeAdapter(
            kind, config={"arbitrary_types_allowed": True, "strict": True}
        ), DIMENSIONS[dimension].default_unit or "" if dimension else ""
    except PydanticUserError:
        return None, ""


def takes(read: TypeAdapter, unit: str, number: float) -> bool:
    """Whether a key takes a number (as written, in its usual unit)."""
    whole = int(number) if number == int(number) else number
    for given in (f"{number!r} {unit}",) if unit else (number, whole, f"{number!r}"):
        try:
            return read.validate_python(given) is not None
        except ValidationError:
            continue
    return False


#: Lengths, masses, stiffnesses and the like that mean nothing at zero.
ABOVE_ZERO = """
spring: free_length solid_height total_coils; installed: installed_height
material: youngs_modulus shear_modulus density; spring.damping: ratio_frequency
card: preload_height rate open_lift open_height free_length mass installed_height solid_height wire_diameter mean_diameter outer_diameter
card: active_coils total_coils
guide: bore rod stiffness; options.finite-element: time_step
train.follower: face_diameter; operation: red_line
train.cam: base_radius width youngs_modulus; train.lever: drive_arm valve_arm inertia stiffness; train.pushrod: mass stiffness
train.pushrod: length outer_diameter wall_thickness youngs_modulus density
train.support: stiffness mass; train.valve: mass stem_stiffness permitted_seating_velocity; train.crank: radius rod_length clearance
polynomial: maximum_lift; polydyne: maximum_lift effective_mass effective_stiffness ramp_lift; cycloidal: maximum_lift
modified-sine: maximum_lift; harmonic: maximum_lift; sine-power: maximum_lift; ramped: maximum_lift ramp_lift
shaped: maximum_lift ramp_lift
cam-card: lobe_lift valve_lift duration duration_lift advertised_duration advertised_lift upper_duration upper_lift lobe_centre ramp_lift
cam-card: ramp_velocity; modified-trapezoid: maximum_lift
three-arc: base_radius nose_radius maximum_lift flank_radius follower_radius; tangent: base_radius nose_radius maximum_lift follower_radius
"""
#: What may be left out of the model by a zero.
ZERO_OR_MORE = """
end: inactive_coils ground_coils; spring.damping: ratio stiffness_share mass_damping stiffness_damping
spring.contact: stiffness damping_time; rubbing: coefficient normal_force; contacts: exponent restitution friction_coefficient
train.cam: poisson_ratio; train.follower: mass damping friction; train.lever: mass damping holding_torque; train.pushrod: damping
train.lever: tip_radius; train.support: damping; train.valve: head_fraction stem_damping damping friction; train.variants: valve_damping
train: lash; train.variants: lash; cam-card: lash
polydyne: design_engine_speed; options.massless: effective_mass_fraction
"""
#: Key -> least and largest value, in the usual unit.
BETWEEN = {
    "end.inactive_coils": (None, 3), "end.ground_coils": (None, 3), "spring.total_coils": (None, 200), "card.active_coils": (None, 200),
    "card.total_coils": (None, 200),
    "material.poisson_ratio": (-1, 0.5), "options.massless.effective_mass_fraction": (None, 1),
    "options.multi-mass.masses_per_coil": (1, 2000), "options.multi-mass.elements": (1, 2000), "options.modal-uniform.modes": (1, 500),
    "options.finite-element.coil_friction": (0, 1),
    "options.finite-element.elements_per_coil": (4, 1000), "options.reduced-rod.elements_per_coil": (8, 200),
    "options.solid.bricks_per_coil": (8, 400), "options.solid.brick_core": (2, 16),
    "options.solid.brick_rings": (1, 16), "options.solid.mass_scaling": (0, 20),
    "options.solid.coil_friction": (0, 1), "options.solid.seat_friction": (0, 1),
    "operation.output_step": (math.degrees(1e-4), math.degrees(0.5)),
    "operation.force_bandwidth": (100.0, 50e3),
    "train.lever.ratio": (0.1, 10), "cam-card.rocker_ratio": (0.2, 5), "polydyne.ramp_blend": (0.01, 1), "ramped.ramp_blend": (0.01, 1),
    "cam-card.ramp_blend": (0.01, 1), "shaped.ramp_blend": (0.01, 0.99), "ramped.nose_acceleration": (None, 0),
    "train.cam.rotation": (-1, 1), "train.lever.drive_side": (-1, 1), "spline.degree": (5, 7), "table.degree": (5, 7),
    "measured.draw": (0, 10_000), "train.lever.inertia": (None, 1e8),
    **dict.fromkeys([f"train.{part}.mass" for part in ("follower", "lever", "pushrod", "support", "valve")], (None, 1e6)),
    "card.mass": (None, 1e6), "spring.contact.stiffness": (None, 1e34), "polydyne.effective_mass": (None, 1e6),
}  # fmt: skip
WHOLE = {"operation.cycles", "train.cycles", "sine-power.power"}


def named(words: str) -> set[str]:
    found = set()
    for group in words.replace("\n", ";").split(";"):
        table, _, keys = group.partition(":")
        found |= {f"{table.strip()}.{key}" for key in keys.split()}
    return found


def numbers_of_keys() -> dict[str, Any]:
    """Key -> field of every key that takes a number."""
    every = {
        f"{name}.{key}": field
        for name, table in TABLES.items()
        for key, field in table.model_fields.items()
        if not (name in registry.BUILT_IN["lifts"] and key in lift_law.LiftModel.model_fields)
    }
    takers = {}
    for key, field in every.items():
        read, unit = adapter(field)
        kinds = set(
            parts(
                Annotated[(field.annotation, *field.metadata)]
                if field.metadata
                else field.annotation
            )
        )
        if read is not None and bool not in kinds and (unit or kinds & {int, float}):
            takers[key] = field
    return takers


KEYS = numbers_of_keys()
LISTS = {
    "polynomial.exponents",
    "polydyne.exponents",
    "train.lever.pivot",
    "train.pushrod.lower_end",
}


def test_every_named_key_exists():
    assert (named(ABOVE_ZERO) | named(ZERO_OR_MORE) | set(BETWEEN) | WHOLE | LISTS) - {
        "train.cam.rotation",
        "train.lever.drive_side",
        "spline.degree",
        "table.degree",
    } <= set(KEYS)
    assert len(KEYS) > 190


@pytest.mark.parametrize("key", sorted(set(KEYS) - LISTS))
def test_a_key_takes_the_numbers_that_mean_something(key):
    read, unit = adapter(KEYS[key])
    low, high = BETWEEN.get(key, (None, None))
    above, from_zero = key in named(ABOVE_ZERO), key in named(ZERO_OR_MORE)
    for number in TRIED:
        wanted = number > 0 if above else number >= 0 if from_zero else True
        wanted = wanted and (low is None or number >= low) and (high is None or number <= high)
        if (
            isinstance(low, int)
            and number != int(number)
            and int in set(parts(KEYS[key].annotation))
        ):
            wanted = False
        assert takes(read, unit, number) == (
            wanted and not (key in WHOLE and number != int(number))
        ), number
    for bound, beyond in ((low, -1), (high, 1)):
        if bound is not None:
            whole = int in set(parts(KEYS[key].annotation))
            step = 1 if whole else max(1e-9, 1e-6 * abs(bound))
            assert takes(read, unit, bound - beyond * step) and not takes(
                read, unit, bound + beyond * step
            )
            assert takes(read, unit, bound) or not whole
