"""Limits: a gauge in closed form: step of a second-order system, gain at the cut-off, half-sine
through a first order, any sampling.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.measured.sensor import Sensor


@pytest.mark.parametrize("damping", [0.02, 0.3, 0.99999, 1.0, 1.5])
def test_the_step_of_a_mounted_gauge(damping):
    """Rise of a second-order system after a step: K. Ogata, Modern Control Engineering, 5-3."""
    frequency, time = 10e3, np.linspace(0.0, 4e-4, 4001)
    turn, late = 2 * np.pi * frequency, time - 0.5e-7  # the step rises within one step of the trace
    root = np.sqrt(complex(damping**2 - 1)) * turn
    if damping == 1.0:
        true = 1 - (1 + turn * late) * np.exp(-turn * late)
    else:
        true = np.real(
            1
            - np.exp(-damping * turn * late)
            * (np.cosh(root * late) + damping * turn / root * np.sinh(root * late))
        )
    seen = Sensor(natural_frequency=frequency, damping_ratio=damping).response(
        time, np.ones(4001) * (time > 0)
    )
    np.testing.assert_allclose(seen[2:], true[2:], atol=1e-5)


def test_stiffness_and_mass_are_the_natural_frequency():
    gauge = Sensor(mounting_stiffness="40 N/um", moved_mass="10 g", damping_ratio=0.02)
    assert gauge.resonance == pytest.approx(np.sqrt(40e6 / 0.01) / (2 * np.pi))


@pytest.mark.parametrize("kind", ["butterworth", "bessel"])
@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_the_gain_at_the_cut_off_is_3_db(order, kind):
    gauge = Sensor(bandwidth="20 kHz", order=order, filter=kind)
    time = np.linspace(0.0, 16 / 20e3, 6401)
    for frequency in (5e3, 20e3, 60e3):
        wave = gauge.response(time, np.sin(2 * np.pi * frequency * time), periodic=True)
        gain = np.sqrt(2 * np.mean(wave[:-1] ** 2))
        assert gain == pytest.approx(gauge.gain(np.array([frequency]))[0], abs=2e-4)
        if kind == "butterworth":
            assert gain == pytest.approx(
                1 / np.sqrt(1 + (frequency / 20e3) ** (2 * order)), abs=2e-4
            )
    assert gauge.gain(np.array([20e3]))[0] == pytest.approx(np.sqrt(0.5))


def spike(time, peak=1430.0, duration=0.05e-3):
    """A half sine (N)."""
    return np.where((time > 0) & (time < duration), peak * np.sin(np.pi * time / duration), 0.0)


def test_a_spike_through_a_first_order_is_that_of_the_closed_form():
    """1430 N over 0.05 ms at 20 kHz: y = P / (1 + (W T)^2) (sin W t - W T cos W t + W T exp(-t /
    T)) while it lasts.
    """
    lag, turn = 1 / (2 * np.pi * 20e3), np.pi / 0.05e-3
    time = np.linspace(-0.1e-3, 0.4e-3, 20_001)
    seen = Sensor(bandwidth="20 kHz", order=1).response(time, spike(time))
    during = (time > 0) & (time < 0.05e-3)
    at = time[during]
    true = (
        1430
        / (1 + (turn * lag) ** 2)
        * (np.sin(turn * at) - turn * lag * np.cos(turn * at) + turn * lag * np.exp(-at / lag))
    )
    np.testing.assert_allclose(seen[during], true, atol=0.01)
    assert np.max(seen) == pytest.approx(1289.0, abs=0.1)


def test_forward_and_backward_has_no_delay_and_squares_the_gain():
    gauge = Sensor(bandwidth="20 kHz", order=4, zero_phase=True)
    time = np.linspace(-0.2e-3, 0.25e-3, 9001)
    seen = gauge.response(time, spike(time))
    assert time[np.argmax(seen)] == pytest.approx(0.025e-3, abs=2e-7)
    assert gauge.gain(np.array([20e3]))[0] == pytest.approx(0.5)


@pytest.mark.parametrize("points", [901, 1801, 9001])
def test_the_recorded_peak_does_not_depend_on_the_samples_of_the_model(points):
    """The same spike told by 100, 200 and 1000 points: what is left is how straight lines between
    them miss it (their own peak).
    """
    gauge = Sensor(
        bandwidth="20 kHz", natural_frequency="60 kHz", damping_ratio=0.02, sampling_rate="100 kHz"
    )
    time = np.linspace(-0.2e-3, 0.25e-3, points)
    found = gauge.record(time, spike(time))
    fine = np.linspace(-0.2e-3, 0.25e-3, 45_001)
    true = gauge.record(fine, spike(fine))
    assert found.peaks == pytest.approx(
        true.peaks, rel=2 * (np.pi / 0.05e-3 * (time[1] - time[0])) ** 2 / 8 + 1e-5
    )


def test_the_scatter_of_the_sampling_phase_is_told():
    gauge = Sensor(bandwidth="20 kHz", sampling_rate="50 kHz")
    time = np.linspace(-0.1e-3, 0.4e-3, 20_001)
    low, high = gauge.record(time, spike(time)).peaks
    every = [gauge.record(time, spike(time), phase).peak for phase in np.arange(0, 1, 1 / 7)]
    assert low - 1 <= min(every) and max(every) <= high + 1
    assert 0.7 * high < low < 0.85 * high
    quick = Sensor(bandwidth="20 kHz", sampling_rate="2 MHz").record(time, spike(time)).peaks
    assert quick[1] - quick[0] < 0.3


def test_a_periodic_trace_has_no_begin():
    """The last turn of many is what one turn in the periodic state is."""
    gauge = Sensor(bandwidth="300 Hz", order=3, natural_frequency="900 Hz", damping_ratio=0.05)
    turn = np.linspace(0.0, 0.01, 2001)
    one = np.sin(2 * np.pi * 100 * turn) + 0.3 * np.cos(2 * np.pi * 400 * turn)
    many_turns = np.linspace(0.0, 0.4, 80_001)
    many = gauge.response(
        many_turns,
        np.sin(2 * np.pi * 100 * many_turns) + 0.3 * np.cos(2 * np.pi * 400 * many_turns),
    )
    np.testing.assert_allclose(gauge.response(turn, one, periodic=True), many[-2001:], atol=2e-4)


def test_resolution_rounds_and_an_ideal_gauge_changes_nothing():
    time = np.linspace(0.0, 1e-3, 101)
    values = np.sin(2 * np.pi * 1e3 * time)
    np.testing.assert_array_equal(Sensor().record(time, values).values, values)
    assert set(np.round(Sensor(resolution=0.5).record(time, values).values * 2) / 2) <= {
        -1.0,
        -0.5,
        0.0,
        0.5,
        1.0,
    }


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"bandwidth": "0 Hz"}, "is none of a gauge"),
        ({"order": 9}, "order is a whole number from 1 to 8"),
        ({"order": True}, "order is"),
        ({"filter": "x"}, "butterworth or bessel"),
        ({"moved_mass": 1.0}, "belong together"),
        ({"damping_ratio": -1}, "damping_ratio is"),
        ({"natural_frequency": 1e4}, "rings for ever"),
        ({"natural_frequency": 1e4, "mounting_stiffness": 1e6, "moved_mass": 0.1}, "not both"),
        ({"bandwidth": "2 N"}, "a frequency"),
    ],
)
def test_what_is_no_gauge_is_one_sentence(given, words):
    with pytest.raises(InputError, match=words):
        Sensor(**given)


@pytest.mark.parametrize(
    ("time", "values", "words"),
    [
        ([0, 1, 1], [0, 0, 0], "times rising"),
        ([0], [0], "two points"),
        ([0, 1], [0, np.nan], "finite"),
        ([0, 1e9], [0, 1], "steps"),
    ],
)
def test_what_is_no_trace_is_one_sentence(time, values, words):
    with pytest.raises(InputError, match=words):
        Sensor(bandwidth="20 kHz").response(
            np.array(time, dtype=float), np.array(values, dtype=float)
        )


@pytest.mark.parametrize(
    ("order", "sum_of_damping"), [(1, 1.0), (2, 2.0**0.5), (4, 2.613125929752753)]
)
def test_a_causal_gauge_is_late_by_the_delay_of_its_filter(order, sum_of_damping):
    """A ramp is late by the first coefficient of the Butterworth polynomial over 2 pi times the
    bandwidth: 0.46 ms of order 4 at 900 Hz.
    """
    time = np.linspace(0.0, 0.05, 50_001)
    seen = Sensor(bandwidth=900.0, order=order).record(time, 1000.0 * time)
    assert time[-1] - seen.values[-1] / 1000.0 == pytest.approx(
        sum_of_damping / (2 * np.pi * 900.0), rel=1e-6
    )
