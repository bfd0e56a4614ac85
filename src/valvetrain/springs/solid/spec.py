"""The solid finite-element model in the registry: statics and modes of a wire; its transient takes hours and is run apart."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_types import PositiveTime, StrictModel
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.solid.deck import SolidContact
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.layout import MeshOptions
from valvetrain.springs.spec import SpringModelSpec

NO_MOTION = (
    "solid finite elements serve statics and modes; a cam cycle would take them days (a short stretch: 'valvetrain compare --solid-motion')"
)


class SolidOptions(StrictModel):
    """Options of the solid mesh: elements along a coil, ``core`` x ``core`` cells and ``rings`` rings over the section, longest run (s)."""

    elements_per_coil: Annotated[int, Field(ge=4, le=200)] = 12
    core: Annotated[int, Field(ge=1, le=12)] = 1
    rings: Annotated[int, Field(ge=1, le=12)] = 1
    time_limit: PositiveTime = 1800.0


def solid_spring(spring: InstalledSpring, options: SolidOptions) -> SolidSpring:
    """The solid model of an installed wire: inactive end turns fixed, coils in contact, seat planes where the spring has them."""
    if spring.wire is None:
        raise InputError(f"spring '{spring.name}' is known by its card only; solid finite elements need its wire")
    contact = SolidContact(seats=spring.seats != "clamps")
    mesh = MeshOptions(options.elements_per_coil, options.core, options.rings, ends="held")
    return SolidSpring(spring.wire, mesh, contact, options.time_limit)


def _make(spring: InstalledSpring, options: SolidOptions, rest: SpringAtRest | None) -> SpringModel:
    raise InputError(NO_MOTION)


SPEC = SpringModelSpec(
    "solid", "solid finite elements", "#a33b53", SolidOptions, _make, wire_only="solid finite elements need its wire",
    no_motion=NO_MOTION, processor_time=1e5, knows="the wire as a body",
    leaves_out="motion over a cam cycle (minutes for statics and modes)",
)  # fmt: skip
