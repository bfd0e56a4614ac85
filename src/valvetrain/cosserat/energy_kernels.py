"""Compiled energy, residual and tangent of the rod for statics and modes.

Unknowns per vertex slot i: [x_i (3), rotation of edge i + 1 (3, body frame)], so that the band is
narrow.
Stretch strain u = R^T (x_{i+1} - x_i) / h; bending strain 2 vec(conj(q_i) q_{i+1}); both linear
elastic.
"""

from __future__ import annotations

import numpy as np

from valvetrain.coil_contact.kernels import contact_energy, contact_response, contact_tangent
from valvetrain.compiled import njit

#: Half bandwidth of the tangent without contact: vertex, edge, vertex, edge couple over 9 unknowns
#: each way.
HALF_BAND = 11


@njit(cache=True)
def rotation_matrix(q, R):
    """Fill R (3, 3) with the matrix of the unit quaternion q (4,)."""
    a, b, c, d = q[0], q[1], q[2], q[3]
    R[0, 0] = 1 - 2 * (c * c + d * d)
    R[1, 1] = 1 - 2 * (b * b + d * d)
    R[2, 2] = 1 - 2 * (b * b + c * c)
    R[0, 1], R[1, 0] = 2 * (b * c - a * d), 2 * (b * c + a * d)
    R[0, 2], R[2, 0] = 2 * (b * d + a * c), 2 * (b * d - a * c)
    R[1, 2], R[2, 1] = 2 * (c * d - a * b), 2 * (c * d + a * b)


@njit(cache=True)
def _skew(v, S):
    S[0, 0] = S[1, 1] = S[2, 2] = 0.0
    S[0, 1], S[0, 2], S[1, 2] = -v[2], v[1], -v[0]
    S[1, 0], S[2, 0], S[2, 1] = v[2], -v[1], v[0]


@njit(cache=True)
def _add_block(band, row0, col0, block):
    """Add a 3 x 3 block to the banded matrix in LAPACK general-band storage (row = HALF_BAND + i -
    j).
    """
    for i in range(3):
        for j in range(3):
            r, c = row0 + i, col0 + j
            band[HALF_BAND + r - c, c] += block[i, j]


@njit(cache=True)
def _add_transposed(band, row0, col0, block):
    for i in range(3):
        for j in range(3):
            r, c = row0 + j, col0 + i
            band[HALF_BAND + r - c, c] += block[i, j]


@njit(cache=True)
def stretch_terms(first, last, x, q, edge_length, stiffness, rest, residual, band, with_tangent):
    """Add the stretch energy's gradient (and Hessian) over edges first + 1 .. last; returns the
    energy (J).
    """
    R, S, U = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    u, n, m = np.empty(3), np.empty(3), np.empty(3)
    energy = 0.0
    for e in range(first + 1, last + 1):
        h = edge_length[e]
        rotation_matrix(q[e], R)
        for k in range(3):
            u[k] = (
                sum_column(
                    R, k, x[e, 0] - x[e - 1, 0], x[e, 1] - x[e - 1, 1], x[e, 2] - x[e - 1, 2]
                )
                / h
            )
            strain = u[k] - rest[e, k]
            n[k] = stiffness[e, k] * strain
            energy += 0.5 * h * n[k] * strain
        lower, edge, upper = 6 * (e - 1), 6 * (e - 1) + 3, 6 * e
        m[0], m[1], m[2] = (
            n[1] * u[2] - n[2] * u[1],
            n[2] * u[0] - n[0] * u[2],
            n[0] * u[1] - n[1] * u[0],
        )
        for i in range(3):
            f = R[i, 0] * n[0] + R[i, 1] * n[1] + R[i, 2] * n[2]
            residual[lower + i] -= f
            residual[upper + i] += f
            residual[edge + i] += h * m[i]
        if not with_tangent:
            continue
        # B = C [u] - [n] maps a body rotation to the change of R^T f; K_xx = R C R^T / h.
        _skew(u, U)
        _skew(n, S)
        product = n[0] * u[0] + n[1] * u[1] + n[2] * u[2]
        kxx, kxr, krr = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    kxx[i, j] += R[i, k] * stiffness[e, k] * R[j, k] / h
                    kxr[i, j] += R[i, k] * (stiffness[e, k] * U[k, j] - S[k, j])
                    krr[i, j] += h * U[k, i] * stiffness[e, k] * U[k, j]
                krr[i, j] += h * 0.5 * (n[i] * u[j] + u[i] * n[j])
            krr[i, i] -= h * product
        _add_block(band, lower, lower, kxx)
        _add_block(band, upper, upper, kxx)
        _add_block(band, lower, upper, -kxx)
        _add_block(band, upper, lower, -kxx)
        _add_block(band, upper, edge, kxr)
        _add_transposed(band, edge, upper, kxr)
        _add_block(band, lower, edge, -kxr)
        _add_transposed(band, edge, lower, -kxr)
        _add_block(band, edge, edge, krr)
    return energy


@njit(cache=True)
def sum_column(R, k, a, b, c):
    """Component k of R^T (a, b, c)."""
    return R[0, k] * a + R[1, k] * b + R[2, k] * c


@njit(cache=True)
def bend_terms(first, last, q, stiffness, rest, residual, band, with_tangent):
    """Add the bending and torsion energy's gradient (and Hessian) over vertices first .. last;
    returns the energy.
    """
    p, M = np.empty(3), np.empty(3)
    La, Lb, P, T = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    energy = 0.0
    for i in range(first, last + 1):
        a, b = q[i], q[i + 1]
        s = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
        p[0] = a[0] * b[1] - b[0] * a[1] - (a[2] * b[3] - a[3] * b[2])
        p[1] = a[0] * b[2] - b[0] * a[2] - (a[3] * b[1] - a[1] * b[3])
        p[2] = a[0] * b[3] - b[0] * a[3] - (a[1] * b[2] - a[2] * b[1])
        for k in range(3):
            strain = 2 * p[k] - rest[i, k]
            M[k] = stiffness[i, k] * strain
            energy += 0.5 * M[k] * strain
        before, after = 6 * (i - 1) + 3, 6 * i + 3
        cross = (M[1] * p[2] - M[2] * p[1], M[2] * p[0] - M[0] * p[2], M[0] * p[1] - M[1] * p[0])
        for k in range(3):
            if before >= 0:
                residual[before + k] += cross[k] - s * M[k]
            residual[after + k] += cross[k] + s * M[k]
        if not with_tangent:
            continue
        _skew(p, P)
        _skew(M, T)
        work = M[0] * p[0] + M[1] * p[1] + M[2] * p[2]
        for r in range(3):
            for c in range(3):
                La[r, c] = P[r, c] - (s if r == c else 0.0)
                Lb[r, c] = P[r, c] + (s if r == c else 0.0)
        kaa, kbb, kab = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
        for r in range(3):
            for c in range(3):
                for k in range(3):
                    kaa[r, c] += La[k, r] * stiffness[i, k] * La[k, c]
                    kbb[r, c] += Lb[k, r] * stiffness[i, k] * Lb[k, c]
                    kab[r, c] += La[k, r] * stiffness[i, k] * Lb[k, c]
                kab[r, c] += 0.5 * (p[r] * M[c] + M[r] * p[c] + s * T[r, c])
            kaa[r, r] -= 0.5 * work
            kbb[r, r] -= 0.5 * work
            kab[r, r] -= 0.5 * work
        _add_block(band, after, after, kbb)
        if before >= 0:
            _add_block(band, before, before, kaa)
            _add_block(band, before, after, kab)
            _add_transposed(band, after, before, kab)
    return energy


@njit(cache=True)
def contact_terms(
    x,
    offset,
    upper_place,
    lower_place,
    distance,
    length,
    stiffness,
    law,
    numbers,
    residual,
    rows,
    columns,
    values,
):
    """Add coil-contact forces to ``residual``; fill triplets of the contact tangent; returns
    (energy, triplets used).

    Each active point couples 6 vertices: up to 324 entries. ``law`` and ``numbers``: of the contact
    (``coil_contact.kernels``), whose overlap is d0 - distance.
    """
    energy, used, parameters = 0.0, 0, numbers.ctypes.data
    weight, vertex = np.empty(6), np.empty(6, np.int64)
    gap, slope = np.empty(3), np.empty(3)
    for g in range(length.shape[0]):
        t0 = upper_place[g]
        for i in range(1, length.shape[1] - 1):
            if length[g, i] <= 0.0:
                continue
            j = i - offset
            weight[0], weight[1], weight[2] = (
                0.5 * (0.5 - t0) ** 2,
                0.75 - t0 * t0,
                0.5 * (0.5 + t0) ** 2,
            )
            square, foot = _foot(x, i, j, t0, lower_place[g], gap, slope)
            overlap = distance[g, i] - np.sqrt(square)
            if overlap <= 0.0:
                continue
            weight[3], weight[4], weight[5] = (
                -0.5 * (0.5 - foot) ** 2,
                -0.75 + foot * foot,
                -0.5 * (0.5 + foot) ** 2,
            )
            for k in range(3):
                vertex[k], vertex[k + 3] = i - 1 + k, j - 1 + k
            k_line = stiffness * length[g, i]
            dist = np.sqrt(square)
            _, force = contact_response(law, parameters, k_line, 0.0, overlap, 0.0)
            energy += contact_energy(law, parameters, k_line, 0.0, overlap)
            norm = np.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2)
            for a in range(6):
                for r in range(3):
                    residual[6 * vertex[a] + r] -= force * weight[a] * gap[r] / dist
            if rows.size == 0:
                continue
            k_line = contact_tangent(law, parameters, k_line, 0.0, overlap)
            for a in range(6):
                for b in range(6):
                    for r in range(3):
                        for c in range(3):
                            nn = gap[r] * gap[c] / square
                            cc = slope[r] * slope[c] / (norm * norm)
                            block = k_line * nn - force / dist * (
                                (1.0 if r == c else 0.0) - nn - cc
                            )
                            rows[used], columns[used] = 6 * vertex[a] + r, 6 * vertex[b] + c
                            values[used] = weight[a] * weight[b] * block
                            used += 1
    return energy, used


@njit(cache=True)
def _foot(x, i, j, t0, s0, gap, slope):
    """Separation vector and slope at the foot of the perpendicular; returns (distance squared, foot
    place).
    """
    b0, b1, b2 = 0.5 * (0.5 - t0) ** 2, 0.75 - t0 * t0, 0.5 * (0.5 + t0) ** 2
    c0, c1, c2 = 0.5 * (0.5 - s0) ** 2, 0.75 - s0 * s0, 0.5 * (0.5 + s0) ** 2
    along, length2 = 0.0, 0.0
    for k in range(3):
        gap[k] = (
            b0 * x[i - 1, k]
            + b1 * x[i, k]
            + b2 * x[i + 1, k]
            - c0 * x[j - 1, k]
            - c1 * x[j, k]
            - c2 * x[j + 1, k]
        )
        slope[k] = (s0 - 0.5) * x[j - 1, k] - 2 * s0 * x[j, k] + (s0 + 0.5) * x[j + 1, k]
        along += gap[k] * slope[k]
        length2 += slope[k] * slope[k]
    shift = along / length2
    square = 0.0
    for k in range(3):
        curve = x[j - 1, k] - 2 * x[j, k] + x[j + 1, k]
        gap[k] -= shift * slope[k] + 0.5 * shift * shift * curve
        slope[k] += shift * curve
        square += gap[k] * gap[k]
    return square, s0 + shift


@njit(cache=True)
def contact_state(x, offset, upper_place, lower_place, distance, length, gaps):
    """Fill ``gaps`` (groups, nv) with distance less contact distance; infinite where there is no
    partner.
    """
    gap, slope = np.empty(3), np.empty(3)
    for g in range(length.shape[0]):
        for i in range(length.shape[1]):
            gaps[g, i] = np.inf
            if length[g, i] > 0.0:
                square, _ = _foot(x, i, i - offset, upper_place[g], lower_place[g], gap, slope)
                gaps[g, i] = np.sqrt(square) - distance[g, i]


@njit(cache=True)
def seat_terms(
    x, lower_limit, upper_limit, length, stiffness, law, numbers, residual, band, with_tangent
):
    """Add wire-to-seat contact (axial, unilateral) on the vertices; returns the energy."""
    energy, row = 0.0, numbers.ctypes.data
    for i in range(x.shape[0]):
        depth = lower_limit[i] - x[i, 2]
        sign = -1.0
        if depth <= 0.0:
            depth, sign = x[i, 2] - upper_limit[i], 1.0
        if depth > 0.0:
            k = stiffness * length[i]
            _, force = contact_response(law, row, k, 0.0, depth, 0.0)
            energy += contact_energy(law, row, k, 0.0, depth)
            residual[6 * i + 2] += sign * force
            if with_tangent:
                band[HALF_BAND, 6 * i + 2] += contact_tangent(law, row, k, 0.0, depth)
    return energy


@njit(cache=True)
def guide_terms(first, last, x, bore, rod, length, stiffness, residual, band, with_tangent):
    """Add the walls' push on vertices first + 1 .. last - 1; returns the energy (J). Energy 1/2 k
    length depth^2, depth radial.
    """
    energy = 0.0
    for i in range(first + 1, last):
        radius = np.sqrt(x[i, 0] ** 2 + x[i, 1] ** 2)
        depth = radius - bore[i] if radius > bore[i] else radius - rod[i]
        if radius <= bore[i] and radius >= rod[i]:
            continue
        k = stiffness * length[i]
        energy += 0.5 * k * depth * depth
        for r in range(2):
            residual[6 * i + r] += k * depth * x[i, r] / radius
        if not with_tangent:
            continue
        for r in range(2):
            for c in range(2):
                across = x[i, r] * x[i, c] / (radius * radius)
                around = (1.0 if r == c else 0.0) - across
                band[HALF_BAND + r - c, 6 * i + c] += k * (across + depth / radius * around)
    return energy
