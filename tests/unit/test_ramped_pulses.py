"""A ramped law by pulses takes every nose in its range, under a flat tappet that the quintic's own
deceleration would undercut.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import direct
from valvetrain.cam.ramped import ramped
from valvetrain.errors import InputError
from valvetrain.mechanism.build import build_mechanism

EVENTS = {
    "maximum_lift": 9e-3, "ramp_lift": 0.3e-3, "ramp_start": math.radians(90), "event_start": math.radians(115),
    "event_end": math.radians(245), "ramp_end": math.radians(270),
}  # fmt: skip
NOSES = (-0.022, -0.024, -0.026)


@pytest.mark.parametrize("nose", NOSES)
def test_the_nose_is_the_one_asked_for_and_the_largest_deceleration(nose):
    """And lift, rest at the nose and the ramp's velocity at the joint are kept."""
    law = ramped(**EVENTS, flank="pulses", nose_acceleration=nose)
    angle = np.linspace(0, math.tau, 50_001)
    assert (
        float(law.lift(math.pi, 2))
        == pytest.approx(nose, rel=1e-9)
        == pytest.approx(np.min(law.lift(angle, 2)), rel=1e-6)
    )
    assert float(law.lift(math.pi)) == pytest.approx(9e-3, rel=1e-12) and float(
        law.lift(math.pi, 1)
    ) == pytest.approx(0, abs=1e-12)
    velocity = 0.3e-3 / (math.radians(25) * (1 - 0.3 / 2))
    assert law.lift(np.radians([115.0, 245.0]), 1) == pytest.approx([velocity, -velocity], rel=1e-9)


@pytest.mark.parametrize("nose", NOSES)
def test_a_flat_tappet_on_18_mm_takes_noses_that_a_quintic_refuses(nose):
    """Its radius is base radius + lift + lift'': 18 + 9 - 26 mm at least; the quintic reaches -36
    mm/rad^2 before any nose.
    """
    train = direct()
    build_mechanism(train, ramped(**EVENTS, flank="pulses", nose_acceleration=nose))
    with pytest.raises(InputError, match="cusp"):
        build_mechanism(train, ramped(**EVENTS, nose_acceleration=nose))


def test_unequal_ramps_meet_at_one_nose():
    law = ramped(**EVENTS | {"ramp_end": math.radians(290)}, flank="pulses")
    side = math.pi + np.array([-1e-7, 1e-7])
    left, right = law.lift(side, 2)
    assert left == pytest.approx(right, rel=1e-6)


def test_a_nose_out_of_range_is_refused_with_the_range():
    with pytest.raises(InputError, match=r"pulses reach -21.* to -56.* mm/rad"):
        ramped(**EVENTS, flank="pulses", nose_acceleration=-0.005)
