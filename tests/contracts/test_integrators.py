"""What every integrator of the registry promises: the order it declares, and agreement with the
others in their common limits.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from spring_parts import CLOSED_ENDS, OPEN_SPRING, PRECOMPRESSION, curved_modal, straight_modal
from train_parts import LAW, direct
from valvetrain.continuum.transient import SolidDynamics
from valvetrain.continuum.wire import SolidContactLaw, SolidMeshSize
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles, Integrator, Periodic, RunOptions, RunUp
from valvetrain.integrate.run import integrator_for, run
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.parts import ElasticLink
from valvetrain.registry import find, places
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.solid.model import SolidModel
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.train_system import TrainSystem

CHAIN = MultiMassSpring.from_card(30e3, 250.0, 0.04, elements=12)
#: Six open coils of six elements that pass through each other: no event whose instant depends on
#: the step.
ROD = FiniteElementRod(
    OPEN_SPRING,
    PRECOMPRESSION,
    elements_per_coil=6,
    dynamics=RodDynamics(mass_damping=20.0, contact_stiffness=0.0),
)
#: The same wire of a few bricks, without contact.
SOLID = SolidModel(
    OPEN_SPRING,
    PRECOMPRESSION,
    SolidMeshSize(8),
    SolidContactLaw(0.0),
    SolidDynamics(mass_damping=20.0),
)
TURN, ENDS = 2 * np.pi, ("seat_force", "retainer_force")


def driven(spring: SpringModel, stiffness: float) -> TrainSystem:
    """A valve of 0.1 kg tied to its lift law by a link (N/m) that pulls as well as it pushes,
    without a seat.
    """
    mechanism = build_mechanism(direct(model="single-mass"), LAW, "valve")
    cam = mechanism.interactions[mechanism.interaction_index("cam")]
    link = ElasticLink(stiffness, 0.2 * math.sqrt(0.14 * stiffness))
    return TrainSystem(
        replace(mechanism, interactions=(replace(cam, law=link, role=""),)), (spring,)
    )


@dataclass(frozen=True)
class Trial:
    """A system that an integrator runs at ``cam_speed`` (rad/s) with ``samples`` per turn, and
    steps per sample, each twice the last.
    """

    system: System
    cam_speed: float
    samples: int
    steps_per_sample: tuple[int, ...]

    @property
    def interval(self) -> float:
        return TURN / self.cam_speed / self.samples

    def seat_force(self, word: str, steps_per_sample: float) -> np.ndarray:
        options = RunOptions(self.samples, self.interval / steps_per_sample, integrator=word)
        found = run(self.system, self.cam_speed, Cycles(1), options)
        assert found.status.completed, found.status.sentence()
        assert found.statistics["integrator"] == word
        return found.channel("seat_force")


TRIALS = {
    "harmonic": Trial(PrescribedSpring((curved_modal(),), LAW), 200.0, 512, (1, 2, 4)),
    "rod-leapfrog": Trial(PrescribedSpring((ROD,), LAW), 300.0, 360, (120, 240, 480)),
    "solid-leapfrog": Trial(PrescribedSpring((SOLID,), LAW), 9600.0, 45, (75, 150, 300)),
    "leapfrog": Trial(PrescribedSpring((CHAIN,), LAW), 200.0, 360, (8, 16, 32)),
    "train-leapfrog": Trial(driven(CHAIN, 1e7), 200.0, 360, (20, 40, 80)),
}


#: What moves springs by another integrator, which is on trial (tests/limits/test_solid_in_train.py holds the rest).
BY_ANOTHER = {"solid-in-train": "solid-leapfrog"}


def test_every_integrator_that_ships_is_on_trial():
    assert set(BY_ANOTHER.values()) <= set(TRIALS)
    assert {*TRIALS, *BY_ANOTHER} == {
        word for word, place in places("integrators").items() if place.startswith("valvetrain.")
    }


@pytest.mark.parametrize("word", TRIALS)
def test_observed_order_is_the_declared_one(word):
    integrator, trial = find("integrators", word), TRIALS[word]
    assert isinstance(integrator, Integrator) and integrator.word == word
    traces = [trial.seat_force(word, steps) for steps in trial.steps_per_sample]
    changes = [
        float(np.sqrt(np.mean((fine - coarse) ** 2))) for coarse, fine in itertools.pairwise(traces)
    ]
    if integrator.order == 0:
        assert changes == [0.0, 0.0], "exact at any step"
    else:
        assert np.log2(changes[0] / changes[1]) == pytest.approx(integrator.order, abs=0.1)


@pytest.mark.parametrize("word", TRIALS)
def test_an_integrator_says_what_it_runs_and_refuses_the_rest(word):
    integrator, system = find("integrators", word), TRIALS[word].system
    assert integrator_for(system, Cycles()).word == word, "the first of the registry that serves"
    assert integrator.serves(system, Periodic())
    assert integrator.serves(system, RunUp(300.0, 100.0)) == (
        word in ("leapfrog", "train-leapfrog")
    )
    other = TRIALS["train-leapfrog" if word != "train-leapfrog" else "leapfrog"].system
    assert not integrator.serves(other, Cycles())
    with pytest.raises(InputError, match="choose another"):
        run(other, 200.0, Cycles(1), RunOptions(integrator=word))
    with pytest.raises(InputError, match="cam speed must be positive"):
        run(system, 0.0, Cycles(1), RunOptions(integrator=word))


@pytest.mark.parametrize(
    ("wire", "contact_damping_time", "tolerance"),
    [(OPEN_SPRING, 1e-6, 1e-6), (CLOSED_ENDS, 0.0, 1e-6), (CLOSED_ENDS, 1e-6, 5e-4)],
    ids=["open", "coils in contact", "coils in damped contact"],
)
def test_the_rods_own_leapfrog_is_the_contracts_leapfrog_of_the_same_rod(
    wire, contact_damping_time, tolerance
):
    """Same mesh, same step: end forces (N, of 300) differ by what rounding makes of another order
    of sums.

    The damping of touching coils sees the retainer's own turns at t_n in the one and half a step
    earlier in the other: 1e-4 N at this
    step, half of it at half the step.
    """
    dynamics = RodDynamics(
        mass_damping=20.0, stiffness_damping=1e-7, contact_damping_time=contact_damping_time
    )
    rod = FiniteElementRod(wire, PRECOMPRESSION, elements_per_coil=8, dynamics=dynamics)
    trial = Trial(PrescribedSpring((rod,), LAW), 300.0, 360, ())
    options = RunOptions(
        trial.samples, trial.interval / 120, keep="ends"
    )  # both round such a step to itself
    own, contract = (
        run(trial.system, trial.cam_speed, Cycles(1), replace(options, integrator=word))
        for word in ("rod-leapfrog", "leapfrog")
    )
    assert own.statistics["time_step_duration"] == pytest.approx(
        contract.statistics["time_step_duration"], rel=1e-12
    )
    for name in ENDS:
        assert np.ptp(own.channel(name)) > 100.0
        assert own.channel(name) == pytest.approx(contract.channel(name), abs=tolerance)
    assert own.channel("valve_lift") == pytest.approx(contract.channel("valve_lift"), abs=1e-15)
    assert own.channel("work_done") == pytest.approx(contract.channel("work_done"), abs=1e-6)


@pytest.mark.parametrize(
    "model", [straight_modal(0.016), curved_modal()], ids=["straight", "curved"]
)
def test_the_modal_spring_in_time_runs_into_its_harmonic_solution(model):
    """As the step and the transient vanish. Equation 5 leaves the dampers out of the end forces,
    the stepped model has them in: their
    share, 2 z G'/ w per mode beside G, is added to the harmonic solution here (0.04 N of 180 N)."""
    cam_speed, samples, system = 200.0, 512, PrescribedSpring((model,), LAW)
    exact = run(system, cam_speed, Cycles(1), RunOptions(samples))
    modal = exact.channel("modal_coordinate")[:-1].T
    number, omega = np.arange(1.0, model.unknowns + 1), TURN * np.asarray(model.natural_frequencies)
    rate = cam_speed * np.fft.irfft(
        1j * np.arange(samples // 2 + 1) * np.fft.rfft(modal), samples, axis=1
    )
    lag = (2 * model.damping_ratio / omega)[:, None] * rate
    share = np.pi * model.secant_stiffness(model.precompression + exact.channel("valve_lift")[:-1])
    seat = exact.channel("seat_force")[:-1] + share * (((-1.0) ** (number + 1) * number) @ lag)
    retainer = exact.channel("retainer_force")[:-1] - share * (number @ lag)
    errors = []
    for steps in (1, 2, 4):
        options = RunOptions(
            samples, TURN / cam_speed / samples / steps, integrator="leapfrog", keep="ends"
        )
        found = run(system, cam_speed, Cycles(16), options)
        errors.append(
            [
                np.max(np.abs(found.channel(name)[:-1] - truth))
                for name, truth in (("seat_force", seat), ("retainer_force", retainer))
            ]
        )
    assert np.array(errors[:-1]) / errors[1:] == pytest.approx(np.full((2, 2), 4.0), rel=0.02)
    assert max(errors[-1]) < 0.005


def test_a_valve_driven_stiffly_has_the_spring_forces_of_prescribed_motion():
    """The two systems meet: a train whose valve is tied to its lift law ever more stiffly is a
    spring under prescribed motion.
    """
    samples, cam_speed = 360, 200.0
    told = run(PrescribedSpring((CHAIN,), LAW), cam_speed, Cycles(2), RunOptions(samples, 2e-6))
    gaps = []
    for stiffness in (1e6, 1e7, 1e8):
        found = run(driven(CHAIN, stiffness), cam_speed, Cycles(2), RunOptions(samples, 2e-6))
        assert found.status.completed
        gaps.append(
            [
                np.max(np.abs(found.channel(name)[:samples] - told.channel(name)[:samples]))
                for name in ("retainer_force", "seat_force")
            ]
        )
    assert np.array(gaps[:-1]) / gaps[1:] == pytest.approx(np.full((2, 2), 10.0), rel=0.15)
    assert max(gaps[-1]) < 0.2  # N, of a span of 150 N
