"""Finite-element rod as a spring model: geometrically exact rod along the wire, with clash between
all coils.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from valvetrain.coil_contact.law import law_of
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring, SpringCard
from valvetrain.parameters.schema_types import Length, PositiveTime
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import RestPoint, SpringAtRest, StaticCurve
from valvetrain.springs.finite_element_model import RodModel
from valvetrain.springs.finite_element_statics import (
    curve_over,
    equilibrium_at,
    modal_result,
    rest_point,
)
from valvetrain.springs.spec import SpringModelSpec
from valvetrain.springs.wire_from_card import wire_from_card
from valvetrain.units import Given, si

#: Rounds in which a made-up wire is brought to the loads of its card, each a hundred times nearer.
ROUNDS = 6


@dataclass(frozen=True, eq=False)
class FiniteElementRod(RodModel):
    """Rod model of ``definition`` installed at ``precompression`` (m from the free state); its
    fields are those of :class:`RodModel`.

    >>> import valvetrain as vt
    >>> rod = vt.springs.FiniteElementRod(vt.parameters.cylindrical("4 mm", "24 mm", total_coils=8, free_length="52 mm"), 7e-3, elements_per_coil=12)
    >>> round(rod.static_point("12 mm").force), round(float(rod.modes(4, attached_mass="50 g").axial_frequencies[0]))
    (370, 103)
    """

    def static_curve(self, largest_compression: Given, steps: int = 64) -> StaticCurve:
        """Force and tangent stiffness from the free state to ``largest_compression`` (m, "8 mm"),
        in even ``steps``, coils closing.

        Raises :class:`InputError` for a compression that is not positive or at which the coils are
        solid, and for less than one step.
        """
        reach = si(largest_compression, "compression", "largest_compression")
        if not reach > 0:
            raise InputError(
                f"a static curve needs a positive compression; it is {reach * 1e3:g} mm",
                "largest_compression",
            )
        if steps < 1:
            raise InputError(f"a static curve takes one step or more; steps is {steps}", "steps")
        if self.dynamics.contact_stiffness > 0:
            self.definition.refuse_solid(reach)
        return curve_over(self, np.linspace(0.0, reach, steps + 1))[0]

    def static_point(self, compression: Given) -> RestPoint:
        """Force, stiffness, stress and what acts on the retainer at a ``compression`` (m, "8 mm");
        errors as :meth:`static_curve`.
        """
        return rest_point(self, equilibrium_at(self, si(compression, "compression", "compression")))

    def modes(self, count: int = 24, attached_mass: Given | None = None) -> ModalResult:
        """The lowest ``count`` modes about the installed state: both ends fixed, or with
        ``attached_mass`` (kg, "50 g"; 0 for a free end)
        on a retainer that moves along the axis.

        Raises :class:`InputError` for a negative mass, and for less than one mode.
        """
        if count < 1:
            raise InputError(f"one mode or more can be requested; count is {count}", "count")
        mass = None if attached_mass is None else si(attached_mass, "mass", "attached_mass")
        if mass is not None and mass < 0:
            raise InputError(
                f"an attached mass is zero or more; it is {mass:g} kg", "attached_mass"
            )
        return modal_result(self, count, mass)


class FiniteElementOptions(SpringOptions):
    """Options of the geometrically exact rod."""

    card_only: ClassVar[tuple[str, ...]] = ("card_lift",)
    elements_per_coil: int = Field(
        default=24, ge=4, le=1000, description="elements along one turn of the wire"
    )
    curvature_correction: bool = Field(
        default=True, description="stiffness of the section corrected for the curvature of the bar"
    )
    time_step: PositiveTime | None = Field(
        default=None, description="time step; without it the stability limit decides"
    )
    lifting_ends: bool = Field(
        default=False,
        description="end coils are bodies on the contact law of coils, which lift; without it only where the ends would pull",
    )
    coil_friction: float = Field(
        default=0.0,
        ge=0,
        le=1,
        description="Coulomb friction where coils touch in motion; none at rest",
    )
    card_lift: Length = Field(
        default=0.012,
        description="lift up to which the coils of a wire made from a card stay apart",
    )


def _make(
    spring: InstalledSpring, options: FiniteElementOptions, rest: SpringAtRest | None
) -> FiniteElementRod:
    wire, precompression, seats = spring.wire, spring.precompression, str(spring.seats)
    if wire is None:
        assert spring.card is not None
        lift = max(options.card_lift, spring.card.open_lift or 0.0)
        wire, precompression = wire_from_card(spring.card, lift)
        seats = "clamps"
    dynamics = RodDynamics(
        mass_damping=spring.damping.mass_damping,
        stiffness_damping=spring.damping.stiffness_damping,
        contact_stiffness=spring.contact.stiffness,
        contact_damping_time=spring.contact.damping_time,
        contact_law=law_of(spring.contact),
        coil_friction=options.coil_friction,
    )
    rod = FiniteElementRod(
        wire,
        precompression,
        options.elements_per_coil,
        dynamics,
        options.curvature_correction,
        seats,
        options.time_step,
        pulls=spring.pulls,
        guide=spring.guide,
        retainer_rotation=spring.retainer_rotation,
        lifting=options.lifting_ends,
    )
    return rod if spring.card is None else _with_loads_of(rod, spring.card, lift)


def _with_loads_of(rod: FiniteElementRod, card: SpringCard, lift: float) -> FiniteElementRod:
    """The ``rod`` of a card with the precompression and the moduli at which it bears the card's loads as
    installed and at its open lift (without one at ``lift``, m): a wire is 1 % off its formulas.
    """
    lift = card.open_lift or lift
    closed, opened, preload = rod.precompression, card.preload + card.rate * lift, 0.0
    for _ in range(ROUNDS):
        preload = equilibrium_at(rod, closed).retainer_force if closed > 0 else 0.0
        rate = (equilibrium_at(rod, closed + lift).retainer_force - preload) / lift
        closed += card.preload / card.rate - preload / rate
    stiffer = opened / (preload + rate * lift)
    steel = rod.definition.material
    steel = replace(steel, youngs_modulus=steel.youngs_modulus * stiffer, shear_modulus=steel.shear_modulus * stiffer)  # fmt: skip
    return replace(rod, definition=replace(rod.definition, material=steel), precompression=closed)


SPEC = SpringModelSpec(
    "finite-element",
    "finite-element rod",
    "#1f5aa6",
    FiniteElementOptions,
    _make,
    shows=("sections", "clash", "stress"),
    processor_time=9.0,
    knows="geometrically exact wire, all coils in contact, seats, stress, buckling, guides",
    leaves_out="contact patches across the wire, friction on guides",
)
