"""Unit: every shape of a follower that slides or turns is drawn where its contact travels, in
millimetres worked out by hand.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.mechanism.gap_kinds import CAM_FLAT, CAM_ROUND
from valvetrain.mechanism.parts import ElasticLink, Interaction
from valvetrain.parameters.train import FollowerParameters
from valvetrain.report.motion import parts as outlines
from valvetrain.report.motion.train import Contact, sliding_follower, turning_pad

MM = 1e-3
#: Contours: a flat face is touched from 9 mm on one side to 8 mm on the other; an arc is leant on
#: by slopes of 0.3 and -0.2.
FLAT_TABLE = MM * np.array([[30.0, 0.0, 0.0], [34.0, 9.0, 0.0], [35.0, -8.0, 0.0]])
ROUND_TABLE = MM * np.array([[40.0, 0.0, 0.0], [42.0, 12.6, 0.0], [41.0, -8.2, 0.0]])
#: Axis along +y, 2 mm beside the cam's centre: the face needs 8 + 2 and 9 - 2 mm to its sides, and
#: 1.5 mm beyond.
HALF_FLAT = 11.5
#: 12 mm times the sine of the steepest slope, 0.3 / sqrt(1.09), and 1.5 mm; of a knife edge 4 mm.
HALF_ROUND = 12 * 0.3 / np.sqrt(1.09) + 1.5


def contact(kind, table, follower, turning=0.0, **columns):
    row = np.zeros(16)
    row[:5] = turning, 2 * MM, 40 * MM, *((15 * MM, 20 * MM) if turning else (0.0, 1.0))
    row[5], row[10] = 1.0, 1.0
    for place, value in columns.items():
        row[int(place[1:])] = value
    return Contact(
        Interaction("cam", kind, ("tappet", "", "", ""), tuple(row), ElasticLink(1e6), "contour"),
        table,
        follower,
    )


def lathe(*points):
    return "lathe", points


def plate(*points):
    return "extrude", points


LEAN = 11.5 * np.tan(0.1)
TALL = 0.9 * HALF_FLAT + 6.0
WIDE = 0.9 * HALF_ROUND + 6.0
FORK = ((-0.6 * HALF_ROUND, 0.0), (0.6 * HALF_ROUND, 0.0), (HALF_ROUND, 32.0), (-HALF_ROUND, 32.0))
FLAT, LEANING = FollowerParameters(), FollowerParameters(tilt=0.1)
ROLLER, DOMED, KNIFE = (
    FollowerParameters("roller", 12 * MM),
    FollowerParameters("domed", 12 * MM),
    FollowerParameters("knife"),
)


@pytest.mark.parametrize(
    ("kind", "table", "follower", "height", "due", "depth"),
    [
        (
            CAM_FLAT,
            FLAT_TABLE,
            FLAT,
            None,
            lathe((0, 0), (HALF_FLAT, 0), (HALF_FLAT, TALL), (0, TALL), (0, 0)),
            None,
        ),
        (
            CAM_FLAT,
            FLAT_TABLE,
            FLAT,
            25.0,
            lathe((0, 0), (HALF_FLAT, 0), (HALF_FLAT, 25), (0, 25), (0, 0)),
            None,
        ),
        (
            CAM_FLAT,
            FLAT_TABLE,
            LEANING,
            25.0,
            plate((-11.5, -LEAN), (11.5, LEAN), (11.5, 25), (-11.5, 25)),
            HALF_FLAT,
        ),
        (CAM_ROUND, ROUND_TABLE, ROLLER, 20.0, plate(*FORK), 5.0),
        (CAM_ROUND, ROUND_TABLE, DOMED, None, lathe(None, (HALF_ROUND, WIDE), (0, WIDE)), None),
        (CAM_ROUND, ROUND_TABLE, DOMED, 20.0, lathe(None, (HALF_ROUND, 20), (0, 20)), None),
        (CAM_ROUND, ROUND_TABLE, KNIFE, 20.0, lathe((0, 0), (4, 6), (4, 20), (0, 20)), None),
        (CAM_ROUND, ROUND_TABLE, KNIFE, 5.0, lathe((0, 0), (4, 6), (4, 8), (0, 8)), None),
    ],
)
def test_a_sliding_follower_is_as_wide_as_its_contact_travels_and_as_tall_as_it_stands(
    kind, table, follower, height, due, depth
):
    """A turned profile about its axis, but for a leaning face and a roller's fork, which are
    plates.
    """
    moved = MM * np.array([0.0, 3.0, 9.0])
    body = sliding_follower(
        contact(kind, table, follower),
        moved,
        "tappet",
        10 * MM,
        None if height is None else height * MM,
    )
    home = body.pose - np.column_stack([np.zeros(3), moved, np.zeros(3)])
    assert home == pytest.approx(np.tile([2 * MM, 40 * MM, 0.0], (3, 1)))
    one = body.shapes[-1]
    form, points = due
    assert one.kind == form
    if points[0] is None:
        dome, points = one.points[:-2], points[1:]
        assert np.hypot(*dome.T) == pytest.approx(np.full(len(dome), 12 * MM))
        assert [dome[0, 0], dome[0, 1], dome[-1, 0]] == pytest.approx(
            [0.0, -12 * MM, HALF_ROUND * MM], abs=1e-12
        )
    assert one.points[-len(points) :] / MM == pytest.approx(np.array(points, dtype=float), abs=1e-9)
    if depth is not None:
        assert one.depth == pytest.approx((-depth * MM, depth * MM))
    if follower.shape == "roller":
        (wheel, _) = body.shapes
        assert np.hypot(*wheel.points.T) == pytest.approx(np.full(len(wheel.points), 12 * MM))
        assert wheel.depth == pytest.approx((-4 * MM, 4 * MM))


@pytest.mark.parametrize(
    ("axis", "turn"),
    [((0.0, 1.0), 0.0), ((1.0, 0.0), -np.pi / 2), ((0.0, -1.0), -np.pi), ((-0.6, 0.8), None)],
)
def test_a_sliding_follower_stands_along_its_axis(axis, turn):
    one = contact(CAM_ROUND, ROUND_TABLE, KNIFE, _3=axis[0], _4=axis[1])
    (pose,) = sliding_follower(one, np.array([5 * MM]), "tappet", 10 * MM, None).pose
    assert pose[:2] / MM == pytest.approx([2 + 5 * axis[0], 40 + 5 * axis[1]])
    assert [-np.sin(pose[2]), np.cos(pose[2])] == pytest.approx(axis, abs=1e-12)
    assert turn is None or pose[2] == pytest.approx(turn)


def test_a_flat_pad_of_a_lever_reaches_beyond_its_contact_and_a_roller_turns_at_its_arm():
    """The face is level (normal along +y, tangent -x) and its point 17 mm beside the cam's centre:
    8 + 17 and -9 + 17 mm along it.
    """
    shapes = turning_pad(
        contact(CAM_FLAT, FLAT_TABLE, FLAT, 1.0, _8=np.pi / 2),
        np.zeros(3),
        np.zeros(3),
        5 * MM,
        6 * MM,
    )
    face = shapes[0].points / MM
    assert face[:, 0] == pytest.approx(
        [15 - (-9 + 17 - 1.5), 15 - (8 + 17 + 1.5), 15 - 26.5, 15 - 6.5]
    )
    assert face[:, 1] == pytest.approx([20, 20, 24, 24]) and shapes[0].depth == pytest.approx(
        (-6 * MM, 6 * MM)
    )
    wheel, bar = turning_pad(
        contact(CAM_ROUND, ROUND_TABLE, ROLLER, 1.0), np.zeros(3), np.zeros(3), 5 * MM, 6 * MM
    )
    assert np.hypot(*(wheel.points / MM - [15, 20]).T) == pytest.approx(
        np.full(len(wheel.points), 12.0)
    )
    assert wheel.depth == pytest.approx((-6.5 * MM, 6.5 * MM)) and bar.depth == pytest.approx(
        (-5 * MM, 5 * MM)
    )
    along = bar.points / MM @ [0.6, 0.8]
    assert [along.min(), along.max()] == pytest.approx(
        [-6.0, 25 + 0.6 * 12], abs=0.03
    )  # of points on its round ends


@pytest.mark.parametrize(("bore", "more"), [(0.0, ()), (2.0, (2.0,))])
def test_a_disc_is_turned_from_its_radial_section(bore, more):
    """Radius and height of the corners, from the lower one at the bore round to it."""
    disc = outlines.disc(9.0, 1.0, 4.0, *more)
    assert disc.kind == "lathe"
    assert disc.points.tolist() == [[bore, 1.0], [9.0, 1.0], [9.0, 4.0], [bore, 4.0], [bore, 1.0]]
