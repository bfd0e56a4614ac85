"""Rules on a study of points (J): the best point, what moves an output, how far it spreads, and which points are missing."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from valvetrain.explore.evaluate import MAX_POINTS
from valvetrain.explore.samplers import ENOUGH_ROWS
from valvetrain.explore.study_facts import PERCENTILES, StudyFacts, put_in
from valvetrain.findings.engine import Fields, Hit, Hits, Rule
from valvetrain.findings.words import Amount, digits_text, speed_text
from valvetrain.solution.definition import label_of

#: Fewest values of a grid along one quantity whose shape is named; share of the output's range within which it is flat, and
#: share of the varied range that a flat part has: more than twice that of a straight line.
FEWEST, FLAT, WIDE = 4, 0.2, 0.45
#: Share within which values are no better than each other.
ALIKE = 0.01
#: Share of another output from which it is a price of the best point.
WORSE = 0.1


def per_cent(share: float) -> str:
    """``83 %``, ``less than 0.1 %``."""
    return f"{digits_text(100 * share, 0, 2)} %" if share >= 1e-3 else "less than 0.1 %"


def nothing(facts: StudyFacts) -> Hits:
    """No point completed, or none has any output."""
    if not facts.outputs:
        told = (*facts.table.failures[:1], *facts.table.not_given[:1], "")
        yield Hit(fields={"told": told[0].rstrip(".")})


def failed(facts: StudyFacts) -> Hits:
    """Points that failed, by the most frequent status."""
    lost = [one for one in facts.table.statuses if not one.completed]
    if lost:
        code = Counter(one.code for one in lost).most_common(1)[0][0]
        first = next(one.message for one in lost if one.code == code)
        share = f"{len(lost)} of {len(facts.table)} points"
        yield Hit(fields={"share": share, "code": code, "told": first})


def lacking(facts: StudyFacts) -> Hits:
    """An output that no completed point has."""
    yield from (Hit(fields={"told": one.rstrip(".")}) for one in facts.table.not_given)


def doubtful(facts: StudyFacts) -> Hits:
    """Points with values that no spring or valve has."""
    found = facts.table.doubts
    for told in list(found.values())[:1]:
        share = f"{len(found)} of {min(len(facts.draws), MAX_POINTS)} points"
        yield Hit(fields={"share": share, "told": told})


def at_an_end(facts: StudyFacts) -> Hits:
    """Limit speeds that are an end of the speeds searched."""
    for name, speeds in facts.limits.items():
        limits = facts.column(name)[np.isfinite(facts.column(name))]
        for side, end in (("above", speeds[-1]), ("below", speeds[0])):
            if count := int(np.count_nonzero(limits == end)):
                share = f"{count} of {len(limits)} points"
                yield Hit(
                    Amount(name, end),
                    fields={"share": share, "side": side, "name": label_of(name)},
                    severity=count,
                )


# -- chosen points ---------------------------------------------------------------------------------


def _chosen(facts: StudyFacts, name: str, design: int, other: int) -> Fields:
    """A design and the one that it is compared with, by an output."""
    values, count = facts.worst(name), len(facts.designs[0]) * len(facts.table.plan.runs)
    judged = name not in facts.limits and facts.sign(name) and count > 1
    speed = facts.speed_at(facts.worst_row(design))
    place = "" if speed is None else f", at {speed_text(speed)}"
    return {
        "name": label_of(name), "point": facts.label(design), "reference": facts.amount(name, values[other]), "other": facts.label(other),
        "worst_of": f"worst of {count} runs{place}" if judged else "", "step": facts.command(design),
    }  # fmt: skip


def from_to(facts: StudyFacts) -> Hits:
    """Chosen points whose output has no better side, or that differ in engine speed, which is no choice."""
    if facts.ends:
        name = facts.outputs[0]
        values = facts.judged(name)
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        if values[low] < values[high] and (facts.over_speed or not facts.sign(name)):
            yield Hit(facts.amount(name, values[high]), fields=_chosen(facts, name, high, low))


def flat(facts: StudyFacts) -> Hits:
    """A grid along one quantity whose output stays near its best over a wide part and then leaves it."""
    if not facts.ends or facts.table.plan.sampler.word != "grid" or len(facts.along) != 1:
        return
    name, varied = facts.outputs[0], facts.table.plan.varied[facts.along[0]]
    order = facts.order[np.isfinite(facts.judged(name)[facts.order])]
    good = facts.sign(name) * facts.judged(name)[order]
    if len(order) < FEWEST or not np.ptp(good) > 0:
        return
    near = good.max() - good <= FLAT * np.ptp(good)
    if near[0] == near[-1]:  # both ends are good, or the best is between
        return
    side = "up to" if near[0] else "from"
    if near[-1]:  # the flat part first
        order, good, near = order[::-1], good[::-1], near[::-1]
    places = facts.draws[[facts.designs[k][0] for k in order], facts.along[0]]
    count = int(near.sum())
    wide = abs(places[count - 1] - places[0]) >= WIDE * np.ptp(places)
    if wide and not near[count:].any():
        bound = facts.sign(name) * good[near].min()
        yield Hit(facts.amount(name, bound), fields={
            **_chosen(facts, name, int(order[count - 1]), int(order[count])), "side": side,
            "next": varied.value_text(float(places[count]), 4),
        })  # fmt: skip


def best_point(facts: StudyFacts) -> Hits:
    """The best of the chosen points against the first of a list, the case, or the worst."""
    if facts.ends:
        name, (best, *others) = facts.outputs[0], facts.ends.values()
        other = next((one for one in others if one != best and np.isfinite(facts.judged(name)[one])), best)  # fmt: skip
        values = facts.judged(name)
        near = int(np.sum(np.abs(values - values[best]) <= ALIKE * abs(values[best]))) - 1
        yield Hit(facts.amount(name, values[best]), fields={
            **_chosen(facts, name, best, other),
            "end": at_end_of_range(facts, best),
            "near": f"{near} more" if near else "",
        })  # fmt: skip


def price(facts: StudyFacts) -> Hits:
    """Another output with a better side that is worse at the best point than at the one that it is compared with."""
    if "best" not in facts.ends:
        return
    best, *others = facts.ends.values()
    other = next((one for one in others if one != best), best)
    for name in (one for one in facts.outputs[1:] if not put_in(one)):
        sign, values = facts.sign(name), facts.worst(name)
        here, there = values[best], values[other]
        worse = sign * (there - here)
        share = worse / abs(there) if there else math.inf * worse if worse > 0 else 0.0
        if share > max(WORSE, facts.bar(name)):
            yield Hit(facts.amount(name, here), fields={
                "name": label_of(name), "reference": facts.amount(name, there), "other": facts.label(other), "point": facts.label(best),
            }, severity=share)  # fmt: skip


def at_end_of_range(facts: StudyFacts, best: int) -> str:
    """``still falling at the lowest value tried``: of a best point at an end of one quantity, next to a worse point."""
    values = facts.judged(facts.outputs[0])
    for side, step in (("lowest", 1), ("highest", -1)) if len(facts.along) == 1 else ():
        first, *rest = facts.order[::step]
        rest = [k for k in rest if np.isfinite(values[k])]
        if (
            first == best
            and rest
            and abs(values[rest[0]] - values[best]) > ALIKE * abs(values[best])
        ):
            return f"still {'rising' if values[best] > values[rest[0]] else 'falling'} at the {side} value tried"
    return ""


def wide_bar(facts: StudyFacts) -> Hits:
    """The error bar of the output is as large as its change between the points."""
    if facts.within_bar:
        name = facts.outputs[0]
        yield Hit(Amount(name, facts.within_bar), fields={"name": label_of(name)})


# -- draws -----------------------------------------------------------------------------------------


def still(facts: StudyFacts) -> Hits:
    """Draws, or several chosen points, over which the output does not change."""
    for name in facts.outputs[:1]:
        values = facts.judged(name) if facts.chosen else facts.finite(name, facts.run)
        alike = len(values) > 1 and np.ptp(values) == 0 if facts.chosen else not facts.effects(name)
        if alike:
            yield Hit(facts.amount(name, np.median(values)), fields={"name": label_of(name)})


def moves(facts: StudyFacts, sure: bool = True) -> Hits:
    """The quantity that moves the output of draws most."""
    if not facts.outputs or facts.chosen:
        return
    name, run, plan = facts.outputs[0], facts.run, facts.table.plan
    effects, rows = facts.effects(name), len(facts.draws)
    near = [one for one in effects if one is effects[0] or one.high >= effects[0].low]
    if not near or (len(near) == 1 and near[0].low > 0) != sure:
        return
    low, high = (
        facts.amount(name, one) for one in np.percentile(facts.finite(name, run), PERCENTILES[::2])
    )
    sign, column = facts.sign(name) or -1, facts.table.column(near[0].varied.name)
    worst = int(np.argmin(sign * near[0].change * column[facts.table.rows_of(run)]))
    enough = ENOUGH_ROWS * (len(plan.varied) + 2) if facts.table.sensitivities else 0
    yield Hit(high, fields={
        "name": label_of(name), "low": low,
        "place": run.label if len(plan.runs) > 1 else "", "count": str(enough if rows < enough else 4 * rows),
        "leader": near[0].varied.shown_name, "share": per_cent(min(1.0, near[0].share)), "by": Amount(name, abs(near[0].change)),
        "verb": {1: "rises", -1: "falls", 0: "varies"}[near[0].rises],
        "rivals": f"{len(near)} quantities are not separated" if len(near) > 1 else "", "step": facts.command(worst, near[0].varied),
    })  # fmt: skip


def too_few(facts: StudyFacts) -> Hits:
    """Draws too few to say which quantity moves the output most."""
    return moves(facts, False)


GUIDE, AGAIN = "studies.md", "set count = {count} in the study file and run it again"
RULES = (
    Rule("J101", "decides", "nothing came out", nothing, (), "[{told}]", "correct the study file and run it again", guide=GUIDE),
    Rule("J134", "decides", "no point is best by {name}", wide_bar, (), "the differences are within its error bar of {value:2}",
         "vary over wider ranges, or use a finer mesh", mark="warn", guide="uncertainty.md"),
    Rule("J120", "decides", "no varied quantity moves {name}", still, (), "[{value:4} at every point]", "vary something else", mark="warn"),
    Rule("J111", "decides", "{name} is {reference..value:4}", from_to, (), "least with {other}, largest with {point}", "[{step}]", mark="",
         unless=("J12", "J134")),
    Rule("J112", "decides", "{name} stays near its best {side} {point}", flat, (), "[{value:4}][, but {reference:4} at {next}][; {worst_of}]",
         "[{step}]", mark="ok", unless=("J11", "J12", "J134")),
    Rule("J113", "decides", "best is {point}, by {name}", best_point, (),
         "[{value:4}][, {end}][, {reference:4} with {other}][; {near} within 1 %][; {worst_of}]", "[{step}]",
         mark="ok", unless=("J11", "J12", "J134")),
    Rule("J114", "warns", "{name} is worse there: {value:3}, {reference:3} with {other}", price,
         unless=("J111", "J12", "J134")),
    Rule("J121", "decides", "too few draws to say what moves {name} most", too_few, (),
         "[{rivals}; ]{low..value:4} in nine of ten draws[, {place}]", AGAIN, mark="warn"),
    Rule("J122", "decides", "{name} {verb} most with {leader}", moves, (),
         "[by {by:2} over its range, ]{share} of its variance; {low..value:4} in nine of ten draws[, {place}]", "[{step}]", mark="ok"),
    Rule("J130", "warns", "{share} failed", failed, (), "{code}[: {told}]", guide=GUIDE, unless=("J101",)),
    Rule("J131", "warns", "{told}", lacking, guide=GUIDE, unless=("J101",)),
    Rule("J132", "warns", "{share} are doubtful", doubtful, (), "{told}"),
    Rule("J133", "warns", "{name} of {share} is {side} the speeds searched", at_an_end, (), "it is given as {value:4}",
         "search over more engine speeds"),
)  # fmt: skip
