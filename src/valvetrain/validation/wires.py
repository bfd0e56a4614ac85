"""Wires of the book's benchmarks: straight lines, arcs and helices of a given section, ready for
``mesh_curve``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.mesh import RodMesh, WireCurve, mesh_curve
from valvetrain.cosserat.section import Section
from valvetrain.cosserat.state import RodState

Array = NDArray[np.float64]


def section(
    shear: float,
    tension: float,
    bending: float,
    torsion: float,
    mass: float = 1.0,
    inertia: float = 1e-6,
) -> Section:
    """One section of given stiffnesses (N, N m2) and mass (kg/m, kg m)."""
    return Section(
        *(
            np.array([value])
            for value in (shear, tension, bending, torsion, mass, inertia, 2 * inertia)
        )
    )


def tube(bending: float, torsion: float, length: float) -> Section:
    """A section so stiff in stretch and shear that the wire of ``length`` (m) keeps its length to
    1e-8.
    """
    stiff = 1e8 * bending / length**2
    return section(stiff, stiff, bending, torsion)


@dataclass(frozen=True)
class Helix:
    """Helix of ``radius`` (m) and ``lead_angle`` (rad), the parameter is the arc length (m); radius
    0 gives a line along x.
    """

    radius: float
    lead_angle: float
    wire: Section

    def _turned(self, parameter: Array) -> Array:
        return (
            parameter * np.cos(self.lead_angle) / self.radius
            if self.radius
            else np.zeros_like(parameter)
        )

    def position(self, parameter: Array) -> Array:
        """Wire axis (n, 3)."""
        turned, rise = self._turned(parameter), np.sin(self.lead_angle) * parameter
        if not self.radius:
            return np.stack([parameter, 0 * parameter, 0 * parameter], axis=-1)
        return np.stack([self.radius * np.cos(turned), self.radius * np.sin(turned), rise], axis=-1)

    def directors(self, parameter: Array) -> tuple[Array, Array, Array]:
        """Outward normal, binormal and tangent (n, 3) each."""
        turned, a = self._turned(parameter), self.lead_angle
        zero, one = np.zeros_like(parameter), np.ones_like(parameter)
        if not self.radius:
            return (
                np.stack([zero, one, zero], -1),
                np.stack([zero, zero, one], -1),
                np.stack([one, zero, zero], -1),
            )
        outward = np.stack([np.cos(turned), np.sin(turned), zero], -1)
        tangent = np.stack(
            [-np.cos(a) * np.sin(turned), np.cos(a) * np.cos(turned), np.sin(a) * one], -1
        )
        return outward, np.cross(tangent, outward), tangent

    def line_speed(self, parameter: Array) -> Array:
        """Arc length per unit of the parameter: one."""
        return np.ones_like(parameter)

    def section(self, parameter: Array, curvature_correction: bool) -> tuple[Section, Array]:
        """The same section everywhere; the wire diameter matters to contact alone."""
        values = (
            np.full_like(parameter, getattr(self.wire, name)[0]) for name in self.wire.__slots__
        )
        return Section(*values), np.full_like(parameter, 1e-3)


def mesh_wire(curve: WireCurve, length: float, elements: int) -> RodMesh:
    """Mesh a wire of ``length`` (m) with even elements."""
    return mesh_curve(curve, np.linspace(0.0, length, elements + 1), 0, elements)


def state_on(curve: WireCurve, mesh: RodMesh, compression: float = 0.0) -> RodState:
    """The state of ``mesh`` bent onto another curve of the same arc length."""
    arc = mesh.coil_number
    middle = np.concatenate((arc[:1], (arc[1:] + arc[:-1]) / 2, arc[-1:]))
    return RodState(curve.position(arc), quat.from_directors(*curve.directors(middle)), compression)
