"""Limits: the implicit rule of Hilber, Hughes and Taylor against its own recurrence and the closed
forms of their paper.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.cam.contract import LiftLaw
from valvetrain.errors import InputError
from valvetrain.integrate.chain_forces import ChainForces
from valvetrain.integrate.clash import RECORDED
from valvetrain.integrate.contract import Cycles, Periodic, RunOptions
from valvetrain.integrate.hht import HilberHughesTaylor
from valvetrain.integrate.run import run
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.springs.chain_layout import uniform_chain
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.prescribed import PrescribedSpring

#: One mass between two springs: a linear oscillator of 4 k / m (k of both together, m half the
#: card's mass), driven by the retainer.
RATE, MASS = 20e3, 0.05
OSCILLATOR = MultiMassSpring(uniform_chain(RATE, MASS, 2), 10e-3, pulls=True)
OMEGA = np.sqrt(4 * RATE / (MASS / 2))
ORIGIN = Provenance("", "")


@dataclass(frozen=True)
class Pluck:
    """A retainer that goes down by ``height`` (m) within the first ``rise`` of a turn and stays
    there.
    """

    height: float
    rise: float

    continuity, joints = 2, ()

    def lift(self, cam_angle, derivative=0):
        share = np.clip(np.asarray(cam_angle, dtype=float) / (2 * np.pi * self.rise), 0.0, 1.0)
        if derivative == 0:
            return self.height * share**3 * (10 - 15 * share + 6 * share**2)
        inside = share < 1
        slope = (
            30 * share**2 * (1 - share) ** 2
            if derivative == 1
            else 60 * share * (1 - share) * (1 - 2 * share)
        )
        return self.height * slope / (2 * np.pi * self.rise) ** derivative * inside


@dataclass(frozen=True)
class Hump:
    """A lift of ``height`` (m) over the first ``rise`` of a turn that begins and ends at rest."""

    height: float
    rise: float

    continuity, joints = 2, ()

    def lift(self, cam_angle, derivative=0):
        share = np.clip(
            np.mod(np.asarray(cam_angle, dtype=float), 2 * np.pi) / (2 * np.pi * self.rise),
            0.0,
            1.0,
        )
        shape = np.polynomial.Polynomial([0, 0, 0, 64]) * np.polynomial.Polynomial([1, -1]) ** 3
        return (
            self.height
            * (shape.deriv(derivative) if derivative else shape)(share)
            / (2 * np.pi * self.rise) ** derivative
        )


def beehive_chain() -> MultiMassSpring:
    """The chain of the shipped beehive, with all its coil contacts."""
    problem = vt.system.build.build("gu2021-beehive-blind")
    by_formula = problem.springs[0].with_options("multi-mass", from_rod=False)
    spring = problem.model_of("multi-mass", by_formula)
    assert isinstance(spring, MultiMassSpring)
    return spring


def motion_after_pluck(alpha: float, steps_per_period: float) -> np.ndarray:
    """Seat force less its mean after a pluck of four steps, one value a step."""
    samples, turns_of_motion = 720, 720 / steps_per_period
    cam_speed = OMEGA / turns_of_motion
    law: LiftLaw = Pluck(1e-3, 0.006)
    found = HilberHughesTaylor(alpha).run(
        PrescribedSpring((OSCILLATOR,), law),
        cam_speed,
        Cycles(1),
        RunOptions(samples, keep="ends"),
        ORIGIN,
    )
    assert found.status.completed
    return found.channel("seat_force") - (10e-3 + 1e-3) * RATE


def ringing(alpha: float, steps_per_period: float) -> tuple[np.ndarray, float]:
    """Seat force less its mean well after the pluck, one value a step, and the step times the
    circular frequency.
    """
    return motion_after_pluck(alpha, steps_per_period)[40:], 2 * np.pi / steps_per_period


def amplification(alpha: float, wave: float) -> np.ndarray:
    """Roots of the paper's amplification matrix (displacement, velocity times h, acceleration times
    h^2) of x'' + w^2 x = 0, w h = wave.
    """
    beta, gamma, square = (1 - alpha) ** 2 / 4, 0.5 - alpha, wave**2
    # rows: M a' + (1 + alpha) w2 x' - alpha w2 x = 0 and both rules of Newmark, written as L y' = R
    # y
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
    # once the third, real root has died away, a sequence of two complex roots obeys y'' = 2 Re r y'
    # - |r|^2 y
    missed = force[2:] - 2 * pair[0].real * force[1:-1] + abs(pair[0]) ** 2 * force[:-2]
    assert np.max(np.abs(missed)) < 1e-8 * np.max(np.abs(force))
    assert np.max(np.abs(force)) > 1.0


@pytest.mark.parametrize("alpha", [-0.05, -0.2, -1 / 3])
def test_the_numerical_damping_begins_with_the_third_power_of_the_step(alpha):
    """-alpha (1 + alpha)^2 (w h)^3 / 8 of critical, the expansion of the rule's roots: a
    second-order rule leaves the low modes alone.
    """
    force, wave = ringing(alpha, 40.0)
    later = np.stack([force[1:-1], force[:-2]], axis=1)
    twice, square = np.linalg.lstsq(later, force[2:], rcond=None)[0]
    root = np.log(complex(twice / 2, np.sqrt(-square - twice**2 / 4)))
    assert -root.real / abs(root) == pytest.approx(
        -alpha * (1 + alpha) ** 2 * wave**3 / 8, rel=0.02
    )


@pytest.mark.parametrize("alpha", [0.0, -0.05, -1 / 3])
@pytest.mark.parametrize("steps_per_period", [0.5, 2.1, 3.0])
def test_high_frequencies_fall_by_what_alpha_says_and_none_grows(alpha, steps_per_period):
    """At steps that resolve no period: the force obeys all three roots of the rule and has fallen
    by the largest of them forty steps later.
    With the step the largest root tends to the paper's (1 + alpha) / (1 - alpha), a half at
    -1/3."""
    wave, force = 2 * np.pi / steps_per_period, motion_after_pluck(alpha, steps_per_period)[6:80]
    roots = amplification(alpha, wave)
    ahead = np.poly(roots).real
    missed = (
        ahead[0] * force[3:]
        + ahead[1] * force[2:-1]
        + ahead[2] * force[1:-2]
        + ahead[3] * force[:-3]
    )
    assert np.max(np.abs(missed)) < 1e-9 and np.max(np.abs(force)) > 0.01
    most, early, late = (
        np.max(np.abs(roots)),
        *(np.max(np.abs(force[part])) for part in (slice(0, 10), slice(40, 50))),
    )
    assert most <= 1 + 1e-9 and late < 3 * most**40 * early + 1e-9
    assert alpha or late > early / 3
    assert np.max(np.abs(amplification(alpha, 1e4))) == pytest.approx(
        (1 + alpha) / (1 - alpha), abs=0.01
    )


def test_the_tangents_are_the_slopes_of_the_forces():
    spring = beehive_chain()
    forces, rng = ChainForces(spring), np.random.default_rng(3)
    nodes = np.concatenate(
        ([0.0], spring.initial_state(3e-3)[: spring.unknowns], [spring.precompression + 3e-3])
    )
    nodes[1:-1] += 2e-5 * rng.normal(size=spring.unknowns)
    rates = 0.1 * rng.normal(size=len(nodes))
    here = forces(nodes, rates)
    assert np.count_nonzero(here.overlap > 0) > 3, "coils are in contact"
    for which, tangent in ((0, here.stiffness), (1, here.damping)):
        step = 1e-10 * rng.normal(size=len(nodes))
        step[[0, -1]] = 0.0
        moved = forces(nodes + (which == 0) * step, rates + (which == 1) * step).inner
        assert moved - here.inner == pytest.approx(
            tangent @ step[1:-1], rel=1e-4, abs=1e-9 * np.max(np.abs(here.inner))
        )


def test_with_fine_steps_the_clashing_chain_moves_as_by_the_leapfrog():
    """4200 rpm of the beehive, first turn: the rule's error at a twelfth of a degree, of 530 N."""
    system, speed = (
        PrescribedSpring(
            (beehive_chain(),), vt.system.build.build("gu2021-beehive-blind").valve_lift
        ),
        4200 * np.pi / 60,
    )
    options = RunOptions(360, 2 * np.pi / speed / 360 / 6, keep="ends")
    ours = run(system, speed, Cycles(1), replace(options, integrator="hht"))
    theirs = run(system, speed, Cycles(1), replace(options, time_step=None, integrator="leapfrog"))
    assert ours.status.completed and ours.statistics["integrator"] == "hht"
    gap = ours.channel("seat_force") - theirs.channel("seat_force")
    assert np.sqrt(np.mean(gap**2)) < 0.4 and np.ptp(theirs.channel("seat_force")) > 400


def imbalance(found: Solution) -> np.ndarray:
    """Energy (J) that is in the chain or was lost in its dampers, less the work of the retainer."""
    names = ("kinetic_energy", "elastic_energy", "contact_energy", "energy_dissipated")
    made = sum((found.channel(name) for name in names), -found.channel("work_done"))
    return made - made[0]


def test_at_half_a_degree_all_channels_are_of_one_time():
    """4200 rpm of the beehive beside the leapfrog of twenty times as many steps; the largest of
    each is 95 N, 3.7 m/s and 0.07 J.
    """
    system, speed = (
        PrescribedSpring(
            (beehive_chain(),), vt.system.build.build("gu2021-beehive-blind").valve_lift
        ),
        4200 * np.pi / 60,
    )
    ours = HilberHughesTaylor(0.0).run(system, speed, Cycles(1), RunOptions(720), ORIGIN)
    theirs = run(system, speed, Cycles(1), RunOptions(720, integrator="leapfrog"))
    assert (
        ours.statistics["steps_per_cycle_count"] == 720
        and theirs.statistics["steps_per_cycle_count"] > 15_000
    )
    for name, most in (
        ("coil_contact_force", 1.0),
        ("axial_velocity", 0.025),
        ("kinetic_energy", 5e-4),
    ):
        gap = ours.channel(name) - theirs.channel(name)
        assert np.sqrt(np.mean(gap**2)) < most, name
    assert np.max(ours.channel("coil_contact_force")) == pytest.approx(
        np.max(theirs.channel("coil_contact_force")), abs=1.0
    )
    assert np.max(np.abs(imbalance(ours))) < 5e-4 and np.ptp(ours.channel("elastic_energy")) > 4.0


def test_the_printed_end_forces_are_those_that_move_the_masses():
    """By the trapezoidal rule the impulse of both is the momentum of all masses, through every
    contact, to rounding.
    """
    chain, law, speed = (
        beehive_chain(),
        vt.system.build.build("gu2021-beehive-blind").valve_lift,
        8000 * np.pi / 60,
    )
    chain = replace(chain, mass_damping=0.0)
    found = HilberHughesTaylor(0.0).run(
        PrescribedSpring((chain,), law), speed, Cycles(1), RunOptions(720), ORIGIN
    )
    force = found.channel("retainer_force") - found.channel("seat_force")
    momentum = -found.channel("axial_velocity")[:, 1:-1] @ chain.layout.masses
    given = found.statistics["time_step_duration"] * np.concatenate(
        ([0.0], np.cumsum((force[1:] + force[:-1]) / 2))
    )
    assert (
        np.max(np.abs(momentum - given)) < 1e-9 * np.max(np.abs(momentum))
        and np.max(np.abs(force)) > 100
    )


@pytest.mark.parametrize(("pulls", "most"), [(True, 1e-12), (False, 1e-3)])
def test_energy_is_balanced_with_dampers_and_with_ends_that_leave_their_seats(pulls, most):
    """To rounding where nothing opens or closes: the losses are the work that the dampers do in the
    rule itself.
    """
    spring = MultiMassSpring(
        uniform_chain(RATE, MASS, 6), 1e-3, mass_damping=20.0, stiffness_damping=2e-5, pulls=pulls
    )
    system, speed = PrescribedSpring((spring,), Hump(8e-3, 0.2)), 200 * np.pi
    ours = HilberHughesTaylor(0.0).run(system, speed, Cycles(1), RunOptions(720), ORIGIN)
    theirs = run(system, speed, Cycles(1), RunOptions(720, integrator="leapfrog"))
    assert np.max(np.abs(imbalance(ours))) < most
    assert ours.channel("energy_dissipated")[-1] == pytest.approx(
        theirs.channel("energy_dissipated")[-1], rel=2e-3
    )
    assert (
        np.min(ours.channel("seat_force")) == 0.0
        if not pulls
        else np.min(ours.channel("seat_force")) < -100
    )


@pytest.mark.parametrize(("rate", "elements"), [(1e6, 300), (1e5, 800)])
def test_a_stiff_or_finely_divided_chain_finds_its_balance(rate, elements):
    """Forces are differences of spring rate times place, here up to 3e6 N: rounding alone leaves
    1e-9 N.
    """
    spring = MultiMassSpring.from_card(rate, 300.0, 0.05, elements=elements, stiffness_damping=2e-6)
    found = run(
        PrescribedSpring((spring,), Hump(9e-3, 0.3)),
        20.0,
        Cycles(1),
        RunOptions(6, integrator="hht", keep="ends"),
    )
    assert found.status.completed, found.status.sentence()
    slow = 300.0 + rate * found.channel("valve_lift")
    assert found.channel("seat_force")[:2] == pytest.approx(slow[:2], rel=0.01)


def test_a_long_record_is_kept_at_the_interval_of_the_contacts_and_without_its_states(monkeypatch):
    """Steps of 0.1 ms, two to a row of contacts; states beyond the bound are left out, as the
    leapfrog does.
    """
    problem, speed = vt.system.build.build("gu2021-beehive-blind"), 8000 * np.pi / 60
    monkeypatch.setattr("valvetrain.integrate.hht.MAX_RECORD", 10.0)
    options = RunOptions(4, 1e-4, integrator="hht")
    found = run(PrescribedSpring((beehive_chain(),), problem.valve_lift), speed, Cycles(1), options)
    assert found.status.completed and "kinetic_energy" not in found.channels.data_vars
    share = 2e-4 / beehive_chain().first_period
    monkeypatch.setattr("valvetrain.springs.multi_mass.WATCH_SHARE", share)
    sparse = run(
        PrescribedSpring((beehive_chain(),), problem.valve_lift), speed, Cycles(1), options
    )
    step = sparse.statistics["time_step_duration"]
    assert (
        sparse.statistics[RECORDED] == pytest.approx(2 * step, rel=1e-12)
        and found.statistics[RECORDED] == step
    )
    assert sparse.channel("seat_force") == pytest.approx(found.channel("seat_force"), abs=0.0)


def test_an_alpha_that_would_grow_is_refused():
    with pytest.raises(InputError, match="from -1/3 to 0"):
        HilberHughesTaylor(0.1)
    with pytest.raises(InputError, match="from -1/3 to 0"):
        HilberHughesTaylor(-0.5)


def test_a_step_without_balance_ends_the_run_with_a_status(monkeypatch):
    monkeypatch.setattr("valvetrain.integrate.hht.ROUNDS", 0)
    found = run(
        PrescribedSpring((OSCILLATOR,), Pluck(1e-3, 0.1)),
        100.0,
        Cycles(1),
        RunOptions(36, integrator="hht"),
    )
    assert not found.status.completed and found.status.time == 0.0
    assert (
        "no balance of forces after 0.0 cam degrees of turn 1" in found.status.message
        and "without bound" not in found.status.message
    )
    assert found.channel("seat_force") == pytest.approx([OSCILLATOR.layout.rate * 10e-3])


def test_a_steady_turn_is_sought_until_two_turns_agree():
    """A damped oscillator forgets its start: the turn found is that of many turns, and the answer
    says how far two turns differed.
    """
    damped = replace(OSCILLATOR, mass_damping=2 * 0.02 * OMEGA)
    system, speed = PrescribedSpring((damped,), Hump(1e-3, 0.5)), OMEGA / 12.3
    sought = HilberHughesTaylor(0.0).run(
        system, speed, Periodic(tolerance=1e-6), RunOptions(360), ORIGIN
    )
    many = HilberHughesTaylor(0.0).run(system, speed, Cycles(12), RunOptions(360), ORIGIN)
    assert sought.status.completed and sought.statistics["steady_tolerance_ratio"] == 1e-6
    assert (
        0 < sought.statistics["steady_residual_ratio"] <= 1e-6
        and "steady_residual_ratio" not in many.statistics
    )
    turns = sought.statistics["steady_cycles_count"]
    fade = np.exp(-0.02 * OMEGA * 2 * np.pi / speed)  # of one turn
    assert (
        turns == pytest.approx(np.log(1e-6) / np.log(fade), abs=4)
        and many.statistics["steady_cycles_count"] == 12
    )
    np.testing.assert_allclose(
        sought.channel("seat_force"),
        many.channel("seat_force"),
        atol=1e-5 * np.ptp(many.channel("seat_force")),
    )


def test_a_steady_turn_that_is_not_found_is_told():
    system = PrescribedSpring((OSCILLATOR,), Hump(1e-3, 0.5))
    found = HilberHughesTaylor(0.0).run(
        system, OMEGA / 12.3, Periodic(cycles=5, tolerance=1e-9), RunOptions(360), ORIGIN
    )
    assert found.status.code == "not-converged" and found.statistics["steady_cycles_count"] == 5
    assert found.statistics["steady_residual_ratio"] > 1e-9
