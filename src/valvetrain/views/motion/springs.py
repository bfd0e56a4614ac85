"""Drawing of a spring: nodes on the helix of its wire, displaced along the axis by the solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.quantities.cycle import Cycle
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.chain_layout import local_compliance
from valvetrain.springs.stress import bergstraesser
from valvetrain.springs.wire_from_card import ACTIVE_COILS, wire_from_card
from valvetrain.views.motion.parts import Colouring, Places, SpringDrawing, Variant

#: Colours from low to high. Nothing to see is grey, on light and dark paper alike; what is large is
#: dark red.
RISING = ("#8fa3b5", "#5b8fc9", "#3f6fd1", "#8a4fc4", "#d14a7a", "#e8503a", "#a3131c")
NEAR = ("#b3131c", "#ef7d2e", "#e9c46a", "#a9b4bf", "#8f9aa6")
BOTH_WAYS = ("#1f4fb0", "#4f86d9", "#a9bdd3", "#9aa3ad", "#e0b59b", "#dd6b3a", "#a8201a")
#: Gaps (mm) from here on look alike.
WIDEST_GAP = 1.0
_ALONG = {"stress": "inner_fibre_shear_stress", "velocity": "axial_velocity"}


def colourings_of(
    cycle: Cycle,
    channel: dict[str, str],
    coil: Array,
    wire: SpringDefinition,
    nodes: Places,
    sample: Places,
) -> list[Colouring]:
    """Every colouring that a run has.

    Parameters
    ----------
    cycle : the reported cycle
    channel : name within a single spring -> name of this spring's channel
    coil : (node,) coil numbers drawn
    wire : the spring's wire
    nodes : (node,) place of every node among the channel's wire points, -1 where the model has none
        (inactive wire)
    sample : (frame,) samples drawn

    Returns
    -------
    Stress over the surface (solid finite elements) and at the inner fibre (MPa), contact force per
    length of wire (N/mm), gap (mm), velocity (m/s), those there are
    """
    found = _surface(cycle, channel["surface_equivalent_stress"], coil, sample)
    if (stress := _along(cycle, channel[_ALONG["stress"]], nodes, sample)) is not None:
        found.append(_rising("stress", "shear stress at the inner fibre", "MPa", 1e-6 * stress))
    pairs = _pairs(cycle, channel["coil_gap"], wire)
    if pairs is not None:
        places, upper, length = pairs
        name = (
            "coil_contact_peak_force"
            if cycle.solution.has(channel["coil_contact_peak_force"])
            else "coil_contact_force"
        )
        force = largest_between(cycle.channel(channel[name])[:, places], sample) / length / 1e3
        found.append(
            _rising(
                "contact",
                "contact force per length of wire",
                "N/mm",
                _on_nodes(force, upper, coil, 0.0, np.maximum),
            )
        )
        gap = 1e3 * cycle.channel(channel["coil_gap"])[:, places][sample]
        shown = _on_nodes(
            np.where(np.isfinite(gap), gap, WIDEST_GAP), upper, coil, WIDEST_GAP, np.minimum
        )
        found.append(
            Colouring(
                "gap",
                f"gap to the next coil, {WIDEST_GAP:g} mm and more alike",
                "mm",
                shown,
                0.0,
                WIDEST_GAP,
                NEAR,
            )
        )
    if (velocity := _along(cycle, channel[_ALONG["velocity"]], nodes, sample)) is not None:
        reach = max(float(np.abs(velocity).max(initial=0.0)), 1e-9)
        label = "axial velocity, towards the retainer positive"
        found.append(Colouring("velocity", label, "m/s", velocity, -reach, reach, BOTH_WAYS))
    return found


def slope_stress(
    wire: SpringDefinition, coil: Array, displacement: Array, preload: float
) -> Colouring:
    """Shear stress from coil displacements by the textbook, for models without section loads.

    Parameters
    ----------
    wire : the spring's wire
    coil : (node,) coil numbers, ascending
    displacement : (frame, node) axial displacement (m) from the installed state, seat to retainer
        positive
    preload : force (N) of the installed spring

    Returns
    -------
    Colouring in MPa: the axial force at a place is the preload and what the slope of the
    displacement over the local compliance
    64 R**3 / (G d**4) per turn adds; the stress k 8 F D / (pi d**3) with Bergstraesser's k (EN
    13906-1). Inactive wire carries none.
    """
    thick, mean = wire.wire_diameter.value(coil), wire.mean_diameter.value(coil)
    compliance = 8 * mean**3 / (wire.material.shear_modulus * thick**4)
    force = preload - np.gradient(displacement, coil, axis=1) / compliance
    first, last = wire.free_coils
    active = (coil >= first - 1e-9) & (coil <= last + 1e-9)
    stress = 1e-6 * np.where(
        active, bergstraesser(mean / thick) * 8 * mean * force / (np.pi * thick**3), 0.0
    )
    return _rising("stress", "shear stress by the slope of the coils", "MPa", stress)


def largest_between(values: Array, sample: Places) -> Array:
    """Largest of ``values`` (sample, n) since the frame before, (frame, n): a spike between two
    frames is seen in the later one.
    """
    starts = np.concatenate(([0], sample[:-1] + 1))
    found: Array = np.maximum.reduceat(values, starts, axis=0)
    # What follows the last frame belongs to no frame.
    found[-1] = values[starts[-1] : sample[-1] + 1].max(axis=0)
    return found


def one_range(variants: tuple[Variant, ...]) -> tuple[Variant, ...]:
    """The variants with one common range per colouring."""
    ends: dict[str, tuple[float, float]] = {}
    for variant in variants:
        for one in (one for spring in variant.springs for one in spring.colourings):
            low, high = ends.get(one.key, (one.low, one.high))
            ends[one.key] = min(low, one.low), max(high, one.high)

    def changed(spring: SpringDrawing) -> SpringDrawing:
        same = tuple(
            replace(one, low=ends[one.key][0], high=ends[one.key][1]) for one in spring.colourings
        )
        return replace(spring, colourings=same)

    return tuple(
        replace(variant, springs=tuple(map(changed, variant.springs))) for variant in variants
    )


def _rising(key: str, label: str, unit: str, values: Array) -> Colouring:
    return Colouring(
        key,
        label,
        unit,
        values,
        min(0.0, float(values.min(initial=0.0))),
        max(float(values.max(initial=0.0)), 1e-9),
        RISING,
    )


def _along(cycle: Cycle, name: str, nodes: Places, sample: Places) -> Array | None:
    """A channel on the nodes (frame, node); inactive wire shows what its neighbour on the model
    shows.
    """
    if not cycle.solution.has(name):
        return None
    inside = np.flatnonzero(nodes >= 0)
    if not len(inside):
        return None
    nearest = nodes[
        inside[np.clip(np.searchsorted(inside, np.arange(len(nodes))), 0, len(inside) - 1)]
    ]
    values: Array = cycle.channel(name)[sample][:, np.where(nodes >= 0, nodes, nearest)]
    return values


def _surface(cycle: Cycle, name: str, coil: Array, sample: Places) -> list[Colouring]:
    """Stress over the surface of the wire, where a run has it; inactive wire shows what its neighbour
    shows.
    """
    places = cycle.solution.arrays.along(name) if cycle.solution.has(name) else None
    if places is None:
        return []
    own = np.unique(places)
    fibres = len(places) // len(own)
    values = 1e-6 * cycle.channel(name)[sample].reshape(len(sample), len(own), fibres)
    right = np.clip(np.searchsorted(own, coil), 1, len(own) - 1)
    share = np.clip((coil - own[right - 1]) / (own[right] - own[right - 1]), 0.0, 1.0)[:, None]
    around = (1 - share) * values[:, right - 1] + share * values[:, right]
    label = "von Mises stress on the wire's surface"
    return [replace(_rising("surface", label, "MPa", around.max(axis=2)), around=around)]


def _pairs(cycle: Cycle, name: str, wire: SpringDefinition) -> tuple[Places, Array, Array] | None:
    """Coil pairs in order of the coil number of the upper partner: places, coil numbers, length of
    wire (m) that each represents.
    """
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
    """Pair values (frame, pair) at the nodes (frame, node): of the pair with the coil below and of
    that with the coil above.
    """
    below, above = (_at(values, upper, coil + turn, outside) for turn in (0.0, 1.0))
    found: Array = choose(below, above)
    return found


def _at(values: Array, upper: Array, coil: Array, outside: float) -> Array:
    right = np.clip(np.searchsorted(upper, coil - 1e-9), 1, len(upper) - 1)
    share = np.clip(
        (coil - upper[right - 1]) / np.maximum(upper[right] - upper[right - 1], 1e-12), 0.0, 1.0
    )
    share = np.where(share > 1 - 1e-9, 1.0, np.where(share < 1e-9, 0.0, share))
    found = (1 - share) * values[:, right - 1] + share * values[:, right]
    inside = (coil >= upper[0] - 1e-6) & (coil <= upper[-1] + 1e-6)
    result: Array = np.where(inside, found, outside)
    return result


#: Nodes per turn that are drawn at most, and of wire on which the model has none.
MAX_PER_TURN, PER_TURN = 16, 8
_CHANNELS = (
    "axial_position", "axial_displacement", "axial_velocity", "inner_fibre_shear_stress", "coil_gap", "coil_contact_force",
    "coil_contact_peak_force", "surface_equivalent_stress",
)  # fmt: skip


def draw_spring(
    installed: InstalledSpring,
    name: str,
    cycle: Cycle,
    sample: Places,
    travel: Array,
    rest: SpringAtRest | None,
    shared: bool = False,
) -> tuple[SpringDrawing | None, tuple[str, ...]]:
    """One spring over the frames, and notes on what is reconstructed.

    Parameters
    ----------
    installed : the spring
    name : its name in the run (``spring``, ``outer``, ``inner``)
    cycle : the reported cycle
    sample : (frame,) samples drawn
    travel : (frame,) displacement (m) of the retainer towards the seat
    rest : the spring at rest, whose static curve gives the installed shape where the run does not
    shared : springs that rub on each other ran as one, so forces are of both; the run gives the
        coils of the outer one alone

    Returns
    -------
    The drawing, None for a card without a mass, and the sentences
    """
    wire, precompression, notes = wire_of(installed, float(np.max(travel, initial=0.0)))
    if wire is None:
        return None, notes
    known = not shared or name != "inner"
    channel = {one: cycle.solution.channel_of(name, one) if known else "" for one in _CHANNELS}
    coil, nodes, remarks = _nodes(cycle, channel["axial_displacement"], wire)
    exact = cycle.solution.has(channel["axial_position"], channel["axial_displacement"])
    if np.any(nodes >= 0):
        moved = np.where(coil < wire.total_coils / 2, 0.0, -travel[:, None])
        moved[:, nodes >= 0] = cycle.channel(channel["axial_displacement"])[sample][
            :, nodes[nodes >= 0]
        ]
    else:
        moved = -travel[:, None] * compliance_share(wire, coil)
        whose = (
            "this model moves no coils"
            if known
            else "of springs that rub the run gives the coils of the outer one alone"
        )
        remarks = (f"{whose}: they are spread over the wire by its compliance, as in slow motion",)
    if exact:
        both = (
            cycle.solution.channel(channel[one])[0, nodes]
            for one in ("axial_position", "axial_displacement")
        )
        heights = next(both) - next(both)
    else:
        heights = installed_heights(wire, precompression, coil, rest)
        remarks += (
            "the installed shape is that of the static curve"
            if _curve(rest)
            else "the installed shape follows the wire's compliance",
        )
    colourings = colourings_of(cycle, channel, coil, wire, nodes, sample)
    moving = channel["axial_displacement"]
    turns = cycle.solution.arrays.along(moving) if cycle.solution.has(moving) else None
    if (
        not shared
        and installed.wire is not None
        and cycle.solution.model != "finite-element"
        and not cycle.solution.has(channel["inner_fibre_shear_stress"])
        and turns is not None
        and len(turns) > 4
        and not _shares(turns, wire)
    ):
        colourings.insert(0, slope_stress(wire, coil, moved, closed_force(cycle, name)))
        remarks += (
            "stress follows from the slope of the coils by the textbook's torsion, for the model gives no section loads",
        )
    spring = SpringDrawing(
        name,
        coil,
        wire.mean_diameter.value(coil) / 2,
        wire.wire_diameter.value(coil) / 2,
        1.0 if wire.hand == "right" else -1.0,
        heights,
        moved,
        wire.free_length - precompression - travel,
        tuple(colourings),
    )
    return spring, (*notes, *remarks)


def closed_force(cycle: Cycle, name: str) -> float:
    """Force (N) of a spring while the valve is closed, the mean of both ends, in which surge
    cancels.
    """
    lift = cycle.channel("valve_lift")
    closed = lift <= lift.min() + 0.01 * np.ptp(lift)
    ends = [cycle.solution.channel_of(name, one) for one in ("retainer_force", "seat_force")]
    return float(
        np.mean(
            [cycle.channel(one)[closed].mean() for one in ends if cycle.solution.has(one)] or [0.0]
        )
    )


def compliance_share(wire: SpringDefinition, coil: Array) -> Array:
    """Share (node,) of the whole compliance between the lower fixed end and ``coil``: how far a
    section moves in slow motion.
    """
    first, last = wire.free_coils
    edges = np.linspace(first, last, 257)
    grown = np.concatenate(([0.0], np.cumsum(local_compliance(wire, edges))))
    found: Array = np.interp(coil, edges, grown / grown[-1])
    return found


def installed_heights(
    wire: SpringDefinition, precompression: float, coil: Array, rest: SpringAtRest | None
) -> Array:
    """Heights (node,) of the wire axis above the lower seat in the installed state (m)."""
    free, curve = wire.axial_position(coil) - wire.lower_seat_height, _curve(rest)
    if curve is None:
        return free - precompression * compliance_share(wire, coil)
    compression, places, heights = curve
    moved = np.array(
        [np.interp(precompression, compression, column - column[0]) for column in heights.T]
    )
    found: Array = free + np.interp(coil, places, moved)
    return found


def _curve(rest: SpringAtRest | None) -> tuple[Array, Array, Array] | None:
    curve = rest.curve if rest is not None else None
    if (
        curve is None
        or rest is None
        or len(curve.coil_number) < 2
        or not (curve.compression[0] <= 0 <= rest.precompression <= curve.compression[-1])
    ):
        return None
    return curve.compression, curve.coil_number, curve.axial_position


def wire_of(
    installed: InstalledSpring, valve_lift: float
) -> tuple[SpringDefinition | None, float, tuple[str, ...]]:
    """The wire to draw, its precompression (m) and a note where a card does not give it; None for a
    card without a mass.

    ``valve_lift`` (m): a wire made up for a card leaves travel for it.
    """
    if installed.wire is not None:
        return installed.wire, installed.precompression, ()
    assert installed.card is not None
    try:
        wire, precompression = wire_from_card(installed.card, valve_lift)
    except InputError:
        return (
            None,
            0.0,
            (
                f"spring '{installed.name}' is known by a card without a mass, so its wire is not drawn",
            ),
        )
    sentence = f"a card does not give the wire: the drawing shows one of {ACTIVE_COILS:g} turns with the rate, preload and mass of the card"
    return wire, precompression, (sentence,)


def _shares(places: Array, wire: SpringDefinition) -> bool:
    """Whether places along the wire are shares 0..1 of a uniform spring, not turns."""
    first, last = wire.free_coils
    return bool(places[0] >= -1e-9 and places[-1] <= 1 + 1e-9 < last - first)


def _nodes(
    cycle: Cycle, name: str, wire: SpringDefinition
) -> tuple[Array, Places, tuple[str, ...]]:
    """Coil numbers that are drawn, ascending from tip to tip, their places among the model's wire
    points (-1: none), and notes.
    """
    turns = wire.total_coils
    bare = np.linspace(0.0, turns, int(np.ceil(turns * PER_TURN)) + 1)
    places = cycle.solution.arrays.along(name) if cycle.solution.has(name) else None
    if places is None or len(places) < 2:
        return bare, np.full(len(bare), -1), ()
    notes: tuple[str, ...] = ()
    own = np.asarray(places, dtype=float)
    first, last = wire.free_coils
    if _shares(own, wire):
        own, notes = (
            first + own * (last - first),
            (
                "the model knows shares of a uniform spring, not turns: they are spread evenly over the free turns",
            ),
        )
    chosen = np.unique(
        np.linspace(0, len(own) - 1, min(len(own), int(turns * MAX_PER_TURN) + 1))
        .round()
        .astype(int)
    )
    lower = (
        np.linspace(0.0, own[0], int(np.ceil(own[0] * PER_TURN)) + 1)[:-1]
        if own[0] > 1e-6
        else np.zeros(0)
    )
    upper = (
        np.linspace(own[-1], turns, int(np.ceil((turns - own[-1]) * PER_TURN)) + 1)[1:]
        if turns - own[-1] > 1e-6
        else np.zeros(0)
    )
    coil = np.concatenate((lower, own[chosen], upper))
    nodes = np.concatenate((np.full(len(lower), -1), chosen, np.full(len(upper), -1)))
    if not cycle.solution.has(name.replace("displacement", "position")):
        notes = (
            *notes,
            "coils are drawn at their axial displacements on the helix of the wire; inactive turns move with seat and retainer",
        )
    return coil, nodes.astype(np.int64), notes
