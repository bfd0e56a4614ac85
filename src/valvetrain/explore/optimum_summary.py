"""What a search found, in sentences made from its numbers: the same in the terminal, on the page
and in JSON.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from valvetrain.explore.doubts import doubts
from valvetrain.explore.measure import BELOW, BEYOND, FOUND, LimitFound, Measure
from valvetrain.explore.optimum import Confirmed, Design, Optimum, bound_label
from valvetrain.explore.optimum_springs import OfCard, as_of_card, card_values, spring_of
from valvetrain.explore.space import Varied
from valvetrain.explore.trial import Array, Trial, best_of
from valvetrain.explore.valley import ALIKE
from valvetrain.report.text import number, speed_text

#: A search whose best value came in this last share of its trials was still rising.
LATE = 0.1
#: Varied values that a verdict names.
MAX_NAMED = 6
#: Share of the gain of the search that another model may lack and still confirm it.
CONFIRMED = 0.1
#: Share of the gain that a small step may cost before the best is called narrow.
NARROW = 0.5


@dataclass(frozen=True)
class AsVaried:
    """An objective that is itself one of the varied quantities, in the words and unit of that."""

    varied: Varied
    spring: str = ""
    limit: None = None

    @property
    def label(self) -> str:
        """What people read, of a pair with its ``spring``."""
        return self.varied.shown_name + (f" of the {self.spring}" if self.spring else "")

    @property
    def unit(self) -> str:
        """The unit as typed."""
        return self.varied.unit

    def shown(self, value: float) -> float:
        """A value (SI) in that unit."""
        return self.varied.shown(value)


def same_as_varied(found: Optimum, index: int) -> int | None:
    """Place of the varied quantity that an objective is, by its values in the case and the best design;
    None for any other.
    """
    best = found.best
    if best is None or found.plan.objectives[index].measure.limit is not None:
        return None
    for place, one in enumerate(found.plan.varied):
        pairs = (
            (trial.objectives[index], trial.values[place]) for trial in (found.case, best.trial)
        )
        if all(np.isclose(value, own, rtol=1e-9, atol=0.0) for value, own in pairs):
            return place if one.operation == "value" else None
    return None


def reported(one: Measure | AsVaried | OfCard, value: float, digits: int = 4) -> str:
    """A value (SI) with its unit, as people read it."""
    if not np.isfinite(value):
        return "no number"
    return f"{number(one.shown(value), digits)} {one.unit}".rstrip().replace("-", "−")


def change(one: Measure | AsVaried | OfCard, value: float, before: float) -> str:
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


def answer(found: Optimum, values: str = "", more: str = "") -> str:
    """The answer in one sentence, with the ``values`` of the best design and what ``more`` is to be said
    of it where they are given; then what the case itself misses.
    """
    best = found.best
    if best is None:
        return _nothing(found)
    case, goals = found.case, found.plan.objectives
    if len(goals) > 1:
        spans = []
        for index, goal in enumerate(goals):
            front = [float(one.objectives[index]) for one in found.front]
            spans.append(
                f"{goal.measure.label} {reported(goal.measure, min(front))} to {reported(goal.measure, max(front))}"
            )
        there = _own(found.case)
        return f"{len(found.front)} designs beat each other in nothing: {'; '.join(spans)}{more}. {there}"
    place = same_as_varied(found, 0)
    one: Measure | AsVaried | OfCard = as_of_card(found, goals[0].measure)
    if place is not None:
        varied = found.plan.varied[place]
        one = AsVaried(varied, spring_of(found.plan.case, varied.key))
    value, before = float(best.trial.objectives[0]), float(case.objectives[0])
    at = f", with {values}" if values else ""
    if best.trial.number == 0:
        trials = f"of {len(found.trials) - 1} trials " if len(found.trials) > 1 else ""
        return f"None {trials}beats the case itself, whose {one.label} is {reported(one, value)}{more}."
    confirmed = _confirmed_change(found, one)
    if not case.feasible:
        most = "most" if goals[0].maximise else "least"
        return f"The {most} that meets every bound: {one.label} {_own_value(best.trial, one, 0)}{at}{more}. {_own(case)}"
    verb, least = (
        "rises" if value > before else "falls",
        "at least " if _beyond(best.trial, one) else "",
    )
    ends = f"from {_own_value(case, one, 0)} of the case to {_own_value(best.trial, one, 0)}"
    said = f"the {one.label} {verb} {ends} ({least}{change(one, value, before)}){at}{more}."
    if confirmed:
        return f"{confirmed}; by the model of the search {said}"
    return f"Within all bounds {said}"


def _confirmed_change(found: Optimum, one: Measure | AsVaried | OfCard) -> str:
    """The least gain of the other models, first, where it is below that of the search by a tenth or
    more; empty where they confirm it.
    """
    assert found.best is not None
    goal = found.plan.objectives[0]

    def gain(trial: Trial, case: Trial) -> float:
        return -goal.sign * float(trial.objectives[0] - case.objectives[0])

    own = gain(found.best.trial, found.case)
    known = [other for other in found.best.confirmed if np.isfinite(gain(other.design, other.case))]
    if not known or not found.case.feasible:
        return ""
    known.sort(key=lambda other: gain(other.design, other.case))
    worst = known[0]
    if gain(worst.design, worst.case) >= (1 - CONFIRMED) * own:
        return ""
    changes = [
        f"{change(one, float(other.design.objectives[0]), float(other.case.objectives[0]))} by {other.label}"
        for other in known
    ]
    if gain(worst.design, worst.case) <= 0:
        return f"No gain is confirmed by every model: of the {one.label} {' and '.join(changes)}"
    return f"Confirmed is a change of the {one.label} of {changes[0]}" + (
        f" ({', '.join(changes[1:])})" if changes[1:] else ""
    )


def optimum_verdict(found: Optimum) -> str:
    """The answer, with the bounds that the best design misses by a finer model, as one sentence."""
    lead = "" if found.finished else f"Stopped after {len(found.trials) - 1} trials: "
    more = ""
    if found.best is not None:
        more = _left_open(found) + _limited(found) + _best_doubtful(found)
        for one in found.best.confirmed:
            if one.design.failure:
                more += f"; by {one.label} the design cannot be computed"
            elif missed := [
                _missed_text(one, k) for k, miss in enumerate(one.design.missed) if miss > 0
            ]:
                more += f"; by {one.label} it misses {' and '.join(missed)}"
    return f"{lead}{answer(found, best_values(found), more).rstrip('.')}."


def _best_doubtful(found: Optimum) -> str:
    """``; the best design is doubtful: 4.2 turns are few``: the first doubt of the best design."""
    best, plan = found.best, found.plan
    if best is None or best.trial.number == 0 or len(plan.objectives) > 1:
        return ""
    first = doubts(plan.case, plan.varied, np.array([best.trial.values])).by_point.get(0, "")
    parts = first.split(": ")[
        1:
    ]  # behind the values: whose it is, where that is said, the doubt, advice
    said = parts[: 2 if first and parts[0].startswith("spring ") else 1]
    doubt = ": ".join(said).partition("; ")[0].partition(". ")[0].rstrip(".")
    return f"; the best design is doubtful: {doubt}" if doubt else ""


def _left_open(found: Optimum) -> str:
    """``; seat load 180 to 200 N does as well within 1 %``: what designs as good leave open."""
    best = found.best
    if best is None or best.valley is None or best.trial.number == 0 or len(best.valley.values) < 2:
        return ""
    objective, parts = same_as_varied(found, 0), []
    for place in best.valley.open:
        if place == objective:
            continue
        one = found.plan.varied[place]
        low, high = (
            one.shown(float(best.valley.values[row][place])) for row in best.valley.ends(place)
        )
        spring = spring_of(found.plan.case, one.key)
        name = one.shown_name + (f" of the {spring}" if spring else "")
        parts.append(f"{name} {number(low, 3)} to {number(high, 3)} {one.unit}".rstrip())
    if not parts or len(parts) > MAX_NAMED:
        return ""
    return f"; {' and '.join(parts)} {'do' if len(parts) > 1 else 'does'} as well within {100 * ALIKE:g} %"


def _limited(found: Optimum) -> str:
    """``; minimum spring margin, ratio at least 1.2 limits it at 6500 rpm``: the active bounds."""
    best = found.best
    if best is None or len(found.plan.objectives) > 1 or not (active := found.active(best.trial)):
        return ""
    speeds = {run[0] for one in found.plan.plans.values() for run in one.runs if run[0] is not None}
    at = f" at {speed_text(speeds.pop())}" if len(speeds) == 1 else ""
    verb = "limit" if len(active) > 1 else "limits"
    return f"; {' and '.join(bound_label(found.plan, index) for index in active)} {verb} it{at}"


def best_values(found: Optimum) -> str:
    """``seat load 147 lbf, open load 260.9 lbf, rate 206 lbf/in``: the best design, as typed, and what
    follows for its card; empty where the case is best.
    """
    best = found.best
    if best is None or best.trial.number == 0 or len(found.plan.objectives) > 1:
        return ""
    objective = same_as_varied(found, 0)
    groups: dict[str, list[str]] = {"": []}  # quantities of no pair come first, unnamed
    for place, (one, value) in enumerate(zip(found.plan.varied, best.trial.values, strict=True)):
        if place != objective:
            groups.setdefault(spring_of(found.plan.case, one.key), []).append(one.text(value, 4))
    if sum(map(len, groups.values())) > MAX_NAMED:
        return ""
    for spring, texts in card_values(found, best.trial).items():
        groups.setdefault(spring, []).extend(texts)
    return ", ".join(
        f"{f'{name}: ' if name else ''}{', '.join(texts)}"
        for name, texts in groups.items()
        if texts
    )


def _own(case: Trial) -> str:
    """Sentence on whether the case itself meets the bounds."""
    if case.failure:
        return f"The case itself cannot be computed: {case.failure}."
    if case.feasible:
        return "The case itself meets every bound."
    missed = [bound_label(case.plan, index) for index, one in enumerate(case.missed) if one > 0]
    return f"The case itself misses: {'; '.join(missed)}."


def _nothing(found: Optimum) -> str:
    nearest = found.missed_by_least
    if nearest is None:
        common = Counter(one.failure for one in found.trials).most_common(1)[0][0]
        cause = found.case.failure or common  # a case that fails is the cause of the others
        return f"None of {len(found.trials)} trials could be computed: {cause}"
    trial, phrase = nearest
    if trial.floating is not None:
        return _lost(found, trial)
    worst = 100 * max(trial.penalties)
    size = f"{worst:.0f}" if worst >= 10 else f"{worst:.2g}"
    return (
        f"No trial meets every bound. Trial {trial.number} comes nearest; it misses '{phrase}' by {size} % of the bound: "
        "loosen that bound, or widen the ranges."
    )


def _lost(found: Optimum, trial: Trial) -> str:
    """Which ranges hold no design that retains contact, the nearest one, and where it loses contact."""
    varied = found.plan.varied
    ends = [
        [one.value_text(float(end)) for end in one.distribution.at([0.0, 1.0])] for one in varied
    ]
    ranges = ", ".join(
        f"{one.shown_name} {' to '.join(both)}" for one, both in zip(varied, ends, strict=True)
    )
    values = ", ".join(
        one.text(float(value)) for one, value in zip(varied, trial.values, strict=True)
    )
    speed = max(run[0] or 0.0 for run in found.plan.losses[0].runs)
    loss = found.contact_loss
    where = ""
    if loss is not None:
        below = "below " if loss.kind == BELOW else ""
        where = f", from {below}{round(loss.value * 30 / np.pi, -1):.0f} rpm"
    return (
        f"No design retains contact at {speed_text(speed)} ({ranges}). Trial {trial.number} comes nearest ({values}): "
        f"it loses contact for {1e3 * trial.losses[0]:.3g} ms of a cycle{where}."
    )


def trust(found: Optimum) -> tuple[str, ...]:
    """How far the answer goes: trials, active bounds, ends of ranges, steps that still improve,
    seeds, other models.
    """
    best = found.best
    every = f"{found.feasible} of {len(found.trials)} designs, the case among them,"
    counts = f"{every} meet every bound"
    failed = sum(bool(one.failure) for one in found.trials)
    lines = [counts + (f", {failed} could not be computed." if failed else ".")]
    lines += _doubtful(found)
    if best is None:
        return tuple(lines)
    trial, varied = best.trial, found.plan.varied
    if active := found.active(trial):
        lines.append(
            f"What limits it: {'; '.join(bound_label(found.plan, index) for index in active)}."
        )
    open_places = best.valley.open if best.valley is not None else ()
    for index, end in found.at_ends(trial):
        if index in open_places:  # no wider range helps what the search does not settle
            continue
        one = varied[index]
        value = one.value_text(float(trial.values[index]))
        lines.append(
            f"The {one.shown_name} is at the {'lower' if end == 'low' else 'upper'} end of its range, {value}: widen the range."
        )
    lines += _limits(best, found)
    lines += _steps(best, found)
    lines += _valley(best, found)
    lines += [*_seeds(found), *_spread(found)]
    lines += [confirmed_text(one, found) for one in best.confirmed]
    return tuple(lines)


def _doubtful(found: Optimum) -> list[str]:
    """How many designs have doubtful values, and whether the best one has."""
    trials = found.trials
    made = doubts(found.plan.case, found.plan.varied, np.array([one.values for one in trials]))
    remark = ""
    if found.best is not None:
        own = any(trials[point] is found.best.trial for point in made.by_point)
        remark = ", the best among them" if own else ", but not the best"
    counted = made.sentence("designs", remark)
    return [f"{counted}."] if counted else []


def _limits(best: Design, found: Optimum) -> list[str]:
    lines = []
    for goal in found.plan.objectives:
        for one in best.trial.measured.limits.get(goal.measure, ()):
            assert goal.measure.limit is not None
            if one.kind == FOUND:
                ends = f"between {goal.measure.shown(one.low):.6g} and {goal.measure.shown(one.high):.6g} rpm"
                lines.append(f"The {goal.measure.label} is {ends}.")
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
        lines.append("Small changes of one quantity no longer improve it within the bounds.")
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
    itself = same_as_varied(found, 0)
    near = [
        float(one.objectives[0])
        for one in best.steps
        if np.isfinite(one.objectives[0]) and one.index != itself
    ]
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


def _valley(best: Design, found: Optimum) -> list[str]:
    """The quantities that designs as good leave open, with the designs at their ends."""
    valley, goal = best.valley, as_of_card(found, found.plan.objectives[0].measure)
    if valley is None or len(valley.values) < 2:
        return []
    lines = []
    lead = f"Within {100 * ALIKE:g} % of the best {goal.label}, and within all bounds,"
    for place in valley.open:
        one = found.plan.varied[place]
        ends = []
        for row in valley.ends(place):
            values, objective = valley.values[row], reported(goal, valley.objectives[row])
            others = f"{_others_of(found, values, place)}{goal.label} {objective}"
            ends.append(f"{one.value_text(values[place], 4)} ({others})")
        lines.append(
            f"{lead} the {one.shown_name} goes from {' to '.join(ends)}: the search does not settle it."
        )
    if not lines:
        lines.append(f"{lead} every quantity stays within a tenth of its range.")
    return lines


def _others_of(found: Optimum, values: Array, place: int) -> str:
    """The other varied quantities of a design, where they are few and none is the objective."""
    others = [
        f"{one.text(value, 4)}, "
        for k, (one, value) in enumerate(zip(found.plan.varied, values, strict=True))
        if k not in (place, same_as_varied(found, 0))
    ]
    return "".join(others) if len(others) < MAX_NAMED else ""


def _seeds(found: Optimum) -> list[str]:
    if len(found.best_by_seed) < 2:
        return []
    one = found.plan.objectives[0].measure
    values = np.array(list(found.best_by_seed.values()))
    each_value = ", ".join(f"{one.shown(float(value)):.5g}" for value in values)
    half = 0.5 * (one.shown(float(values.max())) - one.shown(float(values.min())))
    ends = f"{len(values)} searches from different seeds end at {each_value} {one.unit}".rstrip()
    return [f"{ends}: the search itself is worth {f'±{half:.2g} {one.unit}'.rstrip()}."]


def _spread(found: Optimum) -> list[str]:
    """Sentences on the range of the best designs of several seeds."""
    if len(found.best_by_seed) < 2:
        return []
    bests = [
        best_of([one for one in found.trials if one.seed == seed]) for seed in found.best_by_seed
    ]
    rows = np.array([one.values for one in bests if one is not None])
    spans = [
        f"{one.text(rows[:, k].min(), 4)} to {one.value_text(rows[:, k].max(), 4)}"
        for k, one in enumerate(found.plan.varied)
    ]
    return [f"Over seeds the best designs have {', '.join(spans)}."]


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
        if same_as_varied(found, index) is not None:  # what was put in is the same by every model
            parts += _bounded(one, searched)
            continue
        if not any(_beyond(trial, measure) for trial in (one.design, one.case)):
            apart += f" ({change(measure, value, before)})"
        parts.append(
            f"{measure.label} {apart}, where the search has {_own_value(searched, found.plan.objectives[index].measure, index)}"
        )
    missed = [_missed_text(one, index) for index, miss in enumerate(one.design.missed) if miss > 0]
    bounds = f"It misses: {'; '.join(missed)}." if missed else "All bounds are met."
    detail = f"{'; '.join(parts)}. " if parts else ""
    return f"By {one.label}: {detail}{bounds if parts else bounds[:1].lower() + bounds[1:]}"


def _bounded(one: Confirmed, searched: Trial) -> list[str]:
    """What is bounded, by another model and by that of the search, where they differ."""
    texts = []
    for index, bound in enumerate(one.plan.constraints):
        value, own = float(one.design.constraints[index]), float(searched.constraints[index])
        if np.isfinite(value) and not np.isclose(value, own, rtol=1e-6, atol=0.0):
            measure = bound.measure
            texts.append(
                f"{measure.label} {reported(measure, value)}, where the search has {reported(measure, own)}"
            )
    return texts


def _beyond(trial: Trial, measure: Measure | AsVaried | OfCard) -> bool:
    """Whether a limit speed is outside the speeds that were searched, so that there is no number
    for it.
    """
    return any(bracket.kind != FOUND for bracket in _limits_of(trial, measure))


def _limits_of(trial: Trial, measure: Measure | AsVaried | OfCard) -> tuple[LimitFound, ...]:
    return () if not isinstance(measure, Measure) else trial.measured.limits.get(measure, ())


def _own_value(trial: Trial, measure: Measure | AsVaried | OfCard, index: int) -> str:
    """An objective of a trial; of a limit speed outside the speeds searched, on which side."""
    phrase = reported(measure, float(trial.objectives[index]))
    if not _beyond(trial, measure):
        return phrase
    return (
        f"below {phrase}"
        if any(one.kind == BELOW for one in _limits_of(trial, measure))
        else f"{phrase} or more"
    )


def _missed_text(one: Confirmed, index: int) -> str:
    """A bound that a design misses by another model, with what it has."""
    phrase = bound_label(one.plan, index)
    if index >= len(one.plan.constraints):
        return phrase
    measure = one.plan.constraints[index].measure
    return f"{phrase}, it has {reported(measure, float(one.design.constraints[index]), 4)}"
