"""A spring at rest at heights and under loads that are asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.solution.rest_point import RestPoint
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_rest import equilibrium_at, rest_point
from valvetrain.springs.stress import nominal_stress_per_force

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
