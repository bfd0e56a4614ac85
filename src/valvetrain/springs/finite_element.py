"""Finite-element rod as a spring model: geometrically exact rod along the wire, with clash between
all coils.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import law_of
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.rates import axial_rate, retainer_loads
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.cosserat.turning import rotation_of
from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_types import Length, PositiveTime
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.modes import ModalResult, SpringModes
from valvetrain.solution.static import RestPoint, SpringAtRest, StaticCurve
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.springs.finite_element_channels import (
    interpolation,
    pair_values,
    static_section_loads,
    wire_points,
)
from valvetrain.springs.finite_element_model import RodModel
from valvetrain.springs.spec import SpringModelSpec
from valvetrain.springs.stress import nominal_stress_per_force, wire_stress
from valvetrain.springs.wire_from_card import wire_from_card
from valvetrain.units import Given, si

#: Rounds in which a made-up wire is brought to the loads of its card, each a hundred times nearer.
ROUNDS = 6


@dataclass(frozen=True, eq=False)
class FiniteElementRod(RodModel):
    """Rod model of ``definition`` installed at ``precompression`` (m from the free state); its
    fields are those of :class:`RodModel`.

    >>> import valvetrain as vt
    >>> wire = vt.parameters.SpringDefinition("4 mm", "24 mm", total_coils=8, free_length="52 mm", material="OTEVA 90 SC")
    >>> rod = vt.springs.FiniteElementRod(wire, 7e-3, elements_per_coil=12)
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
    """The rod of a wire, or of a wire that a card leaves possible and that bears the card's loads."""
    if spring.wire is not None:
        return _rod(spring, options, spring.wire, spring.precompression, str(spring.seats))
    assert spring.card is not None
    lift = max(options.card_lift, spring.card.open_lift or 0.0)
    wire, precompression = wire_from_card(spring.card, lift)
    return _with_loads_of(_rod(spring, options, wire, precompression, "clamps"), spring.card, lift)


def _rod(
    spring: InstalledSpring, options: FiniteElementOptions, wire: SpringDefinition, precompression: float, seats: str
) -> FiniteElementRod:  # fmt: skip
    """The rod of ``wire`` on these seats, with the damping, contact and guide of the installed spring."""
    dynamics = RodDynamics(
        mass_damping=spring.damping.mass_damping,
        stiffness_damping=spring.damping.stiffness_damping,
        contact_stiffness=spring.contact.stiffness,
        contact_damping_time=spring.contact.damping_time,
        contact_law=law_of(spring.contact),
        coil_friction=options.coil_friction,
    )
    return FiniteElementRod(
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


#: A force below this share of the curve's largest is what rounding leaves of zero, as in the free
#: state.
ROUND_OFF_SHARE = 1e-11


def curve_over(rod: RodModel, compressions: Array) -> tuple[StaticCurve, list[Equilibrium]]:
    """Curve over rising ``compressions`` (m) from the free state on, as far as equilibria are
    found, and those.

    Ends early with a status.
    """
    path = [
        rod.statics.solve(free_state(rod.mesh), 0.0),
        *compress(rod.statics, compressions[1:].tolist()),
    ]
    reached = [point for point in path if point.converged]
    status = COMPLETED
    if len(reached) < len(path):
        stuck = path[-1].state.compression
        status = Status(
            "not-converged",
            f"no equilibrium beyond {reached[-1].state.compression * 1e3:.3f} mm compression",
            0.0,
            f"{stuck * 1e3:.3f} mm",
            "the coils are solid or the spring buckles; compress less or refine the mesh",
        )
    force = np.array([point.retainer_force for point in reached])
    force[np.abs(force) < ROUND_OFF_SHARE * np.max(np.abs(force))] = 0.0
    coil = wire_points(rod.definition.total_coils)
    heights = (
        np.stack([point.state.position[:, 2] for point in reached])
        @ interpolation(rod.mesh.coil_number, coil).T
    )
    upper, gap, pressed = pair_values(
        rod, np.stack([rod.statics.gaps(point.state.position) for point in reached])
    )
    curve = StaticCurve(
        compression=np.array([point.state.compression for point in reached]),
        force=force,
        stiffness=np.array([axial_rate(rod.statics, point.state) for point in reached]),
        coil_gap=gap,
        coil_contact_force=pressed,
        upper_coil=upper,
        axial_position=heights - rod.definition.lower_seat_height,
        coil_number=coil,
        status=status,
    )
    return curve, reached


def equilibrium_at(rod: RodModel, compression: float) -> Equilibrium:
    """Equilibrium at a compression (m), reached from the installed state where that is smaller, else
    from the free one.

    Raises :class:`InputError` where there is none.
    """
    rod.definition.refuse_solid(compression)
    if compression == rod.precompression:
        return rod.installed
    start = rod.installed.state if compression > rod.precompression > 0 else None
    found = (
        compress(rod.statics, [compression], start)[-1]
        if compression > 0
        else rod.statics.solve(free_state(rod.mesh), 0.0)
    )
    if not found.converged:
        raise InputError(
            f"spring '{rod.definition.name}' finds no equilibrium at {compression * 1e3:.4g} mm compression; compress it less"
        )
    return found


def rest_point(rod: RodModel, equilibrium: Equilibrium) -> RestPoint:
    """All results of the rod for one equilibrium."""
    wire, state = rod.definition, equilibrium.state
    stress = wire_stress(static_section_loads(rod, [state]), wire, wire_points(wire.total_coils))
    force, moment = retainer_loads(rod.statics, state, wire.upper_seat_height - state.compression)
    hand = 1.0 if wire.hand == "right" else -1.0
    return RestPoint(
        compression=state.compression,
        height=wire.free_length - state.compression,
        force=equilibrium.retainer_force,
        stiffness=axial_rate(rod.statics, state),
        nominal_shear_stress=nominal_stress_per_force(wire) * equilibrium.retainer_force,
        shear_stress=float(np.max(stress["inner_fibre_shear_stress"])),
        equivalent_stress=float(np.max(stress["inner_fibre_equivalent_stress"])),
        torque=0.0 if rod.statics.turns else hand * float(moment[2]),
        moment=float(np.hypot(moment[0], moment[1])),
        side_force=float(np.hypot(force[0], force[1])),
        rotation=hand * rotation_of(rod.statics, state) if rod.statics.turns else None,
    )


def spring_modes(rod: RodModel, count: int) -> SpringModes:
    """The lowest ``count`` modes about the installed state, both ends fixed, with their kinds."""
    found = natural_modes(rod.statics, rod.installed.state, count)
    surge = np.isin(np.arange(len(found.natural_frequency)), found.axial_modes(count))
    return SpringModes(found.natural_frequency, found.axial_energy_share, surge)


def modal_result(rod: RodModel, count: int = 24, attached_mass: float | None = None) -> ModalResult:
    """Modes about the installed state, touching coils held together: both ends fixed, or with
    ``attached_mass`` (kg, 0 for none) on a
    retainer that moves along the axis."""
    end_mass = None if attached_mass is None else attached_mass + rod.end_mass
    modes = natural_modes(rod.statics, rod.installed.state, count, end_mass)
    coil = wire_points(rod.definition.total_coils)
    shape = np.einsum("mvc,pv->mpc", modes.shape, interpolation(rod.mesh.coil_number, coil))
    largest = np.abs(shape).max(axis=(1, 2), keepdims=True)
    found = ModalResult(
        compression=rod.precompression,
        natural_frequency=modes.natural_frequency,
        shape=shape / np.where(largest > 0, largest, 1.0),
        coil_number=coil,
        axial_transmission=modes.axial_transmission,
        axial_modes=tuple(modes.axial_modes(3).tolist()),
    )
    return found if attached_mass is None else replace(found, attached_mass=attached_mass)
