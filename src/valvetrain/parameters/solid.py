"""The height at which a spring is solid, and the force that closes its coils."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array, Flags
from valvetrain.parameters.curves import Curve
from valvetrain.parameters.material import Material

#: Pieces a turn of the splines, and places a turn at which coils may touch.
PIECES, PLACES = 12, 24
#: Places along the free wire at which the force that closes it is computed.
SAMPLES = 1001


class WireShape(Protocol):
    """What the solid height of a spring needs; lengths in m over the coil number."""

    @property
    def total_coils(self) -> float: ...
    @property
    def free_coils(self) -> tuple[float, float]: ...
    @property
    def wire_diameter(self) -> Curve: ...
    @property
    def mean_diameter(self) -> Curve: ...
    @property
    def pitch(self) -> Curve: ...
    @property
    def material(self) -> Material: ...
    @property
    def free_length(self) -> float: ...
    @property
    def lower_seat_height(self) -> float: ...
    @property
    def upper_seat_height(self) -> float: ...

    def telescopes(self, coil: ArrayLike) -> Flags:
        """Whether the wire passes inside or outside of the wire one turn below."""

    def axial_position(self, coil: ArrayLike) -> Array:
        """Height z (m) of the wire axis above its lower tip."""

    def solid_rise(self, coil: ArrayLike) -> Array:
        """Rise per turn (m) where every coil touches the one below."""


def closing_forces(spring: WireShape, coil: ArrayLike) -> Array:
    """Force (N) under which the wire at ``coil`` closes by torsion alone, (pitch - rise when closed) G d^4 / (8 D^3)."""
    wire, mean = spring.wire_diameter.value(coil), spring.mean_diameter.value(coil)
    travel = spring.pitch.value(coil) - spring.solid_rise(coil)
    found: Array = np.maximum(travel, 0.0) * spring.material.shear_modulus * wire**4 / (8 * mean**3)
    return found


@lru_cache(maxsize=64)
def computed_solid_height(spring: WireShape) -> float:
    """The height (m) of a spring under the force that closes its last coil by torsion.

    Coils that touch bear part of this force, and end turns bonded to a seat keep their shape, so
    the stack is higher than wire times turns. The wire is a ring beam that bends and twists out of
    its plane (Timoshenko, Strength of Materials II, section 12): the least energy over axial
    displacement and twist, with coils that may touch each other and both seats (Lawson and Hanson,
    Solving Least Squares Problems, chapter 23). The finite-element rod has 27.4 mm for seven turns
    of 3.8 mm wire, this has 27.39. Coils that pass one another meet only the seats, so a cone whose
    turns all do is as high as one wire.

    Parameters
    ----------
    spring : its laws over the coil number, ends and material count
    """
    first, last = spring.free_coils
    force = float(np.max(closing_forces(spring, np.linspace(first, last, SAMPLES))))
    if force <= 0.0:
        return spring.free_length
    pieces = max(4, int(np.ceil((last - first) * PIECES)))
    edges = np.linspace(first, last, pieces + 1)
    knots = np.concatenate([[first] * 3, edges, [last] * 3])
    count = pieces + 3

    # columns: displacement without value and slope at both ends, travel of the upper end, twist without value at both ends
    held = np.zeros((count, 2 * count - 5))
    held[2 : count - 2, : count - 4] = np.eye(count - 4)
    held[count - 2 :, count - 4] = -1.0
    twist = np.zeros_like(held)
    twist[1 : count - 1, count - 3 :] = np.eye(count - 2)

    nodes, weights = np.polynomial.legendre.leggauss(3)
    coil = ((edges[:-1] + edges[1:])[:, None] / 2 + np.diff(edges)[:, None] * nodes / 2).ravel()
    angle = (np.diff(edges)[:, None] * weights).ravel() * np.pi
    radius, wire = spring.mean_diameter.value(coil)[:, None] / 2, spring.wire_diameter.value(coil)
    inertia = np.pi * wire**4 / 64
    value, slope, bow = (_splines(knots, coil, order) / math.tau**order for order in (0, 1, 2))
    bend = value @ twist / radius - bow @ held / radius**2
    turn = slope @ twist / radius + slope @ held / radius**2
    line = angle * radius[:, 0] * inertia
    stiffness = (bend.T * line * spring.material.youngs_modulus) @ bend
    stiffness += (turn.T * line * 2 * spring.material.shear_modulus) @ turn
    load = np.zeros(held.shape[1])
    load[count - 4] = force

    upper = np.linspace(0.0, last + 1, int(PLACES * (last + 1)) + 1)
    upper = upper[(upper > first) & (upper < spring.total_coils + 1) & (upper - 1 < last)]
    passed = spring.telescopes(upper)
    above, below = (
        _splines(knots, np.clip(at, first, last), 0) @ held for at in (upper, upper - 1)
    )
    below[upper - 1 <= first] = 0.0
    seated, retained = (upper < 1.0) | passed, (upper > spring.total_coils) | passed
    paired = ~(seated | retained)
    # the travel of the free wire, and what each touching place takes of it
    apart = np.vstack([(above - below)[paired], above[seated], held[-1] - below[retained]])
    gaps = _free_gaps(spring, upper[paired], upper[seated], upper[retained] - 1)
    answer = np.linalg.solve(stiffness, np.column_stack([apart.T, load]))
    yields, opened = apart @ answer[:, :-1], apart @ answer[:, -1]
    pressing = _pressing_forces(yields, -(gaps + opened))
    travel = float(answer[count - 4] @ np.append(pressing, 1.0))
    return spring.free_length - travel


def _pressing_forces(yields: Array, overlap: Array) -> Array:
    """Forces (n,) that open each ``overlap`` (n,) of a body of compliance ``yields`` (n, n): none pulls, and none
    acts across a gap (Lawson and Hanson, chapter 23).
    """

    def opening(compliance: Array) -> Array:
        among, wanted = np.flatnonzero(touching), np.zeros(len(overlap))
        wanted[among] = np.linalg.solve(compliance[np.ix_(among, among)], overlap[among])
        return wanted

    # a start near the end: of all places that overlap, those that push
    touching, softer = overlap > 0.0, yields + 1e-6 * np.diag(np.diag(yields))
    while np.any((force := opening(softer))[touching] <= 0.0):
        touching &= force > 0.0
    least = 1e-9 * float(np.max(overlap, initial=0.0))
    for _ in range(20 * len(overlap)):
        left = np.where(touching, 0.0, overlap - yields @ force)
        if np.max(left, initial=0.0) <= least:
            break
        touching[np.argmax(left)] = True
        while np.any((wanted := opening(yields))[touching] <= 0.0):
            pulls = np.flatnonzero(touching & (wanted <= 0.0))
            share = force[pulls] / (force[pulls] - wanted[pulls])
            force += np.min(share) * (wanted - force)
            touching[pulls[share <= np.min(share)]] = False
            force[~touching] = 0.0
        force = wanted
    return force


def _splines(knots: Array, place: Array, derivative: int) -> Array:
    """Cubic B-splines (places, knots - 4), or their first or second derivative (Cox and de Boor)."""
    x = np.minimum(place, np.nextafter(knots[-1], knots[0]))[:, None]
    values = np.where((knots[:-1] <= x) & (x < knots[1:]), 1.0, 0.0)
    for degree in (1, 2, 3):
        width = knots[degree:] - knots[:-degree]
        share = 1.0 / np.where(width > 0.0, width, np.inf)
        if degree <= 3 - derivative:
            rising, falling = x - knots[: -degree - 1], knots[degree + 1 :] - x
        else:
            rising, falling = np.array([float(degree)]), np.array([-float(degree)])
        values = rising * share[:-1] * values[:, :-1] + falling * share[1:] * values[:, 1:]
    return values


def _free_gaps(spring: WireShape, upper: Array, lowest: Array, highest: Array) -> Array:
    """Gaps (m) of the unloaded wire: at coils ``upper`` to the wire one turn below, at ``lowest`` to the lower seat, and at
    ``highest`` to the retainer.
    """
    wire = (spring.wire_diameter.value(upper) + spring.wire_diameter.value(upper - 1)) / 2
    mean = spring.mean_diameter.value(upper)
    rise = spring.axial_position(upper) - spring.axial_position(upper - 1)
    shift = (mean - spring.mean_diameter.value(upper - 1)) / 2
    stacked = np.sqrt(np.maximum(wire**2 - shift**2, 0.0))
    down, up = (
        spring.axial_position(coil) + side * spring.wire_diameter.value(coil) / 2
        for coil, side in ((lowest, -1), (highest, 1))
    )
    gaps = np.concatenate(
        (
            rise - stacked * np.hypot(1.0, stacked / (np.pi * mean)),
            down - spring.lower_seat_height,
            spring.upper_seat_height - up,
        )
    )
    found: Array = np.maximum(gaps, 0.0)
    return found
