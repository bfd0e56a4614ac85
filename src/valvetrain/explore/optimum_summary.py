"""What a search found, in sentences made from its numbers: the same in the terminal, on the page
and in JSON.
"""

from __future__ import annotations

import numpy as np

from valvetrain.explore.measure import BELOW, BEYOND, FOUND, Measure
from valvetrain.explore.optimum import Confirmed, Design, Optimum, bound_label
from valvetrain.explore.trial import Trial

#: A search whose best value came in this last share of its trials was still rising.
LATE = 0.1
#: Share of the gain that a small step may cost before the best is called narrow.
NARROW = 0.5


def reported(one: Measure, value: float, digits: int = 5) -> str:
    """A value (SI) with its unit, as people read it."""
    if not np.isfinite(value):
        return "no number"
    return f"{one.shown(value):.{digits}g} {one.unit}".rstrip().replace("-", "−")


def change(one: Measure, value: float, before: float) -> str:
    """The difference of two values (SI) with its sign, and in per cent where that says something."""
    shown = one.shown(value) - one.shown(before)
    share = (
        f", {100 * (value / before - 1):+.1f} %"
        if before and np.isfinite(before) and np.sign(before) == np.sign(value)
        else ""
    )
    return f"{shown:+.4g} {one.unit}".rstrip().replace("-", "−") + share.replace("-", "−")


def sentences(found: Optimum) -> tuple[str, ...]:
    """Everything that is to be said, the answer first."""
    if not found.finished:
        return (
            f"The search was stopped after {len(found.trials) - 1} trials. {answer(found)}",
            *trust(found),
        )
    return (answer(found), *trust(found))


def answer(found: Optimum) -> str:
    """The answer in one sentence."""
    best = found.best
    if best is None:
        return _nothing(found)
    case, goals = found.case, found.plan.objectives
    if len(goals) > 1:
        spans = []
        for index, goal in enumerate(goals):
            values = [float(one.objectives[index]) for one in found.front]
            spans.append(
                f"{goal.measure.label} {reported(goal.measure, min(values))} to {reported(goal.measure, max(values))}"
            )
        there = _own(found.case)
        return f"{len(found.front)} designs beat each other in nothing: {'; '.join(spans)}. {there}"
    one, value, before = (
        goals[0].measure,
        float(best.trial.objectives[0]),
        float(case.objectives[0]),
    )
    if best.trial.number == 0:
        return f"No trial beats the case itself, whose {one.label} is {reported(one, value)}."
    if not case.feasible:
        most = "most" if goals[0].maximise else "least"
        return f"The {most} that keeps every bound: {one.label} {_own_value(best.trial, one, 0)}. {_own(case)}"
    verb, least = (
        "rises" if value > before else "falls",
        "at least " if _beyond(best.trial, one) else "",
    )
    ends = f"from {_own_value(case, one, 0)} of the case to {_own_value(best.trial, one, 0)}"
    return f"Within all bounds the {one.label} {verb} {ends} ({least}{change(one, value, before)})."


def optimum_verdict(found: Optimum) -> str:
    """The answer, with the bounds that the best design misses by a finer model, as one sentence."""
    said = answer(found).rstrip(".")
    lead = "" if found.finished else f"Stopped after {len(found.trials) - 1} trials: "
    if found.best is None:
        return f"{lead}{said}."
    for one in found.best.confirmed:
        if one.design.failure:
            said += f"; by {one.label} the design cannot be computed"
        elif missed := [
            _missed_text(one, k) for k, miss in enumerate(one.design.missed) if miss > 0
        ]:
            said += f"; by {one.label} it misses {' and '.join(missed)}"
    return f"{lead}{said}."


def _own(case: Trial) -> str:
    """Of the case itself, whether it keeps the bounds."""
    if case.failure:
        return f"The case itself cannot be computed: {case.failure}."
    if case.feasible:
        return "The case itself keeps every bound."
    missed = [bound_label(case.plan, index) for index, one in enumerate(case.missed) if one > 0]
    return f"The case itself misses: {'; '.join(missed)}."


def _nothing(found: Optimum) -> str:
    nearest = found.missed_by_least
    if nearest is None:
        return f"None of {len(found.trials)} trials could be computed: {found.trials[-1].failure}"
    trial, phrase = nearest
    worst = max(trial.penalties)
    return (
        f"No trial keeps every bound. Trial {trial.number} comes nearest; it misses '{phrase}' by {100 * worst:.2g} % of the bound: "
        "loosen that bound, or widen the ranges."
    )


def trust(found: Optimum) -> tuple[str, ...]:
    """How far the answer goes: trials, active bounds, ends of ranges, steps that still improve,
    seeds, other models.
    """
    best = found.best
    counts = f"{found.feasible} of {len(found.trials)} trials keep every bound"
    failed = sum(bool(one.failure) for one in found.trials)
    lines = [counts + (f", {failed} could not be computed." if failed else ".")]
    if best is None:
        return tuple(lines)
    trial, varied = best.trial, found.plan.varied
    if active := found.active(trial):
        lines.append(
            f"What limits it: {'; '.join(bound_label(found.plan, index) for index in active)}."
        )
    for index, end in found.at_ends(trial):
        one = varied[index]
        value = f"{one.shown(float(trial.values[index])):.5g} {one.unit}".rstrip()
        lines.append(
            f"The {one.shown_name} is at the {'lower' if end == 'low' else 'upper'} end of its range, {value}: widen the range."
        )
    lines += _limits(best, found)
    lines += _steps(best, found)
    lines += _seeds(found)
    lines += [confirmed_text(one, found) for one in best.confirmed]
    return tuple(lines)


def _limits(best: Design, found: Optimum) -> list[str]:
    lines = []
    for goal in found.plan.objectives:
        for one in best.trial.measured.limits.get(goal.measure, ()):
            assert goal.measure.limit is not None
            if one.kind == FOUND:
                ends = f"between {goal.measure.shown(one.low):.6g} and {goal.measure.shown(one.high):.6g} rpm"
                lines.append(f"The {goal.measure.label} lies {ends}.")
            elif one.kind == BEYOND:
                lines.append(
                    f"The bound is met up to the highest speed searched, {reported(goal.measure, one.low)}: search higher."
                )
    return lines


def _steps(best: Design, found: Optimum) -> list[str]:
    better = [found.plan.varied[one.index].shown_name for one in best.steps if one.improves]
    lines = []
    if better:
        lines.append(
            f"A small step still improves it ({', '.join(dict.fromkeys(better))}): more trials will find more."
        )
    elif best.steps:
        lines.append("Small changes no longer improve it within the bounds.")
    lines += _narrow(best, found)
    if found.finished and len(found.plan.objectives) == 1 and best.trial.number and not better:
        history = found.history(best.trial.seed)
        value = float(best.trial.objectives[0])
        came = int(np.flatnonzero(history == value)[0])
        if came > (1 - LATE) * (len(history) - 1):
            lines.append(
                f"The best value came with trial {came} of {len(history) - 1}: more trials may find more."
            )
    return lines


def _narrow(best: Design, found: Optimum) -> list[str]:
    """A best value whose gain over the case is lost by half or more at a small step is a peak that
    no workshop meets.
    """
    goal = found.plan.objectives[0]
    near = [float(one.objectives[0]) for one in best.steps if np.isfinite(one.objectives[0])]
    gain = goal.sign * (float(found.case.objectives[0]) - float(best.trial.objectives[0]))
    if len(found.plan.objectives) > 1 or not near or not found.case.feasible or not gain > 0:
        return []
    near.sort(key=lambda value: goal.sign * value)
    if goal.sign * (near[-1] - float(best.trial.objectives[0])) < NARROW * gain:
        return []
    one = goal.measure
    ends = f"{reported(one, near[-1])} to {reported(one, near[0])}"
    return [
        f"It is narrow: a hundredth of one range away the {one.label} is {ends}, so count on {reported(one, near[-1])}."
    ]


def _seeds(found: Optimum) -> list[str]:
    if len(found.best_by_seed) < 2:
        return []
    one = found.plan.objectives[0].measure
    values = np.array(list(found.best_by_seed.values()))
    each_value = ", ".join(f"{one.shown(float(value)):.5g}" for value in values)
    half = 0.5 * (one.shown(float(values.max())) - one.shown(float(values.min())))
    ends = f"{len(values)} searches from different seeds end at {each_value} {one.unit}".rstrip()
    return [f"{ends}: the search itself is worth {f'±{half:.2g} {one.unit}'.rstrip()}."]


def confirmed_text(one: Confirmed, found: Optimum) -> str:
    """What another model says of the best design, in one sentence."""
    if one.design.failure or one.case.failure:
        which = "the design" if one.design.failure else "the case"
        return (
            f"By {one.label}, {which} cannot be computed: {one.design.failure or one.case.failure}"
        )
    parts = []
    for index, goal in enumerate(one.plan.objectives):
        measure = goal.measure
        value, before = float(one.design.objectives[index]), float(one.case.objectives[index])
        searched = found.best.trial if found.best else one.design
        apart = f"{_own_value(one.design, measure, index)} against {_own_value(one.case, measure, index)} of the case"
        if not any(_beyond(trial, measure) for trial in (one.design, one.case)):
            apart += f" ({change(measure, value, before)})"
        parts.append(
            f"{measure.label} {apart}, where the search has {_own_value(searched, found.plan.objectives[index].measure, index)}"
        )
    missed = [_missed_text(one, index) for index, miss in enumerate(one.design.missed) if miss > 0]
    bounds = f"It misses: {'; '.join(missed)}." if missed else "All bounds are met."
    return f"By {one.label}: {'; '.join(parts)}. {bounds}"


def _beyond(trial: Trial, measure: Measure) -> bool:
    """Whether a limit speed lies outside the speeds that were searched, so that there is no number
    for it.
    """
    return any(bracket.kind != FOUND for bracket in trial.measured.limits.get(measure, ()))


def _own_value(trial: Trial, measure: Measure, index: int) -> str:
    """An objective of a trial; of a limit speed outside the speeds searched, on which side."""
    phrase = reported(measure, float(trial.objectives[index]))
    if not _beyond(trial, measure):
        return phrase
    return (
        f"below {phrase}"
        if any(one.kind == BELOW for one in trial.measured.limits[measure])
        else f"{phrase} or more"
    )


def _missed_text(one: Confirmed, index: int) -> str:
    """A bound that a design misses by another model, with what it has."""
    phrase = bound_label(one.plan, index)
    if index >= len(one.plan.constraints):
        return phrase
    measure = one.plan.constraints[index].measure
    return f"{phrase}, it has {reported(measure, float(one.design.constraints[index]), 4)}"
