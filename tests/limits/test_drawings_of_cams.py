"""Limits: a cam in a DXF drawing, however it was drawn, is the cam of the closed form."""

from __future__ import annotations

import io
import math
import re

import numpy as np
import pytest

from known_lifts import three_arc
from valvetrain.errors import InputError
from valvetrain.measured.contours import Follower, lift_of_contour
from valvetrain.measured.lift_file import LiftAnswers, lifts_in

ezdxf = pytest.importorskip("ezdxf")
FLAT = LiftAnswers(follower="flat")
BASE, FLANK, NOSE, RISE = 15.0, 60.0, 4.0, 8.0


def arcs(at=(0.0, 0.0)):
    """Centre, radius, first and last angle (deg) of the four arcs of a cam with its nose along x (mm)."""
    far, beyond = BASE + RISE - NOSE, FLANK - BASE
    opening = math.acos(((FLANK - NOSE) ** 2 - far**2 - beyond**2) / (2 * far * beyond))
    flank = -beyond * np.array([math.cos(opening), math.sin(opening)])
    touch = math.degrees(math.atan2(-flank[1], far - flank[0]))
    begin = math.degrees(opening)
    shift = np.array(at)
    return [
        (shift + np.array([far, 0.0]), NOSE, -touch, touch), (shift + flank, FLANK, touch, begin),
        (shift, BASE, begin, 360 - begin), (shift + flank * (1, -1), FLANK, -begin, -touch),
    ]  # fmt: skip


def content(document):
    out = io.StringIO()
    document.write(out)
    return out.getvalue().encode()


def drawing(unit=4):
    document = ezdxf.new(units=unit)
    return document, document.modelspace()


def loose(space, at=(0.0, 0.0), scale=1.0):
    for centre, radius, first, last in [arcs(at)[place] for place in (2, 0, 3, 1)]:
        space.add_arc(tuple(centre * scale), radius * scale, first, last)


def of_arcs():
    document, space = drawing()
    loose(space)
    return document


def about_its_bore_in_a_frame():
    document, space = drawing()
    loose(space, (140.0, 95.0))
    space.add_circle((140.0, 95.0), 6.0)
    space.add_circle((140.0, 95.0), 7.0)
    space.add_lwpolyline([(0, 0), (297, 0), (297, 210), (0, 210)], close=True)
    space.add_text("CAM 2", height=5).set_placement((20, 20))
    return document


def in_inches():
    document, space = drawing(1)
    loose(space, scale=1 / 25.4)
    return document


def as_a_polyline():
    document, space = drawing()
    points = [
        (*(centre + radius * np.array([math.cos(math.radians(first)), math.sin(math.radians(first))])),
         math.tan(math.radians(last - first) / 4))
        for centre, radius, first, last in arcs()
    ]  # fmt: skip
    space.add_lwpolyline(points, format="xyb", close=True)
    return document


def as_a_block():
    document, space = drawing()
    loose(document.blocks.new("LOBE"))
    space.add_blockref("LOBE", (0, 0))
    return document


DRAWN = {
    function.__name__: function
    for function in (of_arcs, about_its_bore_in_a_frame, in_inches, as_a_polyline, as_a_block)
}


@pytest.mark.parametrize("name", DRAWN)
def test_three_arcs_however_they_are_drawn(name):
    (lobe,) = lifts_in(content(DRAWN[name]()), "cam.dxf", FLAT)
    even = np.radians(np.arange(0, 360, 0.1))
    theta, lifts = lift_of_contour(even, three_arc(even), Follower())
    nose = lobe.cam_angles[np.argmax(lobe.lifts)]
    away = np.angle(np.exp(1j * (lobe.cam_angles - nose)))
    true = np.interp(away, np.angle(np.exp(1j * theta)), lifts, period=2 * np.pi)
    np.testing.assert_allclose(lobe.lifts, true, atol=1e-6)
    assert lobe.form == "drawing"


def test_a_circle_beside_its_centre_lifts_twice_its_eccentricity():
    document, space = drawing()
    space.add_circle((5.0, 0.0), 18.0)
    (lobe,) = lifts_in(content(document), "cam.dxf", LiftAnswers(follower="roller 10 mm"))
    assert np.ptp(lobe.lifts) == pytest.approx(10e-3, abs=1e-8)


def test_a_spline_through_a_contour_is_that_contour():
    document, space = drawing()
    turn = np.linspace(0, 2 * np.pi, 181)
    radius = 20 + 4 * np.cos(turn)
    space.add_spline(
        [(x, y, 0) for x, y in zip(radius * np.cos(turn), radius * np.sin(turn), strict=True)]
    )
    (lobe,) = lifts_in(content(document), "cam.dxf", LiftAnswers(follower="roller 3 mm"))
    even = np.radians(np.arange(0, 360, 0.1))
    expected = lift_of_contour(even, 1e-3 * (20 + 4 * np.cos(even)), Follower(3e-3))[1]
    assert lobe.lifts.max() == pytest.approx(expected.max(), abs=1e-6)


def _open():
    document, space = drawing()
    for centre, radius, first, last in arcs()[:3]:
        space.add_arc(tuple(centre), radius, first, last)
    return content(document)


def _elsewhere():
    document, space = drawing()
    loose(space, (140.0, 95.0))
    return content(document)


def _two_bores():
    document, space = drawing()
    loose(space)
    space.add_circle((0.0, 0.0), 3.0)
    space.add_circle((8.0, 0.0), 2.0)
    return content(document)


def _key():
    document, space = drawing()
    space.add_lwpolyline(
        [(10, 2, 0.6), (-10, 2, 0), (-4, 2, 0), (-4, 1, 0), (-10, 1, 0.6), (10, 1, 0)],
        format="xyb",
        close=True,
    )
    return content(document)


def _damaged():
    return content(of_arcs())[:900] + b"\x00\xff" * 200


@pytest.mark.parametrize("wrong", [_open, _elsewhere, _two_bores, _key, _damaged])
def test_what_is_no_cam_is_refused(wrong):
    with pytest.raises(InputError, match=r"cam\.dxf"):
        lifts_in(wrong(), "cam.dxf", FLAT)


def test_a_drawing_without_a_unit_asks_for_it():
    document, space = drawing(0)
    loose(space)
    with pytest.raises(InputError) as refusal:
        lifts_in(content(document), "cam.dxf", FLAT)
    assert refusal.value.where == "lift_unit"


def test_a_damaged_number_is_refused():
    """A point at "4,2" is not one at 4."""
    document, space = drawing()
    loose(space)
    whole = content(document)
    damaged = re.sub(rb"(LINE.*?\n 20\n-?\d+)\.", rb"\1,", whole, count=1, flags=re.DOTALL)
    assert damaged != whole
    with pytest.raises(InputError, match=r"cam\.dxf"):
        lifts_in(damaged, "cam.dxf", FLAT)
