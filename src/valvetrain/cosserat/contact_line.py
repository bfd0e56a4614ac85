"""Coil-to-coil contact geometry: a smooth contact line and the partner of each of its points one
turn below.

The contact line is the quadratic B-spline with the vertices as control points (C1, so no kinks).
The helical
ordering gives the partner: no search. Each contact point belongs to the span of one vertex and is
paired for good with
the span one turn below; one Newton step finds the foot of the perpendicular there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array

#: Contact points per element. Patches of coil on coil are 1-2 mm long: one point per element makes
#: job C drift ten times more.
POINTS_PER_ELEMENT = 2


@dataclass(frozen=True, slots=True)
class ContactLine:
    """Contact points in ``groups`` of one per vertex: rows of shape (groups, nv), SI units.

    ``upper_place`` (groups,) and ``lower_place`` (groups,): span parameter t in [-1/2, 1/2] of the
    point and of its
    partner's first guess; ``offset``: vertices per turn; ``distance``: axis distance at which
    contact begins;
    ``length``: wire length that a point represents (0 where there is no partner).
    """

    offset: int
    upper_place: Array
    lower_place: Array
    distance: Array
    length: Array

    @property
    def groups(self) -> int:
        """Contact points per vertex."""
        return len(self.upper_place)

    @property
    def points(self) -> NDArray[np.bool_]:
        """Mask (groups, nv) of the contact points that have a partner."""
        return self.length > 0


def no_contact(vertices: int) -> ContactLine:
    """A contact line without any partner, for rods whose coils never meet."""
    return ContactLine(1, np.zeros(1), np.zeros(1), np.ones((1, vertices)), np.zeros((1, vertices)))


def span_weights(place: Array | float) -> tuple[Array, Array, Array]:
    """Weights of the three control vertices of a quadratic B-spline span at ``place`` t in [-1/2,
    1/2].
    """
    t = np.asarray(place, dtype=float)
    return 0.5 * (0.5 - t) ** 2, 0.75 - t**2, 0.5 * (0.5 + t) ** 2


def pair_coils(
    coil_number: Array,
    position: Array,
    wire_diameter: Array,
    line_speed: Array,
    total_coils: float,
    axis: Callable[[Array], Array],
) -> ContactLine:
    """Pair every contact point with the wire one turn below; a point represents its cell as far as
    both wires reach.

    Contact begins at the wire diameter, or at the free distance where free coils are already closer
    (closed ends).
    ``axis`` (coil number -> position) is the true wire axis: the free gap is exact, although the
    spline rounds its corners off.
    """
    vertices, step = len(coil_number), coil_number[1] - coil_number[0]
    turn = 1.0 / step
    offset = round(turn)
    places = (np.arange(POINTS_PER_ELEMENT) + 0.5) / POINTS_PER_ELEMENT - 0.5
    partner = offset - turn + places
    # A point at t + (offset - turn) stays in its span or runs at most a quarter over; the parabola
    # continues smoothly.
    index = np.arange(vertices)
    valid = (index - offset >= 1) & (index <= vertices - 2)
    distance, length = np.ones((len(places), vertices)), np.zeros((len(places), vertices))
    for group, (upper, lower) in enumerate(zip(places, partner, strict=True)):
        free = np.linalg.norm(_separation(position, index[valid], offset, upper, lower), axis=1)
        centre, half = coil_number[valid] + upper * step, step / (2 * len(places))
        touch = (
            np.interp(centre, coil_number, wire_diameter)
            + np.interp(centre - 1, coil_number, wire_diameter)
        ) / 2
        true = true_distance(axis, centre)
        distance[group, valid] = free + np.minimum(touch - true, 0.0)
        cell = np.minimum(centre + half, total_coils) - np.maximum(centre - half, 1.0)
        # Mean of both wires, so that counting the coils from the other end changes nothing.
        speed = (
            np.interp(centre, coil_number, line_speed)
            + np.interp(centre - 1, coil_number, line_speed)
        ) / 2
        length[group, valid] = speed * np.maximum(cell, 0.0)
    return ContactLine(offset, places, partner, distance, length)


def true_distance(axis: Callable[[Array], Array], coil: Array) -> Array:
    """Distance (m) from the wire axis at ``coil`` (n,) to the axis one turn below, by Gauss-Newton
    steps along the latter.
    """
    point, below, step = axis(coil), coil - 1.0, 1e-5
    for _ in range(12):
        # Without the axis' curvature, which is unknown at the corners of a diameter law; converges
        # by (radial shift / radius) a step.
        slope = (axis(below + step) - axis(below - step)) / (2 * step)
        below = below + np.sum((point - axis(below)) * slope, axis=1) / np.sum(
            slope * slope, axis=1
        )
    found: Array = np.linalg.norm(point - axis(below), axis=1)
    return found


def _separation(
    position: Array, index: NDArray[np.int64], offset: int, upper: float, lower: float
) -> Array:
    point = sum(w[..., None] * position[index + k - 1] for k, w in enumerate(span_weights(upper)))
    below = index - offset
    before, centre, after = position[below - 1], position[below], position[below + 1]
    slope = (after - before) / 2 + lower * (after - 2 * centre + before)
    base = sum(w[..., None] * position[below + k - 1] for k, w in enumerate(span_weights(lower)))
    gap = point - base
    foot = np.sum(gap * slope, axis=1) / np.sum(slope * slope, axis=1)
    found: Array = (
        gap - foot[:, None] * slope - 0.5 * foot[:, None] ** 2 * (after - 2 * centre + before)
    )
    return found
