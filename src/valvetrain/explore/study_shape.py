"""How the output of a grid goes along one quantity, the worst over engine speeds: how far it stays
near its best.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.study_designs import (
    NO_LASH,
    conditions,
    frequency_clause,
    judged,
    members,
    touch_clause,
    without_lash,
)
from valvetrain.explore.study_points import changing, draws_of
from valvetrain.explore.table import StudyTable
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import definition_of

Array = NDArray[np.float64]
#: Fewest values from which a shape is reported; share of the output's range within which it is flat, and
#: share of the varied range that a flat part has: more than twice that of a straight line.
FEWEST, FLAT, WIDE = 4, 0.2, 0.45


@dataclass(frozen=True)
class Shape:
    """The flat part at the better end of a grid: its ``clause``, what ``also`` belongs to it, and the
    design at its edge.
    """

    clause: str
    edge: int
    also: str = ""


def shape_of(table: StudyTable, name: str) -> Shape | None:
    """``at every engine speed seating velocity stays within 0.162 m/s up to lash 0.2 mm, but 0.479 m/s
    at 0.25 mm``: the flat part at the better end of a grid along one quantity, what surge frequency
    its edge has and where the valve touches; None for points without one, or along several
    quantities.
    """
    held = conditions(table)
    along = [index for index in changing(table) if index not in held]
    sense = definition_of(name).sense
    if len(along) != 1 or not sense or table.plan.sampler.word != "grid":
        return None
    left = np.flatnonzero(~without_lash(table))
    draws = np.array([draws_of(table)[group[0], along[0]] for group in members(table)])[left]
    order = np.argsort(draws)
    designs, place, values = left[order], draws[order], judged(table, name)[left][order]
    if len(place) < FEWEST or not np.isfinite(values).all() or np.ptp(values) <= 0:
        return None
    less = values - values.min() if sense != "larger is better" else values.max() - values
    flat = less <= FLAT * np.ptp(values)
    upward = bool(flat[0])
    if upward == bool(flat[-1]):  # both ends are good, or the best is between
        return None
    count = int(np.argmin(flat if upward else flat[::-1]))
    edge, beyond = (count - 1, count) if upward else (len(flat) - count, len(flat) - count - 1)
    if abs(place[edge] - place[0 if upward else -1]) < WIDE * np.ptp(place):
        return None
    row, good = definition_of(name), values[flat]
    unit, larger = unit_text(row.unit_word), sense == "larger is better"
    bound = f"{'stays at' if larger else 'stays within'} {number(float(good.min() if larger else good.max()), 3)} {unit}"
    frequency = frequency_clause(table, int(designs[edge]))
    varied = table.plan.varied[along[0]]
    at = f"{varied.text(float(place[edge]), 4)}{f' ({frequency})' if frequency else ''}"
    where = f"{'up to' if upward else 'from'} {at}{'' if upward else ' on'}"
    touch = touch_clause(table, designs[: edge + 1] if upward else designs[edge:])
    clause = (
        f"{'at every engine speed ' if held else ''}{row.label} {bound}{' or more' if larger else ''} {where}{touch}, "
        f"but {number(float(values[beyond]), 3)} {unit} at {varied.value_text(float(place[beyond]), 4)}"
    )
    return Shape(clause, int(designs[edge]), f"; {NO_LASH}" if without_lash(table).any() else "")
