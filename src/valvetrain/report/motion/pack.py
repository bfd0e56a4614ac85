"""A moving picture as JSON for motion.js: numbers as base64 of little-endian arrays, lengths in mm, angles of the cam in degrees.

Rounding: axial displacements to half a step of the largest over 32767 (0.2 um for 10 mm), colours to 1/510 of their range, all else to
single precision.
"""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.report.chart import thin
from valvetrain.report.motion.marks import still_frame
from valvetrain.report.motion.parts import Body, Colouring, Moving, Series, SpringDrawing, Variant
from valvetrain.report.plotly_chart import in_script
from valvetrain.report.words import rpm

MM = 1e3
#: Colour of each part, readable on light and on dark paper.
TONES = {
    "cam": "#7d8aa0", "follower": "#a58b62", "lever": "#9a7f9f", "pivot": "#5f6672", "pushrod": "#a58b62", "valve": "#8a9a8e",
    "retainer": "#9aa6a0", "seat": "#7b7f86",
}  # fmt: skip


def motion_json(moving: Moving) -> str:
    """The picture as JSON text that may stand inside a script element."""
    return in_script(json.dumps(motion_data(moving), separators=(",", ":"), ensure_ascii=True))


def motion_data(moving: Moving) -> dict[str, Any]:
    """The picture as plain values: what ``mount(element, data)`` of motion.js takes."""
    return {"version": 1, "title": moving.title, "notes": list(moving.notes), "variants": [_variant(one) for one in moving.variants]}


def _variant(one: Variant) -> dict[str, Any]:
    return {
        "label": one.label, "words": one.words, "rpm": rpm(one.engine_speed), "closed": one.closed, "notes": list(one.notes),
        "start": round(float(np.degrees(one.cam_angle[still_frame(one)])), 4),
        "angle": single(np.degrees(one.cam_angle)), "lift": single(MM * one.valve_lift),
        "springs": [_spring(spring) for spring in one.springs], "bodies": [_body(body) for body in one.bodies],
        "forces": [_series(series) for series in one.forces],
        "marks": [{"angle": round(float(np.degrees(mark.cam_angle)), 3), "kind": mark.kind, "words": mark.words} for mark in one.marks],
    }  # fmt: skip


def _spring(spring: SpringDrawing) -> dict[str, Any]:
    scale = max(float(np.abs(spring.displacement).max(initial=0.0)) * MM / 32767, 1e-9)
    move = np.round(spring.displacement * MM / scale).astype("<i2")
    return {
        "name": spring.name, "coil": single(spring.coil), "radius": single(MM * spring.radius), "wire": single(MM * spring.wire_radius),
        "sign": spring.sign, "rest": single(MM * spring.rest), "move": {"d": _text(move), "scale": scale},
        "retainer": single(MM * spring.retainer), "seat": [MM * value for value in spring.seat], "direction": spring.direction,
        "colours": [_colouring(one) for one in spring.colourings],
    }  # fmt: skip


def _colouring(one: Colouring) -> dict[str, Any]:
    share = np.clip((one.values - one.low) / (one.high - one.low), 0.0, 1.0)
    return {
        "key": one.key, "words": one.words, "unit": one.unit, "low": one.low, "high": one.high, "stops": list(one.stops),
        "d": _text(np.round(share * 255).astype("u1")),
    }  # fmt: skip


def _body(body: Body) -> dict[str, Any]:
    pose = body.pose * (MM, MM, 1.0)
    fixed = bool(np.all(pose == pose[0]))
    shapes = [{"kind": one.kind, "points": single(MM * one.points), "depth": [MM * value for value in one.depth]} for one in body.shapes]
    return {"name": body.name, "colour": TONES[body.tone], "shapes": shapes, "fixed": fixed, "pose": single(pose[:1] if fixed else pose)}


def _series(series: Series) -> dict[str, Any]:
    x, y = thin(np.degrees(series.cam_angle), series.values)
    return {"words": series.words, "colour": series.colour, "angle": single(x), "values": single(y)}


def single(values: ArrayLike) -> str:
    """Values in single precision as base64."""
    return _text(np.asarray(values, dtype="<f4"))


def _text(values: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
