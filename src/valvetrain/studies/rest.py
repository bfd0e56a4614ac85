"""Springs at rest: static curve, natural frequencies and stress of an installed spring, by the rod,
by any spring model, by solids.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from valvetrain.cosserat.static import Equilibrium
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.buckling import formula_compression
from valvetrain.quantities.stress import EQUIVALENT, SHEAR
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import SpringAtRest, StaticCurve, StaticStress
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import static_section_loads, wire_points
from valvetrain.springs.finite_element_rest import curve_over, modal_result, rest_point
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.stress import nominal_stress_per_force, wire_stress
from valvetrain.studies.buckling import find_buckling, find_leaning, path_status
from valvetrain.studies.rest_points import force_of, point_of, slope_of

Array = NDArray[np.float64]
#: End of a curve without lift over the compression at which the spring buckles by the formula.
BEYOND_BUCKLING = 1.25
#: Steps of a static curve, modes about the installed state.
STEPS, MODES = 64, 24
#: Even steps of the path that named numbers are read from: up to the installed state, and from
#: there to the end.
APPROACH, BEYOND = 24, 28


def reach_of(spring: InstalledSpring, maximum_lift: float) -> float:
    """Largest compression (m) of a static curve: a little beyond the largest lift (m), or near
    solid when there is none, but little beyond
    where a slender spring buckles by the formula: what follows is long to compute and no use."""
    assert spring.wire is not None
    travel = spring.wire.free_length - spring.wire.solid_height
    top = maximum_lift if maximum_lift > 0 else 0.8 * travel
    reach = float(min(spring.precompression + 1.06 * top, 0.98 * travel))
    place = formula_compression(spring.wire) if maximum_lift <= 0 and spring.guide is None else None
    return (
        reach
        if place is None
        else min(reach, max(1.06 * spring.precompression, BEYOND_BUCKLING * place))
    )


def path_points(precompression: float, reach: float) -> Array:
    """Compressions (m) of a path from the free state through the installed one to ``reach`` (m),
    the same whatever output is asked for.
    """
    if precompression <= 0:
        return np.linspace(0.0, reach, APPROACH + BEYOND + 1)
    approach = np.linspace(0.0, precompression, APPROACH + 1)
    return (
        approach
        if reach <= precompression * (1 + 1e-9)
        else np.append(approach, np.linspace(precompression, reach, BEYOND + 1)[1:])
    )


def at_rest(
    rod: FiniteElementRod,
    largest_compression: float,
    steps: int | None = None,
    modes: int = MODES,
    visit: Callable[[Equilibrium], None] | None = None,
    attached_mass: float | None = None,
) -> SpringAtRest:
    """Static curve, modes and stress of a wire by the finite-element rod; ``visit`` is told each
    equilibrium as it is found.

    ``steps``: even steps of the curve, None for the points of its path. ``attached_mass`` (kg):
    moves with the retainer in the modes, 0 for
    a free end, None for both ends fixed.
    """
    begun = time.perf_counter()
    curve, stress = static_curve(rod, largest_compression, steps, visit)
    points = curve if curve.path is None else curve.path
    stands = bool(
        points.compression[-1] >= rod.precompression * (1 - 1e-9)
    )  # a curve may stop before the installed state
    facts = {"elements per coil": rod.elements_per_coil, "elements": rod.mesh.elements}
    found = modal_result(rod, modes, attached_mass) if modes and stands else None
    if (
        found is not None
        and curve.buckling is not None
        and rod.precompression >= curve.buckling.compression
    ):
        found = replace(
            found, status=path_status(rod, curve.buckling, curve.leaning) or found.status
        )
    return SpringAtRest(
        rod.definition.name,
        rod.name,
        rod.precompression,
        curve,
        found,
        stress,
        facts,
        time.perf_counter() - begun,
        rest_point(rod, rod.installed) if stands else None,
        stress_per_force=nominal_stress_per_force(rod.definition),
    )


def static_curve(
    rod: FiniteElementRod,
    largest_compression: float,
    steps: int | None = None,
    visit: Callable[[Equilibrium], None] | None = None,
) -> tuple[StaticCurve, StaticStress | None]:
    """Static curve (SI) from the free state to ``largest_compression`` (m) in even ``steps``, and
    the stress of the wire over its path.

    Both rest on one path of equilibria that does not depend on ``steps`` (None: the curve has the
    points of the path). Ends early with a
    status when no equilibrium is found. Raises :class:`InputError` for a compression at which the
    coils are solid.
    """
    if rod.dynamics.contact_stiffness > 0:
        rod.definition.refuse_solid(largest_compression)
    path, reached = curve_over(rod, path_points(rod.precompression, largest_compression), visit)
    buckling, leaning = find_buckling(rod, reached), find_leaning(rod, reached)
    told = path_status(rod, buckling, leaning)
    if told is not None and (path.status.completed or not told.completed):
        path = replace(path, status=told)
    path = replace(path, buckling=buckling, leaning=leaning)
    stress = None
    if len(reached) > 1:
        coil = wire_points(rod.definition.total_coils)
        found = wire_stress(
            static_section_loads(rod, [point.state for point in reached]), rod.definition, coil
        )
        stress = StaticStress(path.compression, coil, found[SHEAR], found[EQUIVALENT])
    if steps is None:
        return path, stress
    curve, _ = curve_over(rod, np.linspace(0.0, largest_compression, steps + 1), visit)
    status = path.status if curve.status.completed or buckling is not None else curve.status
    return replace(curve, path=path, status=status, buckling=buckling, leaning=leaning), stress


def rest_by_model(
    spring: InstalledSpring, word: str, model: SpringModel, compressions: Array, modes: int = 12
) -> SpringAtRest:
    """Static curve over ``compressions`` (m from the free state) and axial frequencies of a spring
    by its ``model`` of any ``word``.

    A model that knows no state but the installed one and those above it gives its curve from there
    on. Raises :class:`InputError` for
    compressions at which the coils are solid.
    """
    if spring.wire is not None and spring.contact.stiffness > 0:
        spring.wire.refuse_solid(float(np.max(compressions)))
    begun = time.perf_counter()
    if isinstance(model, FiniteElementRod):
        return at_rest(model, float(compressions[-1]), len(compressions) - 1, modes)
    path = _curve_of(spring, model, path_points(spring.precompression, float(compressions[-1])))
    curve = replace(_curve_of(spring, model, compressions), path=path)
    frequencies = axial_frequencies(model, modes)
    found = None
    if len(frequencies):
        shape = np.zeros((len(frequencies), 1, 3))
        found = ModalResult(
            spring.precompression,
            frequencies,
            shape,
            np.zeros(1),
            np.ones(len(frequencies)),
            tuple(range(len(frequencies))),
        )
    return SpringAtRest(
        spring.name,
        word,
        spring.precompression,
        curve,
        found,
        None,
        facts_of(model),
        time.perf_counter() - begun,
        point_of(spring, model, spring.precompression),
        stress_per_force=None if spring.wire is None else nominal_stress_per_force(spring.wire),
    )


def _curve_of(spring: InstalledSpring, model: SpringModel, compressions: Array) -> StaticCurve:
    """Force and slope by a model at ``compressions`` (m from the free state)."""
    none, places = np.zeros((len(compressions), 0)), compressions.tolist()
    forces = np.array([force_of(spring, model, place) for place in places])
    slopes = np.array([slope_of(spring, model, place) for place in places])
    return StaticCurve(compressions, forces, slopes, none, none, np.zeros(0), none, np.zeros(0))


def axial_frequencies(model: SpringModel, count: int) -> Array:
    """Axial natural frequencies (Hz), both ends fixed, as installed; empty of a model without inner
    motion.
    """
    if isinstance(model, MultiMassSpring):
        return np.asarray(model.frequencies(0.0, min(count, model.unknowns)))
    given = getattr(model, "natural_frequencies", ())
    if len(given):
        return np.asarray(given, dtype=float)[:count]
    circular = getattr(model, "circular_frequencies", None)
    if circular is not None:
        return np.asarray(circular)[:count] / (2 * np.pi)
    equivalent = getattr(model, "spring", None)
    first = getattr(equivalent, "surge_frequency", None)
    return np.zeros(0) if first is None else float(first) * np.arange(1.0, min(count, 6) + 1)


def facts_of(model: SpringModel) -> Mapping[str, float | int | str]:
    """Mesh of a model in words."""
    return {"unknowns": model.unknowns} if model.unknowns else {}
