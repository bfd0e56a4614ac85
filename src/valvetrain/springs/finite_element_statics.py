"""The rod at rest: curve over compressions, what it carries at one, natural modes with ends fixed
or a mass on the retainer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.rates import axial_rate, retainer_loads
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.cosserat.turning import rotation_of
from valvetrain.errors import InputError
from valvetrain.solution.modes import ModalResult, SpringModes
from valvetrain.solution.static import RestPoint, StaticCurve
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.springs.finite_element_channels import (
    interpolation,
    pair_values,
    static_section_loads,
    wire_points,
)
from valvetrain.springs.finite_element_model import RodModel
from valvetrain.springs.stress import nominal_stress_per_force, wire_stress

Array = NDArray[np.float64]
#: A force below this share of the curve's largest is what rounding leaves of zero, as in the free
#: state.
ROUND_OFF_SHARE = 1e-11


def curve_over(
    rod: RodModel, compressions: Array, visit: Callable[[Equilibrium], None] | None = None
) -> tuple[StaticCurve, list[Equilibrium]]:
    """Curve over rising ``compressions`` (m) from the free state on, as far as equilibria are
    found, and those.

    Ends early with a status. ``visit`` is called with each equilibrium.
    """
    path = [
        rod.statics.solve(free_state(rod.mesh), 0.0),
        *compress(rod.statics, compressions[1:].tolist(), visit=visit),
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
        @ interpolation(rod.mesh, coil).T
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
    shape = np.einsum("mvc,pv->mpc", modes.shape, interpolation(rod.mesh, coil))
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
