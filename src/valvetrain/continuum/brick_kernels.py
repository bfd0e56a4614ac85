"""Internal forces of eight-node bricks along a swept wire, in loops over neighbouring spans that
vectorise.

Energy of a brick: V/2 E:C:E of the mean deformation gradient F (E = (F^T F - 1)/2) plus 1/2 q.K q of
the twelve hourglass amplitudes q = F^T (gamma x) in material axes. Both are unchanged by rotation,
so nothing is decomposed and no Gauss point is visited; K holds what the mean gradient leaves out of
the incompatible-mode stiffness of the undeformed brick (:mod:`valvetrain.continuum.bricks`).

Layout: component k of section node n at station s is ``x[(3 n + k) * stride + s]``. The bricks of one
section quadrilateral are next to each other along the wire and are taken in blocks of at most
:data:`LANES`; entry t of a row of a block is ``constants[block + row * LANES + t]``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.compiled import njit

#: Largest number of spans per block and stride of its rows: the scratch of a block stays in the
#: first cache.
LANES = 32
#: Rows of the constants of a block: mean gradients of the shape functions (8 x 3), coordinates of
#: the hourglass modes (4 x 3), hourglass stiffness (12 x 12), volume.
GRADIENT, MODE, STIFFNESS, VOLUME, CONSTANT_ROWS = 0, 24, 36, 180, 181
#: Generalised strains of a brick: Green's strain xx yy zz xy yz xz (twice the shear), hourglass
#: amplitudes.
STRAINS = 18

_L = np.uint64(LANES)
_GRADIENT, _MODE, _STIFFNESS, _VOLUME = (
    np.uint64(row * LANES) for row in (GRADIENT, MODE, STIFFNESS, VOLUME)
)
_CONSTANTS, _BRANCH = np.uint64(CONSTANT_ROWS * LANES), np.uint64(STRAINS * LANES)
#: Rows of the scratch of a block: F, hourglass vectors, strains, hourglass forces, stress times F.
_F, _G, _E, _M, _P = (np.uint64(row * LANES) for row in (0, 9, 21, 39, 51))
_Q = np.uint64((21 + 6) * LANES)
SCRATCH = 60 * LANES
#: Places of rows 1, 2, ... of a block, and (below, in words) plain counts: signed or computed offsets would be checked and
#: stop vectorisation.
_1, _2, _3, _4, _5, _6, _7, _8, _9, _10, _11 = (np.uint64(n * LANES) for n in range(1, 12))
_12, _21 = np.uint64(12 * LANES), np.uint64(21 * LANES)
_15, _18 = np.uint64(15 * LANES), np.uint64(18 * LANES)
_ZERO, _ONE, _TWO, _THREE, _FOUR, _EIGHT = (np.uint64(n) for n in (0, 1, 2, 3, 4, 8))
_TWELVE, _ALL = np.uint64(12), np.uint64(STRAINS)

#: All of fast maths but the promise that no value is NaN: a diverged run must be seen.
FAST = {"contract", "reassoc", "nsz", "arcp"}
OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "_nrt": False,
    "fastmath": FAST,
}
#: Signs of the hourglass modes eta zeta, xi zeta, xi eta, xi eta zeta on the eight corners.
SIGNS = np.array(
    [
        [1, 1, -1, -1, -1, -1, 1, 1],
        [1, -1, -1, 1, -1, 1, 1, -1],
        [1, -1, 1, -1, 1, -1, 1, -1],
        [-1, 1, -1, 1, 1, -1, 1, -1],
    ],
    dtype=float,
)  # fmt: skip


@njit(**OPTIONS)
def block_strains(x, constants, work, corners, stride, quad, block, first, width):
    """Deformation gradient, hourglass vectors and the 18 strains of a block into its scratch.

    ``x``: positions (m), ``constants``, ``work``: scratch of :data:`SCRATCH` numbers, all flat and as the module lays them
    out; ``corners`` (quads, 8): places in ``x`` of the corners of each quadrilateral, without station. Unsigned integers
    (uint64): ``stride`` of a component, ``quad``, ``block``: place of its constants, ``first`` station, ``width``: spans.
    """
    for axis in range(_THREE):
        shift = axis * stride + first
        p0, p1 = corners[quad, 0] + shift, corners[quad, 1] + shift
        p2, p3 = corners[quad, 2] + shift, corners[quad, 3] + shift
        p4, p5 = corners[quad, 4] + shift, corners[quad, 5] + shift
        p6, p7 = corners[quad, 6] + shift, corners[quad, 7] + shift
        b, c = block + _GRADIENT, block + _MODE
        row, vector = _F + axis * _3, _G + axis * _L
        for t in range(width):
            x0, x1, x2, x3 = x[p0 + t], x[p1 + t], x[p2 + t], x[p3 + t]
            x4, x5, x6, x7 = x[p4 + t], x[p5 + t], x[p6 + t], x[p7 + t]
            k = b + t
            f0 = x0 * constants[k] + x1 * constants[k + _3]
            f1 = x0 * constants[k + _1] + x1 * constants[k + _3 + _1]
            f2 = x0 * constants[k + _2] + x1 * constants[k + _3 + _2]
            f0 += x2 * constants[k + _6] + x3 * constants[k + _9]
            f1 += x2 * constants[k + _6 + _1] + x3 * constants[k + _9 + _1]
            f2 += x2 * constants[k + _6 + _2] + x3 * constants[k + _9 + _2]
            f0 += x4 * constants[k + _12] + x5 * constants[k + _15]
            f1 += x4 * constants[k + _12 + _1] + x5 * constants[k + _15 + _1]
            f2 += x4 * constants[k + _12 + _2] + x5 * constants[k + _15 + _2]
            f0 += x6 * constants[k + _18] + x7 * constants[k + _21]
            f1 += x6 * constants[k + _18 + _1] + x7 * constants[k + _21 + _1]
            f2 += x6 * constants[k + _18 + _2] + x7 * constants[k + _21 + _2]
            work[row + t], work[row + _1 + t], work[row + _2 + t] = f0, f1, f2
            s0, s1, s2, s3 = x0 + x1, x2 + x3, x4 + x5, x6 + x7
            d0, d1, d2, d3 = x1 - x0, x2 - x3, x5 - x4, x6 - x7
            m = c + t
            g0 = (s0 - s1) - (s2 - s3)
            g1 = (d2 + d3) - (d0 + d1)
            g2 = (d1 - d0) + (d3 - d2)
            g3 = (d3 - d2) - (d1 - d0)
            g0 -= f0 * constants[m] + f1 * constants[m + _1] + f2 * constants[m + _2]
            g1 -= f0 * constants[m + _3] + f1 * constants[m + _4] + f2 * constants[m + _5]
            g2 -= f0 * constants[m + _6] + f1 * constants[m + _7] + f2 * constants[m + _8]
            g3 -= f0 * constants[m + _9] + f1 * constants[m + _10] + f2 * constants[m + _11]
            work[vector + t], work[vector + _3 + t] = 0.125 * g0, 0.125 * g1
            work[vector + _6 + t], work[vector + _9 + t] = 0.125 * g2, 0.125 * g3
    for mode in range(_FOUR):
        g, q = _G + mode * _3, _Q + mode * _3
        for t in range(width):
            g0, g1, g2 = work[g + t], work[g + _1 + t], work[g + _2 + t]
            work[q + t] = work[_F + t] * g0 + work[_F + _3 + t] * g1 + work[_F + _6 + t] * g2
            work[q + _1 + t] = (
                work[_F + _1 + t] * g0 + work[_F + _4 + t] * g1 + work[_F + _7 + t] * g2
            )
            work[q + _2 + t] = (
                work[_F + _2 + t] * g0 + work[_F + _5 + t] * g1 + work[_F + _8 + t] * g2
            )
    for t in range(width):
        f00, f01, f02 = work[_F + t], work[_F + _1 + t], work[_F + _2 + t]
        f10, f11, f12 = work[_F + _3 + t], work[_F + _4 + t], work[_F + _5 + t]
        f20, f21, f22 = work[_F + _6 + t], work[_F + _7 + t], work[_F + _8 + t]
        work[_E + t] = 0.5 * (f00 * f00 + f10 * f10 + f20 * f20 - 1.0)
        work[_E + _1 + t] = 0.5 * (f01 * f01 + f11 * f11 + f21 * f21 - 1.0)
        work[_E + _2 + t] = 0.5 * (f02 * f02 + f12 * f12 + f22 * f22 - 1.0)
        work[_E + _3 + t] = f00 * f01 + f10 * f11 + f20 * f21
        work[_E + _4 + t] = f01 * f02 + f11 * f12 + f21 * f22
        work[_E + _5 + t] = f00 * f02 + f10 * f12 + f20 * f22


@njit(**OPTIONS)
def relax_strains(branch, work, start, width, stiffness, decay, gain_new, gain_old):
    """Add the overstrain of the Maxwell branch and carry its state over the step.

    State y holds decay z + gain_new e of the step before, so z = y + gain_old e is the branch strain
    now: exact for a strain that changes evenly over the step.
    """
    for strain in range(_ALL):
        e, y = _E + strain * _L, start + strain * _L
        for t in range(width):
            now = work[e + t]
            lagging = branch[y + t] + gain_old * now
            branch[y + t] = decay * lagging + gain_new * now
            work[e + t] = now + stiffness * (now - lagging)


@njit(**OPTIONS)
def hourglass_forces(constants, work, block, width):
    """Forces m = K q on the hourglass amplitudes of a block."""
    for i in range(_TWELVE):
        k, m = block + _STIFFNESS + i * _12, _M + i * _L
        for t in range(width):
            j = k + t
            total = constants[j] * work[_Q + t] + constants[j + _1] * work[_Q + _1 + t]
            total += constants[j + _2] * work[_Q + _2 + t] + constants[j + _3] * work[_Q + _3 + t]
            total += constants[j + _4] * work[_Q + _4 + t] + constants[j + _5] * work[_Q + _5 + t]
            total += constants[j + _6] * work[_Q + _6 + t] + constants[j + _7] * work[_Q + _7 + t]
            total += constants[j + _8] * work[_Q + _8 + t] + constants[j + _9] * work[_Q + _9 + t]
            total += (
                constants[j + _10] * work[_Q + _10 + t] + constants[j + _11] * work[_Q + _11 + t]
            )
            work[m + t] = total


@njit(**OPTIONS)
def block_stresses(constants, work, block, width, lame, shear):
    """V F S of the mean strain, with what the hourglass forces do through F, into rows P; the
    hourglass vectors are replaced by F m / 8."""
    volume = block + _VOLUME
    for t in range(width):
        v = constants[volume + t]
        e0, e1, e2 = work[_E + t], work[_E + _1 + t], work[_E + _2 + t]
        bulk, twice = v * lame * (e0 + e1 + e2), 2.0 * v * shear
        s0, s1, s2 = bulk + twice * e0, bulk + twice * e1, bulk + twice * e2
        s3, s4, s5 = (
            v * shear * work[_E + _3 + t],
            v * shear * work[_E + _4 + t],
            v * shear * work[_E + _5 + t],
        )
        f0, f1, f2 = work[_F + t], work[_F + _1 + t], work[_F + _2 + t]
        work[_P + t] = f0 * s0 + f1 * s3 + f2 * s5
        work[_P + _1 + t] = f0 * s3 + f1 * s1 + f2 * s4
        work[_P + _2 + t] = f0 * s5 + f1 * s4 + f2 * s2
        f0, f1, f2 = work[_F + _3 + t], work[_F + _4 + t], work[_F + _5 + t]
        work[_P + _3 + t] = f0 * s0 + f1 * s3 + f2 * s5
        work[_P + _4 + t] = f0 * s3 + f1 * s1 + f2 * s4
        work[_P + _5 + t] = f0 * s5 + f1 * s4 + f2 * s2
        f0, f1, f2 = work[_F + _6 + t], work[_F + _7 + t], work[_F + _8 + t]
        work[_P + _6 + t] = f0 * s0 + f1 * s3 + f2 * s5
        work[_P + _7 + t] = f0 * s3 + f1 * s1 + f2 * s4
        work[_P + _8 + t] = f0 * s5 + f1 * s4 + f2 * s2
    for mode in range(_FOUR):
        m, g, c = _M + mode * _3, _G + mode * _3, block + _MODE + mode * _3
        for axis in range(_THREE):
            row, p = _F + axis * _3, _P + axis * _3
            own = g + axis * _L
            for t in range(width):
                m0, m1, m2 = work[m + t], work[m + _1 + t], work[m + _2 + t]
                n = 0.125 * (work[row + t] * m0 + work[row + _1 + t] * m1 + work[row + _2 + t] * m2)
                vector = work[own + t]
                work[p + t] += vector * m0 - n * constants[c + t]
                work[p + _1 + t] += vector * m1 - n * constants[c + _1 + t]
                work[p + _2 + t] += vector * m2 - n * constants[c + _2 + t]
                work[own + t] = n


@njit(**OPTIONS)
def scatter_forces(f, constants, work, corners, signs, stride, quad, block, first, width):
    """Take the internal forces of a block off the forces of its corners."""
    for corner in range(_EIGHT):
        h0, h1 = signs[0, corner], signs[1, corner]
        h2, h3 = signs[2, corner], signs[3, corner]
        b = block + _GRADIENT + corner * _3
        for axis in range(_THREE):
            node = corners[quad, corner] + axis * stride + first
            p, g = _P + axis * _3, _G + axis * _L
            for t in range(width):
                push = work[p + t] * constants[b + t]
                push += work[p + _1 + t] * constants[b + _1 + t]
                push += work[p + _2 + t] * constants[b + _2 + t]
                push += h0 * work[g + t] + h1 * work[g + _3 + t]
                push += h2 * work[g + _6 + t] + h3 * work[g + _9 + t]
                f[node + t] -= push


@njit(**OPTIONS)
def brick_forces(x, f, constants, branch, work, corners, signs, shape, material, damper):
    """Take the internal forces of all bricks off ``f``.

    ``shape``: stride, quadrilaterals, spans, spans per block; ``material``: Lame's constants (Pa);
    ``damper``: stiffness of the Maxwell branch over that of the material (0: none), its decay over a
    step and the two gains.
    """
    stride, quads, spans, most = shape[0], shape[1], shape[2], shape[3]
    block = _ZERO
    state = _ZERO
    for quad in range(quads):
        first = _ZERO
        while first < spans:
            width = min(most, spans - first)
            block_strains(x, constants, work, corners, stride, quad, block, first, width)
            if damper[0] > 0.0:
                relax_strains(
                    branch, work, state, width, damper[0], damper[1], damper[2], damper[3]
                )
            hourglass_forces(constants, work, block, width)
            block_stresses(constants, work, block, width, material[0], material[1])
            scatter_forces(f, constants, work, corners, signs, stride, quad, block, first, width)
            first += most
            block += _CONSTANTS
            state += _BRANCH


@njit(**OPTIONS)
def brick_energies(x, constants, branch, work, corners, shape, material, damper, found):
    """Fill ``found``: elastic energy (J), its hourglass part, energy of the Maxwell branch, and what
    the branch turns to heat, as power times its relaxation time.

    The branch is read after :func:`brick_forces` of the same positions.
    """
    stride, quads, spans, most = shape[0], shape[1], shape[2], shape[3]
    found[:] = 0.0
    block = _ZERO
    state = _ZERO
    for quad in range(quads):
        first = _ZERO
        while first < spans:
            width = min(most, spans - first)
            block_strains(x, constants, work, corners, stride, quad, block, first, width)
            mean, hour = _block_energy(constants, work, block, width, material[0], material[1])
            found[0] += mean + hour
            found[1] += hour
            if damper[0] > 0.0:
                for strain in range(_ALL):
                    e, y = _E + strain * _L, state + strain * _L
                    for t in range(width):
                        now = work[e + t]
                        work[e + t] = now - (branch[y + t] - damper[2] * now) / damper[1]
                mean, hour = _block_energy(constants, work, block, width, material[0], material[1])
                found[2] += damper[0] * (mean + hour)
                found[3] += 2.0 * damper[0] * (mean + hour)
            first += most
            block += _CONSTANTS
            state += _BRANCH


@njit(**OPTIONS)
def _block_energy(constants, work, block, width, lame, shear):
    """Energy of the mean strains and of the hourglass amplitudes in the scratch of a block."""
    hourglass_forces(constants, work, block, width)
    mean, hour = 0.0, 0.0
    for t in range(width):
        e0, e1, e2 = work[_E + t], work[_E + _1 + t], work[_E + _2 + t]
        e3, e4, e5 = work[_E + _3 + t], work[_E + _4 + t], work[_E + _5 + t]
        total = e0 + e1 + e2
        squares = e0 * e0 + e1 * e1 + e2 * e2 + 0.5 * (e3 * e3 + e4 * e4 + e5 * e5)
        volume = constants[block + _VOLUME + t]
        mean += volume * (0.5 * lame * total * total + shear * squares)
    for i in range(_TWELVE):
        q, m = _Q + i * _L, _M + i * _L
        for t in range(width):
            hour += 0.5 * work[q + t] * work[m + t]
    return mean, hour


@njit(**OPTIONS)
def settle_branch(x, constants, branch, work, corners, shape, damper):
    """Put the Maxwell branch at rest at positions ``x``."""
    stride, quads, spans, most = shape[0], shape[1], shape[2], shape[3]
    block = _ZERO
    state = _ZERO
    for quad in range(quads):
        first = _ZERO
        while first < spans:
            width = min(most, spans - first)
            block_strains(x, constants, work, corners, stride, quad, block, first, width)
            for strain in range(_ALL):
                e, y = _E + strain * _L, state + strain * _L
                for t in range(width):
                    branch[y + t] = (damper[1] + damper[2]) * work[e + t]
            first += most
            block += _CONSTANTS
            state += _BRANCH
