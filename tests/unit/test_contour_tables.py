"""Tables of cam contours against curves with a closed form, given at angles that start anywhere."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BPoly, PchipInterpolator

from valvetrain.errors import InputError
from valvetrain.mechanism.contour import (
    check_flat,
    check_round,
    curvature_radius_flat,
    curvature_radius_round,
    lift_table,
    monotone_table,
    table_from_samples,
)

TURN = 2 * np.pi
ANGLES = np.arange(720) * TURN / 720


def wave(angle: np.ndarray, derivative: int = 0, times: int = 2, size: float = 1e-3) -> np.ndarray:
    turned = times**derivative * size * np.cos(times * angle - 0.4 + derivative * np.pi / 2)
    return turned + (0.02 if derivative == 0 else 0.0)


def table(curve, **given: float) -> np.ndarray:
    return np.column_stack([curve(ANGLES, derivative, **given) for derivative in range(3)])


def test_a_lift_table_holds_the_law_and_two_derivatives():
    class Law:
        def lift(self, cam_angle, derivative=0):
            return wave(np.asarray(cam_angle), derivative)

    assert lift_table(Law(), 720) == pytest.approx(table(wave), abs=1e-15)


@pytest.mark.parametrize("start", [-1.3, 0.0, 0.7, 5.9])
def test_samples_from_anywhere_on_uneven_steps_give_the_curve(start):
    even = np.linspace(0, TURN, 2000, endpoint=False)
    chi = start + even + 1e-3 * np.sin(3 * even)
    found = table_from_samples(chi, wave(chi), 720)
    wanted = table(wave)
    for column, within in enumerate((1e-11, 1e-8, 2e-7)):
        assert np.max(np.abs(found[:, column] - wanted[:, column])) < within, column


def test_second_derivatives_stay_within_both_sides_of_a_jump():
    """Lift of two parabolas: 1 and -0.5 per rad^2, a jump at 2 rad."""
    chi = np.linspace(1.0, 3.0, 201)
    value = np.where(chi < 2, 0.5 * (chi - 1) ** 2, 0.5 + (chi - 2) - 0.25 * (chi - 2) ** 2)
    whole, rest = np.append(chi, np.linspace(3.05, 7.2, 60)), np.full(60, value[-1])
    found = table_from_samples(whole, np.append(value, rest), 1440)
    around = slice(int(1.05 / TURN * 1440), int(2.9 / TURN * 1440))
    assert found[around, 2].max() < 1 + 1e-6 and found[around, 2].min() > -0.5 - 1e-6


def test_a_circle_beside_the_axis_has_its_own_radius_under_every_follower():
    away, radius, follower = 0.004, 0.02, 0.007
    flat = np.column_stack(
        [radius + away * np.cos(ANGLES), -away * np.sin(ANGLES), -away * np.cos(ANGLES)]
    )
    assert curvature_radius_flat(flat) == pytest.approx(np.full(720, radius), rel=1e-12)
    whole = radius + follower
    root = np.sqrt(whole**2 - (away * np.sin(ANGLES)) ** 2)
    pitch = away * np.cos(ANGLES) + root
    first = -away * np.sin(ANGLES) - away**2 * np.sin(2 * ANGLES) / (2 * root)
    second = (
        -away * np.cos(ANGLES)
        - away**2 * np.cos(2 * ANGLES) / root
        - (away**2 * np.sin(2 * ANGLES)) ** 2 / (4 * root**3)
    )
    assert curvature_radius_round(
        np.column_stack([pitch, first, second]), follower
    ) == pytest.approx(np.full(720, radius), rel=1e-9)


def test_a_straight_flank_has_no_curvature_and_a_hollow_one_a_negative():
    angle = np.array([-0.3, 0.0, 0.4])
    secant = 1 / np.cos(angle)
    straight = 0.03 * np.column_stack(
        [secant, secant * np.tan(angle), secant * (1 + 2 * np.tan(angle) ** 2)]
    )
    assert np.all(np.abs(curvature_radius_round(straight, 0.01)) > 1e10)
    hollow = straight + np.array([0.0, 0.0, 0.01])
    assert np.all(curvature_radius_round(hollow, 0.01) < -0.01)


@pytest.mark.parametrize("size", [2.4e-3, 2.6e-3])
def test_a_cusp_is_found_where_it_is(size):
    """h = 0.02 + a cos(3 x - 0.4): h + h'' = 0.02 - 8 a cos(3 x - 0.4), least at x = 0.4 / 3."""
    found = table(wave, times=3, size=size)
    if size < 0.0025:
        check_flat(found)
        return
    with pytest.raises(
        InputError, match=r"near cam angle (7\.5|127\.5|247\.5) deg \(radius -0\.80 mm\)"
    ):
        check_flat(found)


def test_a_lift_ten_times_too_large_is_asked_for_its_unit():
    """Contract: a slip of the unit was answered with the cusp alone; a steep cam is not asked."""
    angle = np.linspace(0.0, 2 * np.pi, 1441)[:-1]
    expected = r"cusp .*lift of 80 mm is unusually large for a base circle of 18 mm radius: is the unit right\?$"
    height = 0.018 + 0.04 * (1 - np.cos(angle)) ** 3 / 4
    with pytest.raises(InputError, match=expected):
        check_flat(table_from_samples(angle, height))
    with pytest.raises(InputError, match=r"use a roller$"):
        check_flat(table_from_samples(angle, 0.018 + 0.1 * (height - 0.018) * np.cos(8 * angle)))


@pytest.mark.parametrize(("follower", "passes"), [(0.019, True), (0.021, False)])
def test_an_arc_wider_than_the_pitch_curve_is_undercut(follower, passes):
    circle = np.column_stack([np.full(720, 0.02), np.zeros(720), np.zeros(720)])
    if passes:
        check_round(circle, follower)
        return
    with pytest.raises(
        InputError, match=r"arc of 21 mm needs an undercut cam near cam angle 0\.0 deg"
    ):
        check_round(circle, follower)


@pytest.mark.parametrize("seed", range(6))
def test_a_monotone_table_never_leaves_two_neighbours_and_is_the_cubic_where_it_may(seed):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0.3, 6.0, 9))
    values = rng.normal(0, 500, 9).round(-2)
    nodes = 1440
    found = monotone_table(angles, values, nodes)
    cubic = PchipInterpolator(
        np.concatenate([angles - TURN, angles, angles + TURN]), np.tile(values, 3)
    )
    place = np.arange(nodes) * TURN / nodes
    inside = angles[0] + np.mod(place - angles[0], TURN)
    assert found[:, 0] == pytest.approx(cubic(inside), abs=1e-9)
    same = np.isclose(found[:, 1], cubic(inside, 1), rtol=1e-9, atol=1e-6)
    assert same.mean() > 0.8
    assert np.all(np.abs(found[:, 1]) <= np.abs(cubic(inside, 1)) + 1e-6)
    smooth = same & (
        np.min(np.abs(np.mod(inside[:, None] - angles + np.pi, TURN) - np.pi), axis=1)
        > TURN / nodes
    )
    assert (
        np.mean(np.isclose(found[smooth, 2], cubic(inside, 2)[smooth], rtol=1e-6, atol=1e-3)) > 0.9
    )
    # what the train reads: quintics through value, slope and bend of both nodes
    ends = np.vstack([found, found[:1]])
    quintic = BPoly.from_derivatives(np.append(place, TURN), ends)
    fine = np.linspace(0, TURN, 20 * nodes, endpoint=False)
    around = angles[0] + np.mod(fine - angles[0], TURN)
    left = np.searchsorted(angles, around, side="right") - 1
    low, high = (
        np.minimum(values[left], np.roll(values, -1)[left]),
        np.maximum(values[left], np.roll(values, -1)[left]),
    )
    near = (
        np.minimum(
            np.abs(around - angles[left]),
            np.abs(around - np.append(angles, angles[0] + TURN)[left + 1]),
        )
        < TURN / nodes
    )
    curve = quintic(fine)
    assert np.all((curve >= low - 1e-6) & (curve <= high + 1e-6) | near)
    assert curve.min() >= values.min() - 1e-6 and curve.max() <= values.max() + 1e-6
