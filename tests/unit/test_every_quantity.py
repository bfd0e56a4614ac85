"""Every quantity of the tables has a value known from a formula, a hand calculation or another program, and is held to it."""

from __future__ import annotations

import numpy as np
import pytest

from known_quantities import DEG, GROUPS
from valvetrain.solution.definition import pattern_of, tables

#: Held to known values elsewhere: the lift law's by the answers of the command line.
ELSEWHERE = {"maximum_lift", "maximum_lift_cam_angle"}


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.__name__)
def test_values_are_the_known_ones(group):
    found, known = group()
    assert not sorted(set(known) - set(found))
    wrong = {}
    for name, value in known.items():
        expected, within = value if isinstance(value, tuple) else (value, 1e-6 * abs(value) + 1e-15)
        if not abs(found[name] - expected) <= within:
            wrong[name] = (found[name], expected)
    assert not wrong


def test_no_quantity_is_without_a_known_value():
    known = {name for group in GROUPS for name in group()[1]} | ELSEWHERE
    rows = [one.name for table in tables().values() for one in table]
    assert not [row for row in rows if not any(pattern_of(row).fullmatch(name) for name in known)]


def test_the_known_values_of_a_group_are_all_different():
    """Two alike would let one quantity be shown for the other."""
    for group in GROUPS:
        values = [value[0] if isinstance(value, tuple) else value for value in group()[1].values()]
        same = len(values) - len(np.unique(np.round(np.array(values), 12)))
        assert same <= 8, group.__name__


def test_a_study_of_trains_tells_the_rigid_numbers_of_each_spring_set():
    """The study's own numbers are those of rigid theory: lift of its rigid channel, contact lost where the least contact force is nil."""
    from valvetrain.parameters.loading import load_case
    from valvetrain.studies.run import run_study

    done = run_study(load_case("job-t"), engine_speeds=(200.0,), spring_models=("massless",))
    run, numbers = done.solutions[0], next(one for one in done.still.values() if "rigid_maximum_valve_lift" in one)
    assert numbers["rigid_maximum_valve_lift"] == pytest.approx(np.max(run.channel("rigid_valve_lift")), rel=1e-4)
    speed = numbers["rigid_contact_loss_engine_speed"]
    lost = run_study(load_case("job-t"), engine_speeds=(0.98 * speed, 1.02 * speed), spring_models=("massless",)).solutions
    opened = [one.channel("rigid_valve_lift") > 1e-5 for one in lost]
    least = [float(np.min(one.channel("rigid_contact_force")[mask])) for one, mask in zip(lost, opened, strict=True)]
    assert least[1] < 0 < least[0]
    angle = lost[1].cam_angle[opened[1]][int(np.argmin(lost[1].channel("rigid_contact_force")[opened[1]]))]
    assert abs(angle - numbers["rigid_contact_loss_cam_angle"]) < 3 * DEG
