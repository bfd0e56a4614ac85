"""A close-coiled spring as a round bar bent to a ring, solved on its section: rate and stress that
owe nothing to any factor.

Goehner's problem (Timoshenko and Goodier, Theory of Elasticity, article 140): under axial load each
section turns and slides along the
coil's axis alike, tau_z = G R^2 phi_r / r^2 and tau_r = -G R^2 phi_z / r^2 with phi = 0 on the edge
of the section and
phi_rr - 3 phi_r / r + phi_zz = -2 c. Solved here by Ritz's method with polynomials that vanish on
the edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def ring_section(spring_index: float, degree: int = 12) -> tuple[float, float, float]:
    """Rate over G d^4 / (8 D^3 n), shear stress at the inner and at the outer fibre over 8 F D /
    (pi d^3), of a bar of this D / d.

    In lengths of the bar's radius, G = 1, c = 1: the centre line has the radius w = D / d, and one
    turn rises by 2 pi.
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
