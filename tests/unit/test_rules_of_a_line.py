"""Unit: rules of one line, each against what it says by hand; a larger test would not tell whether
they are followed.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.rig.channels import RigQuantity
from valvetrain.rig.cutting import CycleGrid, grid_of, set_to_zero
from valvetrain.rig.shaft import ShaftAngle
from valvetrain.runs.refine import refined
from valvetrain.runs.refine_variants import with_constant


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_more_damping_of_a_restitution_is_the_restitution_of_more_damping(factor):
    """Hunt and Crossley's damping number d of a rebound e: d (1 + e) = ln((1 + d) / (1 - e d));
    damped ``factor`` times as much.
    """

    def number(e: float) -> float:
        return brentq(lambda d: d * (1 + e) - np.log((1 + d) / (1 - e * d)), 1e-6, (1 - 1e-9) / e)

    contact = ContactParameters(
        "hunt-crossley", {"contact_stiffness": 1e9, "exponent": 1.5, "restitution": 0.7}
    )
    changed = with_constant(contact, "damping", factor).values["restitution"]
    assert number(changed) == pytest.approx(factor * number(0.7), rel=1e-3)
    assert (changed < 0.7) is (factor > 1)


def test_a_dwell_is_looked_for_from_the_first_sample_on():
    """Samples begin at 0.5 s; the dwells, from 1 to 1.2 s and from 2 to 2.2 s, stand 3 and 5 above
    zero, all else far away.
    """
    times = 0.5 + 0.01 * np.arange(300)
    values = np.full(300, 100.0)
    for first, level in ((1.0, 3.0), (2.0, 5.0)):
        values[(times > first - 0.005) & (times < first + 0.205)] = level
    grid = CycleGrid(
        np.zeros(2), np.array([0.5, 2.5]), np.array([[1.1, 1.6], [2.1, 2.4]]), np.ones(2)
    )
    edges = np.array([[1.0, 1.2], [2.0, 2.2]])
    found, zero = set_to_zero(
        np.full((2, 2), 10.0),
        RigQuantity("spring_force", "N", values, 0.5, 0.01, "a"),
        grid,
        edges,
        0.0,
    )
    assert zero == pytest.approx([3.0, 5.0])
    assert found == pytest.approx(np.array([[7.0, 6.0], [5.0, 5.0]]))


def test_cycles_of_a_steady_shaft_have_its_speed():
    """25 rad/s over two seconds: seven whole turns, each of 2 pi / 25 s."""
    times = np.linspace(0.0, 2.0, 200)
    grid = grid_of(ShaftAngle(times, 25.0 * times), 90, 0.0, 0.0, (0.0, 2.0))
    assert grid.cam_speeds == pytest.approx(np.full(7, 25.0)) and np.diff(
        grid.cut_times
    ) == pytest.approx(2 * np.pi / 25)


def test_a_refinement_at_no_speed_is_refused_before_anything_is_computed():
    computed = []
    for speeds in ([0.0], [-100.0], [float("nan")]):
        with pytest.raises(InputError, match="speed"):
            refined(vt.load_case("job-t"), speeds, progress=lambda *given: computed.append(given))
    assert not computed
