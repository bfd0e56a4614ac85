"""Limits of the damping impulses of one step: dense linear algebra with every choice of contacts
held, and kinetic energy.
"""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.integrate import train_damping

STEP = 2e-6


@pytest.fixture(autouse=True)
def plain_python(monkeypatch):
    """The kernels as they are written, not compiled."""
    for name in (
        "_mean_share",
        "_damped_rows",
        "_rate_of",
        "_solve",
        "_exchange",
        "damp",
        "guide",
        "losses",
    ):
        monkeypatch.setattr(train_damping, name, getattr(train_damping, name).py_func)


def drawn(rng: np.random.Generator, bodies: int, interactions: int, heavy: float):
    """A train of so many bodies (kg) and interactions that press, pull or are dampers alone, with
    dampers of every size about ``heavy``.
    """
    index = np.full((interactions, 4), -1)
    gradients = np.zeros((interactions, 4))
    for k in range(interactions):
        taken = rng.permutation(bodies)[: rng.integers(1, min(bodies, 4) + 1)]
        index[k, : len(taken)], gradients[k, : len(taken)] = taken, rng.normal(size=len(taken))
    damping = np.where(
        rng.random(interactions) < 0.8, heavy * 10 ** rng.uniform(-2, 2, interactions), 0.0
    )
    laws = np.where(rng.random(interactions) < 0.7, 0, -1)
    gaps = np.stack(
        [
            rng.uniform(1e-6, 1e-5, interactions),
            np.zeros(interactions),
            rng.uniform(0, 800, interactions),
            damping,
        ],
        1,
    )
    masses, old = rng.uniform(0.02, 0.4, bodies), rng.normal(size=bodies)
    scratch = SimpleNamespace(
        gaps=gaps,
        gradients=gradients,
        old=old,
        dense=np.zeros((interactions, bodies)),
        share=np.ones(interactions),
        before=np.zeros((interactions, 1)),
        bend=np.zeros(interactions),
        guides=np.stack([masses, *np.zeros((2, bodies)), 1 / masses], 1),
        diagonal=np.zeros(interactions),
        right=np.zeros(interactions),
        rows=np.zeros(interactions, dtype=int),
        held=np.zeros(interactions, dtype=int),
        matrix=np.zeros((interactions, interactions)),
        impulse=np.zeros(interactions),
        row=np.zeros(interactions),
        lowest=np.zeros(interactions, dtype=int),
        place=np.zeros(interactions, dtype=int),
        neighbour=np.zeros(interactions, dtype=int),
    )
    train_damping.meet_neighbours.py_func(index, scratch.neighbour)
    return index, laws, scratch, masses


def matrix_of(index, gradients, bodies: int) -> np.ndarray:
    """Gradients of the interactions as rows over all bodies."""
    rows = np.zeros((len(index), bodies))
    for k, slots in enumerate(index):
        for slot, i in enumerate(slots):
            if i >= 0:
                rows[k, i] += gradients[k, slot]
    return rows


def by_every_choice(rows, masses, damping, forces, may_pull, old, v, bend, now):
    """Impulses of dampers on a share theta of the velocity after and the rest of that before, no
    contact pulling: all choices are tried.
    """
    z = STEP * damping * np.sum(rows**2 / masses, axis=1)
    theta, onwards = (6 * now + z) / (6 + z), (1 - now) / now
    mobility, least = rows / masses @ rows.T, -forces * STEP
    constant = theta * (rows @ v + onwards * bend) + (1 - theta) * (rows @ old - bend)
    for choice in product((False, True), repeat=len(damping)):
        held = np.array(choice, dtype=bool) & ~may_pull
        left = (
            np.eye(len(damping)) + np.where(held, 0.0, STEP * damping * theta)[:, None] * mobility
        )
        right = np.where(held, least, STEP * damping * constant)
        left[held] = np.eye(len(damping))[held]
        found = np.linalg.solve(left, right)
        free = (
            STEP * damping * (constant - theta * (mobility @ found))
        )  # what the damper of a held contact would give
        if np.all(may_pull | held | (found >= least - 1e-15)) and np.all(
            ~held | (free <= least + 1e-15)
        ):
            return found
    raise AssertionError("no choice of contacts held")


@pytest.mark.parametrize("heavy", [3.0, 300.0, 3e5])
@pytest.mark.parametrize(("bodies", "interactions"), [(1, 1), (2, 3), (2, 7), (3, 5), (5, 4)])
@pytest.mark.parametrize("now", [0.5, 0.3])
def test_impulses_solve_for_all_interactions_at_once(bodies, interactions, heavy, now):
    rng = np.random.default_rng(bodies * 100 + interactions)
    pulled = 0
    for _ in range(25):
        index, laws, scratch, masses = drawn(rng, bodies, interactions, heavy)
        scratch.bend[:] = rng.normal(scale=0.1, size=interactions)
        v, damped = scratch.old + rng.normal(scale=0.3, size=bodies), scratch.gaps[:, 3] > 0
        rows, forces = (
            matrix_of(index, scratch.gradients, bodies)[damped],
            scratch.gaps[:, 2].copy(),
        )
        args = rows, masses, scratch.gaps[damped, 3], forces[damped], laws[damped] < 0
        expected = by_every_choice(*args, scratch.old, v, scratch.bend[damped], now)
        due = v - rows.T @ expected / masses
        assert train_damping.damp(index, laws, scratch, STEP, now, v) == damped.sum()
        assert v == pytest.approx(due, rel=1e-9, abs=1e-12)
        mean = forces.copy()
        mean[damped] += expected / STEP
        mean[damped & (laws >= 0)] = np.maximum(mean[damped & (laws >= 0)], 0.0)
        assert scratch.gaps[:, 2] == pytest.approx(mean, rel=1e-8, abs=1e-6)
        pulled += int(np.sum(mean[damped] == 0))
    assert pulled > 0 or heavy < 100, "some contact was held at no force"


@pytest.mark.parametrize(("before", "after"), [(1.0, 1.0), (0.6, 1.4)])
def test_a_damper_met_since_the_last_step_acts_from_there_to_the_end_of_the_kick(before, after):
    """Overlaps of -1 and 3 micrometres at the steps: met a quarter of the step ``before`` after its
    begin; the kick ends amid the next.
    """
    kick, impulses = 0.5 * (before + after), []
    for share in (1.0, 0.0):
        scratch = drawn(np.random.default_rng(1), 1, 1, 1.0)[2]
        scratch.gaps[0], scratch.before[0], scratch.share[0] = (
            (3e-6, 0.0, 500.0, 10.0),
            -1e-6,
            share,
        )
        scratch.gradients[0, 0], index = 1.0, np.array([[0, -1, -1, -1]])
        scratch.old[0], scratch.guides[0, [0, 3]] = (
            1.0,
            (1e6, 1e-6),
        )  # so heavy that nothing slows it
        train_damping.damp(
            index, np.array([0]), scratch, STEP, 0.5 * before / kick, np.array([1.0])
        )
        impulses.append(scratch.impulse[0])
    assert impulses == pytest.approx(
        [10.0 * STEP, 10.0 * STEP * (0.75 * before + 0.5 * after) / kick]
    )


@pytest.mark.parametrize("now", [0.5, 0.4])
def test_a_guide_slows_by_viscous_drag_and_friction(now):
    """m (v' - v) = -h c (theta v' + (1 - theta) v_before), c with friction over the speed where
    that is above the least.
    """
    body = np.array(
        [
            [0.1, 0, 40.0, 0.0, 1e-3],
            [0.2, 0, 0.0, 5.0, 1e-3],
            [0.05, 0, 30.0, 8.0, 0.5],
            [0.3, 0, 0.0, 0.0, 1e-3],
        ]
    )
    old, v = np.array([0.7, -1.3, 0.1, 2.0]), np.array([0.9, -1.1, -0.05, 1.8])
    before, scratch = v.copy(), SimpleNamespace(guides=np.zeros((4, 4)), old=old)
    train_damping.guide(body, scratch, STEP, now, v)
    speed = np.abs((1 - now) * old + now * before)
    drag = STEP * (body[:, 2] + body[:, 3] / np.maximum(speed, body[:, 4]))
    theta = (6 * now + drag / body[:, 0]) / (6 + drag / body[:, 0])
    assert body[:, 0] * (v - before) == pytest.approx(
        -drag * (theta * v + (1 - theta) * old), rel=1e-9, abs=1e-18
    )
    assert v[3] == before[3] and scratch.guides[:, 0] == pytest.approx(
        body[:, 0] + np.where(drag > 0, theta * drag, 0.0)
    )


@pytest.mark.parametrize("seed", range(6))
def test_what_dampers_and_guides_take_is_what_kinetic_energy_loses(seed):
    rng = np.random.default_rng(seed)
    index, laws, scratch, masses = drawn(rng, 4, 5, 300.0)
    body = np.stack(
        [masses, np.zeros(4), rng.uniform(0, 50, 4), rng.uniform(0, 9, 4), np.full(4, 1e-3)], 1
    )
    v = scratch.old.copy()
    train_damping.guide(body, scratch, STEP, 0.5, v)
    count = train_damping.damp(index, laws, scratch, STEP, 0.5, v)
    lost = train_damping.losses(index, body, scratch, v, count)
    assert (
        lost == pytest.approx(float(np.sum(masses * (scratch.old**2 - v**2)) / 2), rel=1e-9)
        and count > 1
    )
