"""Limits: the implicit rule of Hilber, Hughes and Taylor against its own recurrence and the closed forms of their paper."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.cam.contract import LiftLaw
from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles, RunOptions
from valvetrain.integrate.hht import ChainForces, HilberHughesTaylor
from valvetrain.integrate.run import run
from valvetrain.solution.provenance import Provenance
from valvetrain.springs.chain_layout import uniform_chain
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.prescribed import PrescribedSpring

#: One mass between two springs: a linear oscillator of 4 k / m (k of both together, m half the card's mass), driven by the retainer.
RATE, MASS = 20e3, 0.05
OSCILLATOR = MultiMassSpring(uniform_chain(RATE, MASS, 2), 10e-3, pulls=True)
OMEGA = np.sqrt(4 * RATE / (MASS / 2))
ORIGIN = Provenance("", "")


@dataclass(frozen=True)
class Pluck:
    """A retainer that goes down by ``height`` (m) within the first ``rise`` of a turn and stays there."""

    height: float
    rise: float

    continuity, joints = 2, ()

    def lift(self, cam_angle, derivative=0):
        share = np.clip(np.asarray(cam_angle, dtype=float) / (2 * np.pi * self.rise), 0.0, 1.0)
        if derivative == 0:
            return self.height * share**3 * (10 - 15 * share + 6 * share**2)
        inside = share < 1
        slope = 30 * share**2 * (1 - share) ** 2 if derivative == 1 else 60 * share * (1 - share) * (1 - 2 * share)
        return self.height * slope / (2 * np.pi * self.rise) ** derivative * inside


def beehive_chain() -> MultiMassSpring:
    """The chain of the shipped beehive, with all its coil contacts."""
    problem = vt.build("gu2021-beehive")
    spring = problem.model_of("multi-mass", problem.springs[0])
    assert isinstance(spring, MultiMassSpring)
    return spring


def ringing(alpha: float, steps_per_period: float) -> tuple[np.ndarray, float]:
    """Seat force less its mean after the pluck, one value a step, and the step times the circular frequency."""
    samples, turns_of_motion = 720, 720 / steps_per_period
    cam_speed = OMEGA / turns_of_motion
    law: LiftLaw = Pluck(1e-3, 0.006)
    found = HilberHughesTaylor(alpha).run(
        PrescribedSpring((OSCILLATOR,), law), cam_speed, Cycles(1), RunOptions(samples, keep="ends"), ORIGIN
    )
    assert found.status.completed
    force = found.channel("seat_force")
    return force[40:] - (10e-3 + 1e-3) * RATE, 2 * np.pi / steps_per_period


def amplification(alpha: float, wave: float) -> np.ndarray:
    """Roots of the paper's amplification matrix (displacement, velocity times h, acceleration times h^2) of x'' + w^2 x = 0, w h = wave."""
    beta, gamma, square = (1 - alpha) ** 2 / 4, 0.5 - alpha, wave**2
    # rows: M a' + (1 + alpha) w2 x' - alpha w2 x = 0 and both rules of Newmark, written as L y' = R y
    left = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1 + alpha) * square, 0.0, 1.0]])
    right = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1 - gamma], [alpha * square, 0.0, 0.0]])
    return np.linalg.eigvals(np.linalg.solve(left, right))


@pytest.mark.parametrize("alpha", [0.0, -0.05, -0.3])
@pytest.mark.parametrize("steps_per_period", [8.0, 24.0])
def test_a_linear_oscillator_decays_and_turns_as_the_roots_of_the_rule_say(alpha, steps_per_period):
    force, wave = ringing(alpha, steps_per_period)
    roots = amplification(alpha, wave)
    pair = roots[np.abs(roots.imag) > 1e-12]
    assert len(pair) == 2
    # once the third, real root has died away, a sequence of two complex roots obeys y'' = 2 Re r y' - |r|^2 y
    missed = force[2:] - 2 * pair[0].real * force[1:-1] + abs(pair[0]) ** 2 * force[:-2]
    assert np.max(np.abs(missed)) < 1e-8 * np.max(np.abs(force))
    assert np.max(np.abs(force)) > 1.0


@pytest.mark.parametrize("alpha", [-0.05, -0.2, -1 / 3])
def test_the_numerical_damping_begins_with_the_third_power_of_the_step(alpha):
    """-alpha (1 + alpha)^2 (w h)^3 / 8 of critical, the expansion of the rule's roots: a second-order rule leaves the low modes alone."""
    force, wave = ringing(alpha, 40.0)
    later = np.stack([force[1:-1], force[:-2]], axis=1)
    twice, square = np.linalg.lstsq(later, force[2:], rcond=None)[0]
    root = np.log(complex(twice / 2, np.sqrt(-square - twice**2 / 4)))
    assert -root.real / abs(root) == pytest.approx(-alpha * (1 + alpha) ** 2 * wave**3 / 8, rel=0.02)


def test_high_frequencies_fall_by_what_alpha_says_and_none_grows():
    for alpha, least in ((0.0, 1.0), (-0.05, 0.95 / 1.05 + 0.01), (-1 / 3, 0.51)):
        for wave in (0.5, 3.0, 100.0, 1e4):
            assert np.max(np.abs(amplification(alpha, wave))) <= 1 + 1e-9
        assert np.max(np.abs(amplification(alpha, 1e4))) <= least + 1e-3


def test_the_tangents_are_the_slopes_of_the_forces():
    spring = beehive_chain()
    forces, rng = ChainForces(spring), np.random.default_rng(3)
    nodes = np.concatenate(([0.0], spring.initial_state(3e-3)[: spring.unknowns], [spring.precompression + 3e-3]))
    nodes[1:-1] += 2e-5 * rng.normal(size=spring.unknowns)
    rates = 0.1 * rng.normal(size=len(nodes))
    here = forces(nodes, rates)
    assert np.count_nonzero(here[3] > 0) > 3, "coils are in contact"
    for which, tangent in ((0, here[1]), (1, here[2])):
        step = 1e-10 * rng.normal(size=len(nodes))
        step[[0, -1]] = 0.0
        moved = forces(nodes + (which == 0) * step, rates + (which == 1) * step)[0]
        assert moved - here[0] == pytest.approx(tangent @ step[1:-1], rel=1e-4, abs=1e-9 * np.max(np.abs(here[0])))


def test_with_fine_steps_the_clashing_chain_moves_as_by_the_leapfrog():
    """4200 rpm of the beehive, first turn: the rule's error at a twelfth of a degree, of 530 N."""
    system, speed = PrescribedSpring((beehive_chain(),), vt.build("gu2021-beehive").valve_lift), 4200 * np.pi / 60
    options = RunOptions(360, 2 * np.pi / speed / 360 / 6, keep="ends")
    ours = run(system, speed, Cycles(1), replace(options, integrator="hht"))
    theirs = run(system, speed, Cycles(1), replace(options, time_step=None, integrator="leapfrog"))
    assert ours.status.completed and ours.statistics["integrator"] == "hht"
    gap = ours.channel("seat_force") - theirs.channel("seat_force")
    assert np.sqrt(np.mean(gap**2)) < 0.4 and np.ptp(theirs.channel("seat_force")) > 400


def test_an_alpha_that_would_grow_is_refused():
    with pytest.raises(InputError, match="from -1/3 to 0"):
        HilberHughesTaylor(0.1)
    with pytest.raises(InputError, match="from -1/3 to 0"):
        HilberHughesTaylor(-0.5)


def test_a_step_without_balance_ends_the_run_with_a_status(monkeypatch):
    monkeypatch.setattr("valvetrain.integrate.hht.ROUNDS", 0)
    found = run(PrescribedSpring((OSCILLATOR,), Pluck(1e-3, 0.1)), 100.0, Cycles(1), RunOptions(36, integrator="hht"))
    assert not found.status.completed and found.status.time == 0.0
    assert found.channel("seat_force") == pytest.approx([OSCILLATOR.layout.rate * 10e-3])
