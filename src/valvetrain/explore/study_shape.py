"""How the output of a grid goes along one quantity, the worst over engine speeds: where it jumps, or
from where on there is little more to gain.
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
#: Fewest values along which a shape is found; share of the whole change that one step makes where the
#: output jumps; share of the gain after which little is left.
FEWEST, JUMP, MOST = 4, 0.5, 0.9


def conditions(table: StudyTable) -> list[int]:
    """Varied quantities that are conditions, beside which others are chosen."""
    keys = [table.plan.varied[index].key in CONDITIONS for index in changing(table)]
    found = [index for index, is_one in zip(changing(table), keys, strict=True) if is_one]
    return found if not all(keys) else []


def shape_clause(table: StudyTable, name: str) -> str:
    """``at every engine speed seating velocity stays within 0.162 m/s up to lash 0.2 mm, but 0.479 m/s
    at 0.25 mm``, or
    ``nine tenths of the gain are there from normal force 40 N on``; empty for points without such a
    shape or along several quantities.
    """
    held = conditions(table)
    along = [index for index in changing(table) if index not in held]
    sense = definition_of(name).sense
    if len(along) != 1 or not sense or table.plan.sampler.word != "grid":
        return ""
    place, values = _worst_along(table, name, along[0], sense)
    if len(place) < FEWEST or not np.isfinite(values).all() or np.ptp(values) <= 0:
        return ""
    steps = np.abs(np.diff(values))
    jump, best = int(np.argmax(steps)), _best(values, sense)
    if held and steps[jump] >= JUMP * np.ptp(values):
        return _jump_text(table, name, along[0], place, values, jump, sense)
    gain = np.abs(values - values[0 if best > len(values) / 2 else -1])
    reached = np.flatnonzero(gain >= MOST * gain[best])
    first = int(reached[0] if best > len(values) / 2 else reached[-1])
    if first == best or abs(best - first) < 2:
        return ""
    return f"nine tenths of the gain are there {'from' if best > first else 'up to'} {_at(table, along[0], place[first])}"


def _best(values: Array, sense: str) -> int:
    return int(np.argmax(values) if sense == "larger is better" else np.argmin(values))


def _worst_along(table: StudyTable, name: str, index: int, sense: str) -> tuple[Array, Array]:
    """Values of one quantity and the worst output over all runs and points that have them."""
    draws = draws_of(table)[:, index]
    found = shown_output(table, name).reshape(len(draws), -1)
    worst = np.min if sense == "larger is better" else np.max
    place = np.unique(draws)
    return place, np.array([worst(found[draws == one]) for one in place])


def _jump_text(
    table: StudyTable, name: str, index: int, place: Array, values: Array, jump: int, sense: str
) -> str:
    row = definition_of(name)
    below = _best(values, sense) <= jump
    good = values[: jump + 1] if below else values[jump + 1 :]
    held = float(np.min(good) if sense == "larger is better" else np.max(good))
    edge, beyond = (jump, jump + 1) if below else (jump + 1, jump)
    unit = unit_text(row.shown_unit)
    bound = "stays at" if sense == "larger is better" else "stays within"
    more = " or more" if sense == "larger is better" else ""
    return (
        f"at every engine speed {row.label} {bound} {number(held, 3)} {unit}{more} "
        f"{'up to' if below else 'from'} {_at(table, index, place[edge])}{'' if below else ' on'}, "
        f"but {number(float(values[beyond]), 3)} {unit} at {_value(table, index, place[beyond])}"
    )


def _at(table: StudyTable, index: int, value: float) -> str:
    return f"{table.plan.varied[index].shown_name} {_value(table, index, value)}"


def _value(table: StudyTable, index: int, value: float) -> str:
    one = table.plan.varied[index]
    return f"{number(one.shown(float(value)), 4)} {unit_text(one.unit)}".strip()
