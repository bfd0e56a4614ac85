"""How a wire lifts off its fixed end: the rows of a chain's contacts there.

A chain knows the travel of a section's plane along the axis. The wire itself stands a radius R off
the axis: a twist dtheta at phi lifts
the wire at psi by R (1 - cos(psi - phi)) dtheta, not by R dtheta. Under uniform twist the wire
rises from its clamp as psi - sin(psi), so
within the first tenths of a turn hardly at all, while the chain's section rises as psi. Between
free neighbours a turn apart the two agree.
A contact force also bends the wire out of its clamp; each contact feels its own bending, not that
by the others.
"""

from __future__ import annotations

import numpy as np

from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.contract import Array


def wire_lift_row(
    spring: SpringDefinition, coil: Array, place: float, *, from_below: bool
) -> Array:
    """Axial travel of the wire at coil number ``place`` towards its fixed end per node travel,
    shape (N + 1,), nodes at ``coil``.

    ``from_below``: relative to the lower fixed end (twist of the elements below counts), else of
    the upper end relative to the wire.
    """
    edges = np.minimum(coil, place) if from_below else np.maximum(coil, place)
    turned = 2 * np.pi * np.abs(place - edges)
    middle = (coil[:-1] + coil[1:]) / 2
    radius = spring.mean_diameter.value(np.array([place]))[0] / spring.mean_diameter.value(middle)
    share = (
        (np.diff(turned) - radius * np.diff(np.sin(turned)))
        / (2 * np.pi * np.diff(coil))
        * (-1.0 if from_below else 1.0)
    )
    row = np.zeros(len(coil))
    row[1:] += share
    row[:-1] -= share
    return row


def bending_compliance(spring: SpringDefinition, place: Array, turns: Array) -> Array:
    """Axial travel (m/N) of the wire at coil numbers ``place`` by its bending alone, ``turns`` off
    the clamp, under a force there.

    The moment R sin(psi - phi) about the wire's normal: R**3 (psi/2 - sin(2 psi)/4) / (E I).
    """
    psi, radius = 2 * np.pi * turns, spring.mean_diameter.value(place) / 2
    bending_stiffness = (
        spring.material.youngs_modulus * np.pi / 64 * spring.wire_diameter.value(place) ** 4
    )
    return np.asarray(radius**3 * (psi / 2 - np.sin(2 * psi) / 4) / bending_stiffness)
