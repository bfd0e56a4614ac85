"""Patches of contact of a spring made of solid finite elements: coil on coil, and the free wire on its
seats, along the wire and across it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.coil_contact.line_contact import line_contact
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.result import Solution

#: What the wire touches -> channel of the force per length there.
LINE_FORCES = {
    "coil below": "coil_line_force",
    "seat": "seat_line_force",
    "retainer": "retainer_line_force",
}


class ContactPatch(NamedTuple):
    """Wire that touches without a break in place or time.

    ``partner``: coil below, seat or retainer; ``first_coil``, ``last_coil``: ends along the (upper)
    wire in coils, over the whole time; ``first_angle`` (rad) and ``duration`` (rad of the cam; 2 pi:
    never open); ``line_force`` (N/m) the largest, at ``coil`` and ``cam_angle`` (rad); ``width`` (m)
    across the wire and ``pressure`` (Pa) there, by Hertz.
    """

    partner: str
    first_coil: float
    last_coil: float
    first_angle: float
    duration: float
    line_force: float
    coil: float
    cam_angle: float
    width: float
    pressure: float


def contact_patches(
    run: Solution, wire: SpringDefinition, spring: str = "spring"
) -> tuple[ContactPatch, ...]:
    """Patches over the reported cam cycle, those of the largest force per length first.

    Parameters
    ----------
    run : a run of the model ``solid``; others have no force per length, and no patches
    wire : the wire of the spring
    spring : its name in the run

    Returns
    -------
    All patches. A force between two samples belongs to the later one, so a patch begins up to one
    sample late.

    Examples
    --------
    >>> import numpy as np
    >>> import valvetrain as vt
    >>> from valvetrain.solution.channels import FINE, spring_channels
    >>> angle, force = np.radians(np.arange(0.0, 361.0)), np.zeros((361, 3))
    >>> force[100:111, 1:] = 1e4
    >>> made = spring_channels(
    ...     angle, angle, {"coil_line_force": force}, extra=FINE, point_coils={"coil_point": [2, 2.5, 3]}
    ... )
    >>> wire = vt.parameters.SpringDefinition("4 mm", "24 mm", total_coils=6, free_length="44 mm", material="OTEVA 90 SC")
    >>> (patch,) = contact_patches(vt.Solution(made), wire)
    >>> patch.first_coil, patch.last_coil, round(np.degrees(patch.first_angle))
    (2.5, 3.0, 100)
    >>> round(patch.width * 1e6, 1), round(patch.pressure / 1e6)
    (21.3, 599)
    """
    found: list[ContactPatch] = []
    for partner, name in LINE_FORCES.items():
        channel = run.channel_of(spring, name)
        coil = run.arrays.along(channel) if run.has(channel) else None
        if coil is not None and len(run.time) > 2:
            found += _patches(run, channel, coil, partner, wire)
    return tuple(sorted(found, key=lambda patch: -patch.line_force))


def _patches(
    run: Solution, channel: str, coil: Array, partner: str, wire: SpringDefinition
) -> list[ContactPatch]:
    cycle = reported_cycle(run)
    force, angle = cycle.channel(channel), cycle.cam_angle
    step, patches = float(angle[1] - angle[0]), list[ContactPatch]()
    for own in _joined(force > 0, cycle.whole):
        rows, columns = own.any(axis=1), np.flatnonzero(own.any(axis=0))
        begins = np.flatnonzero(rows & ~np.roll(rows, 1))
        within = np.where(own, force, 0.0)
        row, column = np.unravel_index(int(np.argmax(within)), own.shape)
        most = float(within[row, column])
        patches.append(
            ContactPatch(
                partner,
                float(coil[columns[0]]),
                float(coil[columns[-1]]),
                float(angle[begins[0]]) if len(begins) else 0.0,
                float(np.count_nonzero(rows)) * step,
                most,
                float(coil[column]),
                float(angle[row]),
                *hertz_of(wire, float(coil[column]), partner, most),
            )
        )
    return patches


def _joined(touching: Flags, whole: bool) -> list[Flags]:
    """Parts of a map (sample, point) that hang together, of a ``whole`` revolution also across its
    seam.
    """
    from scipy import ndimage

    label, count = ndimage.label(touching, np.ones((3, 3)))
    same = np.arange(count + 1)
    for shift in (-1, 0, 1) if whole else ():
        last, first = label[-1, max(0, shift) :], label[0, max(0, -shift) :]
        for one, other in zip(last, first, strict=False):
            if one and other:
                same[same == same[one]] = same[other]
    joined = same[label]
    return [joined == number for number in np.unique(joined) if number]


def ground_width(wire: SpringDefinition, coil: Array, end: str) -> Array:
    """Width (m) of the flat that the seat or retainer plane cuts into the free wire at coil numbers."""
    level = np.asarray(wire.centreline(coil))[:, 2]
    height = level - wire.lower_seat_height if end == "seat" else wire.upper_seat_height - level
    radius = np.asarray(wire.wire_diameter.value(coil)) / 2
    return 2 * np.sqrt(np.maximum(radius**2 - height**2, 0.0))


def hertz_of(
    wire: SpringDefinition, coil: float, partner: str, line_force: float
) -> tuple[float, float]:
    """Width (m) and largest pressure (Pa) across the wire at a coil number under a force per length
    (N/m), by Hertz for round wires and for a flat seat of the same steel; of wire ground wider than
    that its face and the mean pressure.
    """
    own = float(wire.wire_diameter.value(coil))
    if partner == "coil below":
        below = float(wire.wire_diameter.value(coil - 1))
        equal = 2 * own * below / (own + below)
    else:
        equal = 2 * own  # a plane is as two wires of twice the diameter
    half = line_contact(equal, wire.material, line_force).half_width
    face = 0.0
    if partner != "coil below":
        face = float(ground_width(wire, np.array([coil]), partner)[0])
    if face > 2 * half:
        return face, line_force / face
    return 2 * half, 2 * line_force / (np.pi * half)
