"""Which modes are named axial: the strongest of each cluster of one sign, of those that move along
the axis at a real frequency.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.cosserat.modes import EVEN_SHARE, RodModes


def modes(
    transmission: list[float],
    frequency: list[float] | None = None,
    share: list[float] | None = None,
) -> RodModes:
    count = len(transmission)
    return RodModes(
        np.array(frequency or np.arange(1.0, count + 1)),
        np.zeros((count, 0, 3)),
        np.array(transmission),
        np.zeros(count),
        np.array(share or [0.9] * count),
        4e4,
    )


@pytest.mark.parametrize(
    ("transmission", "found"),
    [
        ([0.5, -0.9, 0.4], [0, 1, 2]),
        ([0.3, 0.9, 0.5, -0.2, -0.8, -0.3, 0.7], [1, 4, 6]),
        ([0.9, 0.3, -0.8, -0.2], [0, 2]),
        ([-0.9, -0.95, 0.5], [1, 2]),
        ([0.11, 0.13, -0.11, -0.13], [1, 3]),
        ([0.0, 0.05, -0.1], []),
        ([0.5, -0.5, 0.5, -0.5, 0.5], [0, 1, 2]),
    ],
)
def test_the_strongest_of_each_cluster_of_one_sign(transmission, found):
    assert modes(transmission).axial_modes().tolist() == found


def test_as_many_as_are_asked_for():
    assert modes([0.5, -0.5, 0.5, -0.5, 0.5]).axial_modes(5).tolist() == [0, 1, 2, 3, 4]
    assert modes([0.5, -0.5, 0.5]).axial_modes(1).tolist() == [0]


def test_an_unstable_mode_and_one_that_sways_are_none_of_surge():
    assert modes([0.9, -0.8, 0.7], frequency=[-3.0, 0.0, 5.0]).axial_modes().tolist() == [2]
    assert modes(
        [0.9, -0.8, 0.7], share=[EVEN_SHARE - 0.01, EVEN_SHARE + 0.01, 0.9]
    ).axial_modes().tolist() == [1, 2]
    assert pytest.approx(1 / 3, abs=0.01) == EVEN_SHARE
