"""Unit: the elastic pivot of a lever as a mass on a spring and a damper, by Newton's and Hooke's
laws, in every kind of train.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from train_parts import KINDS, system
from valvetrain.mechanism.parts import ElasticLink
from valvetrain.mechanism.planar import support_parts
from valvetrain.parameters.train_parts import SupportParameters
from valvetrain.system.rigid_pose import rigid_poses

STIFFNESS, DAMPING, MASS, LEVER = 5e7, 200.0, 0.1, 0.06
LEVERS = ("finger", "rocker", "pushrod")


@pytest.mark.parametrize("direction", [0.0, 60.0, 90.0, 200.0])
@pytest.mark.parametrize("kind", LEVERS)
def test_a_pivot_carries_the_lever_and_yields_along_its_direction(kind, direction):
    turned = math.radians(direction)
    train = KINDS[kind](
        support=SupportParameters(STIFFNESS, MASS, DAMPING, turned), gravity=(1.5, -9.81)
    )
    (body,), (link,), along, name = support_parts(train, LEVER)
    assert (name, body.name, link.coordinates) == ("support", "support", ("support",))
    assert along == pytest.approx((math.cos(turned), math.sin(turned)))
    assert body.mass == pytest.approx(MASS + LEVER)
    assert body.force == pytest.approx(
        (MASS + LEVER) * (1.5 * math.cos(turned) - 9.81 * math.sin(turned))
    )
    assert isinstance(link.law, ElasticLink) and (link.law.stiffness, link.law.damping) == (
        STIFFNESS,
        DAMPING,
    )
    assert link.geometry_row()[:2].tolist() == [0.0, 1.0], (
        "it is pressed by the travel of the pivot"
    )


@pytest.mark.parametrize("kind", LEVERS)
def test_a_rigid_pose_leaves_the_pivot_where_it_is_and_the_valve_at_its_lift(kind):
    """The train with the pivot moves as that without it; contacts between valve and pushrod stay as
    they are at rest.
    """
    built = system(KINDS[kind](support=SupportParameters(STIFFNESS, MASS, DAMPING)))
    found, rigid = rigid_poses(built, 9), rigid_poses(system(KINDS[kind]()), 9)
    place = built.coordinate_names.index("support")
    valve = built.mechanism.index(built.mechanism.valve)
    assert found.q[:, place] == pytest.approx(np.zeros(9), abs=1e-12)
    assert found.modes[:, place] == pytest.approx(np.zeros(9), abs=1e-12)
    assert found.q[:, valve] == pytest.approx(found.valve_lifts, abs=1e-12) and found.modes[
        :, valve
    ] == pytest.approx(np.ones(9))
    others = np.delete(np.arange(len(built.masses)), place)
    assert found.q[:, others] == pytest.approx(rigid.q, abs=1e-9)
    assert found.reduced_masses == pytest.approx(rigid.reduced_masses, rel=1e-6)
