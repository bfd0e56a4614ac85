"""Own spring, own contact in one script. Closed form: a linear one gives the numbers of the built-in
one; other solver: a Maxwell spring and a hardening contact against scipy; contract: what is none is
refused in one sentence, and a study in other processes has the numbers of this one.
"""

from __future__ import annotations

import math
import pickle
import threading
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import valvetrain as vt
from valvetrain import registry
from valvetrain.coil_contact.law import contact_response
from valvetrain.coil_contact.law import law_of as coil_law_of
from valvetrain.contact.library import build_contact_law
from valvetrain.errors import InputError
from valvetrain.integrate.train_record import TrainOptions, TrainState
from valvetrain.integrate.train_run import runner
from valvetrain.mechanism.gap_kinds import LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, Interaction
from valvetrain.parameters.own_parts import own_name
from valvetrain.runs.workers import start_method
from valvetrain.system.train_system import TrainSystem
from valvetrain.views.answer import Answer

RATE, PRELOAD, MASS = 40e3, 300.0, 0.06


class Linear:
    """force = rate * compression + preload."""

    def __init__(self, rate=RATE, preload=PRELOAD, mass=MASS / 3):
        self.rate, self.preload, self.mass = rate, preload, mass

    def force(self, compression):
        return self.rate * compression + self.preload


class Maxwell:
    """A spring next to a spring and a damper in series, whose force is the state."""

    initial_state = (0.0,)
    stiffness, damping = 30e3, 15.0

    def derivatives(self, state, compression, velocity):
        return [self.stiffness * (velocity - state[0] / self.damping)]

    def force(self, state, compression, velocity):
        return PRELOAD + RATE * compression + state[0]


def card(train: bool) -> vt.Case:
    """An engine of card values, or its spring alone under a lift of a textbook."""
    spring = vt.Spring(preload=PRELOAD, rate=RATE, mass=MASS)
    if not train:
        angles = {"opening_start": "100 deg", "opening_end": "180 deg", "closing_start": "180 deg", "closing_end": "260 deg"}  # fmt: skip
        lift = {"kind": "cycloidal", "maximum_lift": "10 mm", **angles}
        return vt.Case(spring=spring, lift_law=lift, engine_speeds="3000 rpm")
    tables = vt.Case("tdi-pushrod").tree
    parts = {key: tables["train"][key] for key in ("cam", "follower", "pushrod", "lever", "valve", "contacts")}  # fmt: skip
    return vt.Case(
        train=vt.Train("pushrod", springs=spring, **parts), lift_law=tables["lift_law"], name="mine"
    )


def numbers(run, *without: str) -> dict[str, float]:
    """Named numbers of a run that are compared."""
    assert run.status.completed, run.status
    return {name: value for name, value in run.quantities.items() if name not in without}


@pytest.mark.parametrize("train", [False, True])
def test_a_linear_spring_given_in_python_gives_the_numbers_of_the_massless_model(train):
    case = card(train)
    usual = case.run("3000 rpm", models="massless")
    for own in (Linear(), Linear, CubicSpline([-0.1, 0.1], [PRELOAD - 4e3, PRELOAD + 4e3])):
        run = case.run("3000 rpm", models=own)
        if not isinstance(own, CubicSpline) or not train:  # a spline carries no mass
            assert numbers(run) == pytest.approx(numbers(usual), rel=1e-9, abs=1e-9)
        assert run.label == type(own).__name__ or run.label == "Linear"


def test_a_spring_with_a_state_of_its_own_has_the_force_that_scipy_finds():
    case = card(False)
    run = case.run("3000 rpm", models=Maxwell)
    angle, time = run.cam_angle, run.time
    lift = lambda t: np.interp(t, time, run.channel("valve_lift"))
    speed = CubicSpline(time, run.channel("valve_lift")).derivative()
    own = Maxwell()
    motion = solve_ivp(
        lambda t, y: own.derivatives(y, 0.0, float(speed(t))),
        (time[0], time[-1]),
        [run.channel("retainer_force")[0] - PRELOAD],
        t_eval=time,
        rtol=1e-9,
        atol=1e-6,
        max_step=1e-4,
    )
    exact = PRELOAD + RATE * lift(time) + motion.y[0]
    assert np.ptp(motion.y[0]) > 50  # the damper acts
    assert run.channel("retainer_force") == pytest.approx(exact, abs=1e-3 * np.ptp(exact))
    assert len(angle) == len(exact) and run.has("retainer_force") and not run.has("elastic_energy")


def test_a_mass_on_a_spring_of_ones_own_oscillates_at_its_frequency():
    """Closed form: sqrt(2 k / m) / 2 pi of a mass between two halves of a rate k."""

    class OneMass:
        initial_state = (0.0, 0.0)

        def derivatives(self, state, compression, velocity):
            return [state[1], (80e3 * (compression - state[0]) - 80e3 * state[0]) / 0.02]

        def force(self, state, compression, velocity):
            return PRELOAD + 80e3 * (compression - state[0]), PRELOAD + 80e3 * state[0]

    (found,) = vt.Spring(preload=PRELOAD, rate=RATE, mass=MASS).frequencies(OneMass)
    assert found == pytest.approx(math.sqrt(160e3 / 0.02) / (2 * math.pi), rel=1e-6)
    run = card(True).run("3000 rpm", models=OneMass())
    assert run.status.completed and np.ptp(run.channel("seat_force")) > 100


def test_classes_instances_and_entries_of_the_models_that_ship_are_taken():
    from valvetrain.springs.massless import SPEC

    case = card(True)
    usual = numbers(case.run("3000 rpm", models="massless"))
    spring = vt.springs.MasslessSpring(RATE, PRELOAD, MASS)
    for model in (vt.springs.MasslessSpring, spring, SPEC):
        assert numbers(case.run("3000 rpm", models=model)) == pytest.approx(usual, rel=1e-12)
    both = case.compare("3000 rpm", [spring, "massless", Linear()])
    assert both.labels == ("MasslessSpring", "massless", "Linear")


def test_linear_contacts_given_in_python_give_the_numbers_of_the_built_in_law():
    case, law = (
        card(True),
        {"law": "linear", "contact_stiffness": "60 kN/mm", "damping": "300 N s/m"},
    )
    usual = case.set({"train.contacts.cam": law, "train.contacts.seat": law})
    own = lambda depth, rate: 60e6 * depth + 300.0 * rate
    mine = case.set({"train.contacts.cam": own, "train.contacts.seat": {"law": own}})
    runs = [one.run("3000 rpm", models="massless") for one in (mine, usual)]
    assert numbers(runs[0]) == pytest.approx(numbers(runs[1]), rel=1e-9, abs=1e-9)


def test_a_hardening_contact_rebounds_as_scipy_finds():
    """A mass dropped on F = k d + b d^3 + c d d', at the integrator's own step."""
    mass, speed, duration = 0.1, 1.0, 4e-3
    force = lambda depth, rate: 1e7 * depth + 2e15 * depth**3 + 2e6 * depth * rate
    law = build_contact_law(own_name(force))
    leaves = lambda _, y: y[0]
    leaves.terminal, leaves.direction = True, -1
    exact = solve_ivp(
        lambda _, y: [y[1], -force(*y) / mass], (0, 1e-2), [0.0, speed], rtol=1e-10, atol=1e-15, events=leaves, max_step=5e-6,
    )  # fmt: skip
    floor = Interaction("seat", LINEAR, ("valve",), (0.0, -1.0), law)
    built = TrainSystem(
        AssembledMechanism("drop", (Coordinate("valve", mass),), (floor,), {}, "valve", "valve")
    )
    ready = runner(built, 2 * np.pi / duration, TrainOptions(samples=40))
    place, way = np.array([10 * speed * ready.time_step]), np.array([-speed])
    end, record = ready.cycle(TrainState(place, way, (), np.zeros(0), np.zeros(5)))
    assert end.v[0] == pytest.approx(-exact.y[1, -1], rel=2e-3) and end.v[0] < 0.95
    assert record.peak_forces[0] == pytest.approx(max(force(*y) for y in exact.y.T), rel=5e-3)


def test_a_linear_law_between_coils_gives_the_numbers_of_the_built_in_one():
    case = vt.Case("job-c").set({"operation.cycles": 1})
    mine = case.set({"spring.contact.law": lambda overlap: 2e10 * overlap})
    runs = [one.run(models="multi-mass") for one in (mine, case)]
    assert runs[1].quantities["clash_count"] > 0
    assert numbers(runs[0]) == pytest.approx(numbers(runs[1]), rel=1e-9, abs=1e-9)


def test_a_law_of_a_power_between_coils_has_its_closed_form():
    spring = vt.Spring(
        wire_diameter="4 mm", mean_diameter="24 mm", total_coils=7.5, pitch="7.6 mm", installed_height="42 mm",
        material="EN 10270-2 VDSiCr", contact=lambda overlap: 3e12 * overlap**1.4,
    )  # fmt: skip
    law, depth = coil_law_of(spring.parameters.contact), 5e-6
    found = contact_response(law, [depth, -depth], stiffness=2e10)
    assert found.force == pytest.approx([3e12 * depth**1.4, 0.0], rel=1e-12)
    assert found.tangent == pytest.approx([1.4 * 3e12 * depth**0.4, 0.0], rel=1e-7)
    assert found.energy == pytest.approx([3e12 * depth**2.4 / 2.4, 0.0], rel=1e-7)
    assert law.steepest == pytest.approx(1.4 * 3e12 * 1e-4**0.4 / 2e10, rel=0.01)


def test_a_case_and_a_name_bring_their_parts_to_another_process(monkeypatch):
    """What is pickled here is read where the registry knows none of it."""
    stiffness = 6e7
    case = card(True).set({"train.contacts.seat": lambda depth: stiffness * depth})
    name = own_name(lambda compression: stiffness * compression)
    content = pickle.dumps((case.parameters, name))
    law = str(case.parameters.train.contact("seat").law)
    monkeypatch.setattr(registry, "OWN", {})
    parameters, arrived = pickle.loads(content)
    assert parameters == case.parameters and arrived == name
    assert registry.OWN[law](2.0) == registry.OWN[name](2.0) == 2 * stiffness


@pytest.mark.long
def test_a_study_in_fresh_processes_has_the_numbers_of_this_one():
    stay = threading.Event()
    thread = threading.Thread(target=stay.wait)
    thread.start()  # as a notebook has: workers are fresh interpreters
    try:
        rate = 60e6
        case = card(True).set(
            {"train.contacts.seat": lambda depth: rate * depth, "train.lash": "0.1 mm"}
        )
        request = {"train.lash": vt.Uniform("0.1 mm", "0.2 mm")}, ["peak_cam_contact_force"]

        @dataclass
        class Stiffer:
            rate: float

            def force(self, compression):
                return PRELOAD + self.rate * compression

        assert start_method() == "spawn"
        tables = [
            case.study(*request, count=2, engine_speeds="3000 rpm", models=[Stiffer(45e3)], workers=workers)
            for workers in (1, 2)
        ]  # fmt: skip
        one, two = (table.to_xarray()["peak_cam_contact_force"].values for table in tables)
        assert np.array_equal(one, two) and len(np.unique(one)) == 2
    finally:
        stay.set()
        thread.join()


def test_a_name_changes_with_what_the_part_computes_and_with_nothing_else():
    def spring(rate):
        return lambda compression: rate * compression

    assert own_name(spring(1.0)) == own_name(spring(1.0)) != own_name(spring(2.0))
    assert own_name(Linear()) == own_name(Linear()) != own_name(Linear(41e3))
    assert registry.plain_name(own_name(Linear)) == "Linear" and own_name(Linear) != own_name(
        Linear()
    )
    case = card(True)
    first, second = (case.set({"train.contacts.seat": lambda d, k=k: k * d}) for k in (6e7, 7e7))
    assert first != second and vt.Case(first.text) == first
    changed = Linear()
    name = own_name(changed)
    changed.rate = 1.0
    assert registry.OWN[name].rate == RATE and own_name(changed) != name


def test_a_run_and_a_page_of_a_model_in_python_are_those_of_any_model(tmp_path):
    study = vt.simulate(card(False), "3000 rpm", models=Linear())
    (run,) = study.solutions
    vt.save(run, tmp_path / "run.nc")
    assert vt.load(tmp_path / "run.nc").identical(run) and run.provenance.model == own_name(
        Linear()
    )
    assert (
        "Linear" in str(list(Answer(study).computed()))
        and "nan" not in str(vt.views.study_json(study)).lower()
    )
    sweep = card(True).sweep("3000, 4000 rpm", Linear(), critical_speeds=False)
    assert np.all(sweep.series("Linear", "peak_cam_contact_force") > 0)


def wrong_shape(compression):
    return np.zeros(3)


class NoStates(Linear):
    def derivatives(self, state, compression, velocity):
        return [0.0]

    def force(self, state, compression, velocity):
        return 0.0


@pytest.mark.parametrize(
    ("model", "says"),
    [
        (3.5, "no spring model; give a name, a function"),
        (lambda: 3.0, r"takes \(\); give a function of the compression \(m\), or"),
        (lambda a, b, c: 3.0, r"takes \(a, b, c\); give a function of the compression"),
        (lambda compression: math.nan, "gives nan at a compression of 0 mm; it should be finite"),
        (wrong_shape, r"array of shape \(3,\).* it should give 2 numbers"),
        (lambda compression: "stiff", "which is no number"),
        (lambda compression: compression / 0, "fails .ZeroDivisionError"),
        (NoStates, "give initial_state, a list"),
        (lambda c: Linear(), "which is no number"),
    ],
)
def test_what_is_no_spring_is_refused_in_one_sentence(model, says):
    with pytest.raises(InputError, match=says):
        card(False).run("3000 rpm", models=model)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda: 3.0, "give a function of the penetration"),
        (6e7, "law"),
        (lambda depth, rate: math.nan, "gives nan; it should give one finite number"),
        (lambda depth: np.zeros(2), r"an array of shape \(2,\)"),
        (lambda depth: -6e7 * depth, "presses nothing apart"),
        (CubicSpline([0.0, 1.0], [0.0, 6e7]), "cannot be compiled by numba .* functions of math"),
    ],
)
def test_what_is_no_contact_law_is_refused_in_one_sentence(law, says):
    with pytest.raises(InputError, match=says):
        card(True).set({"train.contacts.seat": law}).run("3000 rpm", models="massless")


def test_a_law_between_coils_takes_the_overlap_alone():
    case = vt.Case("job-c").set({"spring.contact.law": lambda overlap, rate: 2e10 * overlap})
    with pytest.raises(
        InputError, match=r"takes \(overlap, rate\); give a function of the overlap"
    ):
        case.run(models="multi-mass")


def test_a_lift_function_is_taken_by_its_key_path_as_by_its_name():
    lift = lambda angle: 9e-3 * max(0.0, 1 - (angle - np.pi) ** 2) ** 4
    case = card(False)
    assert case.set({"lift_law": lift}) == case.set(lift_law=lift) != case


def test_a_function_where_no_law_is_due_is_refused():
    with pytest.raises(InputError, match="is no value of a case"):
        vt.Spring(preload=PRELOAD, rate=lambda x: RATE)


def test_points_of_a_study_are_known_by_what_their_functions_capture(tmp_path):
    """Contract: stored points of a function are not taken for those of the same text with another value."""

    def forces(factor):
        space = vt.Space({"compression": vt.Values((6e-3, 8e-3))})
        outputs = vt.Outputs("force", function=lambda compression: factor * RATE * compression)
        experiment = vt.Experiment(None, space, outputs)
        return experiment.table([[6e-3], [8e-3]], output=tmp_path, workers=1).values[:, 0]

    assert forces(2.0) == pytest.approx(2 * forces(1.0), rel=1e-12)
