"""Guides of the rod: a bore around the spring, a rod inside it, or both, as walls that the wire
leans on without friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array

#: Radius (m) of a wall that is not there, on either side.
NO_BORE, NO_ROD = 1e6, -1e6


@dataclass(frozen=True, slots=True)
class GuideWalls:
    """``bore`` (nv,): largest radius (m) of the wire's axis that the wall around the spring leaves;
    ``rod`` (nv,): the smallest that the
    wall inside leaves; ``stiffness`` (N/m per m of wire). The walls are centred on the axis of the seats,
    along the whole spring."""

    bore: Array
    rod: Array
    stiffness: float

    def depth(self, position: Array) -> Array:
        """How deep (m) the wire at ``position`` (..., nv, 3) is pressed, outwards positive, inwards
        negative.
        """
        radius = np.hypot(position[..., 0], position[..., 1])
        found: Array = np.maximum(radius - self.bore, 0.0) - np.maximum(self.rod - radius, 0.0)
        return found

    def least_gap(self, position: Array) -> float:
        """Smallest gap (m) between the wire and a wall; negative where it is pressed."""
        radius = np.hypot(position[..., 0], position[..., 1])
        return float(np.min(np.minimum(self.bore - radius, radius - self.rod)))

    def forces(self, position: Array, length: Array) -> Array:
        """Force (..., nv, 3) in N of the walls on the wire; ``length`` (nv,) of wire (m) per
        vertex.
        """
        push = -self.stiffness * length * self.depth(position)
        radius = np.hypot(position[..., 0], position[..., 1])
        return np.stack(
            [push * position[..., 0] / radius, push * position[..., 1] / radius, 0.0 * push],
            axis=-1,
        )

    def pressed(self, position: Array, length: Array) -> Array:
        """Sum (...,) of the normal forces (N)."""
        found: Array = self.stiffness * np.abs(self.depth(position)) @ length
        return found

    def energy(self, position: Array, length: Array) -> Array:
        """Energy (...,) stored in the walls (J)."""
        found: Array = 0.5 * self.stiffness * self.depth(position) ** 2 @ length
        return found


def walls(
    wire_diameter: Array, bore: float | None, rod: float | None, stiffness: float
) -> GuideWalls:
    """Walls of a bore and a rod of these diameters (m; None: there is none) for a wire of
    ``wire_diameter`` (nv,).
    """
    nothing = np.zeros_like(wire_diameter)
    return GuideWalls(
        nothing + NO_BORE if bore is None else (bore - wire_diameter) / 2,
        nothing + NO_ROD if rod is None else (rod + wire_diameter) / 2,
        stiffness,
    )
