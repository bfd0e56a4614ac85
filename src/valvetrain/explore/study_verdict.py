"""The verdict on a study of points: the best point and what it costs, what moves an output most, or
how an output scatters.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.clearance import clearance_clause, over_clearance
from valvetrain.explore.outputs import Run
from valvetrain.explore.sensitivity import Sensitivity
from valvetrain.explore.study_charts import PERCENTILES, shown_output
from valvetrain.explore.study_designs import (
    NO_LASH,
    baseline,
    conditions,
    design_label,
    frequency_clause,
    judged,
    runs_text,
    speeds_differ,
    touch_clause,
    value_text,
    without_lash,
    worst,
)
from valvetrain.explore.study_points import (
    changed_alone,
    draws_of,
    is_chosen,
    point_label,
    point_names,
)
from valvetrain.explore.study_shape import Shape, shape_of
from valvetrain.explore.surrogate import POOR
from valvetrain.explore.table import StudyTable, run_label
from valvetrain.quantities.request import BY_SIZE
from valvetrain.report.clauses import joined
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import definition_of, label_of

Array = NDArray[np.float64]
#: Outputs whose price at the best point is reported.
MAX_COSTS = 3
#: Share within which values are no better than each other, and points of that kind that are named.
ALIKE, MAX_ALIKE = 0.01, 2
#: Further changes of a list that are named behind the largest.
MAX_NEXT = 5
#: Outputs by which springs are judged before all others, for by them they break.
STRESSES = ("largest_amplitude_shear_stress", "peak_shear_stress", "open_nominal_shear_stress")
#: Share up to which the gain of a grid over its reference is worded as "only".
LITTLE = 0.1
#: What makes a stress amplitude larger -> in words.
REASONS = {"surge_amplitude_force": "it surges more", "clash_energy": "its coils clash harder"}
#: Durations of the valve of a run.
DURATION = re.compile(r"valve_\w+_open_crank_angle_range")
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
    elif changed_alone(table) and np.isfinite(worst(table, name)[0]):
        said = _largest_change(table, name)
    else:
        shape = shape_of(table, name)
        single = table.plan.sampler.word == "list" and _bare(name) in STRESSES
        best = _stressed if single else _best
        said = (
            best(table, name)
            if shape is None
            else f"{shape.clause}{shape.also}"
            if conditions(table)
            else _flat(table, name, shape)
        )
    return f"{lead}{said}." if lead else f"{said[:1].upper()}{said[1:]}."


def judged_output(table: StudyTable) -> str:
    """The output that the sentence is about: of chosen points a stress, else a limit speed that is
    searched, else one that the motion gives, for the best of what was put in is no finding; empty
    where none is known.
    """
    known = [one for one in table.outputs if _known(table, one)]
    if not is_chosen(table):
        return next(iter(known), "")
    stress = (one for bare in STRESSES for one in known if _bare(one) == bare)
    limits = {one.name for one in table.plan.experiment.outputs.limit_speeds}
    moved = sorted((one for one in known if not _installed(one)), key=lambda one: one not in limits)
    return next(stress, next(iter(moved), next(iter(known), "")))


def _known(table: StudyTable, name: str) -> bool:
    return bool(np.isfinite(shown_output(table, name)).any())


def _bare(name: str) -> str:
    """A quantity without the spring of a pair that it is of."""
    return name.removeprefix("outer_").removeprefix("inner_")


def _installed(name: str) -> bool:
    """Whether a quantity follows from the dimensions of a spring, its installing and the lift alone."""
    bare = _bare(name)
    return bare in BY_SIZE or bare.startswith(INSTALLED) or bare == "coil_bind_clearance"


def _best(table: StudyTable, name: str) -> str:
    """The best design, next to the one that others are compared with, and what other outputs gain and
    lose there; the extremes of an output that is neither good nor bad, or of points at engine speeds
    of their own.
    """
    values, runs = judged(table, name), runs_text(table, name)
    if not np.isfinite(values).any():
        return f"the {label_of(name)} is known at no point for every run"
    low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
    if values[low] == values[high]:
        return f"the {label_of(name)} is {value_text(name, values[low])} at every point{runs}"
    sense = definition_of(name).sense
    if not sense or speeds_differ(table):
        least, most = (
            f"{value_text(name, values[k])} with {design_label(table, k)}" for k in (low, high)
        )
        return f"the {label_of(name)} is between {least} and {most}{runs}"
    best, other = (high, low) if sense == "larger is better" else (low, high)
    frequency, base = frequency_clause(table, best), baseline(table)
    at = f"{design_label(table, best)}{f' ({frequency})' if frequency else ''}"
    worst_text = f"{value_text(name, values[other])} at the worst point"
    ends = f"{value_text(name, values[best])}, {worst_text}"
    if base is not None and base != best and np.isfinite(values[base]):
        ends = _against(table, name, values, (best, base))
        ends += f", {worst_text}" if other != base else ""
    touch = touch_clause(table, np.array([best]))
    said = f"best is {at}{_alike(table, values, best)}: {label_of(name)} {ends}{touch}"
    return f"{said}{_costs(table, name, best, base)}{runs}{_unlashed(table)}"


def _against(table: StudyTable, name: str, values: Array, pair: tuple[int, int]) -> str:
    """``123.4 N, only 5.8 % below 131 N with normal force 0 N``: the best next to its
    against; of a list the two values.
    """
    best, base = (float(values[k]) for k in pair)
    there = f"{value_text(name, base)} with {design_label(table, pair[1])}"
    share = abs(best / base - 1) if base else np.inf
    if share > LITTLE or table.plan.sampler.word == "list":
        return f"{value_text(name, best)} against {there}"
    word = "below" if abs(best) < abs(base) else "above"
    return f"{value_text(name, best)}, only {number(100 * share, 2)} % {word} {there}"


def _unlashed(table: StudyTable) -> str:
    return f"; {NO_LASH}" if without_lash(table).any() else ""


def _costs(
    table: StudyTable, name: str, best: int, base: int | None = None, above: float = 0.0
) -> str:
    """What other outputs gain and lose at the best design against its reference; without
    that what they lose against their own best, by more than a share.
    """
    held = base is not None and base != best
    gains, costs = list[str](), list[str]()
    for one in table.outputs:
        sense = definition_of(one).sense
        if one == name or not sense or not _known(table, one):
            continue
        own, larger = judged(table, one), sense == "larger is better"
        if not np.isfinite(own[best]):
            continue
        ideal = float(
            own[base] if held and base is not None else np.nanmax(own) if larger else np.nanmin(own)
        )
        if not np.isfinite(ideal) or abs(own[best] - ideal) <= (ALIKE if held else above) * abs(
            ideal
        ):
            continue
        text = f"{label_of(one)} {value_text(one, own[best])}"
        if not held:
            costs.append(f"{text} ({value_text(one, ideal)} at best)")
        else:
            side = gains if (own[best] > ideal) == larger else costs
            side.append(f"{text} against {value_text(one, ideal)}")
    said = "".join(
        f"; {word} there: {joined(some[:MAX_COSTS])}"
        for word, some in (("better", gains), ("worse", costs))
        if some
    )
    return said + (_timing(table, best, base) if held and base is not None else "")


def _timing(table: StudyTable, best: int, base: int) -> str:
    """``; valve open at 0.050 in 250 deg against 249.2 deg``: durations, which are neither good nor bad,
    where the study has none of what is lost of them.
    """
    texts = []
    for one in table.outputs:
        lost = one.replace("_open_crank", "_lost_crank")
        if not DURATION.fullmatch(one) or lost in table.outputs or not _known(table, one):
            continue
        own = worst(table, one)
        texts.append(
            f"{label_of(one)} {value_text(one, own[best])} against {value_text(one, own[base])}"
        )
    return f"; {joined(texts)}" if texts else ""


def _flat(table: StudyTable, name: str, shape: Shape) -> str:
    """How far a grid along one quantity stays near its best, and how little the best point brings
    beyond, which may be no more than the end of what was varied.
    """
    values = judged(table, name)
    ends = (int(np.nanargmin(values)), int(np.nanargmax(values)))
    best, other = ends[::-1] if definition_of(name).sense == "larger is better" else ends
    said = f"{shape.clause} and {value_text(name, values[other])} at the worst point"
    if best == shape.edge or speeds_differ(table):
        return f"{said}{runs_text(table, name)}{shape.also}"
    beyond = f"{design_label(table, best)} brings little more, {value_text(name, values[best])}"
    costs = _costs(table, name, best, shape.edge)
    return f"{said}; {beyond}{costs}{runs_text(table, name)}{shape.also}"


def _stressed(table: StudyTable, name: str) -> str:
    """The point of a list that is stressed most and why, the one that is least, and what else is worse
    there.
    """
    values, runs = worst(table, name), runs_text(table, name)
    if np.count_nonzero(np.isfinite(values)) < 2 or np.nanmin(values) == np.nanmax(values):
        return _best(table, name)
    most, least = int(np.nanargmax(values)), int(np.nanargmin(values))
    if values[most] - values[least] <= ALIKE * values[most]:
        return f"all are stressed alike: {label_of(name)} {value_text(name, values[least])} to {value_text(name, values[most])}{runs}"
    why, worse = _per_force(table, most, least), list[str]()
    for one in table.outputs:
        sense = definition_of(one).sense
        if one == name or not sense or not _known(table, one) or _installed(one):
            continue
        ours, theirs = (worst(table, one)[at] for at in (most, least))
        if (ours < theirs) == (sense == "larger is better") and abs(ours - theirs) > ALIKE * abs(
            ours
        ):
            text = f"{value_text(one, ours)} against {value_text(one, theirs)}"
            if _bare(one) in REASONS:
                why.append(f"{REASONS[_bare(one)]} ({text})")
            else:
                worse.append(f"{label_of(one)} {text}")
    said = (
        f"{design_label(table, most)} is stressed most, so of equal wires it breaks first: {label_of(name)} "
        f"{value_text(name, values[most])} against {value_text(name, values[least])} with {design_label(table, least)}"
    )
    because = f", because {joined(why)}" if why else ""
    more = f"; with {' and '.join(worse[:MAX_COSTS])}" if worse else ""
    return f"{said}{because}{more}{runs}"


def _per_force(table: StudyTable, most: int, least: int) -> list[str]:
    """That a wire bears more stress for each newton, where peak stress and peak force are outputs."""
    names = ("peak_shear_stress", "peak_spring_force")
    if any(name not in table.outputs or not _known(table, name) for name in names):
        return []
    stress, force = (worst(table, name) for name in names)
    ours, theirs = (float(stress[k] / force[k]) for k in (most, least))
    if not ours - theirs > ALIKE * ours:
        return []
    return [
        f"its wire bears more stress per force ({number(ours, 3)} against {number(theirs, 3)} MPa/N)"
    ]


def _alike(table: StudyTable, values: Array, best: int) -> str:
    """The other designs whose value is that of the best within :data:`ALIKE`, in brackets."""
    near = np.abs(values - values[best]) <= ALIKE * abs(values[best])
    others = [design_label(table, int(k)) for k in np.flatnonzero(near) if k != best]
    if not others or near.all():
        return ""
    more = f" and {len(others) - MAX_ALIKE} more" if len(others) > MAX_ALIKE else ""
    return f" (within {100 * ALIKE:.0f} %: {', '.join(others[:MAX_ALIKE])}{more})"


def _largest_change(table: StudyTable, name: str) -> str:
    """The point of a list that changes one quantity at a time at which an output changes most."""
    values, runs = worst(table, name), runs_text(table, name)
    change = values - values[0]
    most = int(np.nanargmax(np.abs(change)))
    if not change[most]:
        return f"no change moves the {label_of(name)} of {value_text(name, values[0])}{runs}"
    most_text = (
        f"{label_of(name)} {value_text(name, values[most])} ({_moved(table, name, change, most)})"
    )
    near = np.abs(np.abs(change) - abs(change[most])) <= ALIKE * abs(change[most])
    equal = [most, *(int(k) for k in np.flatnonzero(near) if k != most)][: MAX_ALIKE + 1]
    names = " or ".join(point_label(table, k) for k in equal)
    first = f" ({point_label(table, 0)})" if point_names(table) else ""
    said = f"most is moved by {names}: {most_text} from {value_text(name, values[0])}{first}"
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
    unit = unit_text(definition_of(name).unit_word)
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
    if table.plan.kind == "surrogate":
        return _over_ranges(table, name, run, where)
    said = f"the {label_of(name)} is {number(low, 4)} to {value_text(name, high)} in nine of ten draws{where}, median {value_text(name, middle)}"
    cause = next(
        (one for one in table.sensitivities if one.output == name and one.run == run), None
    )
    return said + (_cause(cause) if cause is not None else "")


def _over_ranges(table: StudyTable, name: str, run: Run, where: str) -> str:
    """From where to where an output goes over the ranges of a surrogate, with what it goes most, and how
    well the surrogate predicts it.
    """
    rows = table.rows_of(run)
    values = shown_output(table, name)[rows]
    there = np.isfinite(values)
    ends = (
        f"{number(float(values[there].min()), 4)} to {value_text(name, float(values[there].max()))}"
    )
    said = f"the {label_of(name)} is {ends} over the ranges{where}"
    if np.ptp(values[there]) > 0:
        links = [
            float(np.corrcoef(one, values[there])[0, 1]) if np.ptp(one) > 0 else 0.0
            for one in table.inputs[rows][there].T
        ]
        most = int(np.argmax(np.abs(links)))
        verb = "rises" if links[most] > 0 else "falls"
        said += f" and {verb} most with {table.plan.varied[most].shown_name} ({100 * links[most] ** 2:.0f} % of its variance)"
    made = next((one for one in table.surrogates if (one.output, one.run) == (name, run)), None)
    if made is None:
        return said
    good = " and cannot replace a run" if made.share >= POOR else ""
    return f"{said}; the surrogate errs by {made.share_text} of its scatter{good}"


def _cause(one: Sensitivity) -> str:
    """Which quantity makes most of the spread, where it can be distinguished from the next."""
    leader = int(np.argmax(one.total))
    if not one.total[leader] > 0:
        return ""
    rivals = np.delete(one.total_interval[:, 1], leader) >= one.total_interval[leader, 0]
    if rivals.any():
        return "; no quantity alone makes this spread"
    return f"; {one.names[leader]} makes {100 * one.total[leader]:.0f} % of its variance"
