"""Quantities of a spring without motion: of its wire or card, static curve, modes and buckling."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import OTEVA_90_SC, Material
from valvetrain.parameters.solid import closing_forces
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import SpringAtRest, StaticCurve, named
from valvetrain.springs.stress import bergstraesser
from valvetrain.units import Given, si

#: What is named of the installed state next to its force and rate; the nominal stress is that of
#: every model, the rest of a rod's.
POINT_NAMES = tuple(
    f"installed_{name}"
    for name in (
        "nominal_shear_stress",
        "shear_stress",
        "equivalent_stress",
        "retainer_torque",
        "retainer_moment",
        "retainer_side_force",
        "retainer_rotation_angle",
    )
)
#: Slopes that differ by less than this share are one slope: no stiffness change is reported. Large
#: deflection alone bends the curve of
#: an evenly wound spring by about 1 % up to the installed height; one coil of six that closes
#: raises the slope by some 20 %.
SLOPE_SHARE = 0.02


def rest_quantities(rest: SpringAtRest, outputs: Iterable[str] = ()) -> dict[str, float]:
    """All quantities (SI) of one spring at rest; ``outputs``: further names, such as
    ``natural_3_frequency``.
    """
    found = {} if rest.curve is None else static_quantities(rest.curve, rest.precompression)
    if rest.installed is not None:
        shares = named(rest.installed, "installed_")
        found |= {name: shares[name] for name in POINT_NAMES if name in shares}
    if rest.modes is None:
        return found
    # only what a publication numbers in rising order, whatever the direction, is named so
    every = {
        f"natural_{number}_frequency": float(value)
        for number, value in enumerate(rest.modes.natural_frequency, start=1)
    }
    natural = {name: every[name] for name in outputs if name in every}
    return found | modal_quantities(rest.modes) | natural


def static_quantities(curve: StaticCurve, precompression: float) -> dict[str, float]:
    """Preload (N), compression at which the stiffness changes (m) and smallest gap of coils 1 and 2
    (m) when installed.

    Read from the curve's own path, so that they do not depend on the points it shows.
    """
    found: dict[str, float] = {}
    curve = curve.path or curve
    if not curve.compression[0] - 1e-12 <= precompression <= curve.compression[-1] + 1e-12:
        return found
    found["preload"] = curve.force_at(precompression)
    found["installed_rate"] = curve.stiffness_at(precompression)
    inside = curve.compression <= precompression * (1 + 1e-9)
    loose = inside & (curve.force <= 0.0)
    if (
        np.count_nonzero(loose) > 1
    ):  # a model of one rate that is loose near the free state changes no stiffness there
        inside &= ~loose
    knee = slope_change(curve.compression[inside], curve.force[inside])
    if knee is not None:
        found["stiffness_change_compression"] = knee
    pairs = (curve.upper_coil > 1 + 1e-9) & (curve.upper_coil <= 2 + 1e-9)
    if np.any(pairs):
        gaps = [
            float(np.interp(precompression, curve.compression, curve.coil_gap[:, pair]))
            for pair in np.flatnonzero(pairs)
        ]
        found["coil_1_2_installed_gap"] = min(gaps)
    return found


def slope_change(compression: Array, force: Array) -> float | None:
    """Compression (m) where the two best-fitting straight lines of the force meet; None where one
    line fits as well.

    This is what an eye reads off a drawn curve whose slope "changes at about" somewhere.
    """
    if len(compression) < 6:
        return None
    candidates = np.linspace(compression[1], compression[-2], 201)
    best: tuple[float, float | None] = (np.inf, None)
    for knee in candidates:
        base = np.stack(
            [np.ones_like(compression), compression, np.maximum(compression - knee, 0.0)], axis=1
        )
        fit, *_ = np.linalg.lstsq(base, force, rcond=None)
        miss = float(np.sum((base @ fit - force) ** 2))
        if miss < best[0]:
            best = (miss, float(knee) if abs(fit[2]) > SLOPE_SHARE * abs(fit[1]) else None)
    return best[1]


def modal_quantities(result: ModalResult) -> dict[str, float]:
    """Axial natural frequencies (Hz) by number, under a name of their own where the retainer moves."""
    name = "mode" if result.attached_mass is None else "moving_retainer_mode"
    return {
        f"{name}_{number}_frequency": float(value)
        for number, value in enumerate(result.axial_frequencies, start=1)
    }


#: A spring is cylindrical, as the formula has it, where its mean diameter varies by no more than
#: this share.
SAME_DIAMETER = 1e-6


def buckling_compression(
    free_length: Given,
    mean_diameter: Given,
    material: Material = OTEVA_90_SC,
    seating_coefficient: float = 0.5,
) -> float:
    """Compression at which a cylindrical spring buckles by the closed formula of Haringx, as in EN
    13906-1.

    s_K = L_0 / (2 (1 - G/E)) [1 - sqrt(1 - (1 - G/E) / (1/2 + G/E) (pi D / (nu L_0))^2)], J. A.
    Haringx, "On highly compressible helical springs and rubber rods", Philips Research Reports 3
    (1948) 401-449. The spring is taken for an elastic column with shear, its lead angle for small.

    Parameters
    ----------
    free_length : L_0 (m, "81 mm" or a pint quantity)
    mean_diameter : D of the wire's axis (m)
    material : its elastic and shear modulus count
    seating_coefficient : nu, 0.5 with both ends fixed parallel and in line, 0.7 with one fixed and
        one hinged, 1 with both hinged, 2 with
        one fixed and one free

    Returns
    -------
    Compression (m); infinite for a spring too short to buckle at any

    Raises
    ------
    InputError : a length or coefficient that is not positive, a slip of units

    Examples
    --------
    >>> round(buckling_compression("80 mm", "10 mm"), 5)
    0.01584
    >>> buckling_compression("40 mm", "10 mm")
    inf
    """
    length, diameter = (
        si(free_length, "spring_length", "free_length"),
        si(mean_diameter, "mean_diameter", "mean_diameter"),
    )
    for name, value in (
        ("free_length", length),
        ("mean_diameter", diameter),
        ("seating_coefficient", seating_coefficient),
    ):
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"{name} of a spring that may buckle must be positive; it is {value:g}"
            )
    ratio = material.shear_modulus / material.youngs_modulus
    root = (
        1.0
        - (1.0 - ratio) / (0.5 + ratio) * (math.pi * diameter / (seating_coefficient * length)) ** 2
    )
    return math.inf if root < 0.0 else length * 0.5 / (1.0 - ratio) * (1.0 - math.sqrt(root))


def formula_compression(wire: SpringDefinition) -> float | None:
    """Buckling compression (m) of a wire between two seats by the formula; None where it is solid
    before.

    The formula knows cylindrical springs; L_0 is the height between the places where the wire is
    held, of axis to axis.
    """
    coil = np.linspace(*wire.free_coils, 129)
    diameter = np.asarray(wire.mean_diameter.value(coil))
    if np.ptp(diameter) > SAME_DIAMETER * np.max(diameter):
        return None
    ends = wire.centreline(np.array(wire.free_coils))[:, 2]
    found = buckling_compression(float(ends[1] - ends[0]), float(diameter[0]), wire.material)
    return found if found < wire.solid_compression else None


def buckling_quantities(
    spring: InstalledSpring, rest: SpringAtRest, maximum_lift: float
) -> dict[str, float]:
    """Buckling compression by the rod and by the formula (m), the clearance to it at full lift (m),
    and the force on a guide.
    """
    found: dict[str, float] = {}
    if rest.curve is not None and rest.curve.buckling is not None:
        buckling = rest.curve.buckling
        found = {
            "buckling_compression": buckling.compression, "buckling_height": buckling.height,
            "buckling_clearance": buckling.compression - spring.precompression - maximum_lift,
        }  # fmt: skip
    if rest.curve is not None and rest.curve.leaning is not None:
        found |= {
            "guide_contact_compression": rest.curve.leaning.compression,
            "guide_force": rest.curve.leaning.force,
        }
    formula = None if spring.wire is None else formula_compression(spring.wire)
    return found if formula is None else found | {"formula_buckling_compression": formula}


_SAMPLES = 4001


def design_quantities(spring: InstalledSpring) -> dict[str, float]:
    """Quantities (SI, docs/quantities.md) of an installed spring's wire or card."""
    room = {} if spring.room is None else {"coil_bind_lift": spring.room}
    if spring.card is not None:
        return card_quantities(spring.card) | room
    assert spring.wire is not None
    installed = {
        "installed_compression": spring.precompression,
        "installed_height": spring.wire.free_length - spring.precompression,
    }
    formula = formula_compression(spring.wire)
    buckling = {} if formula is None else {"formula_buckling_compression": formula}
    return (
        definition_quantities(spring.wire)
        | solid_quantities(spring.wire)
        | installed
        | room
        | buckling
    )


def size_quantities(spring: InstalledSpring) -> dict[str, float]:
    """Sizes of a wire that its static curve is compared with, and what closes it."""
    if spring.wire is None:
        return {}
    names = ("free_length", "solid_height", "computed_solid_height", "largest_pitch")
    return {
        name: value for name, value in definition_quantities(spring.wire).items() if name in names
    } | solid_quantities(spring.wire)


def solid_quantities(wire: SpringDefinition) -> dict[str, float]:
    """Force (N) that closes the last coil, by torsion of the wire, and the largest shear (Pa) along
    the closed wire, by EN 13906-1.

    A turn closes under (pitch - rise when closed) G d**4 / (8 D**3) and then twists no further; of
    a cylindrical spring of constant pitch that is the theoretical force at solid, rate times
    compression to solid.
    """
    coil = np.linspace(*wire.free_coils, _SAMPLES)
    diameter, mean = wire.wire_diameter.value(coil), wire.mean_diameter.value(coil)
    force = closing_forces(wire, coil)
    shear = bergstraesser(mean / diameter) * 8 * force * mean / (np.pi * diameter**3)
    return {"solid_force": float(np.max(force)), "solid_nominal_shear_stress": float(np.max(shear))}


def definition_quantities(spring: SpringDefinition) -> dict[str, float]:
    """Geometry, mass, and the estimates of rate and first surge frequency in the free state."""
    coil = np.linspace(0.0, spring.total_coils, _SAMPLES)
    index = spring.index(coil)
    rate, active_mass = estimated_rate(spring)
    differs = spring.solid_heights_differ
    other = {"computed_solid_height": spring.computed_solid_height} if differs else {}
    return other | {
        "total_coil_count": spring.total_coils,
        "active_coil_count": spring.active_coils,
        "free_length": spring.free_length,
        "solid_height": spring.solid_height,
        "solid_compression": spring.solid_compression,
        "largest_pitch": float(np.max(spring.pitch.value(coil))),
        "wire_length": spring.wire_length,
        "wire_mass": spring.mass,
        "smallest_index_ratio": float(np.min(index)),
        "largest_index_ratio": float(np.max(index)),
        "largest_outer_diameter": float(np.max(spring.outer_diameter(coil))),
        "smallest_inner_diameter": float(
            np.min(spring.mean_diameter.value(coil) - spring.wire_diameter.value(coil))
        ),
        "estimated_rate": rate,
        "estimated_surge_frequency": 0.5 * float(np.sqrt(rate / active_mass)),
    }


def estimated_rate(spring: SpringDefinition) -> tuple[float, float]:
    """Rate (N/m) of the active turns by torsion of the wire alone, 1/k = integral of 8 D**3 / (G
    d**4) du, and their mass (kg).

    For a cylindrical spring this is G d**4 / (8 D**3 n) (EN 13906-1); with the mass, 0.5 sqrt(k/m)
    is its surge frequency.
    """
    coil = np.linspace(*spring.free_coils, _SAMPLES)
    active = (spring.coil_gap(coil + 1.0) > 1e-6) | (spring.coil_gap(coil) > 1e-6)
    wire, mean = spring.wire_diameter.value(coil), spring.mean_diameter.value(coil)
    give = np.where(active, 8 * mean**3 / (spring.material.shear_modulus * wire**4), 0.0)
    weight = np.where(
        active, np.pi / 4 * wire**2 * spring.material.density * spring.line_speed(coil), 0.0
    )
    return 1.0 / float(np.trapezoid(give, coil)), float(np.trapezoid(weight, coil))


def card_quantities(card: SpringCard) -> dict[str, float]:
    """The values of a spring card, and the surge frequency that follows."""
    values = {
        "card_rate": card.rate, "card_preload": card.preload, "card_mass": card.mass, "card_installed_height": card.installed_height,
        "card_open_force": card.open_load, "card_open_lift": card.open_lift, "card_solid_height": card.solid_height,
        "card_surge_frequency": card.surge_frequency,
    }  # fmt: skip
    return {name: value for name, value in values.items() if value is not None}
