"""Coulomb friction where a solid wire touches: coil on coil and free wire on its seats.

A contact sticks on a spring of :data:`GRIP` times its normal stiffness and slides where that would
carry more than the coefficient times the normal force; heat is what the spring gives up. Surfaces move
with their section's centre and its spin, and friction acts on the section with its couple.
"""

from __future__ import annotations

import math

from valvetrain.compiled import njit
from valvetrain.continuum.brick_kernels import OPTIONS
from valvetrain.continuum.contact_kernels import LOST, STORED, _span, _weights

#: Stiffness of sticking over that of pressing. A force on the rim moves its section five times as
#: easily as one through the centre: with a fifth, the stable step is that of the normal contact.
GRIP = 0.2


@njit(**OPTIONS)
def section_spins(x, v, weights, stations, centre, rate, inverse, spin):
    """Angular velocities (3 x stations) of sections as bodies with the mass shares ``weights``, and the
    ``inverse`` of their moments of inertia for unit mass (xx, yy, zz, xy, yz, zx; 6 x stations).
    """
    for s in range(stations):
        xx, yy, zz, xy, yz, zx, lx, ly, lz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for node in range(len(weights)):
            w, i = weights[node], 3 * node * stations + s
            a, b, c = i, i + stations, i + 2 * stations
            rx, ry, rz = (
                x[a] - centre[s],
                x[b] - centre[stations + s],
                x[c] - centre[2 * stations + s],
            )
            u, p, q = v[a] - rate[s], v[b] - rate[stations + s], v[c] - rate[2 * stations + s]
            xx += w * (ry * ry + rz * rz)
            yy += w * (rz * rz + rx * rx)
            zz += w * (rx * rx + ry * ry)
            xy -= w * rx * ry
            yz -= w * ry * rz
            zx -= w * rz * rx
            lx += w * (ry * q - rz * p)
            ly += w * (rz * u - rx * q)
            lz += w * (rx * p - ry * u)
        a, b, c = yy * zz - yz * yz, zz * xx - zx * zx, xx * yy - xy * xy
        d, e, f = yz * zx - xy * zz, zx * xy - yz * xx, xy * yz - zx * yy
        share = 1.0 / (xx * a + xy * d + zx * f)
        a, b, c, d, e, f = share * a, share * b, share * c, share * d, share * e, share * f
        for row, value in enumerate((a, b, c, d, e, f)):
            inverse[row * stations + s] = value
        spin[s] = a * lx + d * ly + f * lz
        spin[stations + s] = d * lx + b * ly + e * lz
        spin[2 * stations + s] = f * lx + e * ly + c * lz


@njit(**OPTIONS)
def _share(square, limit):
    """Share of a force, given by its square, that a limit leaves."""
    return 1.0 if square <= limit * limit else limit / math.sqrt(square)


@njit(**OPTIONS)
def rub_coils(centre, rate, spin, push, couple, stations, points, coefficient, step, totals):
    """Add friction between coils to the forces and couples on the sections, by the normal forces that
    ``points.held`` has of this step.
    """
    held = points.held
    for k in range(len(points.station)):
        if held[0, k] <= 0.0 and held[1, k] == 0.0 and held[2, k] == 0.0 and held[3, k] == 0.0:
            continue
        upper = _weights(points.place[k])
        span, there = _span(points.foot[k], stations)
        lower = _weights(there)
        hx, hy, hz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for m in range(3):
            i, j = points.station[k] - 1 + m, span - 1 + m
            a, b = upper[m], lower[m]
            # from lower to upper wire, half of it the arm of the force about either axis
            hx += 0.5 * (a * centre[i] - b * centre[j])
            vx += a * rate[i] - b * rate[j]
            wx += a * spin[i] + b * spin[j]
            i, j = i + stations, j + stations
            hy += 0.5 * (a * centre[i] - b * centre[j])
            vy += a * rate[i] - b * rate[j]
            wy += a * spin[i] + b * spin[j]
            i, j = i + stations, j + stations
            hz += 0.5 * (a * centre[i] - b * centre[j])
            vz += a * rate[i] - b * rate[j]
            wz += a * spin[i] + b * spin[j]
        vx, vy, vz = vx - (wy * hz - wz * hy), vy - (wz * hx - wx * hz), vz - (wx * hy - wy * hx)
        grip, square = GRIP * points.stiffness[k], hx * hx + hy * hy + hz * hz
        fx = held[1, k] - grip * step * vx
        fy = held[2, k] - grip * step * vy
        fz = held[3, k] - grip * step * vz
        along = (fx * hx + fy * hy + fz * hz) / square
        fx, fy, fz = fx - along * hx, fy - along * hy, fz - along * hz
        share = _share(fx * fx + fy * fy + fz * fz, coefficient * held[0, k])
        fx, fy, fz = share * fx, share * fy, share * fz
        # the force of a step works at the mean of the velocities before and after it
        before = held[1, k] ** 2 + held[2, k] ** 2 + held[3, k] ** 2
        after = fx * fx + fy * fy + fz * fz
        power = (held[1, k] + fx) * vx + (held[2, k] + fy) * vy + (held[3, k] + fz) * vz
        totals[LOST] -= 0.5 * power + 0.5 * (after - before) / (grip * step)
        totals[STORED] += 0.5 * after / grip
        held[1, k], held[2, k], held[3, k] = fx, fy, fz
        mx, my, mz = hz * fy - hy * fz, hx * fz - hz * fx, hy * fx - hx * fy
        for m in range(3):
            i, j = points.station[k] - 1 + m, span - 1 + m
            a, b = upper[m], lower[m]
            for force, moment in ((fx, mx), (fy, my), (fz, mz)):
                push[i] += a * force
                push[j] -= b * force
                couple[i] += a * moment
                couple[j] += b * moment
                i, j = i + stations, j + stations


@njit(**OPTIONS)
def rub_planes(rate, spin, push, couple, stations, planes, coefficient, step, totals):
    """As :func:`rub_coils` for the free wire on its seats, which do not move sideways."""
    for k in range(len(planes.station)):
        if planes.held[0, k] <= 0.0 and planes.held[1, k] == 0.0 and planes.held[2, k] == 0.0:
            continue
        i, arm = planes.station[k], planes.side[k] * planes.radius[k]
        j, grip = i + stations, GRIP * planes.stiffness[k]
        gx, gy = planes.held[1, k], planes.held[2, k]
        vx, vy = rate[i] - arm * spin[j], rate[j] + arm * spin[i]
        fx, fy = gx - grip * step * vx, gy - grip * step * vy
        share = _share(fx * fx + fy * fy, coefficient * planes.held[0, k])
        fx, fy = share * fx, share * fy
        after = fx * fx + fy * fy
        totals[LOST] -= 0.5 * ((gx + fx) * vx + (gy + fy) * vy)
        totals[LOST] -= 0.5 * (after - gx * gx - gy * gy) / (grip * step)
        totals[STORED] += 0.5 * after / grip
        planes.held[1, k], planes.held[2, k] = fx, fy
        push[i] += fx
        push[j] += fy
        couple[i] += arm * fy
        couple[j] -= arm * fx


@njit(**OPTIONS)
def spread_couple(x, couple, inverse, weights, stations, centre, force):
    """Spread couples on sections over their nodes, so that the spins do the work."""
    for s in range(stations):
        mx, my, mz = couple[s], couple[stations + s], couple[2 * stations + s]
        if mx == 0.0 and my == 0.0 and mz == 0.0:
            continue
        a, b, c = inverse[s], inverse[stations + s], inverse[2 * stations + s]
        d, e, f = inverse[3 * stations + s], inverse[4 * stations + s], inverse[5 * stations + s]
        tx, ty, tz = a * mx + d * my + f * mz, d * mx + b * my + e * mz, f * mx + e * my + c * mz
        for node in range(len(weights)):
            w, i = weights[node], 3 * node * stations + s
            j, k = i + stations, i + 2 * stations
            rx, ry, rz = (
                x[i] - centre[s],
                x[j] - centre[stations + s],
                x[k] - centre[2 * stations + s],
            )
            force[i] += w * (ty * rz - tz * ry)
            force[j] += w * (tz * rx - tx * rz)
            force[k] += w * (tx * ry - ty * rx)
