"""Closed form: a pulse of known width read at samples of 0.5 cam degrees, as the beehive's source
reads: median and range over the phase of the samples, width, impulse.
"""

from __future__ import annotations

import numpy as np
import pytest

from synthetic_spring import beehive_reader, bump, run
from valvetrain.quantities.compare import compare
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import Quantity

FOOT, HEIGHT, PLACE, SUBSTEPS = 300.0, 1000.0, 254.6, 20
SPEED = 8000 * np.pi / 30


def pulsed(half_width: float, per_turn: int = 720):
    """Reader of two turns with a triangular pulse of a half width in cam degrees, known at 20 substeps."""
    angle = np.arange(2 * per_turn) * 360.0 / per_turn
    fine = (angle[:, None] + np.arange(SUBSTEPS) * 360.0 / per_turn / SUBSTEPS) % 360
    force = FOOT + 400 * bump(fine, 180, 100)
    force += HEIGHT * np.maximum(0.0, 1 - np.abs(fine - PLACE) / half_width)
    extra = {"seat_force_fine": (("subsample",), "N", "seat force between the samples")}
    values = {"seat_force": force[:, 0], "seat_force_fine": force}
    return beehive_reader(run(values, per_turn=per_turn, engine_speed=SPEED, extra=extra))


@pytest.mark.parametrize("half_width", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("per_turn", [720, 360])
def test_the_median_of_samples_of_a_triangle_over_their_phase(half_width, per_turn):
    """The nearest sample lies 0 to 0.25 degrees from the top, evenly: the largest sample is between
    1 - 0.25 / w and 1 of the height, 1 - 0.125 / w in the median, w the half width; whatever the
    output step of the run.
    """
    found = pulsed(half_width, per_turn).found
    share = 0.6 * HEIGHT * 0.05 / half_width  # what one phase of the record is worth
    for name, part in (("", 0.125), ("least_sampled_", 0.25), ("largest_sampled_", 0.0)):
        expected = FOOT + HEIGHT * (1 - part / half_width)
        assert found[f"stage_3_{name}peak_force"] == pytest.approx(expected, abs=share), name
    assert np.degrees(found["stage_3_peak_cam_angle"]) == pytest.approx(PLACE, abs=0.25)
    assert found["stage_3_every_instant_peak_force"] >= found["stage_3_largest_sampled_peak_force"]


def test_a_run_no_finer_than_the_source_has_its_own_samples():
    reader = beehive_reader(run({"seat_force": lambda degrees: FOOT + bump(degrees, 254.6, 3)}))
    assert not reader.phases and "stage_3_least_sampled_peak_force" not in reader.found
    assert reader.found["stage_3_peak_force"] == np.max(reader.cycle.channel("seat_force"))


TALL, WIDE = 2000.0, 500.0


def bimodal():
    """Two turns with a tall pulse that half of all half-degree samples miss and a lower one that none
    does, recorded at ten places to a sample and, finer, at fifty.
    """
    angle = np.arange(2 * 720) / 2

    def force(places):
        at = (angle[:, None] + np.arange(places) / places / 2) % 360
        tall = TALL * np.maximum(0.0, 1 - np.abs(at - 248.1) / 0.125)
        return FOOT + 400 * bump(at, 180, 100) + tall + WIDE * bump(at, 253.7, 3)

    extra = {
        "seat_force_fine": (("subsample",), "N", "seat force between the samples"),
        "seat_force_finest": (("fine_subsample",), "N", "the same at fifty places"),
    }
    values = {"seat_force": force(1)[:, 0], "seat_force_fine": force(10), "seat_force_finest": force(50)}  # fmt: skip
    return beehive_reader(run(values, engine_speed=SPEED, extra=extra))


@pytest.mark.parametrize("level", [900.0, 1300.0, 1800.0])
def test_a_comparison_with_samples_has_their_range_and_the_share_at_or_above_it(level):
    """Closed form: a triangle of half width w reaches a share 2 w (1 - rise / height) / 0.5 of all
    phases; in the others the lower pulse is read.
    """
    read = bimodal().phases
    published = [
        PublishedValue("stage_3_peak_force", level, "N", engine_speed=SPEED, model="m"),
        PublishedValue("preload", 300.0, "N", model="m"),
    ]
    computed = {Quantity("stage_3_peak_force", SPEED, "m"): 800.0, Quantity("preload"): 300.0}
    by_phase = {Quantity(name, SPEED, "m"): values for name, values in read.items()}
    spike, rest = compare(published, computed, None, (), by_phase)
    assert rest.samples is None and spike.samples is not None
    assert spike.samples.phases >= 50
    # the worst sample of the lower pulse is a quarter of a degree off its top
    lowest = FOOT + WIDE * np.cos(np.pi * 0.25 / 3) ** 2
    assert spike.samples.low == pytest.approx(lowest, rel=1e-3)
    assert spike.samples.high == pytest.approx(FOOT + TALL, rel=0.05)
    reach = 0.5 * (1 - (level - FOOT) / TALL)
    assert spike.samples.share == pytest.approx(reach, abs=1.5 / spike.samples.phases)


def test_the_angle_of_a_spike_is_that_of_a_collision_and_not_between_two():
    reader = bimodal()
    found, places = reader.found, np.degrees(reader.phases["stage_3_peak_cam_angle"])
    assert np.ptp(places) > 5
    assert np.min(np.abs(places - np.degrees(found["stage_3_peak_cam_angle"]))) < 1e-9
