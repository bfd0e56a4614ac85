"""The solid finite-element model in the registry: statics and modes of a wire; its transient takes
hours and is run apart.
"""

from __future__ import annotations

from pydantic import Field

from valvetrain.continuum.mesh import MeshOptions
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_types import PositiveTime
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.solid.deck import SolidContact
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.spec import SpringModelSpec

NO_MOTION = "solid finite elements serve statics and modes; a cam cycle would take them days (a short stretch: 'valvetrain compare --solid-motion')"


class SolidOptions(SpringOptions):
    """Options of solid finite elements."""

    elements_per_coil: int = Field(
        default=12, ge=4, le=1000, description="slices along one turn of the wire"
    )
    core: int = Field(
        default=1, ge=1, le=40, description="cells across the square core of the section"
    )
    rings: int = Field(default=1, ge=1, le=40, description="rings of cells around the core")
    time_limit: PositiveTime = Field(
        default=1800.0, description="longest time one solution may take"
    )


def solid_spring(spring: InstalledSpring, options: SolidOptions) -> SolidSpring:
    """The solid model of an installed wire: inactive end turns fixed, coils in contact, seat planes
    where the spring has them.
    """
    if spring.wire is None:
        raise InputError(
            f"spring '{spring.name}' is known by its card only; solid finite elements need its wire"
        )
    if spring.guide is not None:
        raise InputError(
            f"spring '{spring.name}' is in a guide, which solid finite elements do not support; remove it or use finite-element"
        )
    contact = SolidContact(seats=spring.seats != "clamps")
    mesh = MeshOptions(options.elements_per_coil, options.core, options.rings, ends="bonded")
    return SolidSpring(spring.wire, mesh, contact, options.time_limit)


def _make(spring: InstalledSpring, options: SolidOptions, rest: SpringAtRest | None) -> SpringModel:
    raise InputError(NO_MOTION)


SPEC = SpringModelSpec(
    "solid",
    "solid finite elements",
    "#a33b53",
    SolidOptions,
    _make,
    wire_only="solid finite elements need its wire",
    no_motion=NO_MOTION,
    processor_time=1e5,
    knows="the wire as a body",
    leaves_out="motion over a cam cycle (minutes for statics and modes)",
)
