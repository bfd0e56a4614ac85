"""Limits: a gauge in closed form: step of a second-order system, gain at the cut-off, half-sine
through a first order.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from valvetrain.errors import InputError
from valvetrain.measured.sensor import Sensor


@pytest.mark.parametrize("damping", [0.02, 0.3, 0.99999, 1.0, 1.5])
def test_the_step_of_a_mounted_gauge(damping):
    """Rise of a second-order system after a step: K. Ogata, Modern Control Engineering, 5-3. The cycle rests for 12 ms first."""
    frequency, cycle = 10e3, np.linspace(-12e-3, 12e-3, 240_001)
    shown = slice(120_000, 124_001)
    time = cycle[shown]
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
    gauge = Sensor(natural_frequency=frequency, damping_ratio=damping)
    seen = gauge.response(cycle, 1.0 * (cycle > 0))[shown]
    np.testing.assert_allclose(seen[2:], true[2:], atol=1e-5)


@pytest.mark.parametrize("kind", ["butterworth", "bessel"])
@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_the_gain_at_the_cut_off_is_3_db(order, kind):
    gauge = Sensor(bandwidth="20 kHz", order=order, filter=kind)
    time = np.linspace(0.0, 16 / 20e3, 6401)
    poles = signal.bessel(order, 2 * np.pi * 20e3, analog=True, norm="mag")
    for frequency in (5e3, 20e3, 60e3):
        wave = gauge.response(time, np.sin(2 * np.pi * frequency * time))
        gain = 1 / np.sqrt(1 + (frequency / 20e3) ** (2 * order))
        if kind == "bessel":
            gain = float(np.abs(signal.freqs(*poles, [2 * np.pi * frequency])[1][0]))
        assert np.sqrt(2 * np.mean(wave[:-1] ** 2)) == pytest.approx(gain, abs=2e-4)
        assert frequency != 20e3 or gain == pytest.approx(np.sqrt(0.5))


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
    tone = np.linspace(0.0, 32 / 20e3, 12_801)
    wave = gauge.response(tone, np.sin(2 * np.pi * 20e3 * tone))
    assert np.sqrt(2 * np.mean(wave[:-1] ** 2)) == pytest.approx(0.5, abs=2e-4)


def test_a_gauge_without_parts_shows_the_trace():
    turn = np.linspace(0.0, 0.01, 501)
    force = np.sin(2 * np.pi * 100 * turn)
    np.testing.assert_array_equal(Sensor().response(turn, force), force)


def test_the_mean_of_a_cycle_passes_and_its_begin_does_not_matter():
    gauge = Sensor(bandwidth="300 Hz", order=3, natural_frequency="900 Hz", damping_ratio=0.05)
    turn = np.linspace(0.0, 0.01, 2001)
    one = 5 + np.sin(2 * np.pi * 100 * turn) + 0.3 * np.cos(2 * np.pi * 400 * turn)
    seen, later = gauge.response(turn, one)[:-1], np.roll(one[:-1], 700)
    assert np.mean(seen) == pytest.approx(5.0, abs=1e-9)
    again = gauge.response(turn, np.append(later, later[0]))[:-1]
    np.testing.assert_allclose(again, np.roll(seen, 700), atol=1e-9)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"bandwidth": "0 Hz"}, "too small"),
        ({"order": 9}, "less than or equal to 8"),
        ({"filter": "x"}, "not among"),
        ({"damping_ratio": -1}, "damping_ratio of the gauge"),
        ({"natural_frequency": 1e4}, "rings for ever"),
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
    bandwidth: 0.46 ms of order 4 at 900 Hz. Here it is half of a triangle.
    """
    time = np.linspace(0.0, 0.1, 100_001)
    seen = Sensor(bandwidth=900.0, order=order).response(
        time, 1000.0 * np.minimum(time, 0.1 - time)
    )
    assert time[40_000] - seen[40_000] / 1000.0 == pytest.approx(
        sum_of_damping / (2 * np.pi * 900.0), rel=1e-6
    )
