"""Every quantity of the tables has a value known from a formula, a hand calculation or another
program, and is held to it.
"""

from __future__ import annotations

import numpy as np
import pytest

from known_buckling import buckling
from known_quantities import DEG
from known_quantities import GROUPS as MOST
from known_sources import SOURCE_GROUPS
from valvetrain.quantities.table import CAM
from valvetrain.solution.definition import pattern_of, tables

GROUPS = (*MOST, *SOURCE_GROUPS, buckling)
#: Held to known values elsewhere: the lift law's by the answers of the command line.
ELSEWHERE = {
    "maximum_lift",
    "maximum_lift_cam_angle",
    "peak_cam_contact_pressure",
    "driver_difference_force",  # to its channels, by tests/limits/test_solid_in_train.py
    "closing_ramp_begin_cam_angle", "closing_ramp_end_cam_angle",  # by tests/unit/test_red_line.py
    # by tests/limits/test_valve_events.py
    *(f"{event}_{at}_crank_angle" for event in ("ivo", "ivc", "evo", "evc") for at in ("lash", "1_mm", "50_thou")),
    "lift_harmonic_9_lift", "surge_half_duration",  # by tests/unit/test_findings_at_rest.py
    *(one.name for one in CAM),  # by tests/unit/test_check_of_the_cam.py
}  # fmt: skip


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
    """The study's own numbers are those of rigid theory: lift of its rigid channel, contact lost
    where the least contact force is nil.
    """
    from valvetrain.parameters.loading import load_case
    from valvetrain.runs.api import simulate

    done = simulate(load_case("vaz-ohc"), engine_speeds=(150.0, 300.0), models=("massless",))
    (slow, fast), (numbers, *_) = done.solutions, done.still.values()
    lift = slow.channel("rigid_valve_lift")
    assert numbers["rigid_maximum_valve_lift"] == pytest.approx(np.max(lift), rel=1e-4)
    at_150, at_300 = (run.channel("rigid_contact_force")[lift > 1e-5] for run in (slow, fast))
    inertia = (at_300 - at_150) / (300.0**2 - 150.0**2)  # per engine speed squared
    falling = np.flatnonzero(inertia < 0)
    squares = (150.0**2 - at_150 / inertia)[falling]
    assert numbers["rigid_contact_loss_engine_speed"] == pytest.approx(
        np.sqrt(squares.min()), rel=0.01
    )
    angle = slow.cam_angle[lift > 1e-5][falling][int(np.argmin(squares))]
    assert abs(angle - numbers["rigid_contact_loss_cam_angle"]) < 2 * DEG
