"""Unit: highlights of coils on a filmed line: shapes learnt from frames, places fitted to them,
beside curves and formulas known apart.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from valvetrain.film.profile import FINE, Profiles, fit, grounds_of
from valvetrain.film.tracks import KNOT, SMOOTH, learn

REACH, STATIONS = 9.0, 90
#: Width (px) of the highlight of each of two coils, and its height.
WIDTHS, HEIGHTS = np.array([1.6, 2.4]), np.array([40.0, 25.0])


def shape(distance, width):
    return np.exp(-0.5 * (distance / width) ** 2)


def known(coils=(0, 1)):
    half = int(REACH * FINE)
    points = np.arange(-half, half + 1) / FINE
    return Profiles(np.array([shape(points, WIDTHS[one]) for one in coils]), REACH)


def picture(places, heights, noise=0.0, ground=5.0, seed=0):
    """Frames (n, stations) of highlights at ``places`` (n, coils) over an even ground, with white
    noise.
    """
    station = np.arange(STATIONS)
    drawn = sum(
        heights[:, coil, None] * shape(station - places[:, coil, None], WIDTHS[coil])
        for coil in range(places.shape[1])
    )
    return drawn + ground + noise * np.random.default_rng(seed).standard_normal(drawn.shape)


def moving(frames, apart=14.0):
    first = 35.0 + 6.0 * np.sin(np.arange(frames) / 7.3)
    return np.column_stack([first, first + apart + 3.0 * np.cos(np.arange(frames) / 5.1)])


def test_grounds_are_an_even_one_and_three_cosines_along_the_line():
    station = np.arange(40)
    assert grounds_of(40) == pytest.approx(
        np.array([np.cos(np.pi * k * station / 40) for k in range(4)])
    )


@pytest.mark.parametrize("apart", [14.0, 7.0])
def test_shapes_of_neighbours_are_learnt_apart_even_where_they_overlap(apart):
    places = moving(120, apart)
    heights = np.tile(HEIGHTS, (120, 1))
    learnt = learn(picture(places, heights), np.arange(120), places, heights, REACH)
    points = np.linspace(-learnt.reach, learnt.reach, learnt.table.shape[1])
    assert learnt.reach == pytest.approx(REACH) and np.diff(points) == pytest.approx(
        np.full(len(points) - 1, 1 / FINE)
    )
    for table, width in zip(learnt.table, WIDTHS, strict=True):
        assert table == pytest.approx(shape(points, width), abs=0.03)
        assert table[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-3)


def test_between_the_stations_a_shape_bends_as_little_as_a_straight_run_of_its_splines_allows():
    """Frames that all meet the highlight at the same distances, a pixel apart, leave its splines
    open: the least sum of squared errors
    and ``SMOOTH`` mean squares of the second differences, by scipy's splines and one stacked least
    squares."""
    places = np.full((30, 1), 40.25)
    heights = np.full((30, 1), 1.0)
    grey = picture(places, 40.0 * heights, noise=2.0, ground=0.0, seed=3)
    inside = np.linspace(-REACH, REACH, int(np.ceil(2 * REACH / KNOT)) + 1)
    step = inside[1] - inside[0]
    knots = np.concatenate(
        [inside[0] - step * np.arange(3, 0, -1), inside, inside[-1] + step * np.arange(1, 4)]
    )
    count = len(knots) - 8
    splines = [
        BSpline.basis_element(knots[place : place + 5], extrapolate=False)
        for place in range(2, 2 + count)
    ]
    station = np.arange(STATIONS)
    near = np.abs(station - 40.25) < REACH
    rows = np.column_stack(
        [
            *(np.nan_to_num(one(station[near] - 40.25)) for one in splines),
            *grounds_of(STATIONS)[:, near],
        ]
    )
    rows = np.tile(rows, (30, 1))
    weight = np.sum(rows[:, :count] ** 2) / count
    bend = np.zeros((count - 2, count + 4))
    for place in range(count - 2):
        bend[place, place : place + 3] = 1.0, -2.0, 1.0
    stacked = np.concatenate(
        [rows, np.sqrt(SMOOTH * weight) * bend, np.sqrt(1e-7 * weight) * np.eye(count + 4)]
    )
    due = np.linalg.lstsq(
        stacked, np.concatenate([grey[:, near].ravel(), np.zeros(len(stacked) - len(rows))])
    )[0][:count]
    learnt = learn(grey, np.arange(30), places, heights, REACH)
    points = np.linspace(-REACH, REACH, learnt.table.shape[1])
    expected = sum(
        share * np.nan_to_num(one(points)) for share, one in zip(due, splines, strict=True)
    )
    assert learnt.table[0] == pytest.approx(expected, abs=0.02)


def lone(noise, frames):
    """Frames of a lone highlight of height 10 at 44.3 px, and the deviation of its place beside
    those of height and ground.
    """
    station = np.arange(STATIONS) - 44.3
    near = np.abs(station) <= REACH
    slope = 10.0 * station / WIDTHS[0] ** 2 * shape(station, WIDTHS[0])
    columns = np.stack([slope, shape(station, WIDTHS[0]), *grounds_of(STATIONS)])[:, near]
    told = noise * np.sqrt(
        np.linalg.inv(columns @ columns.T + np.diag([0, (noise / 3.0) ** 2, 0, 0, 0, 0]))[0, 0]
    )
    places = np.full((frames, 1), 44.3)
    return picture(places, np.full((frames, 1), 10.0), noise), places, told


@pytest.mark.parametrize("light", [0.6, 1.0, 1.5])
def test_places_and_heights_are_those_that_were_drawn_in_any_light(light):
    places = moving(20)
    heights = light * np.tile(HEIGHTS / HEIGHTS.mean(), (20, 1)) * [[1.1, 0.9]]
    found = fit(
        picture(places, heights),
        places + 0.6 * np.sin(np.arange(40).reshape(20, 2)),
        known(),
        np.full(20, light),
        2.0,
    )
    assert found.places == pytest.approx(places, abs=5e-3) and found.heights == pytest.approx(
        heights, rel=5e-3
    )


def test_the_spread_of_a_place_is_that_of_repeated_frames():
    """As its place scatters over 400 frames of white noise; neighbours alike by chance count as
    blur, which widens it only.
    """
    grey, places, due = lone(0.3, 400)
    found = fit(grey, places.copy(), known((0,)), np.full(400, 10.0), 2.0)
    assert np.std(found.places) == pytest.approx(due, rel=0.1) and np.mean(
        found.places
    ) == pytest.approx(44.3, abs=0.2 * due)
    assert np.median(found.noise) == pytest.approx(0.3, rel=0.05)
    assert due < np.sqrt(np.mean(found.spread**2)) < 1.4 * due


@pytest.mark.parametrize(
    ("share", "near"), [(0.0, 1e-4), (0.1, 1 / 3), (0.5, 1.0), (0.8, 2.0), (1.0, 1e3)]
)
def test_a_prediction_counts_by_its_standard_deviation(share, near):
    """Start 0.05 px beside the place: kept where it is sure, half-way where it is as sure as the
    picture, left where it is not.
    """
    grey, places, told = lone(0.3, 60)
    start, light = places - 0.05, np.full(60, 10.0)
    alone, found = (fit(grey, start, known((0,)), light, 2.0, one) for one in (0.0, near * told))
    gained = np.sum((found.places - start) * (alone.places - start)) / np.sum(
        (alone.places - start) ** 2
    )
    assert gained == pytest.approx(share, abs=0.05)
    assert np.mean(found.spread) == pytest.approx(
        np.sqrt(share) * np.mean(alone.spread), rel=0.1, abs=1e-3 * told
    )


def test_neighbours_that_would_pass_each_other_are_kept_apart():
    places = np.array([[40.0, 41.0]])
    found = fit(
        picture(places, HEIGHTS[None]),
        np.array([[41.5, 40.5]]),
        known(),
        np.array([HEIGHTS.mean()]),
        2.5,
    )
    assert found.places[0, 1] - found.places[0, 0] == pytest.approx(2.5, abs=0.05)


def test_between_its_points_a_profile_is_straight_and_beyond_its_reach_dark():
    """Each coil by its own table, up to the last point on either side; coils along the second axis
    from the end.
    """
    points = np.arange(-3 * FINE, 3 * FINE + 1) / FINE
    table = np.random.default_rng(4).uniform(1.0, 2.0, (2, len(points)))
    made = Profiles(table, 3.0)
    one = np.linspace(-3.0, 3.0, 977)
    two = np.concatenate([one[::-1][:975], [-3.0 - 1e-9, 3.0 + 1e-9]])
    found = made.at(np.array([[one, two]]), table)
    assert found.shape == (1, 2, 977)
    assert found[0, 0] == pytest.approx(np.interp(one, points, table[0]), rel=1e-9)
    assert found[0, 1, :975] == pytest.approx(np.interp(two[:975], points, table[1]), rel=1e-9)
    assert np.array_equal(found[0, 1, 975:], [0.0, 0.0])
