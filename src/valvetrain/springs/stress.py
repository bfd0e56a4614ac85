"""Stress of round spring wire at the inner and outer fibre, from the section loads of a (reduced) rod.

Torsion and direct shear carry the curvature of the bar, bending in the coil plane its own. The
published factors hold for an axial
force, where torsional moment T and shear force V belong together (T = V D / 2); they are split into
a share of T and a share of V,
so that a dynamic state, where the two part, is covered as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition

#: Channels of stress in the wire -> words; all in Pa over sample and wire_point.
STRESS_CHANNELS: Mapping[str, str] = {
    "inner_fibre_shear_stress": "shear stress at the inner fibre, positive under compression of the spring",
    "outer_fibre_shear_stress": "shear stress at the outer fibre, positive under compression of the spring",
    "inner_fibre_axial_stress": "stress along the wire at the inner fibre, tension positive",
    "outer_fibre_axial_stress": "stress along the wire at the outer fibre, tension positive",
    "inner_fibre_equivalent_stress": "von Mises stress at the inner fibre",
    "outer_fibre_equivalent_stress": "von Mises stress at the outer fibre",
}

#: The section loads that are needed, as channels of a rod or a reduced rod.
LOADS = ("torsional_moment", "binormal_moment", "normal_force", "shear_force")


def goehner(index: Array) -> Array:
    """1 + 5/(4w) + 7/(8w^2) + 1/w^3, w = D/d: Goehner's series for the ring sector (goehner1932)."""
    return 1 + 5 / (4 * index) + 7 / (8 * index**2) + 1 / index**3


def bergstraesser(index: Array) -> Array:
    """(w + 0.5) / (w - 0.75): Bergstraesser, the factor k of EN 13906-1 (bergstraesser1933)."""
    return (index + 0.5) / (index - 0.75)


def wahl(index: Array) -> Array:
    """(4w - 1)/(4w - 4) + 0.615/w: Wahl, curvature and direct shear added (wahl1963)."""
    return (4 * index - 1) / (4 * index - 4) + 0.615 / index


#: Word -> factor at the inner fibre over the index; the outer fibre is the same law at minus the
#: index, with the centre on its far side.
CURVATURE_FACTORS: Mapping[str, Callable[[Array], Array]] = {
    "bergstraesser": bergstraesser,
    "goehner": goehner,
    "wahl": wahl,
}
DEFAULT_FACTOR = "bergstraesser"
#: Places along the free turns at which the nominal stress is looked for.
NOMINAL_SAMPLES = 4001


def shear_stress_factor(curvature: str, index: ArrayLike, fibre: str = "inner") -> Array:
    """Shear at a fibre over 8 F D / (pi d^3) under an axial force F; ``index`` D/d, ``fibre`` inner
    or outer.

    Raises :class:`InputError` for an unknown factor or fibre, or an index of 1 or less.
    """
    if curvature not in CURVATURE_FACTORS:
        raise InputError(
            f"curvature factor '{curvature}' is unknown; use {', '.join(CURVATURE_FACTORS)} or none"
        )
    if fibre not in ("inner", "outer"):
        raise InputError(f"fibre '{fibre}' is unknown; use inner or outer")
    ratio = np.asarray(index, dtype=float)
    if not np.all(ratio > 1):
        raise InputError(
            f"a spring index of {float(np.min(ratio)):g} has no coil; the mean diameter must exceed the wire diameter"
        )
    return CURVATURE_FACTORS[curvature](ratio if fibre == "inner" else -ratio)


def bending_stress_factor(index: ArrayLike, fibre: str = "inner") -> Array:
    """Stress over 32 M / (pi d^3) of a round bar bent in the plane of its curvature: (4w^2 - w - 1)
    / (4w (w - 1)) at the inner fibre.

    Wahl's form of the Winkler-Bach curved bar; the outer fibre is the same law at minus the index
    (wahl1963).
    """
    w = np.asarray(index, dtype=float) * (1.0 if fibre == "inner" else -1.0)
    return (4 * w**2 - w - 1) / (4 * w * (w - 1))


@dataclass(frozen=True, slots=True)
class FibreFactors:
    """What turns section loads into stress at one fibre: stress per N m or N, arrays (wire_point,)."""

    torsion: Array
    shear: Array
    bending: Array
    tension: Array


def fibre_factors(
    definition: SpringDefinition, coil: Array, fibre: str, curvature: str | None = DEFAULT_FACTOR
) -> FibreFactors:
    """Stress (Pa) per N m and per N at the ``inner`` or ``outer`` fibre of coil numbers ``coil`` (n,), arrays (n,).

    ``curvature`` None leaves out curvature and direct shear alike: 16 T / (pi d^3). The published factors hold the direct
    shear, which is taken out of the factor of the torsion and stands by itself.
    """
    wire, index = definition.wire_diameter.value(coil), definition.index(coil)
    side = 1.0 if fibre == "inner" else -1.0
    torsion, bending, area = 16 / (np.pi * wire**3), 32 / (np.pi * wire**3), np.pi / 4 * wire**2
    if curvature is None:
        return FibreFactors(torsion, np.zeros_like(torsion), side * bending, 1 / area)
    nu = definition.material.poisson_ratio
    # Saint-Venant's shear at the end of the neutral axis of a straight round bar; 1.23 V / A at nu
    # = 0.3 is Wahl's 0.615 / w.
    edge = (1 + 2 * nu) / (1 + nu)
    factor = shear_stress_factor(curvature, index, fibre)
    return FibreFactors(
        torsion * (factor - side * edge / (2 * index)),
        side * edge / area,
        side * bending * bending_stress_factor(index, fibre),
        1 / area,
    )


def wire_stress(
    loads: Mapping[str, Array],
    definition: SpringDefinition,
    coil: Array,
    curvature: str | None = DEFAULT_FACTOR,
) -> dict[str, Array]:
    """All of :data:`STRESS_CHANNELS` (Pa; samples, n) from section loads of these shapes (N m, N)
    at coil numbers ``coil`` (n,).

    The shear force is taken to act with the torsion, as under an axial force. Raises
    :class:`InputError` for an unknown factor.
    """
    compression = -1.0 if definition.hand == "right" else 1.0
    found: dict[str, Array] = {}
    for fibre in ("inner", "outer"):
        by = fibre_factors(definition, coil, fibre, curvature)
        shear = (
            compression * by.torsion * loads["torsional_moment"] + by.shear * loads["shear_force"]
        )
        axial = by.bending * loads["binormal_moment"] + by.tension * loads["normal_force"]
        found[f"{fibre}_fibre_shear_stress"], found[f"{fibre}_fibre_axial_stress"] = shear, axial
        found[f"{fibre}_fibre_equivalent_stress"] = np.sqrt(axial**2 + 3 * shear**2)
    return {name: found[name] for name in STRESS_CHANNELS}


def nominal_stress_per_force(wire: SpringDefinition, corrected: bool = True) -> float:
    """Largest of k 8 D / (pi d**3) (Pa per N) over the free turns, k = (w + 0.5) / (w - 0.75), w =
    D / d (EN 13906-1).

    Not ``corrected`` k is 1: the stress that the standard takes of a load at rest, without curvature and direct shear.
    """
    coil = np.linspace(*wire.free_coils, NOMINAL_SAMPLES)
    diameter, mean = wire.wire_diameter.value(coil), wire.mean_diameter.value(coil)
    factor = bergstraesser(mean / diameter) if corrected else 1.0
    return float(np.max(factor * 8 * mean / (np.pi * diameter**3)))
