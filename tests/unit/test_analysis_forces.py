"""Stages, cycles and filters on signals whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from synthetic_spring import beehive_reader, bump, run
from valvetrain.errors import InputError
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.signal import filtered_force, low_pass

DEG = np.pi / 180


def _force(degrees):
    first = 30 * bump(degrees, 12, 20) + 30 * bump(degrees, 42, 20) + 40 * bump(degrees, 84.5, 20)
    event = 640 * bump(degrees, 160, 60) + 900 * bump(degrees, 190, 50)
    return 280 + first + event + 500 * bump(degrees, 254.5, 4) + 200 * bump(degrees, 297, 4)


def test_falling_flank_is_no_spike_and_one_hump_has_no_valley():
    def force(degrees):
        return 280 + 600 * bump(degrees, 180, 130) + 20 * bump(degrees, 300, 30)

    found = beehive_reader(run({"seat_force": force})).found
    assert found["stage_2_end_force"] > 315
    assert (found["stage_3_peak_force"], found["stage_3_peak_cam_angle"] / DEG) == pytest.approx(
        (300.0, 300.0)
    )
    assert "stage_2_valley_force" not in found


def test_a_peak_at_the_seam_of_the_cycle_counts_once():
    def force(degrees):
        return 300 + 10 * np.cos(3 * degrees * DEG)

    found = beehive_reader(run({"seat_force": force})).found
    assert [
        value / DEG for name, value in found.items() if name.startswith("stage_1_peak")
    ] == pytest.approx([0, 120])


def test_an_aborted_run_gives_only_what_it_covers():
    whole = run({"seat_force": _force}, turns=1)
    cut = type(whole)(whole.channels.isel(sample=slice(0, 300)), provenance=whole.provenance)
    cycle = reported_cycle(cut)
    assert not cycle.whole
    found = beehive_reader(cut).found
    assert "stage_1_maximum_force" in found and not any(
        name.startswith("stage_2") for name in found
    )


def test_last_whole_turn_is_reported():
    turn = np.repeat([1.0, 2.0, 3.0], 720)
    solution = run({"seat_force": turn}, turns=3)
    assert np.all(reported_cycle(solution).channel("seat_force") == 3.0)
    ended = type(solution)(
        solution.channels.isel(sample=slice(0, 2000)), provenance=solution.provenance
    )
    cycle = reported_cycle(ended)
    assert cycle.whole and np.all(cycle.channel("seat_force") == 2.0)
    assert cycle.cam_angle[0] == 0 and len(cycle.cam_angle) == 720


def test_filter_refuses_what_it_cannot_do():
    time = np.arange(100) * 1e-4
    with pytest.raises(InputError, match="10 kHz"):
        low_pass(time, time, 10e3)
    with pytest.raises(InputError, match="evenly"):
        low_pass(time**2, time, 1e3)
    assert filtered_force(run({"seat_force": _force}, per_turn=72), 10e3) is None


def test_filter_of_a_closed_period_sees_its_end_before_its_beginning():
    time = np.arange(2000) * 1e-5
    wave = np.exp(-(((time - 0.5 * time[-1]) / 3e-4) ** 2))
    middle = low_pass(time, wave, 2e3, closed=True)
    at_the_seam = low_pass(time, np.roll(wave, 1000), 2e3, closed=True)
    np.testing.assert_allclose(np.roll(middle, 1000), at_the_seam, atol=1e-12)
