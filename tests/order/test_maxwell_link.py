"""A Maxwell link in the train's loop: second order against its linear system's exact solution, and
part of the periodic state.

Closed form: mass, spring k1 beside spring k2 in series with damper c is x' = A x + b with x = (q,
v, f), solved by the matrix exponential.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from train_parts import pushrod, system
from valvetrain.errors import InputError
from valvetrain.integrate.train_record import TrainOptions, TrainState
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import steady_train
from valvetrain.mechanism.gap_kinds import LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, Interaction, MaxwellLink
from valvetrain.system.train_system import TrainSystem

MASS = 0.1


def mass_on(link: MaxwellLink, force: float) -> TrainSystem:
    hold = Interaction("hold", LINEAR, ("valve",), (0.0, -1.0), link)
    return TrainSystem(
        AssembledMechanism(
            "creep", (Coordinate("valve", MASS, force=force),), (hold,), {}, "valve", "valve"
        )
    )


def exact(link: MaxwellLink, force: float, start: np.ndarray, time: float) -> np.ndarray:
    """(q, v, f) after ``time`` (s), the force's constant carried as a fourth unknown; f presses the
    mass towards larger q.
    """
    k1, k2, c = link.stiffness, link.branch_stiffness, link.branch_damping
    matrix = np.array(
        [[0, 1, 0, 0], [-k1 / MASS, 0, 1 / MASS, force / MASS], [0, -k2, -k2 / c, 0], [0, 0, 0, 0]]
    )
    return (expm(matrix * time) @ np.append(start, 1.0))[:3]


def errors_at(
    link: MaxwellLink, force: float, start: np.ndarray, duration: float, steps: int
) -> np.ndarray:
    """Largest error of the displacement over the run, and error of the branch force at its end,
    both relative to their sizes.
    """
    h = duration / steps
    ready = runner(
        mass_on(link, force), 2 * np.pi / duration, TrainOptions(samples=steps, time_step=h)
    )
    before = exact(link, force, start, -h / 2)
    state = TrainState(start[:1].copy(), before[1:2].copy(), (), start[2:].copy(), np.zeros(5))
    end, record = ready.cycle(state)
    truth = np.array([exact(link, force, start, n * h) for n in range(steps)])
    last = exact(link, force, start, duration)
    size = np.max(np.abs(truth), axis=0)
    return np.array(
        [
            np.max(np.abs(record.q[:, 0] - truth[:, 0])) / size[0],
            abs(end.law_state[0] - last[2]) / size[2],
        ]
    )


@pytest.mark.parametrize("relaxation", [0.05, 1.0, 20.0])
@pytest.mark.parametrize("story", ["creep", "relaxation"])
def test_creep_and_relaxation_converge_with_the_second_order(relaxation, story):
    own = np.sqrt(1e6 / MASS)
    link = MaxwellLink(4e5, 6e5, 6e5 * relaxation / own)
    start = (
        np.zeros(3) if story == "creep" else np.array([1e-3, 0.0, -6e5 * 1e-3])
    )  # stretched at once: the branch takes its share
    counts, fineness = (
        np.array([100, 200, 400, 800]),
        8 if relaxation < 1.0 else 1,
    )  # a short relaxation must be resolved, too
    found = np.array(
        [
            errors_at(link, 200.0 if story == "creep" else 0.0, start, 8.0 / own, steps)
            for steps in fineness * counts
        ]
    )
    orders = np.log2(found[:-1] / found[1:])
    assert found[-1] == pytest.approx(0.0, abs=2e-4)
    assert orders == pytest.approx(2.0, abs=0.1)


def test_a_branch_that_relaxes_within_a_step_leaves_the_lone_spring():
    """A damper of no account: no limit of the step, and the motion of the spring k1 alone."""
    duration, steps = 3e-3, 300
    link = MaxwellLink(4e5, 6e5, 1e-2)
    ready = runner(
        mass_on(link, 200.0),
        2 * np.pi / duration,
        TrainOptions(samples=steps, time_step=duration / steps),
    )
    _, record = ready.cycle(
        TrainState(
            np.zeros(1),
            np.array([-200.0 / MASS * duration / steps / 2]),
            (),
            np.zeros(1),
            np.zeros(5),
        )
    )
    own = np.sqrt(link.stiffness / MASS)
    time = np.arange(steps) * duration / steps
    assert record.q[:, 0] == pytest.approx(
        200.0 / link.stiffness * (1 - np.cos(own * time)), abs=2e-3 * 5e-4
    )


def test_the_damper_takes_what_the_mass_and_the_springs_lose():
    own = np.sqrt(1e6 / MASS)
    link = MaxwellLink(4e5, 6e5, 6e5 / own)
    duration, start, missing = 8.0 / own, np.array([1e-3, 0.0, -600.0]), []
    for steps in (200, 400):
        h = duration / steps
        ready = runner(
            mass_on(link, 0.0), 2 * np.pi / duration, TrainOptions(samples=steps, time_step=h)
        )
        _, record = ready.cycle(
            TrainState(
                start[:1].copy(),
                exact(link, 0.0, start, -h / 2)[1:2],
                (),
                start[2:].copy(),
                np.zeros(5),
            )
        )
        last = exact(link, 0.0, start, duration)
        energy = [
            0.5 * MASS * v**2 + 0.5 * link.stiffness * q**2 + 0.5 * f**2 / link.branch_stiffness
            for q, v, f in (start, last)
        ]
        missing.append(abs(record.work[2] / (energy[0] - energy[1]) - 1))
    assert missing[1] < 1e-3 and missing[0] / missing[1] == pytest.approx(4.0, rel=0.15)


def test_the_step_answers_to_the_stiffness_of_a_quick_motion():
    built = mass_on(MaxwellLink(4e5, 6e5, 100.0), 0.0)
    limit = 2 / np.sqrt(1e6 / MASS)
    with pytest.raises(InputError, match="cannot resolve"):
        runner(built, 1.0, TrainOptions(samples=36, time_step=1.05 * limit))


def train_with_soft_rod(relaxation: float) -> TrainSystem:
    """A pushrod train whose rod creeps: its bar is a Maxwell link of the relaxation time (s) given."""
    built = system(pushrod())
    parts = [
        replace(part, law=MaxwellLink(2e7, 1e7, 1e7 * relaxation))
        if part.name == "pushrod bar"
        else part
        for part in built.mechanism.interactions
    ]
    return replace(built, mechanism=replace(built.mechanism, interactions=tuple(parts)))


@pytest.mark.parametrize("method", ["anderson", "repeat"])
def test_the_branch_force_belongs_to_the_periodic_state(method):
    built = train_with_soft_rod(
        0.05
    )  # twice a cycle: what is left of the cycle before is still felt
    steady = steady_train(
        runner(built, 250.0, TrainOptions(samples=720)), method, tolerance=1e-7, cycles=80
    )
    assert steady.search.converged
    end, record = steady.runner.cycle(steady.start)
    link = built.mechanism.interaction_index("pushrod bar")
    size = np.max(np.abs(record.forces[:, link]))
    assert steady.start.law_state.shape == (1,) and abs(steady.start.law_state[0]) > 1e-3 * size
    assert end.law_state[0] == pytest.approx(steady.start.law_state[0], abs=1e-5 * size)
    # the law's own derivative along the recorded gap, by another integrator, leads to the same
    # force
    time = np.append(record.cam_angle, 2 * np.pi) / 250.0
    gap = CubicSpline(time, np.append(record.gaps[:, link], record.gaps[0, link]))
    law = built.mechanism.interactions[link].law
    truth = solve_ivp(
        lambda t, f: law.memory_derivative(f, -gap(t, 1)),
        (0.0, time[-1]),
        steady.start.law_state,
        rtol=1e-9,
        max_step=1e-4,
        t_eval=record.cam_angle / 250.0,
    )
    branch = record.forces[:, link] + record.gaps[:, link] * law.stiffness
    assert branch == pytest.approx(truth.y[0], abs=1e-3 * np.max(np.abs(branch)))
