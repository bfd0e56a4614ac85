"""Peak velocity, acceleration and jerk of the classical flanks against the factors printed in cam
design handbooks.

Factors of a unit rise over a unit flank, as tabulated by Norton, "Cam Design and Manufacturing
Handbook" (2009), and Rothbart, "Cam Design
Handbook" (2004); those of cycloidal, harmonic, 3-4-5 and 4-5-6-7 also follow by hand from the
closed forms.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from valvetrain.cam.closed_form import Cycloidal, Harmonic, ModifiedSine, Polynomial
from valvetrain.cam.modified_trapezoid import ModifiedTrapezoid
from valvetrain.cam.polydyne import Polydyne

EVENTS = {
    "maximum_lift": 0.008,
    "opening_start": 1.0,
    "opening_end": 2.2,
    "closing_start": 2.4,
    "closing_end": 4.0,
}
FACTORS = [
    (Cycloidal(**EVENTS), (2.0, 2 * math.pi, 4 * math.pi**2), 1e-6),
    (Harmonic(**EVENTS), (math.pi / 2, math.pi**2 / 2, math.pi**3 / 2), 1e-6),
    (Polynomial(**EVENTS, exponents=(3, 4, 5)), (1.875, 10 / math.sqrt(3), 60.0), 1e-6),
    (Polynomial(**EVENTS, exponents=(4, 5, 6, 7)), (2.1875, 84 / (5 * math.sqrt(5)), 52.5), 1e-6),
    (ModifiedSine(**EVENTS), (1.7596, 5.5280, 69.466), 1e-4),
    (ModifiedTrapezoid(**EVENTS), (2.0, 4.888, 61.43), 1e-4),
    (
        ModifiedTrapezoid(**EVENTS),
        (2.0, 8 * math.pi / (2 + math.pi), 32 * math.pi**2 / (2 + math.pi)),
        1e-6,
    ),
]


@pytest.mark.parametrize(
    ("law", "factors", "tolerance"), FACTORS, ids=lambda value: type(value).__name__
)
@pytest.mark.parametrize(
    ("start", "end"), [("opening_start", "opening_end"), ("closing_start", "closing_end")]
)
def test_peak_factors(law, factors, tolerance, start, end):
    flank = EVENTS[end] - EVENTS[start]
    angle = EVENTS[start] + flank * np.linspace(1e-9, 1 - 1e-9, 40_001)
    for derivative, factor in enumerate(factors, start=1):
        peak = (
            np.max(np.abs(law.lift(angle, derivative))) * flank**derivative / EVENTS["maximum_lift"]
        )
        assert peak == pytest.approx(factor, rel=tolerance)


@pytest.mark.parametrize(
    ("exponents", "printed"),
    [
        ((3, 4, 5), (10, -15, 6)),
        ((4, 5, 6, 7), (35, -84, 70, -20)),
        ((5, 6, 7, 8, 9), (126, -420, 540, -315, 70)),
    ],
)
def test_polynomial_factors(exponents, printed):
    from valvetrain.cam.flanks import rise_factors

    assert rise_factors(exponents) == pytest.approx(printed, rel=1e-14)


def test_polydyne_cam_gives_the_valve_its_polynomial():
    # A mass on an elastic train driven by the cam s: m w^2 y'' + k y = k s. Solve it for the valve
    # y by Fourier series; the deflection
    # is chosen so that no harmonic is in resonance (that of order 49.6).
    deflection, count = 4.07e-4, 4096
    law = Polydyne(
        maximum_lift=0.01, opening_start=2.0, closing_end=4.4, dynamic_deflection=deflection
    )
    valve = Polydyne(maximum_lift=0.01, opening_start=2.0, closing_end=4.4)
    angle = 2 * np.pi * np.arange(count) / count
    order = np.fft.rfftfreq(count, 1 / count)
    response = np.fft.irfft(np.fft.rfft(law.lift(angle)) / (1 - deflection * order**2), count)
    assert response == pytest.approx(valve.lift(angle), abs=2e-8)
