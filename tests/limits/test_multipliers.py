"""Multipliers against closed forms: linear maps, Mathieu's equation, and the ball on a swinging table."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

from valvetrain.integrate.multipliers import loss_of_stability, lyapunov_exponent, multipliers

Array = NDArray[np.float64]


def test_the_largest_multipliers_of_many_come_from_few_cycles() -> None:
    """Closed form: rotations of 30 pairs, one of them slow, in a skew basis."""
    rng = np.random.default_rng(2)
    sizes = np.concatenate(([0.9], np.geomspace(0.3, 1e-6, 29)))
    blocks = np.zeros((60, 60))
    for place, size in enumerate(sizes):
        c, s = size * math.cos(1 + place), size * math.sin(1 + place)
        blocks[2 * place : 2 * place + 2, 2 * place : 2 * place + 2] = [[c, -s], [s, c]]
    basis = rng.standard_normal((60, 60))
    turn = basis @ blocks @ np.linalg.inv(basis)
    found = multipliers(lambda x: turn @ x, np.zeros(60), basis)
    assert abs(found[0]) == pytest.approx(0.9, rel=1e-6)
    assert abs(found[0].imag) == pytest.approx(0.9 * abs(math.sin(1)), rel=1e-6)


def mathieu(a: float, q: float) -> Callable[[Array], Array]:
    """Over a period of y'' + (a - 2 q cos 2 t) y = 0."""

    def turn(state: Array) -> Array:
        rate = lambda t, y: [y[1], -(a - 2 * q * math.cos(2 * t)) * y[0]]
        end = solve_ivp(rate, (0.0, math.pi), state, rtol=1e-11, atol=1e-14)
        return np.asarray(end.y[:, -1])

    return turn


@pytest.mark.parametrize("q", [0.3, 1.0])
@pytest.mark.parametrize(
    ("limit", "kind", "sign"),
    [(lambda q: mathieu_b(1, q), "flip", 1), (lambda q: mathieu_a(1, q), "flip", -1), (lambda q: mathieu_b(2, q), "fold", 1)],
)  # fmt: skip
def test_the_stability_limits_of_mathieu_are_met(
    q: float, limit: Callable[[float], float], kind: str, sign: int
) -> None:
    """Product one everywhere (no damping); on the limits of the first and second tongue the multiplier is -1 and 1."""
    inside, outside = (
        multipliers(mathieu(limit(q) + sign * step, q), np.zeros(2), np.eye(2))
        for step in (1e-3, -1e-3)
    )
    assert np.prod(inside).real == pytest.approx(1, abs=1e-6)
    assert loss_of_stability(inside[0]) == kind and abs(inside[0]) > 1.001
    assert np.abs(outside) == pytest.approx([1, 1], abs=1e-6)


RESTITUTION = 0.5


def bounces(drive: float) -> Callable[[Array], Array]:
    """Phase and speed from one bounce on a table to the next (guckenheimer1983, 2.4); the motion of a bounce a period
    is the fixed point.
    """

    def turn(state: Array) -> Array:
        phase = state[0] + state[1]
        return np.array([phase - 2 * math.pi, RESTITUTION * state[1] - drive * math.cos(phase)])

    return turn


FOLD = 2 * math.pi * (1 - RESTITUTION)
FLIP = 2 * math.sqrt((math.pi * (1 - RESTITUTION)) ** 2 + (1 + RESTITUTION) ** 2)


@pytest.mark.parametrize(
    ("drive", "branch", "kind"),
    [
        (1.001 * FOLD, -1, ""),
        (1.001 * FOLD, 1, "fold"),
        (0.999 * FLIP, -1, ""),
        (1.001 * FLIP, -1, "flip"),
    ],
)
def test_a_bouncing_ball_loses_stability_by_fold_and_flip_where_it_must(
    drive: float, branch: int, kind: str
) -> None:
    orbit = np.array([branch * math.acos(-FOLD / drive), 2 * math.pi])
    assert bounces(drive)(orbit) == pytest.approx(orbit, abs=1e-12)
    found = multipliers(bounces(drive), orbit, np.eye(2))
    assert np.prod(found).real == pytest.approx(RESTITUTION, rel=1e-4)
    assert loss_of_stability(found[0]) == kind


def test_the_lyapunov_exponent_of_the_logistic_map_is_ln_2() -> None:
    found = lyapunov_exponent(lambda x: 4 * x * (1 - x), np.array([0.3]), 4000, 1e-9)
    assert found == pytest.approx(math.log(2), abs=0.02)
    assert lyapunov_exponent(lambda x: 0.5 * x, np.array([0.3]), 20) == pytest.approx(math.log(0.5))
