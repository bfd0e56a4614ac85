"""Closed form: a pulse of known width read at samples of 0.5 cam degrees, as the beehive's source
reads: median and range over the phase of the samples, width, impulse.
"""

from __future__ import annotations

import numpy as np
import pytest

from synthetic_spring import EVENT, bump, run
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.sources.gu2021_reading import SAMPLE, half_height, sampled
from valvetrain.sources.gu2021_stages import stage_quantities

FOOT, HEIGHT, PLACE, SUBSTEPS = 300.0, 1000.0, 254.6, 20
SPEED = 8000 * np.pi / 30


def pulsed(half_width: float, per_turn: int = 720):
    """Two turns with a triangular pulse of a half width in cam degrees, known at 20 substeps."""
    angle = np.arange(2 * per_turn) * 360.0 / per_turn
    fine = (angle[:, None] + np.arange(SUBSTEPS) * 360.0 / per_turn / SUBSTEPS) % 360
    force = FOOT + 400 * bump(fine, 180, 100)
    force += HEIGHT * np.maximum(0.0, 1 - np.abs(fine - PLACE) / half_width)
    extra = {"seat_force_fine": (("subsample",), "N", "seat force between the samples")}
    values = {"seat_force": force[:, 0], "seat_force_fine": force}
    return reported_cycle(run(values, per_turn=per_turn, engine_speed=SPEED, extra=extra))


@pytest.mark.parametrize("half_width", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("per_turn", [720, 360])
def test_the_median_of_samples_of_a_triangle_over_their_phase(half_width, per_turn):
    """The nearest sample lies 0 to 0.25 degrees from the top, evenly: the largest sample is between
    1 - 0.25 / w and 1 of the height, 1 - 0.125 / w in the median, w the half width; whatever the
    output step of the run.
    """
    found = stage_quantities(pulsed(half_width, per_turn), np.radians(10), EVENT)
    share = 0.6 * HEIGHT * 0.05 / half_width  # what one phase of the record is worth
    for name, part in (("", 0.125), ("least_sampled_", 0.25), ("largest_sampled_", 0.0)):
        expected = FOOT + HEIGHT * (1 - part / half_width)
        assert found[f"stage_3_{name}peak_force"] == pytest.approx(expected, abs=share), name
    assert np.degrees(found["stage_3_peak_cam_angle"]) == pytest.approx(PLACE, abs=0.25)
    assert found["stage_3_every_instant_peak_force"] >= found["stage_3_largest_sampled_peak_force"]


@pytest.mark.parametrize("half_width", [0.5, 1.0, 2.0])
def test_width_and_impulse_of_the_pulse(half_width):
    """At half its height a triangle is as wide as its half width; its area is that times its height."""
    found = stage_quantities(pulsed(half_width), np.radians(10), EVENT)
    time = np.radians(half_width) / (SPEED / 2)
    assert found["stage_3_peak_duration"] == pytest.approx(time, rel=0.02)
    assert found["stage_3_peak_impulse"] == pytest.approx(HEIGHT * time, rel=0.02)


def test_a_run_no_finer_than_the_source_has_its_own_samples():
    cycle = reported_cycle(run({"seat_force": lambda degrees: FOOT + bump(degrees, 254.6, 3)}))
    read = sampled(cycle)
    assert read.force.shape == (1, 720) and np.array_equal(
        read.force[0], cycle.channel("seat_force")
    )
    assert "stage_3_least_sampled_peak_force" not in stage_quantities(cycle, 0.2, EVENT)


def test_samples_stand_every_half_degree_at_each_phase_of_the_record():
    read = sampled(pulsed(1.0))
    assert read.force.shape[0] == SUBSTEPS
    assert np.allclose(np.diff(read.cam_angle, axis=1), SAMPLE)
    assert np.allclose(np.diff(read.cam_angle[:, 0]), SAMPLE / SUBSTEPS)


def test_a_spike_at_the_edge_of_the_record_keeps_what_is_there():
    angle = np.linspace(0, 1, 1001)
    width, area = half_height(angle, np.maximum(0.0, 1 - angle / 0.1), 0, 0.5)
    assert (width, area) == (pytest.approx(0.05, rel=0.02), pytest.approx(0.05, rel=0.02))
