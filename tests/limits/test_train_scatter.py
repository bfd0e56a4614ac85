"""Trains whose loose parts rattle: judged by the valve, with their scatter told; what is not
settled or floats stays named.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from valvetrain.integrate.train_channels import COMPARED, STEADY_VALVE, cycle_numbers
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import steady_train
from valvetrain.parameters.loading import parse_case
from valvetrain.runs.api import simulate
from valvetrain.system.build import build

RPM = np.pi / 30


#: Lash -> velocity of a ramp that is steep, on which trains rattle.
STEEP_RAMPS = {"0.1 mm": "0.05138 mm/deg", "0.3 mm": "0.06572 mm/deg", "0.56 mm": "0.07518 mm/deg"}


def pushrod(lash: str, torque: str = "0.3 N m", model: str = "multi-mass"):
    """The pushrod train that `valvetrain new` writes, with other lash and ramp, hold of its
    rocker while the lash is open, spring model, and a stiff pushrod, on which it rattles.
    """
    text = (
        resources.files("valvetrain").joinpath("templates/pushrod.toml").read_text(encoding="utf-8")
    )
    changes = {
        "0.3 N m": torque,
        'lash = "0 in"': f'lash = "{lash}"\nramp_lift = "{float(lash.split()[0]) / 1.6 + 0.1} mm"',
        'advertised_duration = "288 deg"': f'ramp_velocity = "{STEEP_RAMPS[lash]}"',
        '# spring_model = "modal-uniform"': f'spring_model = "{model}"',
        'wall_thickness = "0.080 in"': 'mass = "62 g"\nstiffness = "60 kN/mm"\nwall_thickness = "0.080 in"',
    }
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return parse_case(text)


@pytest.fixture(scope="module")
def rattling():
    return simulate(pushrod("0.1 mm"), engine_speeds=[3000 * RPM], workers=1)


def test_rattle_between_events_is_no_failure_and_its_scatter_is_told(rattling):
    (found,) = rattling.solutions
    assert found.status.completed and "the valve repeats to" in found.status.sentence()
    assert (
        found.quantities["motion_period_count"] != 1
        and found.quantities["steady_residual_ratio"] > 1e-4
    )
    assert found.quantities["bounce_height"] == pytest.approx(
        11e-6, abs=3e-6
    )  # some ten micrometres are no failure
    scatter = {
        name: value for name, value in found.quantities.items() if name.startswith("cycle_scatter_")
    }
    assert {
        "cycle_scatter_seating_velocity",
        "cycle_scatter_peak_cam_contact_force",
        "cycle_scatter_bounce_height",
    } <= scatter.keys()
    assert (
        0 < scatter["cycle_scatter_valve_lift"] < STEADY_VALVE * found.quantities["peak_valve_lift"]
    )
    assert (
        scatter["cycle_scatter_valve_lift"]
        < 2e-6
        < 1e-3
        < scatter["cycle_scatter_peak_rocker_contact_force"]
    )
    assert not rattling.failures


def test_a_train_that_repeats_has_no_scatter():
    (found,) = simulate(pushrod("0.1 mm"), engine_speeds=[1000 * RPM], workers=1).solutions
    assert found.status.sentence() == "completed" and found.quantities["motion_period_count"] == 1
    assert not [name for name in found.quantities if name.startswith("cycle_scatter_")]


def test_a_valve_that_floats_does_not_settle():
    (found,) = simulate(
        pushrod("0.56 mm", "0 N m", "massless"), engine_speeds=[8000 * RPM], workers=1
    ).solutions
    assert found.status.code == "not-converged" and "the valve lift by" in found.status.message
    assert (
        found.quantities["cycle_scatter_valve_lift"]
        > STEADY_VALVE * found.quantities["peak_valve_lift"]
    )


def test_scatter_is_the_range_over_plain_cycles():
    """The same cycles run by hand."""
    built = build(pushrod("0.3 mm", model="massless")).members[0].system()
    ready = runner(built, 1500 * RPM, TrainOptions(samples=360))
    found = steady_train(ready, "repeat", cycles=3)
    assert found.status.code == "not-converged"  # three cycles tell nothing of rattle
    state, numbers = steady_train(ready, "repeat", cycles=3, compared=False).start, []
    for _ in range(COMPARED):
        end, record = ready.cycle(state)
        state = replace(end, cam_angle=0.0)
        numbers.append(cycle_numbers(built, record))
    by_hand = {name: float(np.ptp([one[name] for one in numbers])) for name in numbers[0]}
    assert found.scatter.numbers == pytest.approx(by_hand, rel=1e-9, abs=1e-15)


def test_a_train_that_settles_to_no_better_than_asked_is_compared_unless_it_repeats():
    """A rattling one with a wide tolerance: the range of the cycles by hand; one that repeats: none, of two cycles."""
    loose = build(pushrod("0.3 mm", model="massless")).members[0].system()
    ready = runner(loose, 1500 * RPM, TrainOptions(samples=360))
    found = steady_train(ready, "repeat", 1.0, compared=False, least=3, rattling=0.0)
    alone = steady_train(ready, "repeat", 1.0, compared=False, least=3)
    assert found.search.converged and alone.scatter is None
    state, numbers = alone.start, []
    for _ in range(COMPARED):
        end, record = ready.cycle(state)
        state = replace(end, cam_angle=0.0)
        numbers.append(cycle_numbers(loose, record))
    by_hand = {name: float(np.ptp([one[name] for one in numbers])) for name in numbers[0]}
    assert found.scatter.numbers == pytest.approx(by_hand, rel=1e-9, abs=1e-15)
    tight = build(pushrod("0.1 mm")).members[0].system()
    ready = runner(tight, 1000 * RPM, TrainOptions(samples=360))
    assert steady_train(ready, least=3, rattling=0.0).scatter is None


def test_a_bucket_that_rattles_on_its_rod_says_by_how_much():
    """The bucket template with a lash of its own, just below float: a rod had no scatter."""
    text = resources.files("valvetrain").joinpath("templates/direct.toml").read_text("utf-8")
    case = parse_case(text.replace('lash = "0.1 mm"', 'lash = "0.15 mm"'))
    (run,) = simulate(
        case, engine_speeds=[7900 * RPM], models=("finite-element",), spring_sets=("stock",), workers=1
    ).solutions  # fmt: skip
    assert run.status.completed and run.statistics["steady_residual_ratio"] > 1e-4
    assert 1.0 < run.quantities["cycle_scatter_peak_seat_contact_force"] < 300.0
