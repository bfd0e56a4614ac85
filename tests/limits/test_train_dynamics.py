"""Dynamics of trains in their limits: slow and stiff, undamped, dropped on a seat, partitioned, run
up.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import KINDS, LAW, PLACES, contacts, direct, finger, system
from valvetrain.contact.dissipative import rebound
from valvetrain.contact.elastic import LinearContact
from valvetrain.errors import InputError
from valvetrain.integrate.train_record import TrainOptions, TrainState
from valvetrain.integrate.train_run import runner
from valvetrain.mechanism.gap_kinds import LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, ElasticLink, Interaction
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.quantities.kinematics import rigid_table
from valvetrain.springs.massless import MasslessSpring
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.train_system import TrainSystem


def mass_on(law, mass=0.1, force=0.0) -> TrainSystem:
    coordinate = Coordinate("valve", mass, force=force)
    floor = Interaction("seat", LINEAR, ("valve",), (0.0, -1.0), law)
    return TrainSystem(AssembledMechanism("drop", (coordinate,), (floor,), {}, "valve", "valve"))


def integrate_in_time(built, position, velocity, duration, steps):
    """State after ``duration`` from rest-frame values, the half-step velocity taken as given."""
    ready = runner(
        built, 2 * np.pi / duration, TrainOptions(samples=steps, time_step=duration / steps)
    )
    start = TrainState(
        np.array([position]),
        np.array([velocity]),
        (),
        np.zeros(built.arrays.memory_of[-1]),
        np.zeros(5),
    )
    return ready, *ready.cycle(start)


@pytest.mark.parametrize("kind", KINDS)
def test_a_slow_stiff_train_follows_rigid_theory(kind):
    errors = []
    for stiffness in (3e7, 3e8):
        law = ContactParameters(
            "linear", {"contact_stiffness": stiffness, "damping": 0.15 * math.sqrt(stiffness)}
        )
        train = KINDS[kind](contacts=contacts(law))
        if train.pushrod is not None:
            train = train.replace(pushrod=type(train.pushrod)(0.17, lower_end=(0.0, 0.02)))
        built = system(train)
        ready = runner(built, 60.0, TrainOptions(samples=720))
        state = ready.initial_state()
        for _ in range(2):
            state, record = ready.cycle(state)
        table = rigid_table(built, train, 60.0)
        opened = table["valve_lift"] > 0.2 * table["valve_lift"].max()
        valve = built.mechanism.index("valve")
        errors.append(np.max(np.abs(record.q[:, valve] - table["valve_lift"])[opened]))
        assert record.forces[opened, 0] == pytest.approx(table["contact_force"][opened], rel=0.03)
    assert errors[1] < 0.2 * errors[0]


def test_an_undamped_mass_keeps_its_energy_and_its_frequency():
    stiffness, mass = 1e6, 0.1
    omega = math.sqrt(stiffness / mass)
    errors = []
    for steps in (400, 800):
        duration = 10 * 2 * np.pi / omega
        h = duration / steps
        built = mass_on(ElasticLink(stiffness), mass)
        start = 1e-3 * math.cos(omega * -h / 2), -1e-3 * omega * math.sin(omega * -h / 2)
        _, _, record = integrate_in_time(built, 1e-3, start[1], duration, steps)
        time = np.arange(steps) * h
        errors.append(np.max(np.abs(record.q[:, 0] - 1e-3 * np.cos(omega * time))))
        energy = 0.5 * mass * record.v[:, 0] ** 2 + 0.5 * stiffness * record.q[:, 0] ** 2
        # seen at the positions, leapfrog's energy breathes with (omega h)**2 / 8 but never drifts
        assert np.mean(energy[-100:]) == pytest.approx(np.mean(energy[:100]), rel=1e-3)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_damping_is_second_order_and_never_limits_the_step():
    stiffness, mass = 1e6, 0.1
    omega = math.sqrt(stiffness / mass)
    duration, errors = 5 / omega, []
    for steps in (200, 400):
        damping = 0.3 * 2 * mass * omega
        beat = omega * math.sqrt(1 - 0.3**2)
        exact = lambda t, decay=0.3 * omega, w=beat: (
            np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
        )
        h = duration / steps
        slope = (exact(1e-7 - h / 2) - exact(-1e-7 - h / 2)) / 2e-7
        _, _, record = integrate_in_time(
            mass_on(ElasticLink(stiffness, damping), mass), 1.0e-3, 1e-3 * slope, duration, steps
        )
        errors.append(np.max(np.abs(record.q[:, 0] - 1e-3 * exact(np.arange(steps) * h))))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    # thirty times critical at a step near the elastic limit: creeps back without ringing or growth
    heavy = mass_on(ElasticLink(stiffness, 60 * mass * omega), mass)
    _, _, record = integrate_in_time(heavy, 1e-3, 0.0, 40 / omega, 40)
    assert np.all(np.diff(record.q[:, 0]) <= 1e-12) and np.all(record.q[:, 0] > 0)


@pytest.mark.parametrize("q", [0.2, 1.0, 3.0])
def test_a_dropped_mass_rebounds_as_hunt_and_crossley_say(q):
    from valvetrain.contact.dissipative import HuntCrossley

    speed = 0.5
    _, end, record = integrate_in_time(mass_on(HuntCrossley(1e9, q)), 1e-6, -speed, 2e-3, 8000)
    assert record.q[-1, 0] > 0
    assert float(end.v[0]) / speed == pytest.approx(rebound(q * speed), rel=2e-3)
    assert record.work[2] == pytest.approx(0.5 * 0.1 * (speed**2 - float(end.v[0]) ** 2), rel=2e-3)


def test_a_contact_never_pulls():
    for kind in KINDS:
        ready = runner(system(KINDS[kind](lash=2e-4)), 350.0, TrainOptions(samples=720))
        state = ready.initial_state()
        for _ in range(2):
            state, record = ready.cycle(state)
        places = [
            k
            for k, name in enumerate(ready.system.interaction_names)
            if name.replace(" ", "_") in PLACES
        ]
        assert (
            np.min(record.forces[:, places]) == 0.0
        )  # an open contact carries nothing, not a rounding


def test_work_of_the_cam_is_what_damping_takes():
    ready = runner(system(finger()), 220.0, TrainOptions(step_fraction=0.05))
    state = ready.initial_state()
    for _ in range(3):
        state, record = ready.cycle(state)
    cam, constant, lost, spring = record.work
    assert cam + constant == pytest.approx(lost + spring, rel=5e-3)
    assert lost > 0


def test_partitioned_exchange_errs_with_the_exchange_step():
    """Velocity out, force back, held: the force lags by half the exchange and the displacement by
    half a step, so the error goes as
    (exchange + 1) h."""
    built = system(direct(), spring=MultiMassSpring.from_card(30e3, 300.0, 0.04, mass_damping=50.0))
    errors = {}
    for steps in (5760, 11520):
        step = 2 * np.pi / 250.0 / steps * (1 + 1e-9)
        whole = runner(built, 250.0, TrainOptions(samples=360, time_step=step))
        _, truth = whole.cycle(whole.initial_state())
        for exchange in (16, 8, 4, 1):
            split = runner(
                built, 250.0, TrainOptions(samples=360, time_step=step, exchange=exchange)
            )
            assert split.steps == whole.steps == steps
            _, record = split.cycle(split.initial_state())
            errors[steps, exchange] = (
                np.sqrt(np.mean((record.spring_forces - truth.spring_forces) ** 2))
                * steps
                / (exchange + 1)
            )
    assert np.ptp(list(errors.values())) < 0.05 * np.mean(list(errors.values()))


def test_run_up_turns_the_cam_by_the_law_of_constant_acceleration():
    built = system(direct())
    ready = runner(built, 200.0, TrainOptions(samples=720), cam_acceleration=500.0)
    _, record = ready.cycle(ready.initial_state())
    time = np.arange(720) * ready.time_step * (ready.steps // 720)
    assert record.cam_angle == pytest.approx(200.0 * time + 250.0 * time**2, rel=1e-9, abs=1e-9)
    lift = record.q[:, built.mechanism.index("valve")]
    assert lift == pytest.approx(LAW.lift(record.cam_angle), abs=5e-5)


def test_run_up_goes_from_speed_to_speed_and_passes_through_the_steady_states():
    from valvetrain.integrate.run_up import run_up

    built = system(direct())
    records = run_up(built, 100.0, 300.0, 1000.0, TrainOptions(samples=720))
    angle = np.concatenate([record.cam_angle for record in records])
    time = np.arange(len(angle)) * (
        records[0].time_step * (runner(built, 100.0, TrainOptions(samples=720)).steps // 720)
    )
    assert angle == pytest.approx(100.0 * time + 500.0 * time**2, rel=1e-9, abs=1e-9)
    assert records[-1].cam_speed < 300.0 <= records[-1].cam_speed + 1000.0 * 2 * np.pi / 100.0
    lift = np.concatenate([record.q[:, 1] for record in records])
    assert lift == pytest.approx(LAW.lift(angle), abs=5e-5)
    with pytest.raises(InputError, match="must lead from its first to its last speed"):
        run_up(built, 100.0, 300.0, -1000.0)


def test_nested_springs_that_rub_take_more_energy():
    from valvetrain.parameters.loading import load_case
    from valvetrain.runs.api import simulate

    taken = []
    for rubbing in ({}, {"train.rubbing": {"coefficient": 0.15, "normal_force": "60 N"}}):
        case = load_case("vaz-ohc", rubbing)
        study = simulate(
            case,
            engine_speeds=case.operation.engine_speeds[:1],
            models=["multi-mass"],
            spring_sets=["nested-cards"],
            workers=1,
        )
        assert not study.failures
        taken.append(study.solutions[0].quantities["spring_dissipated_energy"])
    # twice the lift's mean slip times the friction force bounds what rubbing can take per cycle
    assert 0.0 < taken[1] - taken[0] < 0.15 * 60.0 * 2 * 9.7e-3 * 4


def test_nested_springs_that_stick_surge_as_one():
    """Closed form: pressed so hard that they stick, both springs have the one frequency sqrt(sum of rates / sum of masses) / 2,
    422 Hz, which order 12 of the cam meets at 4223 rpm; without rubbing neither surges by that order.
    """
    from valvetrain.parameters.loading import load_case
    from valvetrain.runs.api import simulate

    cards = ((17.39e3, 31.8e-3), (14.35e3, 11.5e-3))  # rates and masses of both in the file
    joint = math.sqrt(sum(one for one, _ in cards) / sum(one for _, one in cards)) / 2
    assert 120 * joint / 12 == pytest.approx(4223, rel=0.015)
    found = {}
    for force in (0, 1000):
        stuck = load_case("vaz-ohc", {"train.rubbing": {"coefficient": 0.12, "normal_force": f"{force} N"}})  # fmt: skip
        for speed in (4100, 4225, 4350) if force else (4225,):
            (run,) = simulate(stuck, f"{speed} rpm", models="multi-mass", spring_sets="nested", workers=1).solutions  # fmt: skip
            found[force, speed] = (
                run.quantities["surge_amplitude_force"],
                run.quantities.get("surge_amplitude_cam_order", 0.0),
            )
    assert found[1000, 4225][1] == 12 and found[0, 4225][1] != 12
    assert found[1000, 4225][0] > 3 * found[0, 4225][0]
    assert found[1000, 4225][0] > 1.5 * max(found[1000, 4100][0], found[1000, 4350][0])


def test_planar_and_lumped_trains_are_one_where_geometry_is_straight_and_near_where_it_turns():
    for kind, bound in (("direct", 1e-9), ("finger", 0.02), ("pushrod", 0.02)):
        lifts = []
        for model in ("planar", "lumped"):
            ready = runner(system(KINDS[kind](model=model)), 150.0, TrainOptions(samples=720))
            _, record = ready.cycle(ready.initial_state())
            lifts.append(record.q[:, ready.system.mechanism.index("valve")])
        assert np.max(np.abs(lifts[0] - lifts[1])) < bound * np.max(lifts[0]), kind


def test_gas_force_pushes_the_valve_open():
    from valvetrain.mechanism.contour import NODES, table_from_samples

    angle = np.arange(24) * 2 * np.pi / 24
    gas = table_from_samples(angle, np.full(24, 250.0), NODES)
    built = TrainSystem(
        system(direct(lash=1e-4)).mechanism, (MasslessSpring(30e3, 300.0, 0.04),), gas
    )
    plain = system(direct(lash=1e-4))
    forces = []
    for item in (plain, built):
        ready = runner(item, 100.0, TrainOptions(samples=720))
        forces.append(
            ready.cycle(ready.initial_state())[1].forces[0, item.interaction_names.index("seat")]
        )
    assert forces[0] - forces[1] == pytest.approx(250.0, rel=1e-3)


def test_linear_contact_law_is_the_one_the_loop_reads():
    assert LinearContact(3e7, 300.0).force(1e-6, 0.0) == pytest.approx(30.0)
