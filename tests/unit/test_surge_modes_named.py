"""Which modes of a rod are named surge where coils that lie closed weaken one of them."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.cosserat.modes import RodModes

#: Natural frequency (Hz), transmission and axial share of the energy of modes of beehives whose coil 2 lies closed, as the rod gave them.
CLOSED = {
    "mode 3 spread over three": (
        (696, 0.88, 0.92), (736, 0.06, 0.12), (1168, -0.14, 0.58), (1329, -0.6, 0.84), (1612, 0.117, 0.44), (1699, 0.08, 0.46),
        (1777, 0.09, 0.69), (2071, -0.06, 0.39), (2214, -0.11, 0.49), (2705, -0.17, 0.47), (2995, 0.69, 0.65), (3330, 1.03, 0.78),
    ),
    "a strong one above took the place of mode 2": (
        (697, 0.74, 0.79), (735, 0.19, 0.25), (1167, -0.1, 0.56), (1331, -0.65, 0.87), (1615, 0.11, 0.43), (1781, 0.1, 0.64),
        (1877, 0.06, 0.68), (2054, 0.15, 0.18), (2090, -0.11, 0.35), (2236, -0.13, 0.55), (2735, -0.74, 0.49), (2865, 1.62, 0.95),
    ),
}  # fmt: skip
NAMED = {"mode 3 spread over three": [696, 1329, 1612], "a strong one above took the place of mode 2": [697, 1331, 1615]}


def _modes(rows, **changed):
    frequency, transmission, energy = np.array(rows, dtype=float).T
    return RodModes(frequency, np.zeros((len(rows), 2, 3)), transmission, np.zeros(len(rows)), energy, 4e4, **changed)


@pytest.mark.parametrize("name", CLOSED)
def test_a_weak_surge_mode_is_not_passed_over(name):
    """Where its neighbours stood more than one and a half first frequencies apart, a mode near 3 kHz was called the third."""
    modes = _modes(CLOSED[name])
    assert modes.natural_frequency[modes.axial_modes(3)].tolist() == NAMED[name]
    assert modes.axial_modes(2).tolist() == modes.axial_modes(3)[:2].tolist()


def test_modes_a_first_frequency_apart_are_named_by_their_transmission_alone():
    """A spring of even spacing, beside weak modes of both signs that do not count."""
    rows = [(500.0, 0.9, 0.9), (700.0, -0.1, 0.9), (1000.0, -0.9, 0.9), (1200.0, 0.1, 0.9), (1500.0, 0.9, 0.9)]
    assert _modes(rows).axial_modes(3).tolist() == [0, 2, 4]


def test_steps_between_modes_of_a_retainer_that_moves_say_nothing():
    """With a mass on its end the second surge mode stands far above the first."""
    rows = [(100.0, 0.9, 0.9), (240.0, -0.1, 0.9), (300.0, 0.1, 0.9), (520.0, -0.9, 0.9), (1020.0, 0.9, 0.9)]
    assert _modes(rows, retainer_moves=True).axial_modes(3).tolist() == [0, 3, 4]
    assert _modes(rows).axial_modes(3).tolist() == [0, 1, 2]


def test_a_gap_without_any_mode_stays_as_it_is():
    rows = [(500.0, 0.9, 0.9), (1600.0, -0.9, 0.9)]
    assert _modes(rows).axial_modes(3).tolist() == [0, 1]
