"""The motion of a train carried over as the start of another run, by every spring model that stands
in a train.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from spring_parts import CLOSED_ENDS, PRECOMPRESSION, SLIM, UNIFORM, build_models
from train_parts import LAW, direct, system
from valvetrain.integrate.contract import Cycles, RunOptions
from valvetrain.integrate.run import run_to_orbit
from valvetrain.springs.nested import NestedSprings, carried_state
from valvetrain.springs.wave_rod import WaveRod
from valvetrain.springs.wave_rod_clash import WaveRodWithClash

MODELS = build_models()
#: Cam speeds (rad/s): one at which the train keeps its contacts, and a fast one, whose turns are
#: short, for the rod.
CAM_SPEED, FAST = 300.0, 600.0


@pytest.mark.parametrize("name", MODELS)
def test_a_turn_from_a_motion_is_the_turn_that_follows_it(name: str) -> None:
    """Two turns from rest, and the second once more from the state at its start: the same but for
    the rounding of the cam angle.
    """
    train, speed = (
        system(direct(), LAW, spring=MODELS[name]),
        FAST if name == "finite-element" else CAM_SPEED,
    )
    options = RunOptions(360, keep="ends")
    second, orbit = run_to_orbit(train, speed, Cycles(2), options)
    assert orbit is not None and orbit.cam_speed == speed
    again, _ = run_to_orbit(train, speed, Cycles(1), RunOptions(360, keep="ends", start=orbit))
    for channel in ("valve_lift", "retainer_force", "cam_contact_force"):
        size = float(np.max(np.abs(second.channel(channel))))
        assert second.channel(channel) == pytest.approx(again.channel(channel), abs=1e-5 * size), (
            channel
        )


@pytest.mark.parametrize(
    "name", [name for name in MODELS if name != "finite-element"]
)  # its turns cost seconds, and its grid stays
def test_a_motion_fits_a_neighbouring_speed(name: str) -> None:
    """One per cent faster: the turn after the start differs from the one before by little, where
    one from rest need not run at all.
    """
    train = system(direct(), LAW, spring=MODELS[name])
    first, orbit = run_to_orbit(train, CAM_SPEED, Cycles(3), RunOptions(360, keep="ends"))
    carried, moved = run_to_orbit(
        train, 1.01 * CAM_SPEED, Cycles(1), RunOptions(360, keep="ends", start=orbit)
    )
    assert carried.status.completed and moved is not None
    force = first.channel("retainer_force")
    assert carried.channel("retainer_force") == pytest.approx(force, abs=0.1 * np.max(force))
    assert np.array_equal(moved.state.q, orbit.state.q)  # type: ignore[union-attr]
    assert moved.state.v == pytest.approx(1.01 * orbit.state.v, rel=1e-12, abs=1e-12)  # type: ignore[union-attr]


ROD = WaveRod(UNIFORM, 120)
CLASH = WaveRodWithClash.from_definition(CLOSED_ENDS, PRECOMPRESSION, cells=120)


@pytest.mark.parametrize("spring", [ROD, CLASH], ids=lambda one: str(one.name))
def test_a_rod_on_another_grid_keeps_its_shape(spring: WaveRod | WaveRodWithClash) -> None:
    """A half sine of departure and a ramp of velocity on 120 cells, read on 93: the same functions,
    to the error of straight lines.
    """
    other = replace(spring, cells=93)
    lift, rate, n, m = 4e-3, -2.0, spring.unknowns, other.unknowns
    share, fewer = np.arange(1, n + 1) / (n + 1), np.arange(1, m + 1) / (m + 1)
    state = np.array(spring.initial_state(lift))
    state[:n] += 1e-3 * np.sin(math.pi * share)
    state[n : 2 * n] = rate * share
    found = carried_state(state, spring, other, lift, rate)
    assert len(found) == len(other.initial_state(0.0))
    assert found[:m] - other.initial_state(lift)[:m] == pytest.approx(
        1e-3 * np.sin(math.pi * fewer), abs=2e-7
    )
    assert found[m : 2 * m] == pytest.approx(rate * fewer, rel=1e-9)


def test_a_nested_pair_is_carried_member_by_member() -> None:
    pair = NestedSprings(WaveRod(UNIFORM, 60), WaveRod(SLIM, 40))
    other = NestedSprings(WaveRod(UNIFORM, 50), WaveRod(SLIM, 40))
    state = np.array(pair.initial_state(3e-3))
    state[pair.outer.unknowns : pair.unknowns] += 1e-4  # the inner one, whose grid stays
    found = carried_state(state, pair, other, 3e-3, 0.0)
    outer, inner = other.split(found)
    assert outer == pytest.approx(other.outer.initial_state(3e-3), abs=1e-12)
    assert np.array_equal(inner, pair.split(state)[1])
    assert all(
        np.array_equal(one, two)
        for one, two in zip(
            pair.split(pair.joined(pair.split(state))), pair.split(state), strict=True
        )
    )
