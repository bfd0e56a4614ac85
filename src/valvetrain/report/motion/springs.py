"""A spring as it is drawn: nodes on the helix of its wire, moved along the axis as the solution says."""

from __future__ import annotations

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.quantities.cycle import Cycle
from valvetrain.report.motion.colours import colourings_of, slope_stress
from valvetrain.report.motion.parts import Array, Places, SpringDrawing
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.chain_layout import local_compliance
from valvetrain.springs.wire_from_card import ACTIVE_COILS, wire_from_card

#: Nodes per turn that are drawn at most, and of wire on which the model has none.
MOST_PER_TURN, PER_TURN = 16, 8
_CHANNELS = (
    "axial_position", "axial_displacement", "axial_velocity", "inner_fibre_shear_stress", "coil_gap", "coil_contact_force",
    "coil_contact_peak_force",
)  # fmt: skip


def draw_spring(
    installed: InstalledSpring, name: str, cycle: Cycle, sample: Places, travel: Array, rest: SpringAtRest | None, shared: bool = False
) -> tuple[SpringDrawing | None, tuple[str, ...]]:
    """One spring over the frames, and sentences on what is reconstructed.

    Parameters
    ----------
    installed : the spring
    name : its name in the run (``spring``, ``outer``, ``inner``)
    cycle : the reported cycle
    sample : (frame,) samples drawn
    travel : (frame,) displacement (m) of the retainer towards the seat
    rest : the spring at rest, whose static curve gives the installed shape where the run does not
    shared : springs that rub on each other ran as one, so forces are of both; the run tells the coils of the outer one alone

    Returns
    -------
    The drawing, None for a card without a mass, and the sentences
    """
    wire, precompression, notes = wire_of(installed, float(np.max(travel, initial=0.0)))
    if wire is None:
        return None, notes
    known = not shared or name != "inner"
    channel = {one: cycle.solution.channel_of(name, one) if known else "" for one in _CHANNELS}
    coil, nodes, told = _nodes(cycle, channel["axial_displacement"], wire)
    exact = cycle.solution.has(channel["axial_position"], channel["axial_displacement"])
    if np.any(nodes >= 0):
        moved = np.where(coil < wire.total_coils / 2, 0.0, -travel[:, None])
        moved[:, nodes >= 0] = cycle.channel(channel["axial_displacement"])[sample][:, nodes[nodes >= 0]]
    else:
        moved = -travel[:, None] * compliance_share(wire, coil)
        whose = "this model moves no coils" if known else "of springs that rub the run tells the coils of the outer one alone"
        told = (f"{whose}: they are spread over the wire by its compliance, as in slow motion",)
    if exact:
        both = (cycle.solution.channel(channel[one])[0, nodes] for one in ("axial_position", "axial_displacement"))
        heights = next(both) - next(both)
    else:
        heights = installed_heights(wire, precompression, coil, rest)
        told += (
            "the installed shape is that of the static curve" if _curve(rest) else "the installed shape follows the wire's compliance",
        )
    colourings = colourings_of(cycle, channel, coil, wire, nodes, sample)
    if (
        not shared
        and installed.wire is not None
        and cycle.solution.model != "finite-element"
        and _knows_turns(cycle, channel["axial_displacement"], wire)
    ):
        colourings.insert(0, slope_stress(wire, coil, moved, closed_force(cycle, name)))
        told += ("stress follows from the slope of the coils by the textbook's torsion, for the model gives no section loads",)
    spring = SpringDrawing(
        name, coil, wire.mean_diameter.value(coil) / 2, wire.wire_diameter.value(coil) / 2, 1.0 if wire.hand == "right" else -1.0,
        heights, moved, wire.free_length - precompression - travel,
        tuple(colourings),
    )  # fmt: skip
    return spring, (*notes, *told)


def closed_force(cycle: Cycle, name: str) -> float:
    """Force (N) of a spring while the valve is closed, the mean of both ends, in which surge cancels."""
    lift = cycle.channel("valve_lift")
    closed = lift <= lift.min() + 0.01 * np.ptp(lift)
    ends = [cycle.solution.channel_of(name, one) for one in ("retainer_force", "seat_force")]
    return float(np.mean([cycle.channel(one)[closed].mean() for one in ends if cycle.solution.has(one)] or [0.0]))


def compliance_share(wire: SpringDefinition, coil: Array) -> Array:
    """Share (node,) of the whole compliance between the lower fixed end and ``coil``: how far a section moves in slow motion."""
    first, last = wire.free_coils
    edges = np.linspace(first, last, 257)
    grown = np.concatenate(([0.0], np.cumsum(local_compliance(wire, edges))))
    found: Array = np.interp(coil, edges, grown / grown[-1])
    return found


def installed_heights(wire: SpringDefinition, precompression: float, coil: Array, rest: SpringAtRest | None) -> Array:
    """Heights (node,) of the wire axis above the lower seat in the installed state (m)."""
    free, curve = wire.axial_position(coil) - wire.lower_seat_height, _curve(rest)
    if curve is None:
        return free - precompression * compliance_share(wire, coil)
    compression, places, heights = curve
    moved = np.array([np.interp(precompression, compression, column - column[0]) for column in heights.T])
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


def wire_of(installed: InstalledSpring, valve_lift: float) -> tuple[SpringDefinition | None, float, tuple[str, ...]]:
    """The wire that is drawn, its precompression (m) and a note where a card does not tell it; None for a card without a mass.

    ``valve_lift`` (m): a wire made up for a card has room for it.
    """
    if installed.wire is not None:
        return installed.wire, installed.precompression, ()
    assert installed.card is not None
    try:
        wire, precompression = wire_from_card(installed.card, valve_lift)
    except InputError:
        return None, 0.0, (f"spring '{installed.name}' is known by a card without a mass, so its wire is not drawn",)
    words = f"a card does not tell the wire: drawn is one of {ACTIVE_COILS:g} turns with the rate, preload and mass of the card"
    return wire, precompression, (words,)


def _shares(places: Array, wire: SpringDefinition) -> bool:
    """Whether places along the wire are shares 0..1 of a uniform spring, not turns."""
    first, last = wire.free_coils
    return bool(places[0] >= -1e-9 and places[-1] <= 1 + 1e-9 < last - first)


def _knows_turns(cycle: Cycle, name: str, wire: SpringDefinition) -> bool:
    places = cycle.solution.arrays.along(name) if cycle.solution.has(name) else None
    return places is not None and len(places) > 4 and not _shares(places, wire)


def _nodes(cycle: Cycle, name: str, wire: SpringDefinition) -> tuple[Array, Places, tuple[str, ...]]:
    """Coil numbers that are drawn, ascending from tip to tip, their places among the model's wire points (-1: none), and notes."""
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
            ("the model knows shares of a uniform spring, not turns: they are spread evenly over the free turns",),
        )
    chosen = np.unique(np.linspace(0, len(own) - 1, min(len(own), int(turns * MOST_PER_TURN) + 1)).round().astype(int))
    lower = np.linspace(0.0, own[0], int(np.ceil(own[0] * PER_TURN)) + 1)[:-1] if own[0] > 1e-6 else np.zeros(0)
    upper = np.linspace(own[-1], turns, int(np.ceil((turns - own[-1]) * PER_TURN)) + 1)[1:] if turns - own[-1] > 1e-6 else np.zeros(0)
    coil = np.concatenate((lower, own[chosen], upper))
    nodes = np.concatenate((np.full(len(lower), -1), chosen, np.full(len(upper), -1)))
    if not cycle.solution.has(name.replace("displacement", "position")):
        notes = (*notes, "coils stand at their axial displacements on the helix of the wire; inactive turns move with seat and retainer")
    return coil, nodes.astype(np.int64), notes
