"""Unit: turns, peaks, means, the closed window and dwells of a film's displacements, beside made-up
motions counted by hand.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.film.cycles import closed_window, on_grid, peaks, segments

TURN = 2 * np.pi
GRID = np.radians(np.arange(360.0))


def test_a_motion_is_drawn_across_two_frames_and_not_across_three():
    """A cubic is its own spline: two turns of frames every 2 degrees, one frame lost, then two in a
    row, then the film ends.
    """
    cubic = np.polynomial.Polynomial([1e-3, 2e-3, -3e-4, 1e-5])
    angle = np.radians(np.arange(0.3, 680.0, 2.0))
    moved = cubic(angle)
    moved[[50, 80, 81]] = np.nan
    values = on_grid(angle, moved, [0, 1], GRID)
    lost = np.zeros((2, 360), dtype=bool)
    lost[0, 159:165] = lost[1, 320:] = (
        True  # between the frames at 158.3 and 164.3 degrees; the last frame is at 678.3
    )
    assert np.array_equal(np.isnan(values), lost)
    at = np.stack([GRID, GRID + TURN])
    np.testing.assert_allclose(values[~lost], cubic(at)[~lost], rtol=1e-9)
    moved[3:] = np.nan
    assert np.isnan(on_grid(angle, moved, [0, 1], GRID)).all()


def test_peaks_are_means_over_the_turns_between_the_frames():
    """Tops of 3, 4 and 5 mm scatter by 1 mm; of a steady coil the place of its highlight is what is
    left, of one turn no scatter.
    """
    angle = np.arange(3 * 97) * TURN / 97 + 0.013
    shape = (1 - np.cos(angle)) / 2
    moved = np.column_stack([shape * (3e-3 + 1e-3 * np.floor(angle / TURN)), 2e-3 * shape])
    moved[40, 1] = np.nan
    spread = np.column_stack([np.full(len(angle), 1e-4), np.full(len(angle), 6e-5)])
    spread[7, 1] = np.nan
    first, second = peaks(angle, moved, spread, [0, 1, 2])
    assert (first.coil, second.coil, first.cycles, second.cycles) == (1, 2, 3, 3)
    assert (first.mean, first.scatter, first.spread) == pytest.approx(
        (4e-3, 1e-3, 1e-3 / np.sqrt(3)), rel=1e-4
    )
    assert (second.mean, second.spread) == pytest.approx(
        (2e-3, 6e-5 / np.sqrt(3)), rel=1e-4
    ) and second.scatter < 1e-7
    one, _ = peaks(angle, moved, spread, [1])
    assert (one.mean, one.spread, one.cycles) == (
        pytest.approx(4e-3, rel=1e-4),
        pytest.approx(1e-4),
        1,
    ) and np.isnan(one.scatter)
    some, _ = peaks(angle, moved, spread, [2, 7])
    assert (some.mean, some.cycles) == (pytest.approx(5e-3, rel=1e-4), 1)
    for few in (
        np.full_like(moved, np.nan),
        np.where(np.arange(len(angle))[:, None] < 3, moved, np.nan),
    ):
        with pytest.raises(InputError, match="no cam revolution with a motion"):
            peaks(angle, few, spread, [0, 1, 2])


def open_but(*dwells: tuple[int, int]) -> np.ndarray:
    """1 mm of lift, 0 from the first to the last degree of each dwell."""
    mean = np.full(360, 1e-3)
    for first, last in dwells:
        mean[np.arange(first, last + 1) % 360] = 0.0
    return mean


@pytest.mark.parametrize(
    ("mean", "words"),
    [
        (
            open_but((100, 167), (280, 347)),
            "no part of the turn shows the valve closed",
        ),  # two low parts of 47 deg
        (open_but((0, 40), (120, 160), (240, 280)), "no part of the turn shows the valve closed"),
        (np.where(np.arange(360) < 7, 0.0, np.nan), "hardly seen"),
    ],
)
def test_less_than_54_degrees_of_rest_are_no_dwell(mean, words):
    with pytest.raises(InputError, match=words) as refused:
        closed_window(GRID, mean)
    assert refused.value.where == "dwell"


def test_dwells_are_those_filmed_from_end_to_end_without_a_lost_frame():
    """Frames every 2 degrees over four turns, the dwell 200 to 400 degrees; a frame is lost in the
    second, the fourth is cut.
    """
    angle = np.radians(np.arange(-100.5, 1300.0, 2.0))
    number = np.arange(len(angle))
    dwell = (np.radians(200.0), np.radians(400.0))
    found = [np.degrees(angle[one[[0, -1]]]) for one in segments(angle, number, dwell)]
    assert np.array(found) == pytest.approx(
        np.array([(201.5, 399.5), (561.5, 759.5), (921.5, 1119.5)])
    )
    lost = np.delete(np.arange(len(angle)), int(np.argmin(np.abs(angle - np.radians(600.0)))))
    found = [np.degrees(angle[lost][one[0]]) for one in segments(angle[lost], number[lost], dwell)]
    assert found == pytest.approx([201.5, 921.5])
