"""How the output of a grid goes along one quantity, the worst over engine speeds: how far it stays
near its best.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.study_charts import shown_output
from valvetrain.explore.study_points import changing, draws_of
from valvetrain.explore.table import StudyTable
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import definition_of

Array = NDArray[np.float64]
#: Varied quantities that are conditions of the engine, nobody's choice.
CONDITIONS = ("engine_speed", "cam_speed")
#: Fewest values along which a shape is told; share of the output's range within which it is flat, and
#: share of the varied range that a flat part has: more than twice that of a straight line.
FEWEST, FLAT, WIDE = 4, 0.2, 0.45


def conditions(table: StudyTable) -> list[int]:
    """Varied quantities that are conditions, beside which others are chosen."""
    keys = [table.plan.varied[index].key in CONDITIONS for index in changing(table)]
    found = [index for index, is_one in zip(changing(table), keys, strict=True) if is_one]
    return found if not all(keys) else []


def shape_clause(table: StudyTable, name: str) -> str:
    """``at every engine speed seating velocity stays within 0.162 m/s up to lash 0.2 mm, but 0.479 m/s
    at 0.25 mm``: the flat part at the better end of a grid along one quantity; empty for points
    without one, or along several quantities.
    """
    held = conditions(table)
    along = [index for index in changing(table) if index not in held]
    sense = definition_of(name).sense
    if len(along) != 1 or not sense or table.plan.sampler.word != "grid":
        return ""
    place, values = _worst_along(table, name, along[0], sense)
    if len(place) < FEWEST or not np.isfinite(values).all() or np.ptp(values) <= 0:
        return ""
    less = values - values.min() if sense != "larger is better" else values.max() - values
    flat = less <= FLAT * np.ptp(values)
    upward = bool(flat[0])
    if upward == bool(flat[-1]):  # both ends are good, or the best lies between
        return ""
    count = int(np.argmin(flat if upward else flat[::-1]))
    edge, beyond = (count - 1, count) if upward else (len(flat) - count, len(flat) - count - 1)
    if abs(place[edge] - place[0 if upward else -1]) < WIDE * np.ptp(place):
        return ""
    row, good = definition_of(name), values[flat]
    unit, larger = unit_text(row.shown_unit), sense == "larger is better"
    bound = f"{'stays at' if larger else 'stays within'} {number(float(good.min() if larger else good.max()), 3)} {unit}"
    where = f"{'up to' if upward else 'from'} {_at(table, along[0], place[edge])}{'' if upward else ' on'}"
    return (
        f"{'at every engine speed ' if held else ''}{row.label} {bound}{' or more' if larger else ''} {where}, "
        f"but {number(float(values[beyond]), 3)} {unit} at {_value(table, along[0], place[beyond])}"
    )


def _worst_along(table: StudyTable, name: str, index: int, sense: str) -> tuple[Array, Array]:
    """Values of one quantity and the worst output over all runs and points that have them."""
    draws = draws_of(table)[:, index]
    found = shown_output(table, name).reshape(len(draws), -1)
    worst = np.min if sense == "larger is better" else np.max
    place = np.unique(draws)
    return place, np.array([worst(found[draws == one]) for one in place])


def _at(table: StudyTable, index: int, value: float) -> str:
    return f"{table.plan.varied[index].shown_name} {_value(table, index, value)}"


def _value(table: StudyTable, index: int, value: float) -> str:
    one = table.plan.varied[index]
    return f"{number(one.shown(float(value)), 4)} {unit_text(one.unit)}".strip()
