"""The rod's time step: four fused passes over one flat buffer (see layout), explicit leapfrog.

Order within a step: contact -> section forces -> bending torques -> spin and frames -> velocities
and positions.
Positions live at whole steps, velocities and spins at half steps. All loops are free of branches,
roots and
divisions and vectorise; measured 50 -> 14 ns per element and step against the scalar form of the
same passes, 12 without
reference counts. Kernels come from factories: the distance of neighbours in the buffer (1, or the
number of
variants that are side by side) and the contact group are constants at compile time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from valvetrain.coil_contact.kernels import linear_contact, linear_energy, own_contact, own_energy
from valvetrain.compiled import njit
from valvetrain.cosserat.layout import GROUP as _GROUP
from valvetrain.cosserat.layout import ROW

X, Y, Z, VX, VY, VZ = (ROW[n] for n in ("X", "Y", "Z", "VX", "VY", "VZ"))
Q0, Q1, Q2, Q3, W1, W2, W3 = (ROW[n] for n in ("Q0", "Q1", "Q2", "Q3", "W1", "W2", "W3"))
L1, L2, L3, FX, FY, FZ, T1, T2, T3 = (
    ROW[n] for n in ("L1", "L2", "L3", "FX", "FY", "FZ", "T1", "T2", "T3")
)
A1, A2, A3, B1, B2, B3 = (ROW[n] for n in ("A1", "A2", "A3", "B1", "B2", "B3"))
CX, CY, CZ, XL, YL, ZL = (ROW[n] for n in ("CX", "CY", "CZ", "XL", "YL", "ZL"))
VXL, VYL, VZL, GX, GY, GZ = (ROW[n] for n in ("VXL", "VYL", "VZL", "GX", "GY", "GZ"))
INVH, GA, EA, U1, U2, U3 = (ROW[n] for n in ("INVH", "GA", "EA", "U1", "U2", "U3"))
K1, K2, K3, R1, R2, R3, IM, IJ1, IJ3 = (
    ROW[n] for n in ("K1", "K2", "K3", "R1", "R2", "R3", "IM", "IJ1", "IJ3")
)
D0, DH, KC, IS, PX, PY, PZ = (ROW[n] for n in ("D0", "DH", "KC", "IS", "PX", "PY", "PZ"))
S0, S1, S2, IMPULSE, PEAK, LOSS, STORED, MASS = (
    ROW[n] for n in ("S0", "S1", "S2", "IMPULSE", "PEAK", "LOSS", "STORED", "MASS")
)
LOWER, UPPER, SEAT, BORE, ROD, WALL = (
    ROW[n] for n in ("LOWER", "UPPER", "SEAT", "BORE", "ROD", "WALL")
)
#: Everything of fast maths but the promise that no value is NaN: a diverged run must be seen.
FAST = {"contract", "reassoc", "nsz", "arcp"}
#: Inlined into the loop that is called: a kernel that stays a function has two copies, optimised
#: apart, and which one runs (and so the last
#: bits) depends on whether this process compiled it. No reference counts, whose atomic updates at
#: every call took 20 % of a run.
OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "_nrt": False,
    "fastmath": FAST,
    "forceinline": True,
}


#: Of a kernel with a law of contact of its own: one function for all loops that call it, without
#: fast maths, so that results are bit-identical in each.
OWN_OPTIONS: dict[str, Any] = {
    name: value for name, value in OPTIONS.items() if name not in ("fastmath", "forceinline")
}


def _compiled(
    kernel: Callable[..., Any], *constants: int | np.uint64, options: dict[str, Any] = OPTIONS
) -> Callable[..., Any]:
    # The constants belong to the name: compiled code of equal name from two cached runs would be
    # taken for the same.
    kernel.__qualname__ = "_".join(
        [kernel.__name__, *(str(int(constant)) for constant in constants)]
    )
    found: Callable[..., Any] = njit(**options)(kernel)
    return found


def section_forces_of(one: np.uint64) -> Callable[..., Any]:
    """Kernel: section forces of a wire whose neighbouring entries are ``one`` apart in the
    buffer.
    """

    def section_forces(b, first, last):
        """Section force (space frame) and its torque (body frame) on edges first .. last - 1."""
        for e in range(first, last):
            q0, q1, q2, q3 = b[Q0 + e], b[Q1 + e], b[Q2 + e], b[Q3 + e]
            h = b[INVH + e]
            dx, dy, dz = (
                h * (b[X + e] - b[X - one + e]),
                h * (b[Y + e] - b[Y - one + e]),
                h * (b[Z + e] - b[Z - one + e]),
            )
            a, c, d = q1 + q1, q2 + q2, q3 + q3
            xx, yy, zz = q1 * a, q2 * c, q3 * d
            xy, xz, yz, wx, wy, wz = q1 * c, q1 * d, q2 * d, q0 * a, q0 * c, q0 * d
            r00, r11, r22 = 1.0 - yy - zz, 1.0 - xx - zz, 1.0 - xx - yy
            r01, r10, r02, r20, r12, r21 = xy - wz, xy + wz, xz + wy, xz - wy, yz - wx, yz + wx
            u1 = r00 * dx + r10 * dy + r20 * dz
            u2 = r01 * dx + r11 * dy + r21 * dz
            u3 = r02 * dx + r12 * dy + r22 * dz
            shear = b[GA + e]
            n1, n2, n3 = (
                shear * (u1 - b[U1 + e]),
                shear * (u2 - b[U2 + e]),
                b[EA + e] * (u3 - b[U3 + e]),
            )
            b[FX + e] = r00 * n1 + r01 * n2 + r02 * n3
            b[FY + e] = r10 * n1 + r11 * n2 + r12 * n3
            b[FZ + e] = r20 * n1 + r21 * n2 + r22 * n3
            # Torque -h n x u on the edge; the length comes back as 1 / (1 / h) folded into the
            # inertia rows.
            b[T1 + e], b[T2 + e], b[T3 + e] = (
                n3 * u2 - n2 * u3,
                n1 * u3 - n3 * u1,
                n2 * u1 - n1 * u2,
            )

    return _compiled(section_forces, one)


def bending_torques_of(one: np.uint64, records: int = 1) -> Callable[..., Any]:
    """Kernel: bending torques of a wire whose neighbouring entries are ``one`` apart in the
    buffer.
    """

    def bending_torques(b, first, last, decay, gain_old, gain_new, viscous):
        """Torques of vertices first .. last - 1 on their two edges, with the viscous branch
        (standard linear solid).

        Returns the sum of stiffness times squared branch strain, from which the dissipated power
        follows.
        """
        branch = 0.0
        for i in range(first, last):
            a0, a1, a2, a3 = b[Q0 + i], b[Q1 + i], b[Q2 + i], b[Q3 + i]
            c0, c1, c2, c3 = b[Q0 + one + i], b[Q1 + one + i], b[Q2 + one + i], b[Q3 + one + i]
            s = a0 * c0 + a1 * c1 + a2 * c2 + a3 * c3
            p1 = a0 * c1 - c0 * a1 - a2 * c3 + a3 * c2
            p2 = a0 * c2 - c0 * a2 - a3 * c1 + a1 * c3
            p3 = a0 * c3 - c0 * a3 - a1 * c2 + a2 * c1
            k1, k2, k3 = p1 + p1 - b[R1 + i], p2 + p2 - b[R2 + i], p3 + p3 - b[R3 + i]
            z1, z2, z3 = (
                b[L1 + i] + gain_new * k1,
                b[L2 + i] + gain_new * k2,
                b[L3 + i] + gain_new * k3,
            )
            b[L1 + i], b[L2 + i], b[L3 + i] = (
                decay * z1 + gain_old * k1,
                decay * z2 + gain_old * k2,
                decay * z3 + gain_old * k3,
            )
            z1, z2, z3 = k1 - z1, k2 - z2, k3 - z3
            if records:
                branch += b[K1 + i] * z1 * z1 + b[K2 + i] * z2 * z2 + b[K3 + i] * z3 * z3
            m1, m2, m3 = (
                b[K1 + i] * (k1 + viscous * z1),
                b[K2 + i] * (k2 + viscous * z2),
                b[K3 + i] * (k3 + viscous * z3),
            )
            x1, x2, x3 = m2 * p3 - m3 * p2, m3 * p1 - m1 * p3, m1 * p2 - m2 * p1
            m1, m2, m3 = s * m1, s * m2, s * m3
            b[A1 + i], b[A2 + i], b[A3 + i] = m1 - x1, m2 - x2, m3 - x3
            b[B1 + i], b[B2 + i], b[B3 + i] = -m1 - x1, -m2 - x2, -m3 - x3
        return branch

    return _compiled(bending_torques, one, records)


def turn_edges_of(one: np.uint64) -> Callable[..., Any]:
    """Kernel: turning of the edges of a wire whose neighbouring entries are ``one`` apart in the
    buffer.
    """

    def turn_edges(b, first, last, dt, keep, kick):
        """Spin and frames of edges first .. last - 1: w <- keep w + kick J^-1 torque, q <- q exp(dt
        w / 2).
        """
        half = 0.5 * dt
        for e in range(first, last):
            w1, w2, w3 = b[W1 + e], b[W2 + e], b[W3 + e]
            # The torsional inertia of round wire is twice the bending inertia: the gyroscopic
            # factors are exactly one.
            t1 = b[IJ1 + e] * (b[T1 + e] / b[INVH + e] + b[B1 - one + e] + b[A1 + e]) - w2 * w3
            t2 = b[IJ1 + e] * (b[T2 + e] / b[INVH + e] + b[B2 - one + e] + b[A2 + e]) + w3 * w1
            t3 = b[IJ3 + e] * (b[T3 + e] / b[INVH + e] + b[B3 - one + e] + b[A3 + e])
            w1, w2, w3 = keep * w1 + kick * t1, keep * w2 + kick * t2, keep * w3 + kick * t3
            b[W1 + e], b[W2 + e], b[W3 + e] = w1, w2, w3
            w1, w2, w3 = half * w1, half * w2, half * w3
            q0, q1, q2, q3 = b[Q0 + e], b[Q1 + e], b[Q2 + e], b[Q3 + e]
            r0 = q0 - q1 * w1 - q2 * w2 - q3 * w3
            r1 = q1 + q0 * w1 + q2 * w3 - q3 * w2
            r2 = q2 + q0 * w2 + q3 * w1 - q1 * w3
            r3 = q3 + q0 * w3 + q1 * w2 - q2 * w1
            # One Newton step restores the unit norm without a root.
            unit = 1.5 - 0.5 * (r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
            b[Q0 + e], b[Q1 + e], b[Q2 + e], b[Q3 + e] = unit * r0, unit * r1, unit * r2, unit * r3

    return _compiled(turn_edges, one)


def move_vertices_of(one: np.uint64, records: int = 1) -> Callable[..., Any]:
    """Kernel: motion of the vertices of a wire whose neighbouring entries are ``one`` apart in
    the buffer.
    """

    def move_vertices(b, first, last, dt, keep, kick):
        """Velocities and positions of vertices first .. last - 1; returns the sum of mass times
        (old + new velocity)^2.
        """
        motion = 0.0
        for i in range(first, last):
            m, ox, oy, oz = kick * b[IM + i], b[VX + i], b[VY + i], b[VZ + i]
            vx = keep * ox + m * (b[FX + one + i] - b[FX + i] + b[CX + i])
            vy = keep * oy + m * (b[FY + one + i] - b[FY + i] + b[CY + i])
            vz = keep * oz + m * (b[FZ + one + i] - b[FZ + i] + b[CZ + i])
            if records:
                motion += b[MASS + i] * (
                    (vx + ox) * (vx + ox) + (vy + oy) * (vy + oy) + (vz + oz) * (vz + oz)
                )
            b[VX + i], b[VY + i], b[VZ + i] = vx, vy, vz
            b[X + i] += dt * vx
            b[Y + i] += dt * vy
            b[Z + i] += dt * vz
        return motion

    return _compiled(move_vertices, one, records)


@njit(**OPTIONS)
def copy_lower_wire(b, first, last, offset):
    """Bring the wire one turn below into rows indexed like the upper wire (position and velocity)."""
    for j in range(first, last):
        b[XL + j] = b[X + j - offset]
    for j in range(first, last):
        b[YL + j] = b[Y + j - offset]
    for j in range(first, last):
        b[ZL + j] = b[Z + j - offset]
    for j in range(first, last):
        b[VXL + j] = b[VX + j - offset]
    for j in range(first, last):
        b[VYL + j] = b[VY + j - offset]
    for j in range(first, last):
        b[VZL + j] = b[VZ + j - offset]


def contact_forces_of(
    g: np.uint64, one: np.uint64, records: int = 1, own: bool = False
) -> Callable[..., Any]:
    """Kernel: force of one contact group at points first .. last - 1; span places t above and s
    below; ``own``: by the law at an address, else by the linear one.

    The group is a compile-time shift of the buffer, so that the loop vectorises (18 -> 7 ns per
    point). The overlap d0 - dist is expanded in 1 - dist^2 / d0^2: no root, no division.
    """
    respond, energy = (own_contact, own_energy) if own else (linear_contact, linear_energy)

    def contact_forces(b, first, last, t, s, damping_time, dt, law, row):
        u0, u1, u2 = 0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)
        c0, c1, c2 = 0.5 * (0.5 - s) * (0.5 - s), 0.75 - s * s, 0.5 * (0.5 + s) * (0.5 + s)
        for j in range(first, last):
            xm, xc, xp = b[XL - one + j], b[XL + j], b[XL + one + j]
            ym, yc, yp = b[YL - one + j], b[YL + j], b[YL + one + j]
            zm, zc, zp = b[ZL - one + j], b[ZL + j], b[ZL + one + j]
            dx = (
                u0 * b[X - one + j]
                + u1 * b[X + j]
                + u2 * b[X + one + j]
                - c0 * xm
                - c1 * xc
                - c2 * xp
            )
            dy = (
                u0 * b[Y - one + j]
                + u1 * b[Y + j]
                + u2 * b[Y + one + j]
                - c0 * ym
                - c1 * yc
                - c2 * yp
            )
            dz = (
                u0 * b[Z - one + j]
                + u1 * b[Z + j]
                + u2 * b[Z + one + j]
                - c0 * zm
                - c1 * zc
                - c2 * zp
            )
            bx, by, bz = xm - 2.0 * xc + xp, ym - 2.0 * yc + yp, zm - 2.0 * zc + zp
            sx, sy, sz = (
                0.5 * (xp - xm) + s * bx,
                0.5 * (yp - ym) + s * by,
                0.5 * (zp - zm) + s * bz,
            )
            f = (dx * sx + dy * sy + dz * sz) * b[IS + g + j]
            half = 0.5 * f * f
            dx, dy, dz = dx - f * sx - half * bx, dy - f * sy - half * by, dz - f * sz - half * bz
            p = s + f
            w0, w1, w2 = 0.5 * (0.5 - p) * (0.5 - p), 0.75 - p * p, 0.5 * (0.5 + p) * (0.5 + p)
            inverse = b[D0 + g + j]
            e = 1.0 - (dx * dx + dy * dy + dz * dz) * inverse
            overlap = b[DH + g + j] * e * (1.0 + e * (0.25 + 0.125 * e))
            # Unit normal = separation / d0 * (1 + e/2 + 3/8 e^2); DH = d0 / 2.
            scale = 2.0 * b[DH + g + j] * inverse * (1.0 + e * (0.5 + 0.375 * e))
            nx, ny, nz = scale * dx, scale * dy, scale * dz
            vx = u0 * b[VX - one + j] + u1 * b[VX + j] + u2 * b[VX + one + j]
            vx -= w0 * b[VXL - one + j] + w1 * b[VXL + j] + w2 * b[VXL + one + j]
            vy = u0 * b[VY - one + j] + u1 * b[VY + j] + u2 * b[VY + one + j]
            vy -= w0 * b[VYL - one + j] + w1 * b[VYL + j] + w2 * b[VYL + one + j]
            vz = u0 * b[VZ - one + j] + u1 * b[VZ + j] + u2 * b[VZ + one + j]
            vz -= w0 * b[VZL - one + j] + w1 * b[VZL + j] + w2 * b[VZL + one + j]
            closing = -(nx * vx + ny * vy + nz * vz)
            force, elastic = respond(law, row, b[KC + g + j], damping_time, overlap, closing)
            loss = (force - elastic) * closing
            force = force if e > 0.0 else 0.0
            if records:
                b[LOSS + g + j] += dt * (loss if e > 0.0 else 0.0)
                b[IMPULSE + g + j] += dt * force
                b[PEAK + g + j] = force if force > b[PEAK + g + j] else b[PEAK + g + j]
                b[STORED + g + j] = (
                    energy(law, row, b[KC + g + j], damping_time, overlap) if e > 0.0 else 0.0
                )
            b[PX + g + j], b[PY + g + j], b[PZ + g + j] = force * nx, force * ny, force * nz
            b[S0 + g + j], b[S1 + g + j], b[S2 + g + j] = w0, w1, w2

    if own:
        return _compiled(contact_forces, g, one, records, 1, options=OWN_OPTIONS)
    return _compiled(contact_forces, g, one, records)


def spread_contact_of(g: np.uint64, one: np.uint64) -> Callable[..., Any]:
    """Kernel: gather a group's point forces on the upper wire (rows C) and the lower wire (rows G,
    upper index).
    """

    def spread_contact(b, first, last, t):
        u0, u1, u2 = 0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)
        p, s = PX + g, S0 + g
        for i in range(first, last):
            b[CX + i] += u0 * b[p + one + i] + u1 * b[p + i] + u2 * b[p - one + i]
            b[GX + i] += (
                b[s + one + i] * b[p + one + i]
                + b[S1 + g + i] * b[p + i]
                + b[S2 + g - one + i] * b[p - one + i]
            )
        p = PY + g
        for i in range(first, last):
            b[CY + i] += u0 * b[p + one + i] + u1 * b[p + i] + u2 * b[p - one + i]
            b[GY + i] += (
                b[s + one + i] * b[p + one + i]
                + b[S1 + g + i] * b[p + i]
                + b[S2 + g - one + i] * b[p - one + i]
            )
        p = PZ + g
        for i in range(first, last):
            b[CZ + i] += u0 * b[p + one + i] + u1 * b[p + i] + u2 * b[p - one + i]
            b[GZ + i] += (
                b[s + one + i] * b[p + one + i]
                + b[S1 + g + i] * b[p + i]
                + b[S2 + g - one + i] * b[p - one + i]
            )

    return _compiled(spread_contact, g, one)


_ONE = np.uint64(1)
section_forces, bending_torques = section_forces_of(_ONE), bending_torques_of(_ONE)
turn_edges, move_vertices = turn_edges_of(_ONE), move_vertices_of(_ONE)
contact_forces, contact_forces_second = (
    contact_forces_of(np.uint64(0), _ONE),
    contact_forces_of(_GROUP, _ONE),
)
own_forces, own_forces_second = (
    contact_forces_of(np.uint64(0), _ONE, own=True),
    contact_forces_of(_GROUP, _ONE, own=True),
)
spread_contact, spread_contact_second = (
    spread_contact_of(np.uint64(0), _ONE),
    spread_contact_of(_GROUP, _ONE),
)


@njit(**OPTIONS)
def return_contact(b, first, last, offset):
    """Subtract the force on the lower wire from its own vertices: C(i - offset) -= G(i)."""
    for i in range(first, last):
        b[CX + i - offset] -= b[GX + i]
    for i in range(first, last):
        b[CY + i - offset] -= b[GY + i]
    for i in range(first, last):
        b[CZ + i - offset] -= b[GZ + i]


def seat_contact_of(own: bool) -> Callable[..., Any]:
    """Kernel: push of the seat planes on the wire, by the elastic part of the law of contact."""
    respond = own_contact if own else linear_contact

    def seat_contact(b, first, last, displacement, law, row):
        """Push wire out of the seat planes (axial, unilateral); returns the force on lower and
        upper seat.
        """
        lower, upper = 0.0, 0.0
        for i in range(first, last):
            below, above = b[LOWER + i] - b[Z + i], b[Z + i] - (b[UPPER + i] - displacement)
            below, above = below if below > 0.0 else 0.0, above if above > 0.0 else 0.0
            _, below = respond(law, row, b[SEAT + i], 0.0, below, 0.0)
            _, above = respond(law, row, b[SEAT + i], 0.0, above, 0.0)
            b[CZ + i] += below - above
            lower += below
            upper += above
        return lower, upper

    return _compiled(seat_contact, int(own), options=OWN_OPTIONS if own else OPTIONS)


seat_contact, own_seat_contact = seat_contact_of(False), seat_contact_of(True)


@njit(**OPTIONS)
def guide_contact(b, first, last):
    """Push wire out of the walls of its guide (radial, unilateral, without friction); entries first
    .. last - 1 of any lane.
    """
    for i in range(first, last):
        radius = np.sqrt(b[X + i] * b[X + i] + b[Y + i] * b[Y + i])
        inside, outside = b[ROD + i] - radius, radius - b[BORE + i]
        push = (
            b[WALL + i]
            * ((inside if inside > 0.0 else 0.0) - (outside if outside > 0.0 else 0.0))
            / radius
        )
        b[CX + i] += push * b[X + i]
        b[CY + i] += push * b[Y + i]
