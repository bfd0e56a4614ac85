"""The solid finite-element model in the registry: a wire of bricks in motion."""

from __future__ import annotations

from pydantic import Field

from valvetrain.coil_contact.law import law_of
from valvetrain.continuum.transient import SolidDynamics
from valvetrain.continuum.wire import SolidContactLaw, SolidMeshSize
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.solid.model import ALONE, SolidModel
from valvetrain.springs.spec import SpringModelSpec


class SolidOptions(SpringOptions):
    """Options of solid finite elements."""

    bricks_per_coil: int = Field(
        default=24, ge=8, le=400, description="slices of bricks along a turn of the wire"
    )
    brick_core: int = Field(
        default=2, ge=2, le=16, description="bricks across the square core of the section"
    )
    brick_rings: int = Field(
        default=1, ge=1, le=16, description="rings of bricks around the core of the section"
    )
    mass_scaling: float = Field(
        default=5.0,
        ge=0.0,
        le=20.0,
        description="mass that the deformation of a section has in excess, over its own",
    )
    coil_friction: float = Field(
        default=0.0,
        ge=0,
        le=1,
        description="Coulomb friction where coils touch in motion; none at rest",
    )
    seat_friction: float = Field(
        default=0.0,
        ge=0,
        le=1,
        description="Coulomb friction of free wire on its seats in motion; none at rest",
    )


def _wire_of(spring: InstalledSpring) -> SpringDefinition:
    """The wire. Raises :class:`InputError` for a spring that solids do not represent."""
    if spring.wire is None:
        raise InputError(
            f"spring '{spring.name}' is known by its card only; solid finite elements need its wire"
        )
    if spring.guide is not None:
        raise InputError(
            f"spring '{spring.name}' is in a guide, which solid finite elements do not support; remove it or use finite-element"
        )
    return spring.wire


def _make(spring: InstalledSpring, options: SolidOptions, rest: SpringAtRest | None) -> SpringModel:
    contact, damping = spring.contact, spring.damping
    return SolidModel(
        _wire_of(spring),
        spring.precompression,
        SolidMeshSize(options.bricks_per_coil, options.brick_core, options.brick_rings),
        SolidContactLaw(
            contact.stiffness,
            contact.damping_time,
            law_of(contact),
            options.coil_friction,
            options.seat_friction,
        ),
        SolidDynamics(
            damping.mass_damping, damping.stiffness_damping, mass_scaling=options.mass_scaling
        ),
        str(spring.seats),
        pulls=spring.pulls,
    )


SPEC = SpringModelSpec(
    "solid",
    "solid finite elements",
    "#a33b53",
    SolidOptions,
    _make,
    wire_only="solid finite elements need its wire",
    shows=("sections", "clash", "stress"),
    alone=ALONE,
    driver="finite-element",
    no_statics="solid finite elements are run in motion, by run, compare or sweep",
    processor_time=500.0,
    knows="the wire as a body, its sections deform, all coils in contact, seats",
    leaves_out="its own effect on a train, ends that lift, guides, friction at rest, a retainer that deforms",
)
