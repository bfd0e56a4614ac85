"""Named quantities of a spring as it is installed: before anything is solved."""

from __future__ import annotations

import numpy as np

from valvetrain.parameters.installed_spring import InstalledSpring, SpringCard
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.quantities.statics import formula_compression
from valvetrain.springs.stress import bergstraesser

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


def closing_quantities(spring: InstalledSpring) -> dict[str, float]:
    """Of a wire, force and stress with all coils closed; nothing of a card."""
    return {} if spring.wire is None else solid_quantities(spring.wire)


def size_quantities(spring: InstalledSpring) -> dict[str, float]:
    """Sizes of a wire that its static curve is compared with, and what closes it."""
    if spring.wire is None:
        return {}
    names = ("free_length", "solid_height", "largest_pitch")
    return {
        name: value for name, value in definition_quantities(spring.wire).items() if name in names
    } | solid_quantities(spring.wire)


def solid_quantities(wire: SpringDefinition) -> dict[str, float]:
    """Force (N) that closes the last coil, by torsion of the wire, and the largest shear (Pa) along
    the closed wire, by EN 13906-1.

    A turn closes under (pitch - rise when closed) G d**4 / (8 D**3) and then twists no further; of
    a cylindrical spring of constant pitch
    that is the theoretical force at solid, rate times compression to solid.
    """
    coil = np.linspace(*wire.free_coils, _SAMPLES)
    diameter, mean, pitch = (
        law.value(coil) for law in (wire.wire_diameter, wire.mean_diameter, wire.pitch)
    )
    force = (
        (pitch - wire.solid_rise(coil)) * wire.material.shear_modulus * diameter**4 / (8 * mean**3)
    )
    shear = bergstraesser(mean / diameter) * 8 * force * mean / (np.pi * diameter**3)
    return {"solid_force": float(np.max(force)), "solid_nominal_shear_stress": float(np.max(shear))}


def definition_quantities(spring: SpringDefinition) -> dict[str, float]:
    """Geometry, mass, and the estimates of rate and first surge frequency in the free state."""
    coil = np.linspace(0.0, spring.total_coils, _SAMPLES)
    index = spring.index(coil)
    rate, active_mass = estimated_rate(spring)
    return {
        "total_coil_count": spring.total_coils,
        "active_coil_count": spring.active_coils,
        "free_length": spring.free_length,
        "solid_height": spring.solid_height,
        "solid_compression": spring.free_length - spring.solid_height,
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
    """What a spring card tells, and the surge frequency that follows."""
    values = {
        "card_rate": card.rate, "card_preload": card.preload, "card_mass": card.mass, "card_installed_height": card.installed_height,
        "card_open_force": card.open_load, "card_open_lift": card.open_lift, "card_solid_height": card.solid_height,
        "card_surge_frequency": card.surge_frequency,
    }  # fmt: skip
    return {name: value for name, value in values.items() if value is not None}
