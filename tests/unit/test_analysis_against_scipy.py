"""Peaks and the zero-phase filter against scipy.signal, which the package itself does not load."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from valvetrain.quantities.signal import FILTER_ORDER, low_pass, prominences, prominent_peaks


@pytest.mark.parametrize("size", [3, 5, 50, 721])
@pytest.mark.parametrize("flat", [False, True])
def test_peaks_and_prominences_are_those_of_scipy(size, flat):
    generator = np.random.default_rng(size)
    found = 0
    for _ in range(20):
        walk = np.cumsum(generator.standard_normal(size))
        values = np.round(walk) if flat else walk
        expected = signal.find_peaks(values, prominence=1.0)[0]
        found += len(expected)
        assert np.array_equal(prominent_peaks(values, 1.0), expected)
        peaks = signal.find_peaks(values)[0]
        np.testing.assert_allclose(
            prominences(values, peaks), signal.peak_prominences(values, peaks)[0]
        )
    assert found > 0 or size < 5


@pytest.mark.parametrize("cutoff", [2e3, 10e3, 20e3])
def test_low_pass_is_the_butterworth_filter_run_forward_and_backward(cutoff):
    time = 4e-6 * np.arange(3600)
    noise = np.random.default_rng(2).standard_normal(len(time))
    values = (
        300
        + 200 * np.sin(2 * np.pi * 400 * time)
        + 900 * np.exp(-(((time - 7e-3) / 3e-5) ** 2))
        + noise
    )
    nyquist = 0.5 / 4e-6
    stages = signal.butter(FILTER_ORDER, cutoff / nyquist, output="sos")
    expected = signal.sosfiltfilt(stages, values, padlen=int(np.ceil(20 * nyquist / cutoff)))
    np.testing.assert_allclose(low_pass(time, values, cutoff), expected, atol=1e-6)
