"""Verdict of two springs in one engine: which floats later, surges, clashes and is stressed less."""

from __future__ import annotations

import math

from valvetrain.report.clauses import Runs, Worst, ended_clauses, joined, sentence
from valvetrain.report.run_clauses import bind_clause, condition_of
from valvetrain.report.sweep_verdict import runs_over_speed
from valvetrain.report.text import rpm
from valvetrain.solution.study import Study

#: Quantities of the sentence: what is said of the better spring, its noun, and the value (SI) below
#: which nothing is.
SAID = {
    "surge_amplitude_force": ("surges less", "surge", 1.0),
    "clash_energy": ("clashes less", "clash energy", 1e-5),
    "nominal_peak_shear_stress": ("is stressed less", "stress", 1e6),
}
#: Share below which two numbers are not told apart.
ALIKE = 0.01


def springs_verdict(study: Study) -> str:
    """Which of two springs is better in what, over the speeds of the sweep and those between them."""
    names = [study.runs(label)[0].spring_set or label for label in study.labels[:2]]
    pair = [runs_over_speed(study, label) for label in study.labels[:2]]
    found = ended_clauses([run for run in study.solutions if run.status.code != "not-converged"])
    if len(study.critical_speeds):
        found.append(_float_text(study, names))
    found += _near_bind(names, pair)
    for quantity in SAID:
        found.append(_better(quantity, names, pair))
    found.append(_unknown(names, pair))
    condition = next(filter(None, map(condition_of, pair)), "")
    text = sentence([one for one in found if one], condition)
    first = next((one for one in found if one), "")
    if not text:
        return "No difference between the two springs."
    # A name keeps its letters.
    return first + text[len(first) :] if not condition and first.startswith(tuple(names)) else text


def _better(quantity: str, names: list[str], pair: list[Runs]) -> str:
    """Which spring has less of a quantity, or that its error bar hides it; empty where both are alike."""
    word, noun, least = SAID[quantity]
    one, other = (runs.worst(quantity, False) for runs in pair)
    if one is None or other is None:
        return ""
    if not abs(one.value - other.value) > max(ALIKE * max(one.value, other.value), least):
        return ""
    place = 0 if one.value < other.value else 1
    both = [_numbers(runs, found) for runs, found in zip(pair, (one, other), strict=True)]
    (better, bound), (worse, other_bound) = (
        text.partition(", permitted ")[::2] for text, _ in (both[place], both[1 - place])
    )
    if bound and bound == other_bound:  # the bound of both once
        against = f"({better} against {worse}, permitted {bound})"
    else:
        against = f"({both[place][0]} against {both[1 - place][0]})"
    if not all(known for _, known in both):
        return f"{noun} not resolved {against}"
    return f"{names[place]} {word} {against}"


def _unknown(names: list[str], pair: list[Runs]) -> str:
    """What one spring shows and the other cannot, as a card without its wire."""
    for name, runs, other in zip(names, pair, pair[::-1], strict=True):
        nouns = [
            noun
            for quantity, (_, noun, _) in SAID.items()
            if runs.worst(quantity, False) is None and other.worst(quantity, False) is not None
        ]
        if nouns:
            return f"{joined(nouns)} of {name} unknown without its wire"
    return ""


def _numbers(runs: Runs, found: Worst) -> tuple[str, bool]:
    return runs.bounded(found), runs.bar(found) <= abs(found.value)


def _near_bind(names: list[str], pair: list[Runs]) -> list[str]:
    """Springs that are close to coil bind or beyond it."""
    texts = [
        clause.text
        if (clause := bind_clause(runs)) is not None and "clear of coil bind by" not in clause.text
        else ""
        for runs in pair
    ]
    return [f"{name} {text}" for name, text in zip(names, texts, strict=True) if text]


def _float_text(study: Study, names: list[str]) -> str:
    speeds = []
    for label in study.labels[:2]:
        one = study.critical_speeds.of("float", label)
        speeds.append(math.inf if one is None or not one.found else one.engine_speed)
    if all(map(math.isinf, speeds)):
        return f"neither floats up to {rpm(max(study.engine_speeds)):.5g} rpm"
    never = f"never up to {rpm(max(study.engine_speeds)):.5g} rpm"
    texts = [never if math.isinf(one) else f"{rpm(one):.0f} rpm" for one in speeds]
    if abs(speeds[0] - speeds[1]) <= ALIKE * min(speeds):
        return f"both float from {texts[0]}"
    place = 0 if speeds[0] > speeds[1] else 1
    return f"{names[place]} floats later ({texts[place]} against {texts[1 - place]})"
