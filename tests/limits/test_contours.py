"""Limits: contours of cams and the lifts they give, against closed forms: an eccentric circle under every follower, three arcs."""

from __future__ import annotations

import numpy as np
import pytest

from known_lifts import polar_table, three_arc
from valvetrain.errors import InputError
from valvetrain.lift.figures import lift_figures
from valvetrain.measured.contours import Follower, contour_of_lift, lift_of_contour
from valvetrain.measured.lift_file import LiftAnswers, lifts_in
from valvetrain.measured.lift_smoothing import BAND, smooth_lift

TURN = np.linspace(0, 2 * np.pi, 721)[:-1]
#: A circle of 18 mm whose centre is 5 mm off the cam's, at polar angle 0.
RADIUS, OFF = 18e-3, 5e-3
CIRCLE = OFF * np.cos(TURN) + np.sqrt(RADIUS**2 - (OFF * np.sin(TURN)) ** 2)
FOLLOWERS = {
    "flat": Follower(), "roller": Follower(10e-3), "offset roller": Follower(10e-3, 3e-3), "dome": Follower(60e-3),
    "finger": Follower(10e-3, arm=40e-3, pivot=(40e-3, 27e-3)),
}  # fmt: skip


def height(name: str, theta):
    """Place of a follower on the circle: its centre is always radius plus that of the follower from the circle's."""
    follower, along, aside = FOLLOWERS[name], OFF * np.cos(theta), OFF * np.sin(theta)
    if name == "flat":
        return along
    reach = RADIUS + follower.radius
    if name != "finger":
        return along + np.sqrt(reach**2 - (aside + follower.offset) ** 2)
    x, y = aside - follower.pivot[0], along - follower.pivot[1]
    apart = np.hypot(x, y)
    between = np.arccos((follower.arm**2 + apart**2 - reach**2) / (2 * follower.arm * apart))
    return follower.arm * (np.arctan2(y, -x) + between)


@pytest.mark.parametrize("name", FOLLOWERS)
def test_an_eccentric_circle_lifts_every_follower_exactly(name):
    theta, lifts = lift_of_contour(TURN, CIRCLE, FOLLOWERS[name])
    expected = height(name, theta)
    np.testing.assert_allclose(lifts, expected - expected.min(), atol=2e-9)


@pytest.mark.parametrize("name", ["flat", "roller", "offset roller", "dome"])
def test_the_lift_of_an_eccentric_circle_makes_that_circle(name):
    """Every point 18 mm from the circle's centre, every radius of curvature 18 mm."""
    theta = np.linspace(0, 2 * np.pi, 4001)
    step, found = 1e-4, height(name, theta)
    slope = (height(name, theta + step) - height(name, theta - step)) / (2 * step)
    bend = (height(name, theta + step) - 2 * found + height(name, theta - step)) / step**2
    reach = (
        np.sqrt((RADIUS - OFF + FOLLOWERS[name].radius) ** 2 - FOLLOWERS[name].offset ** 2)
        if name != "flat"
        else RADIUS - OFF
    )
    rise = found + (RADIUS if name == "flat" else 0.0) - reach
    contour = contour_of_lift((rise, slope, bend), theta, RADIUS - OFF, FOLLOWERS[name])
    x, y = contour.radii * [np.cos(contour.polar_angles), np.sin(contour.polar_angles)]
    np.testing.assert_allclose(np.hypot(x - OFF, y), RADIUS, atol=1e-8)
    np.testing.assert_allclose(contour.curvature_radii, RADIUS, rtol=1e-4)
    assert not contour.undercut
    if name == "roller":  # sin = 5 / 28
        assert np.degrees(np.abs(contour.pressure_angles).max()) == pytest.approx(10.2866, abs=1e-4)


def test_three_arcs_under_a_flat_tappet():
    """15 / 60 / 4 mm, rise 8: 100.7 cam degrees at 0.050 in, 8 mm of lift."""
    radii = three_arc(TURN)
    theta, lifts = lift_of_contour(TURN, radii, Follower())
    assert lifts.max() == pytest.approx(8e-3, abs=1e-6)
    away = np.degrees(np.mod(theta + np.pi, 2 * np.pi) - np.pi)
    order = np.argsort(away)
    side = order[away[order] >= 0]
    half = float(np.interp(-1.27e-3, -lifts[side], away[side]))
    assert 2 * half == pytest.approx(100.7, abs=0.05)


def test_there_and_back_within_a_micrometre():
    theta = np.linspace(0, 2 * np.pi, 1441)[:-1]
    u = np.clip((theta - np.pi) / np.radians(80), -1, 1)
    w, scale = 1 - u**2, np.radians(80)
    lift = 5e-3 * np.array([w**3, -6 * u * w**2 / scale, w * (30 * u**2 - 6) / scale**2])
    for follower in (Follower(), Follower(9e-3), Follower(9e-3, 2e-3), Follower(200e-3)):
        contour = contour_of_lift(lift, theta, 20e-3, follower)
        order = np.argsort(np.mod(contour.polar_angles, 2 * np.pi))
        again, lifts = lift_of_contour(
            np.mod(contour.polar_angles, 2 * np.pi)[order], contour.radii[order], follower
        )
        np.testing.assert_allclose(lifts, np.interp(again, theta, lift[0]), atol=1.5e-6)


def test_undercutting_is_said():
    """A flat face on a base circle too small for the deceleration over the nose; a roller larger than its path bends."""
    theta = np.linspace(0, 2 * np.pi, 721)
    lift = 5e-3 * np.array([1 - np.cos(3 * theta), 3 * np.sin(3 * theta), 9 * np.cos(3 * theta)])
    assert contour_of_lift(lift, theta, 20e-3, Follower()).undercut
    assert not contour_of_lift(lift, theta, 40e-3, Follower()).undercut
    assert contour_of_lift(lift, theta, 10e-3, Follower(30e-3)).undercut


def test_a_contour_in_a_file_is_a_lift_by_its_follower():
    radii = three_arc(TURN)
    text = polar_table(TURN, radii)
    with pytest.raises(InputError, match="follower"):
        lifts_in(text, "own.csv", LiftAnswers())
    x, y = 1e3 * radii * np.cos(TURN), 1e3 * radii * np.sin(TURN)
    drawn = "\n".join(
        ["x (mm);y (mm)", *(f"{one:.6f};{two:.6f}" for one, two in zip(x, y, strict=True))]
    ).encode()
    (lobe,), (again,) = (
        lifts_in(one, "own.csv", LiftAnswers(follower="flat")) for one in (text, drawn)
    )
    np.testing.assert_allclose(lobe.lifts, again.lifts, atol=1e-7)
    assert lobe.lift_of == "tappet" and lobe.lifts.max() == pytest.approx(8e-3, abs=1e-6)
    # under a flat face arcs accelerate by their distance from the cam's centre: at most the flank's as it begins
    law = smooth_lift(lobe.cam_angles, lobe.lifts)
    figures = {figure.name: figure for figure in lift_figures(law)}
    for name, true in (("largest_acceleration", 45e-3), ("nose_acceleration", -19e-3)):
        assert abs(figures[name].value - true) < BAND * figures[name].spread < 0.05
    for wrong in ("ball", "roller", "roller -3 mm"):
        with pytest.raises(InputError):
            Follower.of(wrong)
