"""Reference wires of the book: lines, arcs and helices of a given section for ``mesh_curve``, and a
bar bent to a ring.
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


def ring_section(spring_index: float, degree: int = 12) -> tuple[float, float, float]:
    """A close-coiled spring as a round bar bent to a ring, solved on its section without any
    factor.

    Returns rate over G d^4 / (8 D^3 n), shear stress at the inner and at the outer fibre over 8 F D
    / (pi d^3), of a bar of this D / d. Goehner's problem (Timoshenko and Goodier, Theory of
    Elasticity, article 140): under axial load each section turns and slides along the coil's axis
    alike, tau_z = G R^2 phi_r / r^2 and tau_r = -G R^2 phi_z / r^2 with phi = 0 on the edge of the
    section and phi_rr - 3 phi_r / r + phi_zz = -2 c; here by Ritz's method with polynomials that
    vanish on the edge. In lengths of the bar's radius, G = 1, c = 1: the centre line has the radius
    w = D / d, and one turn rises by 2 pi.
    """
    points, weights = np.polynomial.legendre.leggauss(2 * degree)
    radius, turn = (points + 1) / 2, np.pi * (np.arange(4 * degree) + 0.5) / (2 * degree)
    x, z = radius[:, None] * np.cos(turn), radius[:, None] * np.sin(turn)
    area = (weights / 2 * radius)[:, None] * (np.pi / (2 * degree)) * np.ones_like(x)
    powers = [(i, j) for i in range(degree + 1) for j in range(0, degree + 1 - i, 2)]
    cube = (spring_index + x) ** 3
    first = np.array([_slopes(i, j, x, z) for i, j in powers])
    stiffness = np.einsum("akpq,bkpq,pq->ab", first, first, area / cube)
    shape = np.array([(1 - x**2 - z**2) * x**i * z**j for i, j in powers])
    amounts = np.linalg.solve(stiffness, 2 * np.einsum("apq,pq->a", shape, area / cube))
    # The slopes that vanish on the edge by parts: F = integral of phi_r / r^2 = integral of 2 phi /
    # r^3.
    force = 2 * float(amounts @ np.einsum("apq,pq->a", shape, area / cube))
    plain = 2 * force * spring_index / np.pi
    inner, outer = (
        float(
            amounts @ np.array([_slopes(i, j, np.array(side), np.array(0.0))[0] for i, j in powers])
        )
        / (spring_index + side) ** 2
        for side in (-1.0, 1.0)
    )
    # c = 1 per rad: the plain spring carries G d^4 / (8 D^3) 2 pi over a turn, and 8 F D / (pi d^3)
    # = 2 F w / pi.
    return force / (np.pi / (2 * spring_index**3)), inner / plain, -outer / plain


def _slopes(i: int, j: int, x: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivatives (2, ...) by x and by z of (1 - x^2 - z^2) x^i z^j."""
    edge, xi, zj = 1 - x**2 - z**2, x**i, z**j
    by_x = -2 * x * xi * zj + (edge * i * x ** (i - 1) * zj if i else 0.0)
    by_z = -2 * z * xi * zj + (edge * xi * j * z ** (j - 1) if j else 0.0)
    return np.array([by_x, by_z])
