"""Trains drawn to scale: gaps measured on the drawn outlines with nothing but plane geometry are
those of the solution.

The oracle knows no contour table: the drawn lobe is a polygon, the distance of the drawn follower
from it is found by brute force.
"""

from __future__ import annotations

import base64
from functools import cache
from importlib import resources

import numpy as np
import pytest

from valvetrain.parameters.loading import parse_case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.runs.api import simulate
from valvetrain.views.motion.project import motion_data
from valvetrain.views.motion.scene import moving_picture

KINDS = ("direct", "finger", "pushrod", "rocker")
Numbers = np.ndarray


def numbers(text: str) -> Numbers:
    return np.frombuffer(base64.b64decode(text), "<f4").astype(float)


@cache
def drawn(kind: str, model: str = "planar"):
    """A template's run at its first speed with massless springs, the picture as a page holds it,
    its samples, the case's train.
    """
    text = (resources.files("valvetrain") / "templates" / f"{kind}.toml").read_text(
        encoding="utf-8"
    )
    case = parse_case(text, kind, changes={"train.model": model})
    study = simulate(
        case, engine_speeds=case.operation.engine_speeds[:1], models=("massless",), workers=1
    )
    picture = moving_picture(study, 150)
    data = motion_data(picture)["variants"][0]
    return study, data, picture.variants[0].sample, case.train


def body(data, name: str):
    """Points (n, 2) of a body's shapes in mm, and its pose (frame, 3)."""
    one = next(one for one in data["bodies"] if one["name"] == name)
    pose = numbers(one["pose"]).reshape(-1, 3)
    return [numbers(shape["points"]).reshape(-1, 2) for shape in one["shapes"]], pose


def placed(points: Numbers, pose: Numbers) -> Numbers:
    """Points of a body in the plane (mm) at one pose."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return pose[:2] + points @ np.array([[c, s], [-s, c]])


def distance_to(polygon: Numbers, point: Numbers) -> float:
    """Distance (mm) of a point outside a closed polygon from its nearest side."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    along = end - start
    share = np.clip(np.sum((point - start) * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
    return float(np.min(np.hypot(*(start + share[:, None] * along - point).T)))


def arc_centre(kind: str, data, train, place: int) -> Numbers:
    """Centre (mm) of the follower's arc as drawn."""
    if kind == "pushrod":
        return body(data, "tappet")[1][place][:2]
    # Pad and roller are drawn in the lever's frame; the arc's centre is the one point at even
    # distance from its outer points.
    shapes, pose = body(data, "lever")
    arc = shapes[0][:30] if kind == "finger" else shapes[0]
    rows = np.column_stack([2 * (arc[1:] - arc[0])])
    centre = np.linalg.lstsq(rows, np.sum(arc[1:] ** 2, axis=1) - np.sum(arc[0] ** 2), rcond=None)[
        0
    ]
    assert np.hypot(*(arc[0] - centre)) == pytest.approx(1e3 * train.follower.radius, abs=2e-3)
    return placed(centre[None], pose[place])[0]


@pytest.mark.parametrize("kind", KINDS)
def test_the_drawn_gap_between_lobe_and_follower_is_that_of_the_solution(kind):
    study, data, sample, train = drawn(kind)
    gap = 1e3 * reported_cycle(study.solutions[0]).channel("cam_gap")[sample]
    shapes, pose = body(data, "cam")
    found = np.zeros(len(sample))
    for place in range(len(sample)):
        lobe = placed(shapes[0], pose[place])
        if kind == "direct":
            face, tappet = body(data, "tappet")
            normal = np.array(
                [-np.sin(tappet[place][2]), np.cos(tappet[place][2])]
            )  # the tappet's y axis
            found[place] = tappet[place][:2] @ normal + face[0][0][1] - np.max(lobe @ normal)
        else:
            found[place] = (
                distance_to(lobe, arc_centre(kind, data, train, place))
                - 1e3 * train.follower.radius
            )
    assert np.ptp(gap) > 1e-3
    # Chords of half a degree under a radius of some 30 mm, and single precision.
    np.testing.assert_allclose(found, gap, atol=1.5e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_drawn_lift_and_the_gap_at_the_stem_are_those_of_the_solution(kind):
    study, data, sample, train = drawn(kind)
    cycle = reported_cycle(study.solutions[0])
    stem, head = body(data, "valve stem")[1], body(data, "valve head")[1]
    opening = np.array(
        [np.cos(train.valve.opening_direction), np.sin(train.valve.opening_direction)]
    )
    lift = (head - body(data, "valve seat")[1][0])[:, :2] @ opening
    np.testing.assert_allclose(lift, 1e3 * cycle.channel("valve_lift")[sample], atol=1e-4)
    np.testing.assert_allclose(
        numbers(data["lift"]), 1e3 * cycle.channel("valve_lift")[sample], atol=1e-5
    )
    if kind == "direct":
        shapes, tappet = body(data, "tappet")
        below = (stem - tappet)[:, :2] @ opening - shapes[0][:, 1].max()
    else:
        shapes, lever = body(data, "lever")
        bar = shapes[-2]
        reach = np.array([np.max(placed(bar[_tip_half(bar)], pose) @ opening) for pose in lever])
        below = stem[:, :2] @ opening - reach
    np.testing.assert_allclose(below, 1e3 * cycle.channel("valve_tip_gap")[sample], atol=2e-3)


def _tip_half(bar: Numbers) -> Numbers:
    """The half of a bar's outline about its far end."""
    return np.arange(len(bar)) >= len(bar) // 2


def test_the_pushrod_keeps_its_length_and_its_gap():
    """The ball of the rocker, found from the case's own arm and the drawn turn, stands off the
    drawn rod's end by the solution's gap.
    """
    study, data, sample, train = drawn("pushrod")
    shapes, rod = body(data, "pushrod")
    turn = body(data, "lever")[1]
    ball = (
        1e3
        * train.lever.drive_arm
        * np.array([np.cos(train.lever.drive_angle), np.sin(train.lever.drive_angle)])
    )
    length = shapes[0][:, 1].max()
    home = 1e3 * np.array(train.lever.pivot) + ball - 1e3 * np.array(train.pushrod.lower_end)
    assert length == pytest.approx(np.hypot(*home), abs=1e-3)
    cycle = reported_cycle(study.solutions[0])
    squeeze = (
        1e3
        * (cycle.channel("pushrod_top_displacement") - cycle.channel("pushrod_displacement"))[
            sample
        ]
        if study.solutions[0].has("pushrod_top_displacement")
        else 0.0
    )
    found = (
        np.array(
            [
                np.hypot(*(placed(ball[None], pose)[0] - foot[:2]))
                for pose, foot in zip(turn, rod, strict=True)
            ]
        )
        - length
        - squeeze
    )
    np.testing.assert_allclose(found, 1e3 * cycle.channel("rocker_gap")[sample], atol=1e-3)
