"""The force of the gas between the angles at which it is given."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.mechanism.contour import monotone_table
from valvetrain.mechanism.gaps import table_value

FINE = np.linspace(0, 2 * np.pi, 14_401)


def force_at(cam_angles, forces):
    table = monotone_table(np.asarray(cam_angles), np.asarray(forces))[None]
    return np.array([table_value(table, 0, angle)[0] for angle in FINE])


def test_a_pulse_of_gas_does_not_swing_beyond_the_forces_given():
    """0, 0, -800, -200, 0, 0 N: a cubic spline through them swings from -2127 to +3392 N."""
    degrees = np.array([0.0, 100.0, 105.0, 112.0, 117.0, 200.0])
    found = force_at(np.radians(degrees), [0.0, 0.0, -800.0, -200.0, 0.0, 0.0])
    assert found.min() == pytest.approx(-800.0, abs=1e-6) and found.max() <= 1e-9
    assert np.all(np.abs(found[(np.degrees(FINE) < 100) | (np.degrees(FINE) > 117)]) < 1e-9)


def test_the_force_passes_through_what_is_given_and_is_the_monotone_cubic():
    """Closed form: between two equal steps of the same sign the slope is their harmonic mean; next
    to a level it is zero.
    """
    angles = np.radians([0.0, 90.0, 180.0, 270.0])
    found = force_at(angles, [0.0, 100.0, 400.0, 400.0])
    at = {
        round(float(degree), 3): value
        for degree, value in zip(np.degrees(FINE), found, strict=True)
    }
    assert [at[degree] for degree in (0.0, 90.0, 180.0, 270.0)] == pytest.approx(
        [0.0, 100.0, 400.0, 400.0], abs=1e-6
    )
    slope = 2 / (1 / 100 + 1 / 300)  # N per quarter turn, at 90 degrees
    assert at[135.0] == pytest.approx((100 + 400) / 2 + slope / 8, abs=1e-3)
    assert at[225.0] == pytest.approx(400.0, abs=1e-6)
