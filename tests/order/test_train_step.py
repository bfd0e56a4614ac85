"""Numbers of trains at the usual step against a step a quarter as long, and what any step must
keep: pressing contacts and energy.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from valvetrain.integrate.contract import Periodic, RunOptions
from valvetrain.integrate.run import run
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.loading import load_case
from valvetrain.runs.prepared import Plan, prepare, with_quantities
from valvetrain.system.build import build

FIRM = (
    "peak_spring_force", "minimum_spring_force", "peak_retainer_force", "surge_amplitude_force", "peak_cam_contact_force",
    "peak_rocker_contact_force", "peak_valve_tip_contact_force", "peak_seat_contact_force", "peak_support_force", "nose_cam_contact_force",
    "minimum_cam_contact_force", "peak_valve_lift", "lift_loss_displacement", "seating_velocity", "bounce_height", "cycle_work_energy",
    "cycle_dissipated_energy", "loss_of_contact_duration", "peak_cam_torque", "minimum_cam_torque", "peak_valve_acceleration",
)  # fmt: skip


@cache
def prepared(case: str, label: str):
    problem = build(load_case(case), spring_set="as printed" if "as printed" in label else ())
    member = next(one for one in problem.members if one.label == label)
    return prepare(problem, member, {}, problem.record.study), problem.engine_speeds[0]


def numbers(case: str, label: str, share: float) -> dict[str, float]:
    """Quantities at a share of the usual step."""
    ready, speed = prepared(case, label)
    usual = runner(ready.system, speed / 2, TrainOptions(), rest=ready.rest).time_step
    step = None if share == 1.0 else share * usual * (1 + 1e-9)
    found = with_quantities(
        ready,
        run(ready.system, speed / 2, Periodic(), RunOptions(time_step=step, rest=ready.rest)),
        Plan(),
        {},
    )
    assert found.status.completed
    return dict(found.quantities)


@pytest.mark.parametrize(
    ("case", "label"),
    [
        ("tdi-pushrod", "stock"),
        ("tdi-pushrod", "stock, as printed"),
        ("tdi-pushrod", "performance, as printed, zeta 1"),
        ("vaz-ohc", "single mass, lash 0.1 mm"),
    ],
)
def test_headline_numbers_at_the_usual_step_are_within_one_per_cent(case, label):
    usual, fine = numbers(case, label, 1.0), numbers(case, label, 0.25)
    names = [
        name for name in FIRM if name in usual and abs(fine[name]) > 1e-9
    ]  # a spring without masses has no surge, but rounding
    assert {"peak_spring_force", "peak_cam_contact_force", "peak_valve_lift"} <= set(names)
    small = 1e-3 * max(
        abs(usual["peak_spring_force"]), 100.0
    )  # a spring without seat load is at no force while closed
    for name in names:
        assert usual[name] == pytest.approx(
            fine[name], rel=0.01, abs=small if name.endswith("m_spring_force") else 0.0
        ), name


def test_work_of_the_cam_is_what_a_heavy_damper_of_the_valve_takes():
    """Slowed after the impulses of its contacts instead of with them, the valve took 5.9 J out of
    4.85.
    """
    found = numbers("tdi-pushrod", "performance, zeta 1", 1.0)
    assert found["cycle_work_energy"] == pytest.approx(
        found["cycle_dissipated_energy"] + found["spring_dissipated_energy"], rel=2e-3
    )


@pytest.mark.parametrize("parts", [1, 4])
def test_a_contact_that_is_pressed_presses(parts):
    """A contact held at no force beside one that opens must be let go again: the pushrod sank into
    its rocker without force.
    """
    ready, speed = prepared("tdi-pushrod", "stock")
    samples = parts * runner(ready.system, speed / 2, TrainOptions(), rest=ready.rest).steps
    every = runner(
        ready.system, speed / 2, TrainOptions(samples, impact_steps=0), rest=ready.rest
    )  # a record at each step
    state = every.initial_state()
    for _ in range(3):
        state, record = every.cycle(state)
    closing = np.diff(-record.gaps, axis=0) / every.time_step > 2e-3
    pressed = closing[1:] & closing[:-1] & (record.gaps[1:-1] < -1e-6)
    assert np.count_nonzero(pressed) > 100
    assert np.all(record.forces[1:-1][pressed] > 0)
