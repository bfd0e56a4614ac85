"""What a study of chosen points is judged by: its designs, each at the worst of its engine speeds and
runs, the one that the others are compared with, and what the touch of the valve and surge frequencies
say of one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import nominal
from valvetrain.explore.study_charts import shown_output
from valvetrain.explore.study_points import changed_alone, changing, draws_of, point_label
from valvetrain.explore.table import StudyTable
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import NESTED, definition_of, label_of

Array = NDArray[np.float64]
#: Varied quantities that are conditions of the engine, not a choice of the designer.
CONDITIONS = ("engine_speed", "cam_speed")
TOUCH = "seating_cam_angle"
FREQUENCY = "surge_frequency"
#: What a study without any lash leaves out, as people read it.
NO_LASH = "without lash a valve that grows warm would stay open, so that is no choice"


def conditions(table: StudyTable) -> list[int]:
    """Varied quantities that are conditions, if others are chosen, too."""
    keys = [table.plan.varied[index].key in CONDITIONS for index in changing(table)]
    found = [index for index, is_one in zip(changing(table), keys, strict=True) if is_one]
    return found if not all(keys) else []


def speeds_differ(table: StudyTable) -> bool:
    """Whether points are at engine speeds of their own, so that none can be preferred to another."""
    varies = any(table.plan.varied[index].key in CONDITIONS for index in changing(table))
    return varies and len(members(table)) == len(draws_of(table)) and not changed_alone(table)


def members(table: StudyTable) -> list[NDArray[np.intp]]:
    """The points (from 0) of each design: those that differ in engine speed alone, where every design has
    the same speeds; else every point is a design.
    """
    draws, held = draws_of(table), conditions(table)
    single = [np.array([point]) for point in range(len(draws))]
    if not held or changed_alone(table):
        return single
    own = np.delete(draws, held, axis=1)
    _, first, place = np.unique(own, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    groups = [np.flatnonzero(place.ravel() == k) for k in order]
    at = [set(map(tuple, draws[group][:, held].tolist())) for group in groups]
    return groups if all(one == at[0] for one in at) else single


def worst(table: StudyTable, name: str) -> Array:
    """Of every design the worst value of its points and runs by the sense of the quantity, the mean of
    those without one; nan where a run failed.
    """
    values = shown_output(table, name).reshape(len(draws_of(table)), -1)
    sense = definition_of(name).sense
    take = np.mean if not sense else np.min if sense == "larger is better" else np.max
    return np.array([take(values[group]) for group in members(table)])


def without_lash(table: StudyTable) -> NDArray[np.bool_]:
    """Which designs have no lash where others have some."""
    groups = members(table)
    none = np.zeros(len(groups), dtype=bool)
    for index in changing(table):
        if table.plan.varied[index].key.rpartition(".")[2] == "lash":
            none |= np.array([draws_of(table)[group[0], index] <= 0 for group in groups])
    return none if not none.all() else np.zeros_like(none)


def judged(table: StudyTable, name: str) -> Array:
    """As :func:`worst`, nan for designs that are of no use."""
    return np.where(without_lash(table), math.nan, worst(table, name))


def design_label(table: StudyTable, design: int) -> str:
    """Label that distinguishes a design from the others, without the engine speeds that all have."""
    group = members(table)[design]
    return point_label(table, int(group[0]), () if len(group) < 2 else tuple(conditions(table)))


def runs_text(table: StudyTable, name: str) -> str:
    """``, each the worst of 3 engine speeds``; empty where a design has one run."""
    speeds, runs = len(members(table)[0]), len(table.plan.runs)
    if speeds * runs < 2:
        return ""
    kind = "engine speeds" if runs < 2 else "runs"
    return f", {'each the worst' if definition_of(name).sense else 'the mean'} of {speeds * runs} {kind}"


def baseline(table: StudyTable) -> int | None:
    """The design that others are compared with: the first of a list, that without what a single quantity
    adds, or that of the case; None where a grid has neither.
    """
    if table.plan.sampler.word == "list":
        return 0
    along = [index for index in changing(table) if index not in conditions(table)]
    if table.plan.sampler.word != "grid" or table.plan.case is None or not along:
        return None
    values = np.array([draws_of(table)[group[0]] for group in members(table)])[:, along]
    there = values[:, 0] == 0 if len(along) == 1 else np.zeros(len(values), dtype=bool)
    if not there.any():
        try:
            own = [nominal(table.plan.case, table.plan.varied[index]) for index in along]
        except InputError:
            return None
        there = np.isclose(values, own, rtol=1e-9, atol=0.0).all(axis=1)
    found = np.flatnonzero(there & ~without_lash(table))
    return int(found[0]) if len(found) else None


def touch_clause(table: StudyTable, designs: NDArray[np.intp]) -> str:
    """``, touching at 133 cam deg or later``: where in the cycle the valve meets its seat by these
    designs; empty for a study that does not have it.
    """
    if TOUCH not in table.outputs:
        return ""
    values = shown_output(table, TOUCH).reshape(len(draws_of(table)), -1)
    groups = members(table)
    own = np.concatenate([values[groups[k]].ravel() for k in designs])
    if not np.isfinite(own).all():
        return ""
    first, last = number(float(own.min()), 3), number(float(own.max()), 3)
    if len(designs) < 2:
        ends = first if first == last else f"{first} to {last}"
        return f", touching at {ends} cam deg"
    others = np.setdiff1d(np.arange(len(groups)), [*designs, *np.flatnonzero(without_lash(table))])
    left = [values[groups[k]].ravel() for k in others]
    earlier = not left or float(np.nanmax(np.concatenate(left))) < float(own.min())
    return f", touching at {first} {'cam deg or later' if earlier else f'to {last} cam deg'}"


def frequency_clause(table: StudyTable, design: int) -> str:
    """``387 Hz, 4.6 % from the outer's 370 Hz``: the surge frequency that what is varied makes, of a pair
    also how far from that of the other spring; empty where no output says it.
    """
    known = {
        spring: worst(table, name)
        for spring in ("inner", "outer", "")
        if (name := f"{spring}_{FREQUENCY}".lstrip("_")) in table.outputs
    }
    known = {spring: one for spring, one in known.items() if np.isfinite(one).all()}
    moved = [spring for spring, one in known.items() if np.ptp(one) > 1e-3 * float(one.max())]
    if not moved:
        return ""
    own = float(known[moved[0]][design])
    other = {"inner": "outer", "outer": "inner"}.get(moved[0], "")
    rival = float(known[other][design]) if other in known else _of_card(table, other)
    if not math.isfinite(rival):
        return f"{label_of(f'{moved[0]}_{FREQUENCY}'.lstrip('_'))} {number(own, 3)} Hz"
    share = number(100 * abs(own / rival - 1), 2)
    return f"{number(own, 3)} Hz, {share} % from the {other}'s {number(rival, 3)} Hz"


def _of_card(table: StudyTable, spring: str) -> float:
    """Surge frequency (Hz) of the card of one of a pair that the study leaves as it is; nan for any other."""
    train = table.plan.case.train if table.plan.case is not None else None
    sets = {run[2] for run in table.plan.runs}
    word = sets.pop() if len(sets) == 1 else ""
    springs = train.springs.get(word or train.spring_set, ()) if train is not None else ()
    if len(springs) != 2 or spring not in NESTED:
        return math.nan
    place = NESTED.index(spring)
    head = f"train.springs.{word or (train.spring_set if train else '')}.{place}."
    card = springs[place].card
    if card is None or any(one.key.startswith(head) for one in table.plan.varied):
        return math.nan
    return card.surge_frequency or math.nan


def value_text(name: str, value: float) -> str:
    """A value in the unit of tables, with it."""
    return f"{number(value, 4)} {unit_text(definition_of(name).unit_word)}".strip()
