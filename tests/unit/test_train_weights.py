"""Unit: gravity pulls the valve of every train, and the parts of an elastic stem, along the stem."""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import KINDS, LAW
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.train_parts import ValveParameters

MASS, SHARE = 0.08, 0.7
#: Gravity (m/s2) and the direction (rad) in which the valve opens -> pull along it (m/s2), by hand.
PULLS = [
    ((0.0, -9.8), -math.pi / 2, 9.8), ((0.0, -9.8), math.pi / 2, -9.8), ((0.0, -9.8), 0.0, 0.0), ((0.0, 0.0), -math.pi / 2, 0.0),
    ((3.0, -4.0), math.atan2(-4.0, 3.0), 5.0), ((-2.0, 0.0), math.pi, 2.0), ((0.0, -9.8), math.radians(-60), 9.8 * math.sqrt(0.75)),
]  # fmt: skip


#: The cam of a lever pushes one way only: there gravity alone is turned.
CASES = [("direct", *one) for one in PULLS] + [
    (kind, gravity, -math.pi / 2, -gravity[1])
    for kind in KINDS
    for gravity in ((0.0, -9.8), (3.0, 4.0), (-5.0, 0.0))
]


@pytest.mark.parametrize(("kind", "gravity", "opens", "pull"), CASES)
def test_a_valve_is_pulled_by_its_weight_along_its_stem_and_each_of_its_parts_by_its_own(
    kind, gravity, opens, pull
):
    for stem, masses in (
        (None, {"valve": MASS}),
        (2e7, {"valve": SHARE * MASS, "valve tip": (1 - SHARE) * MASS}),
    ):
        valve = ValveParameters(
            MASS, opening_direction=opens, stem_stiffness=stem, head_fraction=SHARE
        )
        made = build_mechanism(KINDS[kind](valve=valve, gravity=gravity), LAW, "tappet")
        found = {
            one.name: (one.mass, one.force)
            for one in made.coordinates
            if one.name.startswith("valve")
        }
        assert set(found) == set(masses)
        for name, mass in masses.items():
            np.testing.assert_allclose(
                found[name], (mass, mass * pull), rtol=1e-12, atol=1e-12, err_msg=name
            )
