"""The result objects refuse what would mislead their readers."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve


def test_a_solution_of_plain_arrays_and_one_of_their_dataset_are_the_same():
    arrays = spring_channels(
        [0.0, 1.0],
        [0.0, 2.0],
        {"seat_force": [1.0, 3.0], "coil_gap": [[1e-3], [2e-3]]},
        upper_coil=[2.5],
    )
    plain, labelled = Solution(arrays), Solution(arrays.dataset)
    assert (
        plain.identical(labelled) and labelled.channels is arrays.dataset and plain.arrays is arrays
    )
    assert plain.channels.seat_force.attrs["units"] == plain.unit("seat_force") == "N"
    assert np.shares_memory(plain.channels["coil_gap"].values, plain.channel("coil_gap"))
    assert (
        plain.channels["coil_gap"].coords["upper_coil"].values.tolist()
        == plain.arrays.along("coil_gap").tolist()
        == [2.5]
    )
    assert replace(plain, events=()).identical(plain) and not plain.reduced().channels.data_vars
    assert pickle.loads(pickle.dumps(labelled)).identical(plain)


def test_static_curve_interpolates_inside_only():
    steps = np.linspace(0, 8e-3, 9)
    empty = np.zeros((9, 0))
    curve = StaticCurve(
        steps, steps * 4e4, np.full(9, 4e4), empty, empty, np.zeros(0), empty, np.zeros(0)
    )
    assert curve.force_at(7.5e-3) == pytest.approx(300.0)
    assert curve.stiffness_at(8e-3) == pytest.approx(4e4)
    with pytest.raises(InputError, match="outside"):
        curve.force_at(9e-3)
    with pytest.raises(InputError, match="shape"):
        StaticCurve(steps, steps[1:], steps, empty, empty, np.zeros(0), empty, np.zeros(0))


def test_modal_result_refuses_wrong_shapes_and_indices():
    arrays = dict(
        natural_frequency=np.ones(2),
        shape=np.zeros((2, 3, 3)),
        coil_number=np.arange(3.0),
        axial_transmission=np.ones(2),
    )
    good = {"compression": 0.0, **arrays}
    with pytest.raises(InputError, match="axial_modes"):
        ModalResult(**good, axial_modes=(2,))
    with pytest.raises(InputError, match="shape"):
        ModalResult(**{**good, "shape": np.zeros((2, 3))}, axial_modes=())
