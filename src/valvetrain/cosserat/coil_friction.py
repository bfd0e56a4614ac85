"""Coulomb friction where coils touch: against the sliding of the two surfaces, the spin of the wires
counted, with its couple on both wires. Coils that stick creep.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.compiled import njit
from valvetrain.cosserat.layout import GROUP as _GROUP
from valvetrain.cosserat.layout import ROW

X, Y, Z, VX, VY, VZ = (ROW[n] for n in ("X", "Y", "Z", "VX", "VY", "VZ"))
Q0, Q1, Q2, Q3, W1, W2, W3 = (ROW[n] for n in ("Q0", "Q1", "Q2", "Q3", "W1", "W2", "W3"))
CX, CY, CZ, T1, T2, T3 = (ROW[n] for n in ("CX", "CY", "CZ", "T1", "T2", "T3"))
PX, PY, PZ, S0, S1, S2, LOSS = (ROW[n] for n in ("PX", "PY", "PZ", "S0", "S1", "S2", "LOSS"))
IM, IJ1, IJ3, INVH = (ROW[n] for n in ("IM", "IJ1", "IJ3", "INVH"))
GROUP, ONE = _GROUP, np.uint64(1)
OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}

#: Sliding velocity (m/s) below which touching surfaces creep, and the largest share of it that the force
#: of one point may take away in a step: a larger one would turn the sliding round.
CREEP, TAKEN = 0.01, 0.5


@njit(forceinline=True, **OPTIONS)
def spin_of(b, e):
    """Angular velocity of edge e in space (rad/s)."""
    q0, q1, q2, q3 = b[Q0 + e], b[Q1 + e], b[Q2 + e], b[Q3 + e]
    w1, w2, w3 = b[W1 + e], b[W2 + e], b[W3 + e]
    x, y, z = q2 * w3 - q3 * w2, q3 * w1 - q1 * w3, q1 * w2 - q2 * w1
    return (
        w1 + 2.0 * (q0 * x + q2 * z - q3 * y),
        w2 + 2.0 * (q0 * y + q3 * x - q1 * z),
        w3 + 2.0 * (q0 * z + q1 * y - q2 * x),
    )


@njit(forceinline=True, **OPTIONS)
def turn_by(b, e, share, x, y, z):
    """Add ``share`` of a torque in space (N m) to those of edge e, which are stored in its frame over its
    length.
    """
    q0, q1, q2, q3 = b[Q0 + e], -b[Q1 + e], -b[Q2 + e], -b[Q3 + e]
    u, v, w = q2 * z - q3 * y, q3 * x - q1 * z, q1 * y - q2 * x
    share *= b[INVH + e]
    b[T1 + e] += share * (x + 2.0 * (q0 * u + q2 * w - q3 * v))
    b[T2 + e] += share * (y + 2.0 * (q0 * v + q3 * u - q1 * w))
    b[T3 + e] += share * (z + 2.0 * (q0 * w + q1 * v - q2 * u))


@njit(**OPTIONS)
def rub_coils(b, coefficient, dt, offset, groups, places, stretches, count):
    """Friction of the watched contact points by their forces of this step: on the vertices (rows C), the
    edges (rows T, after the section forces) and in the losses.
    """
    for n in range(count):
        for g in range(groups):
            shift, t = GROUP * np.uint64(g), places[g, 0]
            upper = (0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t))
            for i in range(stretches[n, 0], stretches[n, 1]):
                j = np.uint64(i)
                nx, ny, nz = b[PX + shift + j], b[PY + shift + j], b[PZ + shift + j]
                normal = np.sqrt(nx * nx + ny * ny + nz * nz)
                if normal == 0.0:
                    continue
                nx, ny, nz = nx / normal, ny / normal, nz / normal
                k = j - offset
                lower = (b[S0 + shift + j], b[S1 + shift + j], b[S2 + shift + j])
                s = lower[2] - lower[0]
                # from lower to upper wire, half of it the arm of the force about either axis
                hx, hy, hz, vx, vy, vz, give = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                for m in range(3):
                    a, c = j - ONE + np.uint64(m), k - ONE + np.uint64(m)
                    hx += 0.5 * (upper[m] * b[X + a] - lower[m] * b[X + c])
                    hy += 0.5 * (upper[m] * b[Y + a] - lower[m] * b[Y + c])
                    hz += 0.5 * (upper[m] * b[Z + a] - lower[m] * b[Z + c])
                    vx += upper[m] * b[VX + a] - lower[m] * b[VX + c]
                    vy += upper[m] * b[VY + a] - lower[m] * b[VY + c]
                    vz += upper[m] * b[VZ + a] - lower[m] * b[VZ + c]
                    give += upper[m] ** 2 * b[IM + a] + lower[m] ** 2 * b[IM + c]
                edges = (j, j + ONE, k, k + ONE)
                shares = (0.5 - t, 0.5 + t, 0.5 - s, 0.5 + s)
                arm = hx * hx + hy * hy + hz * hz
                for m in range(4):
                    wx, wy, wz = spin_of(b, edges[m])
                    vx -= shares[m] * (wy * hz - wz * hy)
                    vy -= shares[m] * (wz * hx - wx * hz)
                    vz -= shares[m] * (wx * hy - wy * hx)
                    give += arm * shares[m] ** 2 * max(b[IJ1 + edges[m]], b[IJ3 + edges[m]])
                along = vx * nx + vy * ny + vz * nz
                vx, vy, vz = vx - along * nx, vy - along * ny, vz - along * nz
                square = vx * vx + vy * vy + vz * vz
                drag = min(
                    coefficient * normal / np.sqrt(square + CREEP * CREEP),
                    TAKEN / (dt * give + 1e-300),
                )
                fx, fy, fz = -drag * vx, -drag * vy, -drag * vz
                # with the velocity in the middle of the step, which the force has slowed down
                b[LOSS + shift + j] += dt * drag * square * (1.0 - 0.5 * dt * drag * give)
                for m in range(3):
                    a, c = j - ONE + np.uint64(m), k - ONE + np.uint64(m)
                    b[CX + a] += upper[m] * fx
                    b[CY + a] += upper[m] * fy
                    b[CZ + a] += upper[m] * fz
                    b[CX + c] -= lower[m] * fx
                    b[CY + c] -= lower[m] * fy
                    b[CZ + c] -= lower[m] * fz
                mx, my, mz = hz * fy - hy * fz, hx * fz - hz * fx, hy * fx - hx * fy
                for m in range(4):
                    turn_by(b, edges[m], shares[m], mx, my, mz)
