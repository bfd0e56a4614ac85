"""Springs at rest: static curve, natural frequencies and stress of installed springs by any model;
what ``valvetrain static`` and ``valvetrain modes`` show.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.forces import lift_harmonics
from valvetrain.quantities.limits import plausible_rest, refuse_implausible_motion
from valvetrain.quantities.statics import (
    buckling_quantities,
    estimated_rate,
    formula_compression,
    rest_quantities,
    size_quantities,
)
from valvetrain.quantities.stress import EQUIVALENT, SHEAR
from valvetrain.runs.buckling import find_buckling, find_leaning, path_status
from valvetrain.runs.prepared import largest_lift, spring_lift
from valvetrain.runs.stored_error_bars import belongs, load_uncertainty
from valvetrain.runs.workers import Progress
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.static import RestPoint, SpringAtRest, StaticCurve, StaticStress
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import ErrorBars
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
from valvetrain.springs.spec import spring_model
from valvetrain.springs.stress import nominal_stress_per_force, wire_stress
from valvetrain.system.build import build, default_model
from valvetrain.system.problem import Problem

#: Default models of a wire, of a card with a mass and of one without.
WIRE = "finite-element"
#: Steps of a static curve, and of one computed along with modes; modes about the installed state.
STEPS, CURVE_OF_MODES, MODES = 64, 24, 24
#: Even steps of the path that named numbers are read from: up to the installed state, and from
#: there to the end.
APPROACH, BEYOND = 24, 28
#: End of a curve without lift over the compression at which the spring buckles by the formula.
BEYOND_BUCKLING = 1.25
#: Half the travel (m) of the difference quotient for the slope of a model without a tangent of its
#: own.
SLOPE_TRAVEL = 1e-6
#: Share of the travel to solid up to which a load is searched: close to solid the force rises
#: without bound.
NEAR_SOLID = 0.98
#: Compressions (m) closer than this are one.
SAME_COMPRESSION = 1e-12


def static_study(
    case: Case,
    models: Sequence[str] = (),
    *,
    spring_sets: Sequence[str] = (),
    command: str = "static",
    largest_compression: float | None = None,
    compression: float | None = None,
    steps: int = CURVE_OF_MODES,
    modes: int = 0,
    heights: Sequence[float] = (),
    loads: Sequence[float] = (),
    attached_mass: float | None = None,
    progress: Progress | None = None,
    implausible: bool = False,
) -> Study:
    """Static curve and natural frequencies of every spring of a case by each of ``models``
    (empty: :func:`default_model`).

    ``largest_compression`` (m from the free state): end of the curve, None for a little beyond full
    lift. ``compression`` (m): state of the ``modes`` lowest modes, None for the installed one.
    ``heights`` (m), ``loads`` (N): states to solve as well. ``attached_mass`` (kg): moves with the
    retainer in the modes of a wire, 0 for a free end, None for both ends fixed. ``implausible``
    values pass. Raises :class:`InputError` for a compression beyond coil bind, a model that cannot
    represent a spring and a lift that no cam gives.
    """
    begun = time.perf_counter()
    problem = build(case, spring_set=spring_sets)
    if problem.moves and not implausible:
        refuse_implausible_motion(problem.valve_lift, ())
    lift = largest_lift(problem)
    found: list[SpringAtRest] = []
    still: dict[str, dict[str, float]] = {}
    # springs of several sets share their names, and sentences speak of the first
    in_use = "" if case.train is None else case.train.spring_set
    springs = [
        one
        for member in problem.only(lambda one: one.spring_set == in_use)
        for one in member.springs
    ]
    for installed in dict.fromkeys((*springs, *problem.springs)):
        spring = installed if compression is None else _compressed(installed, compression)
        end = _curve_end(spring, lift, largest_compression)
        chosen = tuple(models) or (default_model(spring),)
        rod_result = None
        for name in chosen:
            spec = spring_model(name, "models")
            if reason := spec.why_not(spring):
                raise InputError(reason, "models")
            if spec.no_statics:
                raise InputError(f"{spec.no_statics}; choose {WIRE}", "models")
            if spec.needs_rest and rod_result is None:
                rod_result = _by_rod(problem.model_of(WIRE, spring), end, max(modes, 8))
            if attached_mass is not None and name != WIRE:
                raise InputError(
                    f"modes with a mass on the retainer are those of {WIRE}; leave {name} out",
                    "models",
                )
            model = problem.model_of(name, spring, rod_result)
            places = np.linspace(0.0, end, steps + 1)
            one = statics_by_model(spring, name, model, places, modes, attached_mass)
            one = replace(one, points=requested_points(spring, model, one, heights, loads))
            found.append(one if implausible else plausible_rest(one))
            label = f"{one.spring}, {one.model}"
            again = sum(other == label or other.startswith(f"{label}, ") for other in still)
            still[f"{label}, {again + 1}" if again else label] = (
                size_quantities(spring)
                | (_estimates(spring) | _ringing(spring, one) if command == "modes" else {})
                | rest_quantities(one)
                | buckling_quantities(installed, one, lift)
                | _travel(installed, lift, case.train is not None)
            )
            if progress is not None:
                share = len(found) / (len(problem.springs) * len(chosen))
                progress(share, f"{spring.name} by {name}")
    still = {"": next(iter(still.values()))} if len(found) == 1 else still
    if command == "modes" and lift > 0:
        sizes = enumerate(lift_harmonics(spring_lift(problem)))
        of_lift = {f"lift_harmonic_{order}_lift": float(one) for order, one in sizes if order}
        still[""] = still.get("", {}) | of_lift
    record = problem.record
    origin = collect_provenance(
        record.name,
        ", ".join(dict.fromkeys(one.model for one in found)),
        citations=record.citations,
    )
    study = Study(
        record,
        command,
        (),
        tuple(found),
        still,
        provenance=origin,
        wall_time=time.perf_counter() - begun,
    )
    statics = (row for row in load_uncertainty(record) if row.engine_speed is None)
    bars = ErrorBars(tuple(row for row in statics if belongs(row, study.quantities)))
    return replace(study, error_bars=bars)


def _travel(spring: InstalledSpring, lift: float, train: bool) -> dict[str, float]:
    """The largest lift (m), of rigid parts in a ``train``, and that at which the coils are solid, as far as
    they are known.
    """
    found = {"rigid_maximum_valve_lift" if train else "maximum_lift": lift} if lift > 0 else {}
    return found if spring.room is None else found | {"coil_bind_lift": spring.room}


def _estimates(spring: InstalledSpring) -> dict[str, float]:
    """What a card would have of a wire: rate and surge frequency by torsion alone."""
    if spring.wire is None:
        return {}
    rate, mass = estimated_rate(spring.wire)
    return {"estimated_rate": rate, "estimated_surge_frequency": 0.5 * float(np.sqrt(rate / mass))}


def _ringing(spring: InstalledSpring, rest: SpringAtRest) -> dict[str, float]:
    """How long free surge takes to halve (s); empty without damping or with a mass on the retainer."""
    modes = rest.modes
    if modes is None or modes.attached_mass is not None or not len(modes.axial_modes):
        return {}
    frequency = float(modes.axial_frequencies[0])
    rate = spring.damping.ratio_at(frequency) * 2 * np.pi * frequency
    return {"surge_half_duration": float(np.log(2) / rate)} if rate > 0 else {}


def curve_by_model(
    spring: InstalledSpring,
    name: str,
    valve_lift: float,
    largest_compression: float | None,
    steps: int,
    implausible: bool = False,
) -> StaticCurve:
    """Static curve of one spring by the model ``name`` up to ``largest_compression`` (m from the
    free state), None for a little beyond ``valve_lift`` (m); ``implausible`` values pass.

    Raises :class:`InputError` for a model that cannot represent the spring or has no static curve,
    and for a compression beyond coil bind.
    """
    spec = spring_model(name, "spring_model")
    end = _curve_end(spring, valve_lift, largest_compression, "largest_compression")
    if reason := spec.why_not(spring):
        raise InputError(reason, "spring_model")
    if spec.no_statics:
        raise InputError(f"{spec.no_statics}; choose another model", "spring_model")
    rod_result = _by_rod(spring_model(WIRE).build(spring), end, 8) if spec.needs_rest else None
    model = spec.build(spring, rod_result)
    one = statics_by_model(spring, name, model, np.linspace(0.0, end, steps + 1), 0)
    curve = (one if implausible else plausible_rest(one)).curve
    assert curve is not None
    return curve


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


def requested_points(
    spring: InstalledSpring,
    model: SpringModel,
    rest: SpringAtRest,
    heights: Sequence[float],
    loads: Sequence[float],
) -> tuple[RestPoint, ...]:
    """The spring at ``heights`` (m) between its seats and under ``loads`` (N), each solved on its
    own, in that order.

    Raises :class:`InputError` for a height above the free length or at which the coils are solid,
    for any height of a spring without an installed one, and for a load that the spring does not
    carry before it is nearly solid.
    """
    compressions = [_at_height(spring, height) for height in heights]
    compressions += [_under_load(spring, model, rest, load) for load in loads]
    return tuple(point_of(spring, model, compression) for compression in compressions)


def _at_height(spring: InstalledSpring, height: float) -> float:
    if spring.installed_height is None:
        raise InputError(
            f"the card of spring '{spring.name}' has no installed_height, so heights are not known; use --load",
            "--height",
        )
    free = spring.installed_height + spring.precompression
    compression = free - height
    low = spring.solid_height
    if compression < -1e-9 or (low is not None and height <= low):
        solid = "" if low is None else f" and solid at {low * 1e3:.4g} mm"
        raise InputError(
            f"spring '{spring.name}' has no height of {height * 1e3:.4g} mm: it is free at {free * 1e3:.4g} mm{solid}; choose one between",
            "--height",
        )
    return max(compression, 0.0)


def _under_load(
    spring: InstalledSpring, model: SpringModel, rest: SpringAtRest, load: float
) -> float:
    if load < 0:
        raise InputError(f"a load is zero or more; it is {load:g} N", "--load")
    curve = rest.curve
    assert curve is not None
    curve = curve.path or curve
    above = np.flatnonzero(curve.force >= load)
    if len(above):
        first = int(above[0])
        if first == 0:
            return float(curve.compression[0])
        low, high = float(curve.compression[first - 1]), float(curve.compression[first])
    else:
        low = high = float(curve.compression[-1])
        if spring.wire is not None:
            high = NEAR_SOLID * spring.wire.solid_compression
        elif spring.solid_height is not None and spring.room is not None:
            high = spring.precompression + NEAR_SOLID * spring.room
        else:
            high = max(2 * low, 2 * load / float(curve.stiffness[-1]))
        largest = force_of(spring, model, high) if high > low else float(curve.force[-1])
        if largest < load:
            raise InputError(
                f"spring '{spring.name}' carries {largest:.5g} N at {high * 1e3:.4g} mm compression, all but solid; a load of {load:g} N is "
                "beyond it, give less",
                "--load",
            )

    def excess(compression: float) -> float:
        return force_of(spring, model, compression) - load

    return float(brentq(excess, low, high, xtol=SAME_COMPRESSION, rtol=1e-13))


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
    reach = float(min(installed + 1.06 * top, 0.98 * travel))
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


def _by_rod(rod: SpringModel, reach: float, modes: int) -> SpringAtRest:
    assert isinstance(rod, FiniteElementRod)
    return rod_statics(rod, reach, None, modes)


def _compressed(spring: InstalledSpring, compression: float) -> InstalledSpring:
    if spring.wire is None:
        raise InputError(
            f"spring '{spring.name}' is known by its card, so only its installed state is; leave the option out",
            "--compression",
        )
    spring.wire.refuse_solid(compression, "--compression")
    return replace(spring, precompression=compression)


def _curve_end(
    spring: InstalledSpring, lift: float, largest_compression: float | None, option: str = "--to"
) -> float:
    if largest_compression is None:
        return reach_of(spring, lift)
    if not largest_compression > 0:
        raise InputError(
            f"a static curve needs a positive compression; it is {largest_compression * 1e3:g} mm",
            option,
        )
    if spring.wire is not None:
        spring.wire.refuse_solid(largest_compression, option)
    return largest_compression
