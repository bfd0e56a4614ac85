"""The springs of a case at rest: what ``valvetrain static``, ``valvetrain modes`` and :func:`valvetrain.static_curve`
compute.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.forces import lift_harmonics
from valvetrain.quantities.limits import plausible_rest, refuse_implausible_motion
from valvetrain.quantities.statics import (
    buckling_quantities,
    rest_quantities,
    size_quantities,
)
from valvetrain.runs.prepared import largest_lift, spring_lift
from valvetrain.runs.requests import Modes, Static, Watch
from valvetrain.runs.statics import (
    force_of,
    point_of,
    reach_of,
    rod_statics,
    statics_by_model,
)
from valvetrain.runs.stored_error_bars import belongs, load_uncertainty
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import ErrorBars
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.system.build import build, default_model
from valvetrain.system.problem import Problem

#: Model of a wire whose modes may have a mass, and from which models are made that follow a rod.
WIRE = "finite-element"
#: Share of the travel to solid up to which a load is searched: close to solid the force rises
#: without bound.
NEAR_SOLID = 0.98
#: Compressions (m) closer than this are one.
SAME_COMPRESSION = 1e-12


def static_study(request: Static | Modes, watch: Watch = Watch()) -> Study:
    """Static curve and natural frequencies of every spring of a case by each of the requested models (none:
    :func:`default_model`).

    Raises :class:`InputError` for a compression beyond coil bind, a model that cannot represent a spring and a lift that
    no cam gives.
    """
    begun = time.perf_counter()
    case, implausible = request.case, request.implausible
    problem = build(case, spring_set=request.spring_sets)
    if problem.moves and not implausible:
        refuse_implausible_motion(problem.valve_lift, ())
    lift = largest_lift(problem)
    rest: list[SpringAtRest] = []
    still: dict[str, dict[str, float]] = {}
    # springs of several sets share their names, and sentences speak of the first
    in_use = "" if case.train is None else case.train.spring_set
    springs = [
        spring
        for member in problem.members
        if member.spring_set == in_use
        for spring in member.springs
    ]
    for installed in dict.fromkeys((*springs, *problem.springs)):
        models = request.models or (default_model(installed),)
        for one in _at_rest(request, problem, installed, models):
            rest.append(one if implausible else plausible_rest(one))
            label = f"{one.spring}, {one.model}"
            again = sum(other == label or other.startswith(f"{label}, ") for other in still)
            still[f"{label}, {again + 1}" if again else label] = (
                size_quantities(installed)
                | ({} if request.command == "static" else _ringing(installed, one))
                | rest_quantities(one)
                | buckling_quantities(installed, one, lift)
                | _travel(installed, lift, case.train is not None)
            )
            if watch.progress is not None:
                share = len(rest) / (len(problem.springs) * len(models))
                watch.progress(share, f"{installed.name} by {one.model}")
    still = {"": next(iter(still.values()))} if len(rest) == 1 else still
    if request.command == "modes" and lift > 0:
        sizes = enumerate(lift_harmonics(spring_lift(problem)))
        of_lift = {f"lift_harmonic_{order}_lift": float(size) for order, size in sizes if order}
        still[""] = still.get("", {}) | of_lift
    record, used = problem.record, ", ".join(dict.fromkeys(one.model for one in rest))
    origin = collect_provenance(record.name, used, citations=record.citations)
    wall_time = time.perf_counter() - begun
    study = Study(
        record, request.command, (), tuple(rest), still, provenance=origin, wall_time=wall_time
    )
    statics = (row for row in load_uncertainty(record) if row.engine_speed is None)
    bars = ErrorBars(tuple(row for row in statics if belongs(row, study.quantities)))
    return replace(study, error_bars=bars)


def _at_rest(
    request: Static | Modes, problem: Problem, spring: InstalledSpring, models: Sequence[str]
) -> Iterator[SpringAtRest]:
    """A spring at rest by each of the ``models``, with the modes or the states that are requested."""
    largest, modes, attached_mass = None, 0, None
    heights: tuple[float, ...] = ()
    loads: tuple[float, ...] = ()
    if isinstance(request, Modes):
        modes, attached_mass = request.count, request.end_mass
        if request.compression is not None:
            spring = _compressed(spring, request.compression)
    else:
        largest = request.largest_compression
        heights, loads = request.heights, request.loads
    end = _curve_end(spring, largest_lift(problem), largest)
    rod_result = None
    for name in models:
        spec = _spec_at_rest(spring, name, "models", WIRE)
        if spec.needs_rest and rod_result is None:
            rod_result = _by_rod(problem.model_of(WIRE, spring), end, max(modes, 8))
        if attached_mass is not None and name != WIRE:
            raise InputError(
                f"modes with a mass on the retainer are those of {WIRE}; leave {name} out", "models"
            )
        model = problem.model_of(name, spring, rod_result)
        compressions = np.linspace(0.0, end, request.steps + 1)
        rest = statics_by_model(spring, name, model, compressions, modes, attached_mass)
        asked = [_at_height(spring, height) for height in heights]
        asked += [_under_load(spring, model, rest, load) for load in loads]
        yield replace(rest, points=tuple(point_of(spring, model, one) for one in asked))


def _spec_at_rest(spring: InstalledSpring, name: str, where: str, other: str) -> SpringModelSpec:
    """The model ``name``. Raises :class:`InputError` at ``where`` if it cannot represent the spring, or not at rest, with
    ``other`` models to choose.
    """
    spec = spring_model(name, where)
    if reason := spec.why_not(spring):
        raise InputError(reason, where)
    if spec.no_statics:
        raise InputError(f"{spec.no_statics}; choose {other}", where)
    return spec


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
    end = _curve_end(spring, valve_lift, largest_compression, "largest_compression")
    spec = _spec_at_rest(spring, name, "spring_model", "another model")
    rod_result = _by_rod(spring_model(WIRE).build(spring), end, 8) if spec.needs_rest else None
    model = spec.build(spring, rod_result)
    rest = statics_by_model(spring, name, model, np.linspace(0.0, end, steps + 1), 0)
    curve = (rest if implausible else plausible_rest(rest)).curve
    assert curve is not None
    return curve


def _travel(spring: InstalledSpring, lift: float, train: bool) -> dict[str, float]:
    """The largest lift (m), of rigid parts in a ``train``, and that at which the coils are solid, as far as
    they are known.
    """
    found = {"rigid_maximum_valve_lift" if train else "maximum_lift": lift} if lift > 0 else {}
    found |= spring.clearances(lift) if lift > 0 else {}
    return found if spring.room is None else found | {"coil_bind_lift": spring.room}


def _ringing(spring: InstalledSpring, rest: SpringAtRest) -> dict[str, float]:
    """How long free surge takes to halve (s); empty without damping or with a mass on the retainer."""
    modes = rest.modes
    if modes is None or modes.attached_mass is not None or not len(modes.axial_modes):
        return {}
    frequency = float(modes.axial_frequencies[0])
    rate = spring.damping.ratio_at(frequency) * 2 * np.pi * frequency
    return {"surge_half_duration": float(np.log(2) / rate)} if rate > 0 else {}


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


def _by_rod(rod: SpringModel, reach: float, modes: int) -> SpringAtRest:
    assert isinstance(rod, FiniteElementRod)
    return rod_statics(rod, reach, None, modes)
