"""Limits: contours of cams and the lifts they give, against closed forms: an eccentric circle under every follower, three arcs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from known_lifts import polar_table, three_arc
from valvetrain.errors import InputError
from valvetrain.lift.figures import LobeResult, lift_figures
from valvetrain.lift.shape import with_contour
from valvetrain.measured.contours import (
    Follower,
    contour_of_lift,
    curvature_of_contour,
    lift_of_contour,
)
from valvetrain.measured.lift_file import LiftAnswers, MeasuredLift, lifts_in
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


@pytest.mark.parametrize("name", FOLLOWERS)
def test_the_lift_of_an_eccentric_circle_makes_that_circle(name):
    """Every point 18 mm from the circle's centre, every radius of curvature 18 mm."""
    theta = np.linspace(0, 2 * np.pi, 4001)
    step, found = 1e-4, height(name, theta)
    slope = (height(name, theta + step) - height(name, theta - step)) / (2 * step)
    bend = (height(name, theta + step) - 2 * found + height(name, theta - step)) / step**2
    follower = FOLLOWERS[name]
    least = np.sqrt((RADIUS - OFF + follower.radius) ** 2 - follower.offset**2)
    rise = found - {"flat": -OFF, "finger": found.min()}.get(name, least)
    contour = contour_of_lift((rise, slope, bend), theta, RADIUS - OFF, FOLLOWERS[name])
    x, y = contour.radii * [np.cos(contour.polar_angles), np.sin(contour.polar_angles)]
    np.testing.assert_allclose(np.hypot(x - OFF, y), RADIUS, atol=1e-8)
    np.testing.assert_allclose(contour.curvature_radii, RADIUS, rtol=1e-4)
    assert not contour.undercut
    # between the line through both centres and the motion of the follower
    reach, centre = RADIUS + follower.radius, OFF * np.array([np.cos(theta), np.sin(theta)])
    if name == "finger":
        angle = found / follower.arm
        place = np.array(follower.pivot)[::-1, None] + follower.arm * np.array(
            [np.sin(angle), -np.cos(angle)]
        )
        expected = np.arccos(
            np.sum((place - centre) * [np.cos(angle), np.sin(angle)], axis=0) / reach
        )
    else:
        expected = np.arcsin(np.abs(centre[1] + follower.offset) / reach) * (name != "flat")
    np.testing.assert_allclose(np.abs(contour.pressure_angles), expected, atol=1e-6)
    if name == "roller":  # sin = 5 / 28
        assert np.degrees(expected.max()) == pytest.approx(10.2866, abs=1e-4)


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
    for follower in (
        Follower(),
        Follower(9e-3),
        Follower(9e-3, 2e-3),
        Follower(200e-3),
        FOLLOWERS["finger"],
    ):
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


@pytest.mark.parametrize(
    ("base", "follower"), [(30e-3, "flat"), (15e-3, "flat"), (15e-3, "roller 10 mm")]
)
def test_the_page_of_a_lift_says_what_its_cam_is(base, follower):
    """5 mm over 65 degrees on either side: the acceleration at the nose is -6 lift / half^2, the largest velocity a closed form."""
    half, high, angles = np.radians(65), 5e-3, np.radians(np.arange(360.0))
    lifts = high * np.clip(1 - ((angles - np.pi) / half) ** 2, 0, None) ** 3
    law = smooth_lift(angles, lifts, noise=1e-8)
    lobe = LobeResult(MeasuredLift("lift", angles, lifts, "tappet", "columns"), law, ())
    made = with_contour(lobe, base, Follower.of(follower))
    found = {one.name: one.value for one in made.figures}
    nose, whole = 6 * high / half**2, base + high
    flat = whole - nose
    assert made.contour.undercut == (follower == "flat" and flat < 0)
    largest = whole**2 / -flat if flat < 0 else None
    assert found.get("largest_roller") == (largest and pytest.approx(largest, rel=2e-3))
    if follower == "flat":
        assert found["flat_width"] == pytest.approx(2 * nose * half * np.sqrt(0.2) * 0.64, rel=1e-3)
    radius = flat if follower == "flat" else (whole + 10e-3) ** 2 / (whole + 10e-3 + nose) - 10e-3
    if radius > 0:
        assert found["least_radius"] == pytest.approx(radius, rel=2e-3)
        assert np.degrees(found["place_of_least_radius"]) == pytest.approx(180, abs=0.5)
    with pytest.raises(InputError, match="valve"):
        with_contour(
            replace(lobe, measured=replace(lobe.measured, lift_of="valve")), base, Follower()
        )


def test_curvature_of_a_contour_is_that_of_its_arcs():
    """Base 15, flank 60 and nose 4 mm; with half a micrometre of noise, and a hollow; too rough a contour has none."""
    radii = three_arc(TURN)
    found, _ = curvature_of_contour(TURN, radii)
    assert found.min() == pytest.approx(4e-3, rel=1e-6) and found.max() == pytest.approx(
        60e-3, rel=1e-6
    )
    noise = np.random.default_rng(3).normal(0, 1, 720)
    noisy, spread = curvature_of_contour(TURN, radii + 5e-7 * noise)
    place = int(np.argmin(noisy))
    assert abs(noisy[place] - 4e-3) < 2 * BAND * spread[place] < 1e-3 and noisy.min() > 0
    hollow, _ = curvature_of_contour(TURN, 20e-3 - 2e-3 * np.cos(3 * TURN))
    # r^3 / (r + 2 r'^2 / r - r'') at the least radius: 18^2 / (18 - 9 x 2) is straight, at the largest 22^2 / (22 + 18)
    assert hollow[hollow > 0].min() == pytest.approx(22e-3**2 / 40e-3, rel=5e-3)
    assert np.all(np.isnan(curvature_of_contour(TURN, radii + 2e-5 * noise)[0]))


def test_a_contour_in_a_file_is_a_lift_by_its_follower():
    radii = three_arc(TURN)
    text = polar_table(TURN, radii)
    with pytest.raises(InputError, match="follower"):
        lifts_in(text, "own.csv", LiftAnswers())
    with pytest.raises(InputError, match="the angle in own"):
        lifts_in(text + b"\n" + 300 * b"9" + b",15", "own.csv", LiftAnswers(follower="flat"))
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
    assert Follower.of("roller 10 mm arm 40 mm pivot 40 mm, 27 mm") == FOLLOWERS["finger"]
    for wrong in ("ball", "roller", "roller -3 mm", "roller 10 mm arm 40 mm"):
        with pytest.raises(InputError):
            Follower.of(wrong)
