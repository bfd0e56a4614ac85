"""Every kind of gap against its formula: rows of random geometry, points by complex numbers,
gradients by differences.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from valvetrain.mechanism.gap_kinds import (
    ARC_RADIUS,
    CAM_FLAT,
    CAM_LIFT,
    CAM_ROUND,
    DISTANCE,
    GEOMETRY_COLUMNS,
    LINEAR,
    POINT_PLANE,
)
from valvetrain.mechanism.gaps import gap_rows
from valvetrain.mechanism.sliding import SLIDING_KINDS, sliding_gradient

NODES, ANGLE = 1440, 2.3


def level(angle: float, derivative: int = 0) -> float:
    """A smooth contour (m) over the cam angle."""
    turned = angle + derivative * math.pi / 2
    return (
        (0.03 if derivative == 0 else 0.0)
        + 4e-3 * math.cos(turned)
        + 1e-3 * 2**derivative * math.sin(2 * angle + derivative * math.pi / 2)
    )


def contour() -> np.ndarray:
    angles = 2 * np.pi * np.arange(NODES) / NODES
    other = np.zeros((NODES, 3))  # a first table that nobody shall read
    return np.array([other, [[level(angle, n) for n in range(3)] for angle in angles]])


def planar_point(row: np.ndarray, q: np.ndarray) -> tuple[complex, float]:
    """Point X of a body and the angle that the body has turned; q: body, support."""
    origin, arm, support = complex(*row[1:3]), complex(*row[3:5]), complex(*row[6:8])
    turn = row[5] * q[0] if row[0] else 0.0
    return origin + support * q[1] + (arm * cmath.exp(1j * turn) if row[0] else arm * q[0]), turn


def penetration(kind: int, row: np.ndarray, q: np.ndarray, cam_angle: float) -> float:
    """The formula of the kind, as the module of the kinds states it; q: the four coordinates, zero
    where there is none.
    """
    if kind == LINEAR:
        return row[0] + row[1:5] @ q
    if kind == CAM_LIFT:
        return row[5] * level(cam_angle) - row[0] - row[1:5] @ q
    point, turn = planar_point(row, q)
    if kind == CAM_FLAT:
        direction = row[8] + turn
        chi = cam_angle - row[10] * (direction - row[9])
        return level(chi) - (point * cmath.exp(-1j * direction)).real
    if kind == CAM_ROUND:
        chi = cam_angle - row[10] * (cmath.phase(point) - row[9])
        return (level(chi) - abs(point)) * math.cos(math.atan2(level(chi, 1), level(chi)))
    if kind == POINT_PLANE:
        closed = complex(*row[1:3]) + (complex(*row[3:5]) if row[0] else 0)
        return ((point - closed) * complex(row[8], -row[9])).real - row[11] * q[2] - row[10]
    bar = point - complex(row[8], row[9]) - complex(row[10], row[11]) * q[3]
    return q[2] - q[3] - (abs(bar) - row[12]) - row[13]


def row_of(kind: int, turning: bool) -> np.ndarray:
    rng = np.random.default_rng(kind + 10 * turning)
    row = rng.uniform(0.2, 0.9, GEOMETRY_COLUMNS)
    if kind in (LINEAR, CAM_LIFT):
        return row
    row[0], row[5] = float(turning), -1.0 if turning else row[5]
    row[1:5] = (0.02, 0.035, 0.013, -0.021) if kind == CAM_ROUND else rng.uniform(-0.05, 0.05, 4)
    row[10] = -1.0 if kind in (CAM_FLAT, CAM_ROUND) else row[10]
    row[9] = 1.1 if kind == CAM_ROUND else row[9]
    return row


def state(
    kind: int, row: np.ndarray, index: np.ndarray, position: np.ndarray
) -> tuple[float, np.ndarray, float]:
    """Penetration, gradient by the coordinates and slope by the cam angle, as the kernel has them;
    the row stands second of two.
    """
    kinds, geometry = np.array([LINEAR, kind]), np.array([np.full(GEOMETRY_COLUMNS, np.nan), row])
    indices, table_of = np.array([[-1] * 4, index]), np.array([0, 1])
    geometry[0, 0] = 0.0
    pens, gradients, slopes = np.zeros((1, 2)), np.zeros((1, 2, len(position))), np.zeros((1, 2))
    gap_rows(
        kinds,
        indices,
        geometry,
        contour(),
        table_of,
        position[None],
        np.array([ANGLE]),
        np.zeros((2, 4)),
        pens,
        gradients,
        slopes,
    )
    return float(pens[0, 1]), gradients[0, 1], float(slopes[0, 1])


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("kind", [LINEAR, CAM_LIFT, CAM_FLAT, CAM_ROUND, POINT_PLANE, DISTANCE])
@pytest.mark.parametrize("missing", [(), (0,), (1,), (2,), (3,), (1, 2, 3)])
def test_a_gap_is_that_of_its_formula(kind, turning, missing):
    row, position = row_of(kind, turning), np.array([9.0, 3e-3, 2e-3, -1e-3, 1.5e-3])
    order = np.array([2, 4, 1, 3])  # the coordinates of the interaction, in any order
    index = np.array([-1 if slot in missing else order[slot] for slot in range(4)])

    def values(where: np.ndarray) -> np.ndarray:
        q = np.array([where[i] if i >= 0 else 0.0 for i in index])
        if kind == DISTANCE and index[2] < 0:
            q[2] = q[3]  # without an upper end of its own the bar is rigid
        return q

    def formula(where: np.ndarray, cam_angle: float = ANGLE) -> float:
        return penetration(kind, row, values(where), cam_angle)

    pen, gradient, slope = state(kind, row, index, position)
    assert pen == pytest.approx(formula(position), abs=1e-11)
    for i, unit in enumerate(np.eye(len(position))):
        difference = (formula(position + 1e-6 * unit) - formula(position - 1e-6 * unit)) / 2e-6
        assert gradient[i] == pytest.approx(difference, abs=1e-7)
    around = (formula(position, ANGLE + 1e-5) - formula(position, ANGLE - 1e-5)) / 2e-5
    assert slope == pytest.approx(around, abs=1e-9)
    assert np.max(np.abs(gradient)) > 1e-3 or len(missing) == 3


def contact_of(kind: int, row: np.ndarray, q: np.ndarray) -> tuple[complex, complex]:
    """Where the contact is and its normal, both in the plane of the train."""
    point, turn = planar_point(row, q)
    if kind == POINT_PLANE:
        normal = complex(row[8], row[9])
        return point + row[ARC_RADIUS] * normal, normal
    if kind == CAM_FLAT:
        normal = cmath.exp(1j * (row[8] + turn))
        chi = ANGLE - row[10] * (row[8] + turn - row[9])
        return normal * (level(chi) - 1j * row[10] * level(chi, 1)), normal
    chi = ANGLE - row[10] * (cmath.phase(point) - row[9])
    normal = (level(chi) + 1j * row[10] * level(chi, 1)) * cmath.exp(1j * cmath.phase(point))
    normal /= abs(normal)
    return point - row[ARC_RADIUS] * normal, normal


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("kind", SLIDING_KINDS)
@pytest.mark.parametrize("support", [1, -1])
def test_a_contact_slides_as_its_material_does(kind, turning, support):
    """Material of the body (and, under a cam, less it from that of the turning cam) at the contact,
    along the tangent i n.
    """
    row, q = row_of(kind, turning), np.array([2e-3, -1e-3 if support >= 0 else 0.0])
    row[ARC_RADIUS] = 6e-3
    slides = np.full((1, 2), np.nan)
    index = np.array([[0, support, -1, -1]])
    given = np.array([kind]), index, row[None], contour(), np.array([1]), q, ANGLE, slides
    per_angle = sliding_gradient(0, *given)
    place, normal = contact_of(kind, row, q)
    tangent = 1j * normal

    def along(velocity: complex) -> float:
        return (velocity * tangent.conjugate()).real

    pivot = complex(*row[1:3]) + complex(*row[6:8]) * q[1]
    of_body = 1j * row[5] * (place - pivot) if turning else complex(*row[3:5])
    side = 1.0 if kind == POINT_PLANE else -1.0
    assert slides[0] == pytest.approx(
        [side * along(of_body), side * along(complex(*row[6:8]))], abs=1e-9
    )
    assert per_angle == pytest.approx(
        0.0 if kind == POINT_PLANE else along(1j * row[10] * place), abs=1e-9
    )
    assert np.min(np.abs(slides)) > 1e-4
