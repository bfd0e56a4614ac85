"""Rules on a search (O): what the best design is and gains, what limits it, and why to trust it or not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from valvetrain.explore.optimum import Confirmed
from valvetrain.explore.optimum_facts import ALIKE, SearchFacts
from valvetrain.findings.engine import Hit, Rule
from valvetrain.findings.words import UNRESOLVED, Amount, Said, joined, speed_text
from valvetrain.solution.definition import label_of

#: Varied quantities and bounds that a sentence names at most.
NAMED = 2
#: Share of the gain that another model may lack and still confirm it.
CONFIRMED = 0.1
#: Spring models of the whole wire.
FULL = {"finite-element", "solid"}
Hits = Iterator[Hit]


def nothing(facts: SearchFacts) -> Hits:
    """No design could be computed."""
    result = facts.result
    if facts.trial is None:
        common = Counter(one.failure for one in result.trials).most_common(1)[0][0]
        yield Hit(fields={"count": f"{len(result.trials)}", "why": result.case.failure or common})


def missed(facts: SearchFacts) -> Hits:
    """No design meets every bound: the bound that the nearest misses most, and by how much."""
    trial, bounds = facts.trial, facts.result.plan.constraints
    if facts.result.best is None and trial is not None:
        place = int(np.argmax(trial.penalties))
        by: Said = f"{100 * trial.penalties[place]:.2g} %"
        if place < len(bounds):
            away = abs(float(trial.constraints[place]) - bounds[place].bound)
            by = facts.said(bounds[place].measure, away) or by
        yield Hit(fields={"bound": facts.bound(place), "by": by, "wide": wide(facts)})


def wide(facts: SearchFacts) -> str:
    """``the range of seat load``: that of the first varied quantity at an end of its range, else all."""
    names = [facts.result.plan.varied[place].shown_name for place in facts.ends]
    return f"the range of {names[0]}" if names else "the ranges"


def front(facts: SearchFacts) -> Hits:
    """Of several objectives: the designs of the front, and how far the first two go."""
    designs = facts.result.front
    if facts.several and facts.result.best is not None:
        fields: dict[str, Said] = {"count": f"{len(designs)}", "step": facts.step}
        for place, word in enumerate("ab"):
            one = facts.result.plan.objectives[place].measure
            values = [float(each.objectives[place]) for each in designs]
            fields |= {word: one.label, f"{word}_least": facts.said(one, min(values)), f"{word}_most": facts.said(one, max(values))}  # fmt: skip
        yield Hit(fields=fields)


def itself(facts: SearchFacts) -> Hits:
    """Nothing beats the case."""
    result = facts.result
    if not facts.several and result.best is not None and not result.best.trial.number:
        before = facts.objective(result.case)
        yield Hit(fields={"name": facts.goal.label, "before": before, "wide": wide(facts)})


def denying(facts: SearchFacts) -> Confirmed | None:
    """The other model that confirms least of the gain, less than nine tenths; None where all confirm it."""
    best, case = facts.best, facts.result.case
    if best is None or not case.feasible or not facts.result.confirmed:
        return None
    least = min(facts.result.confirmed, key=lambda one: facts.gain(one.design, one.case))
    enough = (1 - CONFIRMED) * facts.gain(best.trial, case)
    return least if facts.gain(least.design, least.case) < enough else None


def within_bars(facts: SearchFacts) -> bool:
    """Whether the gain is within the error bars."""
    best, case = facts.best, facts.result.case
    if best is None or not case.feasible:
        return False
    bars = (facts.bar(facts.goal, float(one.objectives[0]), one) for one in (best.trial, case))
    return facts.gain(best.trial, case) <= sum(bars)


def better(condition: Callable[[SearchFacts], object]) -> Callable[[SearchFacts], Hits]:
    """The best design of one objective next to the case, where a condition holds."""

    def hits(facts: SearchFacts) -> Hits:
        best, result, fields = facts.best, facts.result, dict[str, Said]()
        if best is None or not condition(facts):
            return
        if (other := denying(facts)) is not None:
            pair = (facts.said(one.plan.objectives[0].measure, float(one.objectives[0]), one) for one in (other.case, other.design))  # fmt: skip
            fields = dict(zip(("by_before", "by_after"), pair, strict=True)) | {"by": other.label}
        active = result.active(best.trial)
        limits: Said = tuple(map(facts.bound, active)) if len(active) <= NAMED else f"{len(active)} bounds"  # fmt: skip
        worse = [facts.bound(place) for place, miss in enumerate(result.case.missed) if miss > 0]
        fields |= {
            "name": facts.goal.label, "before": facts.objective(result.case), "after": facts.objective(best.trial), "limits": limits,
            "hold": "limit" if len(active) > 1 else "limits", "worse": result.case.failure or worse[:1],
            "most": "most" if result.plan.objectives[0].maximise else "least", "step": facts.step, "share": f"{100 * facts.slight:.2g} %",
        }  # fmt: skip
        yield Hit(fields=fields)

    return hits


def cut(facts: SearchFacts) -> Hits:
    """A search that was stopped."""
    if not facts.result.finished:
        yield Hit(fields={"count": f"{len(facts.result.trials) - 1}"})


def other_model(facts: SearchFacts) -> Hits:
    """Bounds that the best design misses by another model, or that it cannot compute it."""
    for one in facts.result.confirmed:
        if one.design.failure:
            yield Hit(fields={"by": one.label, "why": one.design.failure}, severity=float("inf"))
            continue
        there = SearchFacts(
            replace(facts.result, plan=one.design.plan)
        )  # with the bounds by that model
        for place, miss in enumerate(one.design.missed):
            if miss > 0:
                off: Said = f"{100 * miss:.2g} %"
                yield Hit(fields={"by": one.label, "bound": there.bound(place), "off": off}, severity=float(miss))  # fmt: skip


def confirmed(facts: SearchFacts) -> Hits:
    """Other models by which the best design meets every bound."""
    for one in facts.result.confirmed:
        if one.design.feasible and one.design.number:
            after = facts.said(facts.goal, float(one.design.objectives[0]), one.design)
            yield Hit(fields={"by": one.label, "name": facts.goal.label, "after": after})


def doubtful(facts: SearchFacts) -> Hits:
    """Values of the best design that are unusual where those of the case are not."""
    if facts.result.doubt:
        yield Hit(fields={"doubt": facts.result.doubt.partition(". ")[0].partition("; ")[0]})


def at_end(facts: SearchFacts) -> Hits:
    """A varied quantity of the best design at an end of its range."""
    if facts.ends and facts.result.best is not None:
        yield Hit(fields={"wide": wide(facts)})


def unresolved(facts: SearchFacts) -> Hits:
    """Numbers of the search whose error bar is half of them or more."""
    for row in facts.result.error_bars:
        if row.numerical >= UNRESOLVED * abs(row.value) > 0:
            fields = {"name": label_of(row.quantity), "speed": speed_text(row.engine_speed or 0.0)}
            yield Hit(Amount(row.quantity, row.value, row.numerical), None, None, fields, row.numerical / abs(row.value))  # fmt: skip


def alone(facts: SearchFacts) -> Hits:
    """Runs by models that leave out parts of the spring, with no other to confirm them."""
    result = facts.result
    models = {run[1] for one in result.plan.measures for run in one.runs if run[0] or one.limit}  # fmt: skip
    if result.best is not None and not result.confirmed and models and not models & FULL:
        yield Hit(fields={"model": joined(sorted(filter(None, models))) or "the model of the case"})


def alike(facts: SearchFacts) -> Hits:
    """Quantities that designs as good leave open."""
    reaches = {one.shown_name: facts.alike(place) for place, one in enumerate(facts.result.plan.varied)}  # fmt: skip
    texts = [f"{name}: {reach}" for name, reach in reaches.items() if reach]
    if texts:
        only = max(reaches.values(), key=len) if len(texts) == 1 else ""
        yield Hit(fields={"ranges": texts, "share": f"{100 * ALIKE:g} %", "only": only})


STEP = "[{step}]"
RULES = (
    Rule("O101", "decides", "none of {count} designs can be computed", nothing, (), "{why}", "valvetrain check {case}"),
    Rule("O103", "decides", "no design meets every bound", missed, (), "the nearest misses {bound} by {by}",
         "loosen that bound, or widen {wide}", unless=("O101",)),
    Rule("O104", "decides", "{count} designs trade {a} against {b}", front, (), "{a_least} to {a_most} for {b_least} to {b_most}", STEP, mark="ok"),
    Rule("O105", "decides", "no design beats the case", itself, (), "its {name} is {before:4}", "widen {wide}", mark="warn"),
    Rule("O106", "decides", "{name} goes from {by_before:4} to {by_after:4} by {by}", better(denying), (),
         "the model of the search has {after:4}", STEP, mark="warn"),
    Rule("O107", "decides", "no gain beyond the error bars", better(within_bars), (), "{name} {before:4} of the case and {after:4} of the best",
         STEP, mark="warn", unless=("O106",)),
    Rule("O108", "decides", "{name} {after:4} is the {most} that meets every bound", better(lambda facts: not facts.result.case.feasible), (),
         "the case misses {worse}", STEP, mark="ok"),
    Rule("O109", "decides", "{name} goes from {before:4} to {after:4}", better(lambda facts: not facts.slight), (), "[{limits} {hold} it]",
         STEP, mark="ok", unless=("O106", "O107", "O108")),
    Rule("O110", "decides", "the case is within {share} of the best", better(lambda facts: facts.slight), (),
         "{name} {before:4}, at best {after:4}[; {limits} {hold} it]", STEP, mark="ok", unless=("O106", "O107", "O108")),
    Rule("O120", "warns", "the search was stopped after {count} trials", cut, step="start the command again to continue"),
    Rule("O121", "warns", "by {by} the best design [misses {bound} by {off}][cannot be computed: {why}]", other_model),
    Rule("O122", "warns", "the best design is doubtful: {doubt}", doubtful),
    Rule("O123", "warns", "widen {wide}: the best is at its end", at_end, remark="end of its range"),
    Rule("O126", "warns", "{name} of the best is not resolved at {speed}", unresolved, guide="uncertainty.md"),
    Rule("O127", "warns", "only {model} computed it: confirm it by finite-element", alone, mark="", guide="optimisation.md"),
    Rule("O128", "warns", "designs as good within {share} have {ranges}", alike, remark="[{only} as good]", mark="", guide="optimisation.md"),
    Rule("O129", "notes", "by {by} the best design has {name} {after:4} and meets every bound", confirmed, guide="optimisation.md"),
)  # fmt: skip
