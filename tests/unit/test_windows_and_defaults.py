"""Edges of what is taken and values of what is left out, each written down once more by hand."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.installed_spring import DampingParameters
from valvetrain.units import si
from valvetrain.units.inputs import PLAUSIBLE

#: Quantity -> SI value of its usual unit, the unit, and the least and largest plausible value in
#: it.
WINDOWS = {
    "wire_diameter": (1e-3, "mm", 0.2, 20), "mean_diameter": (1e-3, "mm", 3, 200), "pitch": (1e-3, "mm", 0.2, 100),
    "spring_length": (1e-3, "mm", 3, 1000), "compression": (1e-3, "mm", 0, 500), "valve_lift": (1e-3, "mm", 1e-6, 100),
    "engine_speed": (np.pi / 30, "rpm", 10, 30000), "cam_speed": (np.pi / 30, "rpm", 5, 15000),
    "cam_angle": (np.pi / 180, "deg", 1e-9 * 180 / np.pi, 1440), "spring_rate": (1e3, "N/mm", 0.1, 5000),
    "modulus": (1e9, "GPa", 0.1, 2000),
    "density": (1.0, "kg/m^3", 100, 100000), "mass": (1e-3, "g", 1e-3, 20000), "moving_mass": (1e-3, "g", 1e-9, 1e15),
}  # fmt: skip


@pytest.mark.parametrize("name", PLAUSIBLE)
def test_a_value_in_its_usual_unit_is_believed_and_doubted_outside_its_window(name):
    assert name in WINDOWS, "write down the window of the new quantity"
    scale, unit, low, high = WINDOWS[name]
    for value in (1.01 * low, 0.99 * high):
        assert si(f"{value!r} {unit}", name, "the value") == pytest.approx(value * scale)
    for value in (*([0.9 * low] if low else []), 1.1 * high):
        with pytest.warns(UnusualValueWarning, match="the value"):
            assert si(f"{value!r} {unit}", name, "the value") == pytest.approx(value * scale)
        with pytest.raises(InputError, match="the value"):
            si(value * scale, name, "the value")
    assert PLAUSIBLE[name].default_unit == unit


def test_a_damping_is_changed_by_its_ratio_or_by_its_coefficients():
    """Half of the ratio from each at 600 Hz; a coefficient given by itself stands alone, and the
    other of the two stays.
    """
    both = DampingParameters(ratio=0.016, ratio_frequency=600.0)
    turning = 2 * np.pi * 600
    assert (both.mass_damping, both.stiffness_damping) == pytest.approx(
        (0.016 * turning, 0.016 / turning)
    )
    stiffer = both.replace(ratio=0.032)
    assert (stiffer.mass_damping, stiffer.stiffness_damping) == pytest.approx(
        (0.032 * turning, 0.032 / turning)
    )
    alone = both.replace(mass_damping=10.0)
    assert (alone.ratio, alone.mass_damping) == (
        None,
        10.0,
    ) and alone.stiffness_damping == pytest.approx(0.016 / turning)
    assert both.ratio_at(600.0) == pytest.approx(0.016)
