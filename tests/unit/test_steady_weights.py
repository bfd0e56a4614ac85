"""What counts how much where a train is asked whether it repeats itself, and the root that speeds
and ramps are found by.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from scipy.optimize import brentq

from train_parts import LAW, direct, finger, system
from valvetrain.cam.pieces import solve
from valvetrain.integrate.train_run import TrainOptions, runner
from valvetrain.integrate.train_steady import _pack, _unpack, _weights
from valvetrain.springs.multi_mass import MultiMassSpring

SPEED, LIFT = 150.0, LAW.maximum_lift


@pytest.mark.parametrize("name", ["multi-mass", "finite-element"])
@pytest.mark.parametrize("build", [direct, finger])
def test_every_unknown_counts_by_its_own_scale(build, name):
    """Lengths by the lift, turns by a quarter radian, velocities by these times the cam speed;
    frames of a rod are no lengths.
    """
    spring = replace(MultiMassSpring.from_card(30e3, 250.0, 0.04, elements=5), name=name)
    built = system(build(), spring=spring)
    ready = runner(built, SPEED, TrainOptions(samples=360))
    state, lift = ready.initial_state(), max(built.mechanism.kinematics.maximum_lift, 1e-4)
    bodies = [0.25 if part.unit == "rad" else lift for part in built.mechanism.coordinates]
    memory = ready.system.differential_memory(lift)[1]
    masses, counted = spring.unknowns, 0.0 if name == "finite-element" else 1.0
    expected = (
        [1 / one for one in bodies]
        + [1 / (one * SPEED) for one in bodies]
        + [1 / one for one in memory]
    )
    expected += [counted / lift] * masses + [counted / (lift * SPEED)] * masses
    assert _weights(state, ready) == pytest.approx(expected)
    assert len(expected) == len(_pack(state, ready)) and masses == 4
    assert (0.25 in bodies) == (build is finger) and lift == pytest.approx(LIFT, rel=0.6)


def test_what_is_packed_is_unpacked_in_its_place():
    ready = runner(
        system(finger(), spring=MultiMassSpring.from_card(30e3, 250.0, 0.04)),
        SPEED,
        TrainOptions(samples=360),
    )
    state = ready.initial_state()
    vector = np.arange(1.0, len(_pack(state, ready)) + 1)
    back, bodies = _unpack(vector, state, ready), len(state.q)
    assert _pack(back, ready) == pytest.approx(vector)
    assert back.q == pytest.approx(vector[:bodies]) and back.v == pytest.approx(
        vector[bodies : 2 * bodies]
    )
    assert back.springs[0][:8] == pytest.approx(vector[-8:]) and back.springs[0][
        8:
    ] == pytest.approx(state.springs[0][8:])


@pytest.mark.parametrize(
    "curve",
    [
        lambda x: x**3 - 2,
        lambda x: np.exp(x) - 3,
        lambda x: 0.5 - x,
        lambda x: np.arctan(20 * (x - 1.01)),
    ],
)
def test_a_root_is_that_of_scipy(curve):
    asked = count()

    def counted(x: float) -> float:
        next(asked)
        return float(curve(x))

    assert solve(counted, (0.0, 2.0)) == pytest.approx(
        brentq(curve, 0.0, 2.0, xtol=1e-15), rel=1e-13
    )
    assert next(asked) < 40
    assert solve(counted, (2.0, 0.0)) == pytest.approx(
        brentq(curve, 0.0, 2.0, xtol=1e-15), rel=1e-13
    )


def test_a_root_at_a_bound_between_equals_and_nowhere():
    assert solve(lambda x: x, (-1.0, 0.0)) == 0.0 and solve(
        lambda x: x, (0.0, 1.0)
    ) == pytest.approx(0.0, abs=1e-15)
    assert solve(lambda x: 0.0, (1.0, 2.0)) == 2.0
    assert (
        solve(lambda x: x + 3.0, (0.0, 1.0)) is None
        and solve(lambda x: -x - 3.0, (0.0, 1.0)) is None
    )


def test_a_root_is_left_alone_once_it_is_near_enough():
    asked: list[float] = []

    def curve(x: float) -> float:
        asked.append(x)
        return x**3 - 2.0

    rough = solve(curve, (0.0, 2.0), within=1e-2)
    few = len(asked)
    exact = solve(curve, (0.0, 2.0))
    assert (
        rough == pytest.approx(exact, abs=1e-2)
        and rough != exact
        and abs(asked[few - 1] - asked[few - 2]) <= 1e-2
    )
    assert few < len(asked) - few
