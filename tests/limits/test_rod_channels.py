"""Limits: channels of a rod run are those of its raw record, read by other means: distances of a
dense centreline, splines, differences.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from spring_shapes import cylindrical
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.transient import simulate
from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import (
    NEAR_GAP,
    SLIDING_VELOCITY,
    rod_channels,
)

WIRE, REST, STROKE = 3.8e-3, 4e-3, 9e-3
#: Turns of growing pitch between closed ends: every pair of coils has a gap of its own, and the
#: lowest close in the stroke.
SPRING = cylindrical(
    WIRE, 22e-3, PiecewiseLinear((0, 1, 2, 5, 6, 7), "3.8, 3.8, 5.2, 8, 5, 3.8 mm"), 7
)
EIGHTH = 0.125


@pytest.fixture(scope="module")
def run():
    """A stroke of 9 mm in 4 ms, told every 0.1 ms."""
    rod = FiniteElementRod(SPRING, REST, 24, RodDynamics(mass_damping=40.0))
    stroke = simulate(
        rod.mesh,
        rod.installed.state,
        lambda time: REST + STROKE / 2 * (1 - np.cos(np.pi * time / 4e-3)),
        1e-4,
        60,
        rod.dynamics,
    )
    return rod, stroke, rod_channels(rod, stroke, 100.0), rod_channels(rod, stroke, 100.0, False)


def measured_gaps(coil_number, position, upper):
    """Gap (m) of each coil number to the wire about a turn below, on a centreline drawn as a cubic
    spline.
    """
    line = CubicSpline(coil_number, position)
    below = line(upper[:, None] - 1 + np.linspace(-0.04, 0.04, 801))
    return np.linalg.norm(line(upper)[:, None] - below, axis=2).min(axis=1) - WIRE


def test_gap_of_each_pair_of_coils_is_the_least_distance_of_their_wires_there(run):
    """Least over an eighth of a turn. Free gaps of closed turns count from where they lie, so the
    pairs in between are read.
    """
    rod, stroke, found, ends = run
    gap = found["coil_gap"]
    upper = found.along("coil_gap")
    between = (upper > 2.2) & (upper < 5.8)
    assert np.allclose(np.diff(upper), EIGHTH) and gap.values.shape == (61, len(upper))
    seen = []
    for sample in (0, 17, 40, 60):
        for pair in np.flatnonzero(between):
            inside = upper[pair] + np.linspace(-5 / 96, 5 / 96, 11)
            seen.append(
                (
                    gap.values[sample, pair],
                    measured_gaps(rod.mesh.coil_number, stroke.position[sample], inside).min(),
                )
            )
    told, measured = np.array(seen).T
    assert np.abs(told - measured).max() < 1e-5 and measured.max() > 2.9e-3 and told.min() < 0
    np.testing.assert_array_equal(ends["coil_gap"].values, gap.values)


def pairs_of(coil_number, upper):
    """Vertices of each pair of coils: those nearest to its coil number, from one turn on."""
    return [
        [v for v, coil in enumerate(coil_number) if coil > 1 - 1e-9 and abs(coil - at) < EIGHTH / 2]
        for at in upper
    ]


@pytest.mark.parametrize(
    ("name", "record"),
    [("coil_contact_force", "contact_force"), ("coil_contact_peak_force", "contact_peak")],
)
def test_contact_force_of_a_pair_is_the_sum_of_its_points(run, name, record):
    rod, stroke, found, ends = run
    own, upper = getattr(stroke, record), found.along(name)
    expected = np.array(
        [
            [own[s][:, pair].sum() for pair in pairs_of(rod.mesh.coil_number, upper)]
            for s in range(61)
        ]
    )
    np.testing.assert_allclose(found[name].values, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(ends[name].values, found[name].values)
    assert np.count_nonzero(expected[17]) > 3 and np.count_nonzero(expected[17] == 0) > 3


def test_contact_status_tells_far_near_pressed_and_sliding(run):
    """0 further than a tenth of a millimetre, 1 nearer, 2 pressed, 3 pressed and sliding by 1 cm/s;
    all four occur in the stroke.
    """
    rod, stroke, found, _ = run
    gap, force, upper = (
        found["coil_gap"].values,
        found["coil_contact_force"].values,
        found.along("coil_gap"),
    )
    per_turn = round(1 / (rod.mesh.coil_number[1] - rod.mesh.coil_number[0]))
    expected = np.zeros(gap.shape, dtype=int)
    for s in range(len(gap)):
        for place, vertices in enumerate(pairs_of(rod.mesh.coil_number, upper)):
            slide = 0.0
            for v in vertices:
                away = stroke.position[s, v] - stroke.position[s, v - per_turn]
                moving = stroke.velocity[s, v] - stroke.velocity[s, v - per_turn]
                slide = max(slide, np.linalg.norm(np.cross(moving, away)) / np.linalg.norm(away))
            pressed = gap[s, place] < 0 or force[s, place] > 0
            expected[s, place] = (
                (3 if slide > 0.01 else 2) if pressed else int(gap[s, place] < 1e-4)
            )
    assert (NEAR_GAP, SLIDING_VELOCITY) == (1e-4, 0.01) and set(np.unique(expected)) == {0, 1, 2, 3}
    np.testing.assert_array_equal(found["contact_status"].values, expected)


def test_motion_along_the_wire_is_that_of_its_vertices(run):
    """Heights and velocities by a spline through all vertices; acceleration is the difference of
    samples, none at the first.
    """
    rod, stroke, found, _ = run
    coil, vertices = found.along("axial_displacement"), rod.mesh.coil_number
    np.testing.assert_array_equal(coil, np.arange(57) / 8)
    height = CubicSpline(vertices, stroke.position[..., 2], axis=1)(coil)
    rest = CubicSpline(vertices, rod.installed.state.position[:, 2])(coil)
    velocity = CubicSpline(vertices, stroke.velocity[..., 2], axis=1)(coil)
    inside = slice(1, -1)  # a spline's own ends are free to bend
    np.testing.assert_allclose(
        found["axial_displacement"].values[:, inside], (height - rest)[:, inside], atol=2e-6
    )
    np.testing.assert_allclose(
        found["axial_position"].values[:, inside],
        height[:, inside] - SPRING.lower_seat_height,
        atol=2e-6,
    )
    np.testing.assert_allclose(
        found["axial_velocity"].values[:, inside],
        velocity[:, inside],
        atol=2e-3 * np.abs(velocity).max(),
    )
    told = found["axial_velocity"].values
    np.testing.assert_allclose(
        found["axial_acceleration"].values,
        np.vstack([0 * told[:1], np.diff(told, axis=0) / 1e-4]),
        rtol=1e-12,
    )
    np.testing.assert_allclose(
        found["valve_lift"].values,
        STROKE / 2 * (1 - np.cos(np.pi * stroke.time / 4e-3)),
        atol=1e-15,
    )
    speed = STROKE / 2 * np.pi / 4e-3
    np.testing.assert_allclose(
        found["retainer_velocity"].values,
        speed * np.sin(np.pi * stroke.time / 4e-3),
        atol=2e-3 * speed,
    )
    np.testing.assert_allclose(found.coords["cam_angle"].values, 100.0 * stroke.time, rtol=1e-15)


def test_fine_channels_hold_what_comes_up_to_the_next_sample(run):
    """Row of a sample: its own record first, then those before the next; the last row repeats the
    last record.
    """
    _, stroke, found, ends = run
    for name, series in (
        ("seat_force", stroke.dense_seat_force),
        ("retainer_force", stroke.dense_retainer_force),
    ):
        fine = found[f"{name}_fine"].values
        count = fine.shape[1]
        assert count == (len(series) - 1) // 60 > 1
        np.testing.assert_array_equal(fine[:-1].ravel(), series[:-1])
        np.testing.assert_array_equal(fine[-1], np.full(count, series[-1]))
        np.testing.assert_array_equal(found[name].values, getattr(stroke, name))
        np.testing.assert_array_equal(ends[f"{name}_fine"].values, fine)


def test_the_finest_record_agrees_with_the_coarser_ones_where_both_have_a_value(run):
    """It begins at each sample, misses no top of any step by more than what a step changes, and passes
    through the fine record at its places.
    """
    _, _, found, _ = run
    finest, fine = found["seat_force_finest"].values, found["seat_force_fine"].values
    scale = np.ptp(finest)
    np.testing.assert_allclose(finest[:, 0], found["seat_force"].values, atol=1e-9 * scale)
    places = np.arange(finest.shape[1]) / finest.shape[1]
    for row, expected in zip(finest[:-1], fine[:-1], strict=True):
        there = np.interp(np.arange(fine.shape[1]) / fine.shape[1], places, row)
        np.testing.assert_allclose(there, expected, atol=0.02 * scale)
    tops = found["seat_force_highest"].values
    assert np.all(finest[:-1].max(axis=1) <= tops[:-1] * (1 + 1e-12))
    assert np.max(tops[:-1] - finest[:-1].max(axis=1)) < 0.02 * scale
