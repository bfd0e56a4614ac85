"""A spring at rest: static curve, natural frequencies and stress of an installed spring by any model."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import (
    formula_compression,
)
from valvetrain.quantities.stress import EQUIVALENT, SHEAR
from valvetrain.runs.buckling import find_buckling, find_leaning, path_status
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import RestPoint, SpringAtRest, StaticCurve, StaticStress
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.finite_element import (
    FiniteElementRod,
    curve_over,
    equilibrium_at,
    modal_result,
    rest_point,
)
from valvetrain.springs.finite_element_channels import static_section_loads, wire_points
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.springs.stress import nominal_stress_per_force, wire_stress
from valvetrain.system.build import default_model
from valvetrain.system.problem import Problem

#: Steps of a static curve; modes about the installed state.
STEPS, MODES = 64, 24
#: Even steps of the path that named numbers are read from: up to the installed state, and from
#: there to the end.
APPROACH, BEYOND = 24, 28
#: End of a curve without lift over the compression at which the spring buckles by the formula.
BEYOND_BUCKLING = 1.25
#: Half the travel (m) of the difference quotient for the slope of a model without a tangent of its
#: own.
SLOPE_TRAVEL = 1e-6


def spring_statics(problem: Problem, spring: InstalledSpring, maximum_lift: float) -> SpringAtRest:
    """A spring at rest by its :func:`default_model`, to a little beyond a lift (m); the rod of a
    run is shared with it.
    """
    name, end = default_model(spring), reach_of(spring, maximum_lift)
    model = problem.model_of(name, spring)
    if isinstance(model, FiniteElementRod):
        return rod_statics(model, end)
    return statics_by_model(spring, name, model, np.linspace(0.0, end, 33))


def rod_statics(
    rod: FiniteElementRod,
    largest_compression: float,
    steps: int | None = None,
    modes: int = MODES,
    attached_mass: float | None = None,
) -> SpringAtRest:
    """Static curve, modes and stress of a wire by the finite-element rod.

    ``steps``: even steps of the curve, None for the points of its path. ``attached_mass`` (kg):
    moves with the retainer in the modes, 0 for a free end, None for both ends fixed.
    """
    begun = time.perf_counter()
    curve, stress = static_curve(rod, largest_compression, steps)
    points = curve if curve.path is None else curve.path
    # A curve may stop before the installed state.
    installed = bool(points.compression[-1] >= rod.precompression * (1 - 1e-9))
    found = modal_result(rod, modes, attached_mass) if modes and installed else None
    buckling = curve.buckling
    if found is not None and buckling is not None and rod.precompression >= buckling.compression:
        status = path_status(rod, buckling, curve.leaning)
        found = replace(found, status=status or found.status)
    return SpringAtRest(
        rod.definition.name,
        rod.name,
        rod.precompression,
        curve,
        found,
        stress,
        {"elements per coil": rod.elements_per_coil, "elements": rod.mesh.elements},
        time.perf_counter() - begun,
        rest_point(rod, rod.installed) if installed else None,
        stress_per_force=nominal_stress_per_force(rod.definition),
    )


def static_curve(
    rod: FiniteElementRod,
    largest_compression: float,
    steps: int | None = None,
) -> tuple[StaticCurve, StaticStress | None]:
    """Static curve (SI) from the free state to ``largest_compression`` (m) in even ``steps``, and
    the stress of the wire.

    Both come from one path of equilibria that does not depend on ``steps`` (None: the curve has the
    points of the path). Ends early with a status when no equilibrium is found. Raises
    :class:`InputError` for a compression at which the coils are solid.
    """
    if rod.dynamics.contact_stiffness > 0:
        rod.definition.refuse_solid(largest_compression)
    path, reached = curve_over(rod, path_points(rod.precompression, largest_compression))
    buckling, leaning = find_buckling(rod, reached), find_leaning(rod, reached)
    status = path_status(rod, buckling, leaning)
    if status is not None and (path.status.completed or not status.completed):
        path = replace(path, status=status)
    path = replace(path, buckling=buckling, leaning=leaning)
    stress = None
    if len(reached) > 1:
        coil = wire_points(rod.definition.total_coils)
        loads = static_section_loads(rod, [point.state for point in reached])
        found = wire_stress(loads, rod.definition, coil)
        stress = StaticStress(path.compression, coil, found[SHEAR], found[EQUIVALENT])
    if steps is None:
        return path, stress
    curve, _ = curve_over(rod, np.linspace(0.0, largest_compression, steps + 1))
    status = path.status if curve.status.completed or buckling is not None else curve.status
    return replace(curve, path=path, status=status, buckling=buckling, leaning=leaning), stress


def statics_by_model(
    spring: InstalledSpring,
    name: str,
    model: SpringModel,
    compressions: Array,
    modes: int = 12,
    attached_mass: float | None = None,
) -> SpringAtRest:
    """Static curve over ``compressions`` (m from the free state) and axial frequencies of a spring
    by any ``model``; ``attached_mass`` as for :func:`rod_statics`.

    A model of the installed state and those above it gives its curve from there on; the curve of a
    card is the card's by every model. Raises :class:`InputError` for compressions at which the coils are solid.
    """
    if spring.wire is not None and spring.contact.stiffness > 0:
        spring.wire.refuse_solid(float(np.max(compressions)))
    begun = time.perf_counter()
    if isinstance(model, ReducedRod):  # at rest it is its rod
        found_by_rod = statics_by_model(spring, name, model.rod, compressions, modes)
        return replace(found_by_rod, model=name)
    if isinstance(model, FiniteElementRod) and spring.wire is not None:
        steps = len(compressions) - 1
        return rod_statics(model, float(compressions[-1]), steps, modes, attached_mass)
    path = _curve_of(spring, model, path_points(spring.precompression, float(compressions[-1])))
    curve = replace(_curve_of(spring, model, compressions), path=path)
    frequencies = axial_frequencies(model, modes)
    count, found = len(frequencies), None
    if count:
        shape, transmission = np.zeros((count, 1, 3)), np.ones(count)
        found = ModalResult(
            spring.precompression,
            frequencies,
            shape,
            np.zeros(1),
            transmission,
            tuple(range(count)),
        )
    return SpringAtRest(
        spring.name,
        name,
        spring.precompression,
        curve,
        found,
        None,
        {"unknowns": model.unknowns} if model.unknowns else {},
        time.perf_counter() - begun,
        point_of(spring, model, spring.precompression),
        stress_per_force=None if spring.wire is None else nominal_stress_per_force(spring.wire),
    )


def _curve_of(spring: InstalledSpring, model: SpringModel, compressions: Array) -> StaticCurve:
    """Force and slope by a model at ``compressions`` (m from the free state)."""
    none, values = np.zeros((len(compressions), 0)), compressions.tolist()
    forces = np.array([force_of(spring, model, value) for value in values])
    slopes = np.array([slope_of(spring, model, value) for value in values])
    return StaticCurve(compressions, forces, slopes, none, none, np.zeros(0), none, np.zeros(0))


def axial_frequencies(model: SpringModel, count: int) -> Array:
    """Axial natural frequencies (Hz), both ends fixed, as installed; empty of a model without inner
    motion.
    """
    if isinstance(model, (ReducedRod, FiniteElementRod)):
        rod = model.rod if isinstance(model, ReducedRod) else model
        return np.asarray(modal_result(rod, count).axial_frequencies if count else ())
    if isinstance(model, MultiMassSpring):
        return np.asarray(model.frequencies(0.0, min(count, model.unknowns)))
    natural = getattr(model, "natural_frequencies", ())
    if len(natural):
        return np.asarray(natural, dtype=float)[:count]
    circular = getattr(model, "circular_frequencies", None)
    if circular is not None:
        return np.asarray(circular)[:count] / (2 * np.pi)
    first = getattr(getattr(model, "spring", None), "surge_frequency", None)
    return np.zeros(0) if first is None else float(first) * np.arange(1.0, min(count, 6) + 1)


def point_of(spring: InstalledSpring, model: SpringModel, compression: float) -> RestPoint:
    """State of the spring by a ``model`` at a compression (m from the free state)."""
    model = model.rod if isinstance(model, ReducedRod) else model
    if isinstance(model, FiniteElementRod) and spring.wire is not None:
        return rest_point(model, equilibrium_at(model, compression))
    force = force_of(spring, model, compression)
    height = (
        None
        if spring.installed_height is None
        else spring.installed_height + spring.precompression - compression
    )
    nominal = None if spring.wire is None else nominal_stress_per_force(spring.wire) * force
    return RestPoint(compression, force, slope_of(spring, model, compression), height, nominal)


def force_of(spring: InstalledSpring, model: SpringModel, compression: float) -> float:
    """Retainer force (N) of a model at rest at a compression (m from the free state); the loads of a
    card are the card's, whatever model runs.
    """
    lift = compression - spring.precompression
    if spring.card is not None:
        return spring.card.preload + spring.card.rate * lift
    model = model.rod if isinstance(model, ReducedRod) else model
    if isinstance(model, FiniteElementRod):
        return equilibrium_at(model, compression).retainer_force
    return model.force(model.initial_state(lift), lift).retainer


def slope_of(spring: InstalledSpring, model: SpringModel, compression: float) -> float:
    """Slope of the force (N/m) of a model without a tangent of its own; at the free state that of
    compressing it.
    """
    down = min(SLOPE_TRAVEL, max(compression, 0.0))
    upper = force_of(spring, model, compression + SLOPE_TRAVEL)
    return (upper - force_of(spring, model, compression - down)) / (SLOPE_TRAVEL + down)


def reach_of(spring: InstalledSpring, maximum_lift: float) -> float:
    """Largest compression (m) of a static curve: a little beyond the largest lift (m), or near
    solid where there is none.

    Little beyond the compression at which a slender spring buckles by the formula: what follows
    takes long to compute.
    """
    installed = spring.precompression
    if spring.wire is None:
        return installed + max(1.06 * maximum_lift, 0.2 * installed)
    travel = spring.wire.solid_compression
    top = maximum_lift if maximum_lift > 0 else 0.8 * travel
    full = installed + maximum_lift
    reach = float(min(installed + 1.06 * top, max(0.98 * travel, full if full < travel else 0.0)))
    if maximum_lift > 0 or spring.guide is not None:
        return reach
    buckling = formula_compression(spring.wire)
    return (
        reach if buckling is None else min(reach, max(1.06 * installed, BEYOND_BUCKLING * buckling))
    )


def path_points(precompression: float, reach: float) -> Array:
    """Compressions (m) of a path from the free state through the installed one to ``reach`` (m),
    whatever is output.
    """
    if precompression <= 0:
        return np.linspace(0.0, reach, APPROACH + BEYOND + 1)
    approach = np.linspace(0.0, precompression, APPROACH + 1)
    if reach <= precompression * (1 + 1e-9):
        return approach
    return np.append(approach, np.linspace(precompression, reach, BEYOND + 1)[1:])
