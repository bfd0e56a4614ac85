"""Channels along the wire as colours: stress, contact, gap and velocity, each over one range for the whole cycle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.parameters.spring import SpringDefinition
from valvetrain.quantities.cycle import Cycle
from valvetrain.report.motion.parts import Array, Colouring, Places, SpringDrawing, Variant
from valvetrain.springs.stress import bergstraesser

#: Colours from low to high. Nothing to see is grey, on light and dark paper alike; what is large is dark red.
RISING = ("#8fa3b5", "#5b8fc9", "#3f6fd1", "#8a4fc4", "#d14a7a", "#e8503a", "#a3131c")
NEAR = ("#b3131c", "#ef7d2e", "#e9c46a", "#a9b4bf", "#8f9aa6")
BOTH_WAYS = ("#1f4fb0", "#4f86d9", "#a9bdd3", "#9aa3ad", "#e0b59b", "#dd6b3a", "#a8201a")
#: Keys of the colourings.
COLOURS = ("stress", "contact", "gap", "velocity")
#: Gaps (mm) from here on look alike.
WIDEST_GAP = 1.0
_ALONG = {"stress": "inner_fibre_shear_stress", "velocity": "axial_velocity"}


def colourings_of(
    cycle: Cycle, channel: dict[str, str], coil: Array, wire: SpringDefinition, nodes: Places, sample: Places
) -> list[Colouring]:
    """Every colouring that a run has.

    Parameters
    ----------
    cycle : the reported cycle
    channel : name within a single spring -> name of this spring's channel
    coil : (node,) coil numbers drawn
    wire : the spring's wire
    nodes : (node,) place of every node among the channel's wire points, -1 where the model has none (inactive wire)
    sample : (frame,) samples drawn

    Returns
    -------
    Stress (MPa), contact force per length of wire (N/mm), gap (mm), velocity (m/s), those there are
    """
    found: list[Colouring] = []
    if (stress := _along(cycle, channel[_ALONG["stress"]], nodes, sample)) is not None:
        found.append(_rising("stress", "shear stress at the inner fibre", "MPa", 1e-6 * stress))
    pairs = _pairs(cycle, channel["coil_gap"], wire)
    if pairs is not None:
        places, upper, length = pairs
        name = "coil_contact_peak_force" if cycle.solution.has(channel["coil_contact_peak_force"]) else "coil_contact_force"
        force = largest_between(cycle.channel(channel[name])[:, places], sample) / length / 1e3
        found.append(_rising("contact", "contact force per mm of wire", "N/mm", _on_nodes(force, upper, coil, 0.0, np.maximum)))
        gap = 1e3 * cycle.channel(channel["coil_gap"])[:, places][sample]
        shown = _on_nodes(np.where(np.isfinite(gap), gap, WIDEST_GAP), upper, coil, WIDEST_GAP, np.minimum)
        found.append(Colouring("gap", f"gap to the next coil, {WIDEST_GAP:g} mm and more alike", "mm", shown, 0.0, WIDEST_GAP, NEAR))
    if (velocity := _along(cycle, channel[_ALONG["velocity"]], nodes, sample)) is not None:
        reach = max(float(np.abs(velocity).max(initial=0.0)), 1e-9)
        words = "axial velocity, towards the retainer positive"
        found.append(Colouring("velocity", words, "m/s", velocity, -reach, reach, BOTH_WAYS))
    return found


def slope_stress(wire: SpringDefinition, coil: Array, displacement: Array, preload: float) -> Colouring:
    """Shear stress of a model that tells how its coils move and no section loads, by the textbook.

    Parameters
    ----------
    wire : the spring's wire
    coil : (node,) coil numbers, ascending
    displacement : (frame, node) axial displacement (m) from the installed state, seat to retainer positive
    preload : force (N) of the installed spring

    Returns
    -------
    Colouring in MPa: the axial force at a place is the preload and what the slope of the displacement over the local compliance
    64 R**3 / (G d**4) per turn adds; the stress k 8 F D / (pi d**3) with Bergstraesser's k (EN 13906-1). Inactive wire carries none.
    """
    thick, mean = wire.wire_diameter.value(coil), wire.mean_diameter.value(coil)
    compliance = 8 * mean**3 / (wire.material.shear_modulus * thick**4)
    force = preload - np.gradient(displacement, coil, axis=1) / compliance
    first, last = wire.free_coils
    active = (coil >= first - 1e-9) & (coil <= last + 1e-9)
    stress = 1e-6 * np.where(active, bergstraesser(mean / thick) * 8 * mean * force / (np.pi * thick**3), 0.0)
    return _rising("stress", "shear stress by the slope of the coils", "MPa", stress)


def largest_between(values: Array, sample: Places) -> Array:
    """Largest of ``values`` (sample, n) since the frame before, (frame, n): a spike between two frames is seen in the later one."""
    starts = np.concatenate(([0], sample[:-1] + 1))
    found: Array = np.maximum.reduceat(values, starts, axis=0)
    # What follows the last frame belongs to no frame.
    found[-1] = values[starts[-1] : sample[-1] + 1].max(axis=0)
    return found


def one_range(variants: tuple[Variant, ...]) -> tuple[Variant, ...]:
    """The variants with one range per colouring, so that a colour means the same in all of them."""
    ends: dict[str, tuple[float, float]] = {}
    for variant in variants:
        for one in (one for spring in variant.springs for one in spring.colourings):
            low, high = ends.get(one.key, (one.low, one.high))
            ends[one.key] = min(low, one.low), max(high, one.high)

    def changed(spring: SpringDrawing) -> SpringDrawing:
        same = tuple(replace(one, low=ends[one.key][0], high=ends[one.key][1]) for one in spring.colourings)
        return replace(spring, colourings=same)

    return tuple(replace(variant, springs=tuple(map(changed, variant.springs))) for variant in variants)


def _rising(key: str, words: str, unit: str, values: Array) -> Colouring:
    return Colouring(key, words, unit, values, min(0.0, float(values.min(initial=0.0))), max(float(values.max(initial=0.0)), 1e-9), RISING)


def _along(cycle: Cycle, name: str, nodes: Places, sample: Places) -> Array | None:
    """A channel on the nodes (frame, node); inactive wire shows what its neighbour on the model shows."""
    if not cycle.solution.has(name):
        return None
    inside = np.flatnonzero(nodes >= 0)
    if not len(inside):
        return None
    nearest = nodes[inside[np.clip(np.searchsorted(inside, np.arange(len(nodes))), 0, len(inside) - 1)]]
    values: Array = cycle.channel(name)[sample][:, np.where(nodes >= 0, nodes, nearest)]
    return values


def _pairs(cycle: Cycle, name: str, wire: SpringDefinition) -> tuple[Places, Array, Array] | None:
    """Coil pairs in order of the coil number of the upper partner: places, coil numbers, length of wire (m) that each stands for."""
    if not cycle.solution.has(name):
        return None
    upper = cycle.solution.arrays.along(name)
    if upper is None:
        return None
    values, places, counts = np.unique(upper, return_index=True, return_counts=True)
    # Contacts with seat and retainer all bear the coil number of a tip and no place along the wire.
    order = places[(counts == 1) & (values >= 1.0 - 1e-9)]
    if len(order) < 2:
        return None
    spacing = float(np.median(np.diff(upper[order])))
    return order, upper[order], spacing * wire.line_speed(upper[order])


def _on_nodes(values: Array, upper: Array, coil: Array, outside: float, choose: np.ufunc) -> Array:
    """Pair values (frame, pair) at the nodes (frame, node): of the pair with the coil below and of that with the coil above."""
    below, above = (_at(values, upper, coil + turn, outside) for turn in (0.0, 1.0))
    found: Array = choose(below, above)
    return found


def _at(values: Array, upper: Array, coil: Array, outside: float) -> Array:
    right = np.clip(np.searchsorted(upper, coil - 1e-9), 1, len(upper) - 1)
    share = np.clip((coil - upper[right - 1]) / np.maximum(upper[right] - upper[right - 1], 1e-12), 0.0, 1.0)
    share = np.where(share > 1 - 1e-9, 1.0, np.where(share < 1e-9, 0.0, share))
    found = (1 - share) * values[:, right - 1] + share * values[:, right]
    inside = (coil >= upper[0] - 1e-6) & (coil <= upper[-1] + 1e-6)
    result: Array = np.where(inside, found, outside)
    return result
