"""Variants side by side give what single runs give, whatever their neighbours and the number of
workers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from valvetrain.cosserat.batch import simulate_batch
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.lanes import LANES
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.cosserat.transient import simulate
from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END, EndCoil

DYNAMICS = RodDynamics(mass_damping=60.0, stiffness_damping=4e-6)
INTERVAL, SAMPLES = 2e-5, 60


def variant(factor, per_coil, end=OPEN_END, coils=3.0):
    """A short spring that clashes within a millisecond; ``factor`` scales its open pitch."""
    pitch = PiecewiseLinear((0.0, 1.2, 1.6, coils), (4.3e-3, 4.3e-3, 7e-3 * factor, 7e-3 * factor))
    spring = SpringDefinition(
        Constant(4e-3),
        PiecewiseLinear((0.0, coils), (24e-3, 22e-3)),
        pitch,
        total_coils=coils,
        material=OTEVA_90_SC,
        lower_end=end,
        upper_end=end,
    )
    mesh = mesh_spring(spring, per_coil)
    return mesh, compress(RodStatics(mesh), [1e-3])[-1].state


def push(time):
    """One stroke of 2.5 mm within 1 ms."""
    return 1e-3 + 2.5e-3 * np.sin(np.pi * np.minimum(time, 1e-3) / 1e-3) ** 2


@pytest.mark.parametrize(
    ("per_coil", "end", "coils"), [(12, OPEN_END, 3.0), (20, OPEN_END, 3.0), (12, EndCoil(), 4.5)]
)
def test_variants_side_by_side_equal_single_runs(per_coil, end, coils):
    built = [variant(factor, per_coil, end, coils) for factor in np.linspace(0.97, 1.03, LANES + 2)]
    meshes, starts = [mesh for mesh, _ in built], [state for _, state in built]
    batch = simulate_batch(meshes, starts, push, INTERVAL, SAMPLES, DYNAMICS, 2e-7)
    assert batch.completed.all()
    touched = 0.0
    for index in (0, 3, LANES, LANES + 1):
        single = simulate(meshes[index], starts[index], push, INTERVAL, SAMPLES, DYNAMICS, 2e-7)
        touched = max(touched, float(single.contact_peak.max()))
        scale = np.abs(single.dense_seat_force).max()
        np.testing.assert_allclose(
            batch.dense_seat_force[index], single.dense_seat_force, atol=1e-7 * scale
        )
        np.testing.assert_allclose(
            batch.dense_retainer_force[index], single.dense_retainer_force, atol=1e-7 * scale
        )
        np.testing.assert_allclose(batch.seat_force[index], single.seat_force, atol=1e-7 * scale)
        np.testing.assert_allclose(batch.time, single.time, rtol=1e-14)
    assert touched > 1.0, "the variants must clash, or contact is not tested"


def test_workers_and_neighbours_change_no_bit():
    built = [variant(factor, 12) for factor in np.linspace(0.97, 1.03, LANES + 3)]
    meshes, starts = [mesh for mesh, _ in built], [state for _, state in built]
    one = simulate_batch(meshes, starts, push, INTERVAL, SAMPLES, DYNAMICS, 2e-7)
    many = simulate_batch(meshes, starts, push, INTERVAL, SAMPLES, DYNAMICS, 2e-7, workers=3)
    turned = simulate_batch(meshes[::-1], starts[::-1], push, INTERVAL, SAMPLES, DYNAMICS, 2e-7)
    assert np.array_equal(one.dense_seat_force, many.dense_seat_force)
    assert np.array_equal(one.dense_seat_force, turned.dense_seat_force[::-1])
    assert np.ptp(one.dense_seat_force, axis=0).max() > 0.1, "the variants must differ"


def test_a_diverging_variant_does_not_touch_its_neighbours():
    built = [variant(factor, 12) for factor in (0.98, 1.0, 1.02)]
    meshes, starts = [mesh for mesh, _ in built], [state for _, state in built]
    light = replace(meshes[1], node_mass=meshes[1].node_mass / 50)
    sound = simulate_batch(meshes, starts, push, INTERVAL, SAMPLES, DYNAMICS, 2e-7)
    broken = simulate_batch(
        [meshes[0], light, meshes[2]], starts, push, INTERVAL, SAMPLES, DYNAMICS, 2e-7
    )
    assert broken.completed.tolist() == [True, False, True]
    assert np.isnan(broken.dense_seat_force[1, -1])
    for index in (0, 2):
        np.testing.assert_allclose(
            broken.dense_seat_force[index], sound.dense_seat_force[index], rtol=1e-9
        )


def test_meshes_of_different_size_are_refused():
    first, second = variant(1.0, 12), variant(1.0, 14)
    with pytest.raises(InputError, match="differ in size"):
        simulate_batch([first[0], second[0]], [first[1], second[1]], push, INTERVAL, 5, DYNAMICS)
    with pytest.raises(InputError, match="start states"):
        simulate_batch([first[0]], [], push, INTERVAL, 5, DYNAMICS)
