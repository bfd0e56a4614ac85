"""Plain NumPy twins of rod/energy_kernels.py: energies written down from the definitions, gradients
by NumPy algebra.
"""

from __future__ import annotations

import numpy as np


def rotation_matrix(q):
    """Matrices (..., 3, 3) of unit quaternions (..., 4), from v + 2 w x (w x v) + 2 s w x v."""
    s, w = q[..., 0], q[..., 1:]
    cross = np.zeros((*q.shape[:-1], 3, 3))
    cross[..., 0, 1], cross[..., 0, 2], cross[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    cross -= np.swapaxes(cross, -1, -2)
    return np.eye(3) + 2 * s[..., None, None] * cross + 2 * cross @ cross


def product(a, b):
    """Quaternion products (..., 4)."""
    scalar = a[..., 0] * b[..., 0] - np.sum(a[..., 1:] * b[..., 1:], axis=-1)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar[..., None], vector], axis=-1)


def conjugate(a):
    """Conjugate quaternions."""
    return a * np.array([1.0, -1.0, -1.0, -1.0])


def stretch(first, last, x, q, edge_length, stiffness, rest):
    """Energy (J), gradient (nv, 6) of the stretch of edges first + 1 .. last."""
    e = np.arange(first + 1, last + 1)
    R, h = rotation_matrix(q[e]), edge_length[e]
    u = np.einsum("eji,ej->ei", R, x[e] - x[e - 1]) / h[:, None]
    n = stiffness[e] * (u - rest[e])
    out = np.zeros((len(x), 6))
    force = np.einsum("eij,ej->ei", R, n)
    np.add.at(out[:, :3], e, force)
    np.add.at(out[:, :3], e - 1, -force)
    np.add.at(out[:, 3:], e - 1, h[:, None] * np.cross(n, u))
    return 0.5 * np.sum(h[:, None] * n * (u - rest[e])), out


def bend(first, last, q, stiffness, rest):
    """Energy (J), gradient (nv, 6) of bending and torsion at vertices first .. last."""
    i = np.arange(first, last + 1)
    relative = product(conjugate(q[i]), q[i + 1])
    s, p = relative[:, :1], relative[:, 1:]
    moment = stiffness[i] * (2 * p - rest[i])
    out = np.zeros((len(rest), 6))
    np.add.at(out[:, 3:], i, np.cross(moment, p) + s * moment)
    before = i >= 1
    np.add.at(out[:, 3:], i[before] - 1, (np.cross(moment, p) - s * moment)[before])
    return 0.5 * np.sum(moment * (2 * p - rest[i])), out


def spline(x, place):
    """Points of the quadratic B-spline of vertices (nv, 3) at global place (nv units, vertex i at
    i), with the place's weights.
    """
    base = np.clip(np.round(place).astype(int), 1, len(x) - 2)
    t = (place - base)[:, None]
    weights = np.concatenate([0.5 * (0.5 - t) ** 2, 0.75 - t**2, 0.5 * (0.5 + t) ** 2], axis=1)
    return np.einsum("nk,nkc->nc", weights, x[base[:, None] + np.arange(-1, 2)])


def span(x, i, t):
    """Point, slope and second derivative of span ``i`` at place ``t``."""
    w = np.array([0.5 * (0.5 - t) ** 2, 0.75 - t**2, 0.5 * (0.5 + t) ** 2])
    d = np.array([t - 0.5, -2 * t, t + 0.5])
    near = x[i - 1 : i + 2]
    return w @ near, d @ near, near[0] - 2 * near[1] + near[2], w


def contact(x, offset, upper_place, lower_place, distance, length, stiffness):
    """Energy, gradient (nv, 6) and gaps (groups, nv): one Newton step for the foot, penalty along
    the separation.
    """
    out, gaps, energy = np.zeros((len(x), 6)), np.full(length.shape, np.inf), 0.0
    for g, i in zip(*np.nonzero(length > 0), strict=True):
        upper, _, _, above = span(x, i, upper_place[g])
        base, slope, curve, _ = span(x, i - offset, lower_place[g])
        shift = (upper - base) @ slope / (slope @ slope)
        gap = upper - base - shift * slope - 0.5 * shift**2 * curve
        gaps[g, i] = np.linalg.norm(gap) - distance[g, i]
        if gaps[g, i] >= 0:
            continue
        below = span(x, i - offset, lower_place[g] + shift)[3]
        force = -stiffness * length[g, i] * gaps[g, i] * gap / np.linalg.norm(gap)
        energy += 0.5 * stiffness * length[g, i] * gaps[g, i] ** 2
        out[i - 1 : i + 2, :3] -= above[:, None] * force
        out[i - offset - 1 : i - offset + 2, :3] += below[:, None] * force
    return energy, out, gaps
