"""Contact of coil with coil on the spline of section centres, and of the wire with seat planes.

The contact line is the quadratic B-spline with the section centres as control points. A contact point
is at a fixed place of it; its foot one turn below slides along the spline and is followed by one
Newton step per time step. Law and constants are those of the rod (:mod:`valvetrain.coil_contact`).
Component k of centre i is ``centre[k * stations + i]``.
"""

from __future__ import annotations

import math

import numpy as np

from valvetrain.coil_contact.kernels import contact_energy, contact_response
from valvetrain.compiled import njit
from valvetrain.continuum.brick_kernels import OPTIONS

#: What :func:`coil_forces` and :func:`plane_forces` add up: energy stored (J), power lost (W).
STORED, LOST, TOTALS = 0, 1, 2


@njit(inline="always")
def _weights(place):
    """Weights of the three control points of a span at ``place`` in [-1/2, 1/2]."""
    return 0.5 * (0.5 - place) * (0.5 - place), 0.75 - place * place, 0.5 * (0.5 + place) ** 2


@njit(inline="always")
def _span(foot, stations):
    """Span of a place along the wire (in stations) and the place within it."""
    span = min(max(math.floor(foot + 0.5), 1), stations - 2)
    return span, foot - span


@njit(**OPTIONS)
def step_foot(centre, stations, station, place, foot):
    """One Newton step of the foot of a contact point, and the distance vector from the new foot."""
    a, b, c = _weights(place)
    span, there = _span(foot, stations)
    d, e, f = _weights(there)
    slope_0, slope_1, slope_2 = there - 0.5, -2.0 * there, there + 0.5
    along, curvature = 0.0, 0.0
    for axis in range(3):
        i, j = axis * stations + station, axis * stations + span
        point = a * centre[i - 1] + b * centre[i] + c * centre[i + 1]
        below = d * centre[j - 1] + e * centre[j] + f * centre[j + 1]
        slope = slope_0 * centre[j - 1] + slope_1 * centre[j] + slope_2 * centre[j + 1]
        bend = centre[j - 1] - 2.0 * centre[j] + centre[j + 1]
        along += (point - below) * slope
        curvature += slope * slope - (point - below) * bend
    # half a station next to either end the spline continues as its last parabola: a foot held at its
    # end would push askew there, where the clamped coil carries most of a clash
    foot = min(max(foot + along / curvature, 0.0), stations - 1.0)
    span, there = _span(foot, stations)
    d, e, f = _weights(there)
    x, y, z = 0.0, 0.0, 0.0
    for axis in range(3):
        i, j = axis * stations + station, axis * stations + span
        apart = a * centre[i - 1] + b * centre[i] + c * centre[i + 1]
        apart -= d * centre[j - 1] + e * centre[j] + f * centre[j + 1]
        if axis == 0:
            x = apart
        elif axis == 1:
            y = apart
        else:
            z = apart
    return foot, x, y, z


@njit(**OPTIONS)
def follow_feet(centre, stations, points, margin, sweeps):
    """Newton steps for the feet of all contact points, their distances, and which points are nearer
    than ``margin`` (m) to touching.
    """
    for k in range(len(points.station)):
        x, y, z = 0.0, 0.0, 0.0
        for _ in range(sweeps):
            points.foot[k], x, y, z = step_foot(
                centre, stations, points.station[k], points.place[k], points.foot[k]
            )
        points.apart[k] = math.sqrt(x * x + y * y + z * z)
        points.near[k] = points.apart[k] < points.distance[k] + margin


@njit(**OPTIONS)
def coil_forces(centre, rate, push, stations, points, law, row, damping_time, totals):
    """Add the forces of near contact points to those on the centres; force (N) and stored energy (J)
    of each pair of coils into ``points.pressed``.
    """
    points.pressed[:] = 0.0
    for k in range(len(points.station)):
        if not points.near[k]:
            continue
        station, place = points.station[k], points.place[k]
        foot, x, y, z = step_foot(centre, stations, station, place, points.foot[k])
        points.foot[k] = foot
        apart = math.sqrt(x * x + y * y + z * z)
        overlap = points.distance[k] - apart
        drag = points.drag[0, k]
        if overlap <= 0.0:
            totals[LOST] += 0.5 * drag * points.drag[1, k]
            points.drag[0, k], points.held[0, k] = 0.0, 0.0
            continue
        a, b, c = _weights(place)
        span, there = _span(foot, stations)
        d, e, f = _weights(there)
        closing = 0.0
        for axis in range(3):
            i, j = axis * stations + station, axis * stations + span
            normal = (x if axis == 0 else y if axis == 1 else z) / apart
            moved = a * rate[i - 1] + b * rate[i] + c * rate[i + 1]
            moved -= d * rate[j - 1] + e * rate[j] + f * rate[j + 1]
            closing -= normal * moved
        stiffness = points.stiffness[k]
        force, elastic = contact_response(law, row, stiffness, damping_time, overlap, closing)
        energy = contact_energy(law, row, stiffness, damping_time, overlap)
        totals[STORED] += energy
        # the damping force of a step works at the mean of the speeds before and after it
        totals[LOST] += 0.5 * (drag + force - elastic) * closing
        points.drag[0, k], points.drag[1, k] = force - elastic, closing
        points.held[0, k], points.peak[k] = force, max(points.peak[k], force)
        points.pressed[0, points.pair[k]] += force
        points.pressed[1, points.pair[k]] += energy
        for axis in range(3):
            i, j = axis * stations + station, axis * stations + span
            part = force * (x if axis == 0 else y if axis == 1 else z) / apart
            push[i - 1] += a * part
            push[i] += b * part
            push[i + 1] += c * part
            push[j - 1] -= d * part
            push[j] -= e * part
            push[j + 1] -= f * part


@njit(**OPTIONS)
def plane_forces(centre, push, stations, planes, travel, law, row, totals):
    """Push the wire out of the seat plane and of the retainer plane, which has come down by
    ``travel`` (m); returns the force (N) on either.
    """
    lower, upper = 0.0, 0.0
    axial = 2 * stations
    for k in range(len(planes.station)):
        i = axial + planes.station[k]
        below = planes.side[k] > 0.0
        limit = planes.height[k] if below else planes.height[k] - travel
        depth = planes.side[k] * (limit - centre[i])
        if depth <= 0.0:
            planes.held[0, k] = 0.0
            continue
        _, force = contact_response(law, row, planes.stiffness[k], 0.0, depth, 0.0)
        totals[STORED] += contact_energy(law, row, planes.stiffness[k], 0.0, depth)
        planes.held[0, k], planes.peak[k] = force, max(planes.peak[k], force)
        push[i] += planes.side[k] * force
        if below:
            lower += force
        else:
            upper += force
    return lower, upper


@njit(**OPTIONS)
def section_centres(x, weights, stations, centre):
    """Centres (3 x stations) of sections as weighted means of their nodes."""
    centre[:] = 0.0
    for node in range(len(weights)):
        weight, base = weights[node], np.uint64(3 * node * stations)
        for i in range(np.uint64(3 * stations)):
            centre[i] += weight * x[base + i]


@njit(**OPTIONS)
def spread_push(push, weights, stations, force):
    """Spread forces on the centres over the nodes of their sections, so that a centre does the work."""
    for node in range(len(weights)):
        weight, base = weights[node], np.uint64(3 * node * stations)
        for i in range(np.uint64(3 * stations)):
            force[base + i] += weight * push[i]
