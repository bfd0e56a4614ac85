"""Plain NumPy twins of rod/step_kernels.py on the same flat buffer: whole-array algebra, square
roots and divisions as written in books.
"""

from __future__ import annotations

import numpy as np

from twins.rod_energy import conjugate, product, rotation_matrix
from valvetrain.cosserat.layout import row


def rows(b, names, count):
    """Copies of rows as columns (count, len(names))."""
    return np.stack([row(b, name, count) for name in names.split()], axis=1)


def put(b, names, where, values):
    """Write columns ``values`` (n, k) into rows ``names`` at indices ``where``."""
    for name, column in zip(names.split(), values.T, strict=True):
        row(b, name, where[-1] + 1)[where] = column


def section_forces(b, first, last):
    """Force R n in space and torque -n x u (per length) in the body frame."""
    e, count = np.arange(first, last), last + 1
    x, q = rows(b, "X Y Z", count), rows(b, "Q0 Q1 Q2 Q3", count)[e]
    R = rotation_matrix(q)
    u = np.einsum("eji,ej->ei", R, x[e] - x[e - 1]) * row(b, "INVH", count)[e, None]
    n = rows(b, "GA GA EA", count)[e] * (u - rows(b, "U1 U2 U3", count)[e])
    put(b, "FX FY FZ", e, np.einsum("eij,ej->ei", R, n))
    put(b, "T1 T2 T3", e, -np.cross(n, u))


def bending_torques(b, first, last, decay, gain_old, gain_new, viscous):
    """Torques on the two edges of each vertex, and the low pass of the strain (standard linear
    solid).
    """
    i, count = np.arange(first, last), last + 1
    q = rows(b, "Q0 Q1 Q2 Q3", count + 1)
    relative = product(conjugate(q[i]), q[i + 1])
    s, p = relative[:, :1], relative[:, 1:]
    stiffness, strain = rows(b, "K1 K2 K3", count)[i], 2 * p - rows(b, "R1 R2 R3", count)[i]
    low = rows(b, "L1 L2 L3", count)[i] + gain_new * strain
    put(b, "L1 L2 L3", i, decay * low + gain_old * strain)
    moment = stiffness * (strain + viscous * (strain - low))
    put(b, "A1 A2 A3", i, s * moment - np.cross(moment, p))
    put(b, "B1 B2 B3", i, -s * moment - np.cross(moment, p))
    return float(np.sum(stiffness * (strain - low) ** 2))


def turn_edges(b, first, last, dt, keep, kick):
    """Euler's equations of a disc-like section (J, J, 2 J), then q <- q (1, dt w / 2), normalised
    by one Newton step.
    """
    e, count = np.arange(first, last), last + 1
    w, torque = (
        rows(b, "W1 W2 W3", count)[e],
        rows(b, "T1 T2 T3", count)[e] / row(b, "INVH", count)[e, None],
    )
    torque = torque + rows(b, "B1 B2 B3", count)[e - 1] + rows(b, "A1 A2 A3", count)[e]
    turning = rows(b, "IJ1 IJ1 IJ3", count)[e] * torque
    inertia = np.array([1.0, 1.0, 2.0])
    turning -= np.cross(w, inertia * w) / inertia
    w = keep * w + kick * turning
    put(b, "W1 W2 W3", e, w)
    q = rows(b, "Q0 Q1 Q2 Q3", count)[e]
    q = product(q, np.concatenate([np.ones((len(e), 1)), 0.5 * dt * w], axis=1))
    put(b, "Q0 Q1 Q2 Q3", e, q * (1.5 - 0.5 * np.sum(q**2, axis=1)[:, None]))


def move_vertices(b, first, last, dt, keep, kick):
    """Newton's law of the vertices; returns sum of mass times (old + new velocity) squared."""
    i, count = np.arange(first, last), last + 1
    old, force = rows(b, "VX VY VZ", count)[i], rows(b, "FX FY FZ", count + 1)
    new = keep * old + kick * row(b, "IM", count)[i, None] * (
        force[i + 1] - force[i] + rows(b, "CX CY CZ", count)[i]
    )
    put(b, "VX VY VZ", i, new)
    put(b, "X Y Z", i, rows(b, "X Y Z", count)[i] + dt * new)
    return float(row(b, "MASS", count)[i] @ np.sum((new + old) ** 2, axis=1))


def copy_lower_wire(b, first, last, offset):
    """Rows of the wire one turn below."""
    j = np.arange(first, last)
    put(b, "XL YL ZL VXL VYL VZL", j, rows(b, "X Y Z VX VY VZ", last)[j - offset])


def weights(place):
    """Weights (n, 3) of a quadratic B-spline span."""
    t = np.atleast_1d(place)
    return np.stack([0.5 * (0.5 - t) ** 2, 0.75 - t**2, 0.5 * (0.5 + t) ** 2], axis=-1)


def contact_forces(b, first, last, t, s, damping_time, dt, law=0, numbers=0, suffix=""):
    """Kelvin-Voigt force along the separation at the foot, never adhesive; one Newton step with the
    stored 1/slope^2.
    """
    j, count = np.arange(first, last), last + 1
    around = j[:, None] + np.arange(-1, 2)
    names = "D0 DH KC IS LOSS IMPULSE PEAK".split()
    inverse, half, stiffness, slope_inverse, loss, impulse, peak = (
        row(b, n + suffix, count)[j] for n in names
    )
    low = rows(b, "XL YL ZL", count)[around]
    gap = np.einsum("k,nkc->nc", weights(t)[0], rows(b, "X Y Z", count)[around]) - np.einsum(
        "k,nkc->nc", weights(s)[0], low
    )
    curve = low[:, 0] - 2 * low[:, 1] + low[:, 2]
    slope = (low[:, 2] - low[:, 0]) / 2 + s * curve
    foot = np.sum(gap * slope, axis=1) * slope_inverse
    gap = gap - foot[:, None] * slope - 0.5 * foot[:, None] ** 2 * curve
    below = weights(s + foot)
    dist = np.linalg.norm(gap, axis=1)
    overlap, normal = 2 * half - dist, gap / dist[:, None]
    velocity = np.einsum("k,nkc->nc", weights(t)[0], rows(b, "VX VY VZ", count)[around])
    velocity = velocity - np.einsum("nk,nkc->nc", below, rows(b, "VXL VYL VZL", count)[around])
    closing = -np.sum(normal * velocity, axis=1)
    touching = dist < 1 / np.sqrt(inverse)
    force = np.where(touching, np.maximum(stiffness * (overlap + damping_time * closing), 0.0), 0.0)
    pressed = np.maximum(stiffness * (overlap + damping_time * closing), 0.0)
    put(
        b,
        f"LOSS{suffix}",
        j,
        (loss + dt * np.where(touching, (pressed - stiffness * overlap) * closing, 0.0))[:, None],
    )
    put(b, " ".join(n + suffix for n in ("PX", "PY", "PZ")), j, force[:, None] * normal)
    put(b, " ".join(n + suffix for n in ("S0", "S1", "S2")), j, below)
    put(b, f"IMPULSE{suffix}", j, (impulse + dt * force)[:, None])
    put(b, f"PEAK{suffix}", j, np.maximum(peak, force)[:, None])
    put(b, f"STORED{suffix}", j, np.where(touching, 0.5 * stiffness * overlap**2, 0.0)[:, None])


def spread_contact(b, first, last, t, suffix=""):
    """Point forces to the vertices of the upper wire (rows C) and of the lower wire (rows G, upper
    index).
    """
    i, count = np.arange(first, last), last + 1
    up, down = np.zeros((count + 1, 3)), np.zeros((count + 1, 3))
    force = rows(b, " ".join(n + suffix for n in ("PX", "PY", "PZ")), count)
    below = rows(b, " ".join(n + suffix for n in ("S0", "S1", "S2")), count)
    for j in range(first - 1, last + 1):
        for k in range(3):
            up[j - 1 + k] += weights(t)[0, k] * force[j]
            down[j - 1 + k] += below[j, k] * force[j]
    put(b, "CX CY CZ", i, rows(b, "CX CY CZ", count)[i] + up[i])
    put(b, "GX GY GZ", i, rows(b, "GX GY GZ", count)[i] + down[i])


def return_contact(b, first, last, offset):
    """Reaction on the lower wire."""
    i = np.arange(first, last)
    put(
        b,
        "CX CY CZ",
        i - offset,
        rows(b, "CX CY CZ", last)[i - offset] - rows(b, "GX GY GZ", last)[i],
    )


def seat_contact(b, first, last, displacement, law=0, numbers=0):
    """Axial unilateral seats; returns the forces on lower and upper seat."""
    i = np.arange(first, last)
    z, seat = row(b, "Z", last)[i], row(b, "SEAT", last)[i]
    below = seat * np.maximum(row(b, "LOWER", last)[i] - z, 0.0)
    above = seat * np.maximum(z - row(b, "UPPER", last)[i] + displacement, 0.0)
    row(b, "CZ", last)[i] += below - above
    return float(below.sum()), float(above.sum())
