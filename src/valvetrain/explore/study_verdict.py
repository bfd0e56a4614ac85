"""The verdict on a study of points: the best point and what it costs, what moves an output most, or
how an output scatters.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.clearance import clearance_clause, over_clearance
from valvetrain.explore.outputs import Run
from valvetrain.explore.sensitivity import Sensitivity
from valvetrain.explore.study_charts import PERCENTILES, shown_output
from valvetrain.explore.study_points import (
    changed_alone,
    draws_of,
    is_chosen,
    point_label,
    point_names,
)
from valvetrain.explore.study_shape import conditions, shape_clause
from valvetrain.explore.table import StudyTable, run_label
from valvetrain.quantities.request import BY_SIZE
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import definition_of

Array = NDArray[np.float64]
#: Outputs whose price at the best point is told.
MAX_COSTS = 2
#: Share within which values are no better than each other, and points of that kind that are named.
ALIKE, MAX_ALIKE = 0.01, 2
#: Further changes of a list that are named behind the largest.
MAX_NEXT = 3
#: Outputs by which springs are judged before all others, for by them they break.
STRESSES = ("largest_amplitude_shear_stress", "peak_shear_stress", "nominal_peak_shear_stress")
#: Names of what a spring is installed with begin so.
INSTALLED = ("preload", "installed_")


def study_verdict(table: StudyTable) -> str:
    """The sentence; points that failed come first."""
    failed = int(np.count_nonzero(~table.completed))
    if failed == len(table):
        reason = f": {table.failures[0]}" if table.failures else ""
        return f"No point completed{reason}."
    lead = f"{failed} of {len(table)} points failed; of the others: " if failed else ""
    known = [one for one in table.outputs if _known(table, one)]
    if not known:
        return f"{lead}{table.not_given[0]}"
    name, calmed = judged_output(table), over_clearance(table)
    if calmed:
        said = clearance_clause(table, calmed)
    elif not is_chosen(table):
        said = _scatter(table, known[0])
    elif changed_alone(table) and np.isfinite(_worst(table, name)[0]):
        said = _largest_change(table, name)
    else:
        shape = shape_clause(table, name)
        single = table.plan.sampler.word == "list" and _bare(name) in STRESSES
        best = _stressed if single else _best
        said = (
            best(table, name)
            if not shape
            else shape
            if conditions(table)
            else _flat(table, name, shape)
        )
    return f"{lead}{said}." if lead else f"{said[:1].upper()}{said[1:]}."


def judged_output(table: StudyTable) -> str:
    """The output that the sentence is about: of chosen points one that the motion gives, for the best
    of what was put in is no finding; empty where none is known.
    """
    known = [one for one in table.outputs if _known(table, one)]
    if not is_chosen(table):
        return next(iter(known), "")
    stress = (one for bare in STRESSES for one in known if _bare(one) == bare)
    moved = (one for one in known if not _installed(one))
    return next(stress, next(moved, next(iter(known), "")))


def _known(table: StudyTable, name: str) -> bool:
    return bool(np.isfinite(shown_output(table, name)).any())


def _bare(name: str) -> str:
    """A quantity without the spring of a pair that it is of."""
    return name.removeprefix("outer_").removeprefix("inner_")


def _installed(name: str) -> bool:
    """Whether a quantity follows from the dimensions of a spring, its installing and the lift alone."""
    bare = _bare(name)
    return bare in BY_SIZE or bare.startswith(INSTALLED) or bare == "coil_bind_clearance"


def _label(name: str) -> str:
    return definition_of(name).label


def _shown(name: str, value: float) -> str:
    return f"{number(value, 4)} {unit_text(definition_of(name).shown_unit)}".strip()


def _worst(table: StudyTable, name: str) -> Array:
    """Of every point the worst value of its runs by the sense of the quantity, the mean of those
    without one; nan where a run failed.
    """
    values = shown_output(table, name).reshape(len(draws_of(table)), -1)
    sense = definition_of(name).sense
    worst = np.mean if not sense else np.min if sense == "larger is better" else np.max
    return np.asarray(worst(values, axis=1))


def _runs_text(table: StudyTable, name: str) -> str:
    count = len(table.plan.runs)
    if count < 2:
        return ""
    return f", {'each the worst' if definition_of(name).sense else 'the mean'} of {count} runs"


def _best(table: StudyTable, name: str) -> str:
    """The best point and what other outputs are worse there; the extremes of an output that is
    neither good nor bad.
    """
    values, runs = _worst(table, name), _runs_text(table, name)
    if not np.isfinite(values).any():
        return f"the {_label(name)} is known at no point for every run"
    low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
    if values[low] == values[high]:
        return f"the {_label(name)} is {_shown(name, values[low])} at every point{runs}"
    sense = definition_of(name).sense
    if not sense:
        least, most = (
            f"{_shown(name, values[k])} with {point_label(table, k)}" for k in (low, high)
        )
        return f"the {_label(name)} is between {least} and {most}{runs}"
    best, other = (high, low) if sense == "larger is better" else (low, high)
    ends = f"{_shown(name, values[best])}, {_shown(name, values[other])} at the worst point"
    said = f"best is {point_label(table, best)}{_alike(table, values, best)}: {_label(name)} {ends}"
    return f"{said}{_costs(table, name, best)}{runs}"


def _costs(table: StudyTable, name: str, best: int, above: float = 0.0) -> str:
    """What other outputs lose at the best point against their own best, by more than a share."""
    costs: list[str] = []
    for one in table.outputs:
        if one == name or not definition_of(one).sense or not _known(table, one):
            continue
        own = _worst(table, one)
        if not np.isfinite(own[best]):
            continue
        larger = definition_of(one).sense == "larger is better"
        ideal = float(np.nanmax(own) if larger else np.nanmin(own))
        if abs(own[best] - ideal) > above * abs(ideal):
            costs.append(f"{_label(one)} {_shown(one, own[best])} ({_shown(one, ideal)} at best)")
    return f"; it costs {' and '.join(costs[:MAX_COSTS])}" if costs else ""


def _flat(table: StudyTable, name: str, shape: str) -> str:
    """How far a grid along one quantity stays near its best, and how little the best point brings
    beyond, which may be no more than the end of what was varied.
    """
    values = _worst(table, name)
    ends = (int(np.nanargmin(values)), int(np.nanargmax(values)))
    best, worst = ends[::-1] if definition_of(name).sense == "larger is better" else ends
    most = f"{_shown(name, values[worst])} at the worst point"
    beyond = f"{point_label(table, best)} brings little more, {_shown(name, values[best])}"
    return (
        f"{shape} and {most}; {beyond}{_costs(table, name, best, ALIKE)}{_runs_text(table, name)}"
    )


def _stressed(table: StudyTable, name: str) -> str:
    """The point of a list that is stressed most, the one that is least, and what else is worse there."""
    values, runs = _worst(table, name), _runs_text(table, name)
    if np.count_nonzero(np.isfinite(values)) < 2 or np.nanmin(values) == np.nanmax(values):
        return _best(table, name)
    most, least = int(np.nanargmax(values)), int(np.nanargmin(values))
    if values[most] - values[least] <= ALIKE * values[most]:
        return f"all are stressed alike: {_label(name)} {_shown(name, values[least])} to {_shown(name, values[most])}{runs}"
    worse: list[str] = []
    for one in table.outputs:
        sense = definition_of(one).sense
        if one == name or not sense or not _known(table, one) or _installed(one):
            continue
        ours, theirs = (_worst(table, one)[at] for at in (most, least))
        if (ours < theirs) == (sense == "larger is better") and abs(ours - theirs) > ALIKE * abs(
            ours
        ):
            worse.append(f"{_label(one)} {_shown(one, ours)} against {_shown(one, theirs)}")
    said = (
        f"{point_label(table, most)} is stressed most, so of equal wires it breaks first: {_label(name)} "
        f"{_shown(name, values[most])} against {_shown(name, values[least])} with {point_label(table, least)}"
    )
    more = f"; with {' and '.join(worse[:MAX_COSTS])}" if worse else ""
    return f"{said}{more}{runs}"


def _alike(table: StudyTable, values: Array, best: int) -> str:
    """The other points whose value is that of the best within :data:`ALIKE`, in brackets."""
    near = np.abs(values - values[best]) <= ALIKE * abs(values[best])
    others = [point_label(table, int(k)) for k in np.flatnonzero(near) if k != best]
    if not others or near.all():
        return ""
    more = f" and {len(others) - MAX_ALIKE} more" if len(others) > MAX_ALIKE else ""
    return f" (within {100 * ALIKE:.0f} %: {', '.join(others[:MAX_ALIKE])}{more})"


def _largest_change(table: StudyTable, name: str) -> str:
    """The point of a list that changes one quantity at a time at which an output changes most."""
    values, runs = _worst(table, name), _runs_text(table, name)
    change = values - values[0]
    most = int(np.nanargmax(np.abs(change)))
    if not change[most]:
        return f"no change moves the {_label(name)} of {_shown(name, values[0])}{runs}"
    most_text = f"{_label(name)} {_shown(name, values[most])} ({_moved(table, name, change, most)})"
    near = np.abs(np.abs(change) - abs(change[most])) <= ALIKE * abs(change[most])
    equal = [most, *(int(k) for k in np.flatnonzero(near) if k != most)][: MAX_ALIKE + 1]
    names = " or ".join(point_label(table, k) for k in equal)
    first = f" ({point_label(table, 0)})" if point_names(table) else ""
    said = f"most is moved by {names}: {most_text} from {_shown(name, values[0])}{first}"
    rest = [
        int(k) for k in np.argsort(-np.abs(change), kind="stable") if change[k] and k not in equal
    ]
    others = [f"{point_label(table, k)} {_moved(table, name, change, k)}" for k in rest[:MAX_NEXT]]
    if others:
        more = f" and {len(rest) - MAX_NEXT} more" if len(rest) > MAX_NEXT else ""
        said += f"; then {', '.join(others)}{more}"
    return f"{said}{runs}"


def _moved(table: StudyTable, name: str, change: Array, point: int) -> str:
    """A change with its sign and unit; of a mass also for each gram."""
    unit = unit_text(definition_of(name).shown_unit)
    said = f"{change[point]:+.3g} {unit}".strip()
    one = table.plan.varied[changed_alone(table)[point]]
    draws = draws_of(table)[[0, point], changed_alone(table)[point]]
    grams = abs(float(one.shown(float(draws[1])) - one.shown(float(draws[0]))))
    if one.unit == "g" and grams:
        said += f", {abs(float(change[point])) / grams:.2g} {unit} per g"
    return said.replace("-", "−")


def _scatter(table: StudyTable, name: str) -> str:
    """Nine in ten draws of an output at its worst run, and what makes its spread."""
    sense = definition_of(name).sense
    ends: dict[Run, Array] = {}
    for run in table.plan.runs:
        found = shown_output(table, name)[table.rows_of(run)]
        if np.isfinite(found).any():
            ends[run] = np.percentile(found[np.isfinite(found)], PERCENTILES)
    run = (
        min(ends, key=lambda one: float(ends[one][0]))
        if sense == "larger is better"
        else max(ends, key=lambda one: float(ends[one][2]))
    )
    low, middle, high = (float(value) for value in ends[run])
    where = f" at {run_label(run)}" if len(table.plan.runs) > 1 else ""
    said = f"the {_label(name)} is {number(low, 4)} to {_shown(name, high)} in nine of ten draws{where}, median {_shown(name, middle)}"
    cause = next(
        (one for one in table.sensitivities if one.output == name and one.run == run), None
    )
    return said + (_cause(cause) if cause is not None else "")


def _cause(one: Sensitivity) -> str:
    """Which quantity makes most of the spread, where it can be told from the next."""
    leader = int(np.argmax(one.total))
    if not one.total[leader] > 0:
        return ""
    rivals = np.delete(one.total_interval[:, 1], leader) >= one.total_interval[leader, 0]
    if rivals.any():
        return "; no quantity alone makes this spread"
    return f"; {one.names[leader]} makes {100 * one.total[leader]:.0f} % of its variance"
