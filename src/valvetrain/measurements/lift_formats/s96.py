"""The ``.s96`` form of cam analysers: one lift a line, 360 of one cam degree each and 36 that repeat."""

from __future__ import annotations

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.content import text_of
from valvetrain.measurements.lift_formats.contract import LiftColumns, LiftFormat, LiftTable
from valvetrain.measurements.text_table import read_text_table

TURN, REPEATED = 360, 36


def recognise(content: bytes, name: str) -> bool:
    """Whether the text holds 396 rows of one number."""
    if b"\0" in content:
        return False
    try:
        return read_text_table(text_of(content, name), name).rows.shape == (TURN + REPEATED, 1)
    except InputError:
        return False


def read(content: bytes, name: str) -> LiftColumns:
    """The 360 lifts at whole cam degrees; its unit is not in the file.

    Raises :class:`InputError` when the last 36 rows neither repeat the first ones nor rest where they do.
    """
    table = read_text_table(text_of(content, name), name)
    lifts, again = table.rows[:TURN, 0], table.rows[TURN:, 0]
    allowed = 0.01 * float(np.ptp(lifts)) + 1e-12
    repeats = np.all(np.abs(again - lifts[:REPEATED]) <= allowed)
    rests = np.all(np.abs(again - lifts[0]) <= allowed) and abs(lifts[0] - lifts[-1]) <= allowed
    if not (repeats or rests):
        raise InputError(f"the last {REPEATED} rows of {name} neither repeat its first ones nor lie on the base circle; export it again")
    rows = np.column_stack([np.arange(TURN, dtype=float), lifts])
    said = {"angle_unit": "deg", "angle_of": "cam"}
    return LiftColumns("s96", rows, ("angle", "lift"), ("deg", ""), said, table.headings)


def write(table: LiftTable) -> bytes:
    """One lift (mm) a line at whole cam degrees from 0, the first 36 repeated at the end. Raises :class:`InputError` for two lobes."""
    if table.lifts.shape[1] != 1:
        raise InputError("the s96 form holds one lobe; write each lobe to its own file")
    grid = np.radians(np.arange(TURN, dtype=float))
    angles = np.mod(table.cam_angles, 2 * np.pi)
    order = np.argsort(angles)
    lifts = np.interp(grid, angles[order], table.lifts[order, 0], period=2 * np.pi)
    return ("\n".join(f"{1e3 * lift:.6f}" for lift in (*lifts, *lifts[:REPEATED])) + "\n").encode()


SPEC = LiftFormat("s96 of cam analysers", recognise, read, write)
