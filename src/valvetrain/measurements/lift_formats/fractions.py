"""Fractions of lift over fractions of the event, from 0 to 1 both ways, as engine simulations pass lifts on."""

from __future__ import annotations

import io

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.content import text_of
from valvetrain.measurements.lift_formats.contract import LiftColumns, LiftFormat, LiftTable
from valvetrain.measurements.text_table import read_text_table


def recognise(content: bytes, name: str) -> bool:
    """Whether two columns run from (0, 0) over a largest lift of 1 to (1, 0)."""
    if b"\0" in content:
        return False
    try:
        rows = read_text_table(text_of(content, name), name).rows
    except InputError:
        return False
    if rows.shape[1] != 2 or len(rows) < 5:
        return False
    place, lift = rows.T
    ends = abs(place[0]) < 1e-6 and abs(place[-1] - 1) < 1e-6 and abs(lift[0]) < 0.02 and abs(lift[-1]) < 0.02
    return bool(ends and np.all(np.diff(place) > 0) and abs(lift.max() - 1) < 1e-3 and lift.min() > -0.02)


def read(content: bytes, name: str) -> LiftColumns:
    """The fractions; peak lift, duration and opening angle have to be told."""
    table = read_text_table(text_of(content, name), name)
    said = {"angle_unit": "1", "lift_unit": "1"}
    return LiftColumns("fractions", table.rows, ("angle", "lift"), ("", ""), said, table.headings)


def write(table: LiftTable) -> bytes:
    """Fractions of the largest lift over fractions of the event. Raises :class:`InputError` for two lobes."""
    if table.lifts.shape[1] != 1:
        raise InputError("fractions of lift hold one lobe; write each lobe to its own file")
    up = np.flatnonzero(table.lifts[:, 0] > 0)
    first, last = max(int(up[0]) - 1, 0), min(int(up[-1]) + 1, len(table.lifts) - 1)
    angles, lifts = table.cam_angles[first : last + 1], np.clip(table.lifts[first : last + 1, 0], 0.0, None)
    lifts = np.concatenate([[0.0], lifts[1:-1], [0.0]])
    out = io.StringIO()
    out.write("fraction of duration,fraction of lift\n")
    for place, lift in zip((angles - angles[0]) / (angles[-1] - angles[0]), lifts / lifts.max(), strict=True):
        out.write(f"{place:.6f},{lift:.6f}\n")
    return out.getvalue().encode()


SPEC = LiftFormat("fractions of lift", recognise, read, write)
