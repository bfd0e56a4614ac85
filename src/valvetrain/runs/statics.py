"""Springs at rest: static curve, natural frequencies and stress of an installed spring, by the rod,
by any spring model, by solids.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from valvetrain.cosserat.rates import axial_rate
from valvetrain.cosserat.stability import PLACE_TOLERANCE, last_before, negative_modes
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import formula_compression
from valvetrain.quantities.stress import EQUIVALENT, SHEAR
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import (
    Buckling,
    Leaning,
    RestPoint,
    SpringAtRest,
    StaticCurve,
    StaticStress,
)
from valvetrain.solution.status import Status
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import static_section_loads, wire_points
from valvetrain.springs.finite_element_statics import (
    curve_over,
    equilibrium_at,
    modal_result,
    rest_point,
)
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.stress import nominal_stress_per_force, wire_stress

#: Half the travel (m) over which a model without a tangent of its own tells its slope.
SLOPE_TRAVEL = 1e-6
#: Share of the way to solid up to which a load is looked for: close to solid the force rises
#: without bound.
NEAR_SOLID = 0.98
#: Compressions (m) closer than this are one.
SAME_COMPRESSION = 1e-12


def point_of(spring: InstalledSpring, model: SpringModel, compression: float) -> RestPoint:
    """What a ``model`` tells of the spring at a compression (m from the free state)."""
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
    """Retainer force (N) of a model at rest at a compression (m from the free state)."""
    if isinstance(model, FiniteElementRod) and spring.wire is not None:
        return equilibrium_at(model, compression).retainer_force
    lift = compression - spring.precompression
    return model.force(model.initial_state(lift), lift).retainer


def slope_of(spring: InstalledSpring, model: SpringModel, compression: float) -> float:
    """Slope of the force (N/m) of a model without a tangent of its own; at the free state that of
    compressing it.
    """
    down = min(SLOPE_TRAVEL, max(compression, 0.0))
    rise = force_of(spring, model, compression + SLOPE_TRAVEL) - force_of(
        spring, model, compression - down
    )
    return rise / (SLOPE_TRAVEL + down)


def points_asked(
    spring: InstalledSpring,
    model: SpringModel,
    rest: SpringAtRest,
    heights: Sequence[float],
    loads: Sequence[float],
) -> tuple[RestPoint, ...]:
    """The spring at ``heights`` (m) between its seats and under ``loads`` (N), each solved for
    itself, in the order asked for.

    Raises :class:`InputError` for a height above the free length or at which the coils are solid, a
    height where none is known, and a
    load that the spring does not carry before it is all but solid.
    """
    places = [_at_height(spring, height) for height in heights] + [
        _under_load(spring, model, rest, load) for load in loads
    ]
    return tuple(point_of(spring, model, place) for place in places)


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
    from scipy.optimize import brentq

    if load < 0:
        raise InputError(f"a load is zero or more; it is {load:g} N", "--load")
    curve = rest.curve
    assert curve is not None
    known = curve.path or curve
    above = np.flatnonzero(known.force >= load)
    if len(above):
        first = int(above[0])
        if first == 0:
            return float(known.compression[0])
        low, high = float(known.compression[first - 1]), float(known.compression[first])
    else:
        low = high = float(known.compression[-1])
        if spring.wire is not None:
            high = NEAR_SOLID * spring.wire.solid_compression
        elif spring.solid_height is not None and spring.room is not None:
            high = spring.precompression + NEAR_SOLID * spring.room
        else:
            high = max(2 * low, 2 * load / float(known.stiffness[-1]))
        most = force_of(spring, model, high) if high > low else float(known.force[-1])
        if most < load:
            raise InputError(
                f"spring '{spring.name}' carries {most:.5g} N at {high * 1e3:.4g} mm compression, all but solid; a load of {load:g} N is "
                "beyond it, give less",
                "--load",
            )
    return float(
        brentq(
            lambda place: force_of(spring, model, place) - load,
            low,
            high,
            xtol=SAME_COMPRESSION,
            rtol=1e-13,
        )
    )


Array = NDArray[np.float64]

#: A spring has buckled where its rate is this share of its rate as wound. Beyond an opened
#: pitchfork a tenth of the rate is left, and two
#: thirds of that fall are done at the critical point of the perfect column (decision 0049).
RATE_SHARE = 0.5
#: The rate is the mean over this share of the free length: single points of contact of the end
#: coils that open make the tangent jump.
WINDOW_SHARE = 0.01


def find_buckling(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Buckling | None:
    """First place on a ``path`` of rising compression, from the free state on, at which the rod
    buckles; None where it stands.
    """
    if len(path) < 2:
        return None
    states = [one.state for one in path]
    places = [
        place for place in (_lost_rate(rod, path), _lost_sign(rod, states)) if place is not None
    ]
    if not places:
        return None
    compression = float(min(places))
    return Buckling(
        compression, rod.definition.free_length - compression, _force(rod, states, compression)
    )


def _lost_sign(rod: FiniteElementRod, states: Sequence[RodState]) -> float | None:
    """Compression (m) from which the tangent at the end of the path has lost a sign, None where it
    has not.
    """

    def stands(state: RodState) -> bool:
        return negative_modes(rod.statics, state) == 0

    if stands(states[-1]):
        return None
    above, below = len(states) - 1, 0
    while above - below > 1:
        middle = (above + below) // 2
        above, below = (above, middle) if stands(states[middle]) else (middle, below)
    return last_before(rod.statics, states[below], states[above].compression, stands).compression


def _lost_rate(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> float | None:
    """Compression (m) at which the mean rate falls through a share of that as wound, None where it
    does not.
    """
    half, states = 0.5 * WINDOW_SHARE * rod.definition.free_length, [one.state for one in path]
    compression, force = (
        np.array([one.compression for one in states]),
        np.array([one.retainer_force for one in path]),
    )
    enough = RATE_SHARE * axial_rate(rod.statics, states[0]) * 2 * half
    middle = compression[(compression >= half) & (compression <= compression[-1] - half)]
    low = np.flatnonzero(
        np.interp(middle + half, compression, force) - np.interp(middle - half, compression, force)
        <= enough
    )
    if not len(low):
        return None

    def excess(place: float) -> float:
        return _force(rod, states, place + half) - _force(rod, states, place - half) - enough

    # The path's straight lines may be off by an interval where the force bends.
    place, before = int(low[0]), max(int(low[0]) - 1, 0)
    while before > 0 and excess(middle[before]) <= 0.0:
        place, before = before, before - 1
    while excess(middle[place]) > 0.0:
        before, place = place, place + 1
        if place == len(middle):
            return None
    if (
        excess(middle[before]) <= 0.0
    ):  # a very slender spring has lost its rate where the first mean over the window stands
        return float(middle[before])
    return float(brentq(excess, middle[before], middle[place], xtol=PLACE_TOLERANCE))


def _force(rod: FiniteElementRod, states: Sequence[RodState], compression: float) -> float:
    """Force (N) at a compression (m) from the next state of the path below."""
    below = max(
        place
        for place, state in enumerate(states)
        if state.compression <= compression or place == 0
    )
    if states[below].compression == compression:
        return rod.statics.solve(states[below], compression).retainer_force
    return compress(rod.statics, [compression], states[below])[-1].retainer_force


def find_leaning(rod: FiniteElementRod, path: Sequence[Equilibrium]) -> Leaning | None:
    """Where the wire first touches its guide on a ``path`` of rising compression, and how hard it
    leans on it in the end.
    """
    walls = rod.mesh.guide
    if walls is None:
        return None

    def clear(state: RodState) -> bool:
        return walls.least_gap(state.position) > 0.0

    met = next((place for place, one in enumerate(path) if not clear(one.state)), None)
    if met is None:
        return None
    touch = last_before(
        rod.statics, path[max(met - 1, 0)].state, path[met].state.compression, clear
    )
    return Leaning(
        float(touch.compression),
        float(walls.pressed(path[-1].state.position, rod.mesh.node_length)),
    )


def path_status(
    rod: FiniteElementRod, buckling: Buckling | None, leaning: Leaning | None
) -> Status | None:
    """What a static curve ends with that passes a ``buckling`` or ends ``leaning`` on a guide; None
    for any other.

    A spring in a guide that bows until it leans on it has not failed.
    """
    if buckling is None and leaning is None:
        return None
    name = f"spring '{rod.definition.name}'"
    if leaning is not None:
        bows = (
            ""
            if buckling is None
            else f" buckles at {buckling.compression * 1e3:.4g} mm compression and"
        )
        touch = f" leans on its guide from {leaning.compression * 1e3:.4g} mm, in the end with {leaning.force:.4g} N in all"
        return Status("completed", name + bows + touch)
    assert buckling is not None
    place = f"{buckling.height * 1e3:.4g} mm high, {buckling.force:.4g} N"
    words = f"{name} buckles at {buckling.compression * 1e3:.4g} mm compression ({place}); what lies beyond is a spring bent sideways"
    if rod.guide is not None:
        return Status(
            "completed",
            f"{name} buckles at {buckling.compression * 1e3:.4g} mm compression and does not yet touch its guide",
        )
    return Status(
        "buckled",
        words,
        0.0,
        place,
        "compress it less, guide it in a bore or on a rod, or make it shorter or wider",
    )


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
