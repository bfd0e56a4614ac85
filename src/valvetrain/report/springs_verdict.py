"""Verdict of two springs in one engine: which is stressed more and why, which keeps contact and floats
later, surges and clashes less.
"""

from __future__ import annotations

import math
from dataclasses import replace

from valvetrain.report.clauses import (
    Runs,
    Worst,
    ended_clauses,
    joined,
    parted,
    sentence,
)
from valvetrain.report.control import Control, control_of, range_in_use, span_text
from valvetrain.report.run_clauses import bind_clause, condition_of
from valvetrain.report.springs_stress import stress_clause
from valvetrain.report.sweep_verdict import runs_over_speed
from valvetrain.report.text import rpm
from valvetrain.solution.critical import CriticalSpeed
from valvetrain.solution.study import Study

#: Quantities of the sentence: what is said of the better spring, its noun, and the value (SI) below
#: which nothing is.
SAID = {
    "surge_amplitude_force": ("surges less", "surge", 1.0),
    "clash_energy": ("clashes less", "clash energy", 1e-5),
}
STRESS = "open_nominal_shear_stress"
#: Share below which two numbers count as equal, and the words for it.
ALIKE, WITHIN = 0.01, " within 1 %"
#: Kind of critical speed -> what the better spring does, what both do.
LATER = {
    "contact-loss": ("keeps contact longer", f"both lose contact{WITHIN}", "neither loses contact"),
    "float": ("floats later", f"both float{WITHIN}", "neither floats"),
}


#: Kind of loss -> what a spring does that never has it, and what one does that has.
NEVER = {
    "contact-loss": ("keeps contact", "loses it"),
    "float": ("does not float", "floats"),
}


def springs_verdict(study: Study) -> str:
    """Which of two springs is better in what, over the speeds of the sweep and those between them; stress,
    surge and clash at those in use, then how surge and clash are beyond.
    """
    names = [study.runs(label)[0].spring_set or label for label in study.labels[:2]]
    pair = _alike_speeds([runs_over_speed(study, label) for label in study.labels[:2]])
    found = ended_clauses([run for run in study.solutions if run.status.code != "not-converged"])
    found.append(_named(study.interruption, study, names))
    used, until = _in_use(study, pair)
    stress, why = stress_clause(names, used)
    found.append(f"{until} {stress}".strip() if stress else "")
    if len(study.critical_speeds):
        found += [_later_text(kind, study, names) for kind in LATER]
    found += _near_bind(names, pair)
    for quantity in SAID:
        found.append(_better(quantity, names, used, until))
        found.append(_beyond(quantity, names, used, pair, until))
    found.append(_unknown(names, pair))
    first, rest = parted(found, [])
    if not first:
        return "No difference between the two springs."
    condition = next(filter(None, map(condition_of, pair)), "")
    more = [one for one in (why, *rest) if one]
    if more and more[0].startswith(tuple(names)):
        more[0] = f"also {more[0]}"  # a sentence begins with a capital, a name keeps its letters
    return f"{_sentence(first, names, condition)} {_sentence(more, names)}".strip()


def _sentence(parts: list[str], names: list[str], condition: str = "") -> str:
    """Parts as a sentence in which a name keeps its letters."""
    text = sentence(parts, condition)
    if condition or not parts or not parts[0].startswith(tuple(names)):
        return text
    return parts[0] + text[len(parts[0]) :]


def _in_use(study: Study, pair: list[Runs]) -> tuple[list[Runs], str]:
    """The runs of both springs at the speeds in use, and ``up to 7056 rpm``; all of them and empty text where
    there are no others, or one spring has none.
    """
    limit, _ = range_in_use(study)
    used = [
        replace(runs, solutions=tuple(one for one in runs.solutions if one.engine_speed <= limit))
        for runs in pair
    ]
    counts = [[len(runs.solutions) for runs in some] for some in (used, pair)]
    if counts[0] == counts[1] or 0 in counts[0]:
        return pair, ""
    return used, f"up to {rpm(limit):.0f} rpm"


def _beyond(quantity: str, names: list[str], used: list[Runs], pair: list[Runs], until: str) -> str:
    """``at all speeds a surges less (...)`` where that differs from what holds in use; empty elsewhere."""
    text = _better(quantity, names, pair) if until else ""
    return f"at all speeds {text}" if text and text != _better(quantity, names, used) else ""


def _better(quantity: str, names: list[str], pair: list[Runs], until: str = "") -> str:
    """Which spring has less of a quantity ``until`` a speed, or that its error bar hides it; empty where both
    are alike.
    """
    word, noun, least = SAID[quantity]
    one, other = (runs.worst(quantity, False) for runs in pair)
    if one is None or other is None:
        return ""
    if not abs(one.value - other.value) > max(ALIKE * max(one.value, other.value), least):
        return ""
    place = 0 if one.value < other.value else 1
    (better, known), (worse, other_known) = (
        _numbers(pair[at], (one, other)[at]) for at in (place, 1 - place)
    )
    against = f"({better} against {worse})"
    if not (known and other_known):
        return f"{noun} not resolved {until} {against}".replace("  ", " ")
    return f"{until} {names[place]} {word} {against}".strip()


def _unknown(names: list[str], pair: list[Runs]) -> str:
    """What one spring shows and the other cannot, as a card without its wire."""
    for name, runs, other in zip(names, pair, pair[::-1], strict=True):
        nouns = [
            noun
            for quantity, noun in ((STRESS, "stress"), *((one, SAID[one][1]) for one in SAID))
            if runs.worst(quantity, False) is None and other.worst(quantity, False) is not None
        ]
        if nouns:
            return f"{joined(nouns)} of {name} unknown without its wire"
    return ""


def _numbers(runs: Runs, found: Worst) -> tuple[str, bool]:
    return runs.text(found), runs.bar(found) <= abs(found.value)


def _near_bind(names: list[str], pair: list[Runs]) -> list[str]:
    """Springs that are close to coil bind or beyond it."""
    texts = [
        clause.text
        if (clause := bind_clause(runs)) is not None and "clear of coil bind by" not in clause.text
        else ""
        for runs in pair
    ]
    return [f"{name} {text}" for name, text in zip(names, texts, strict=True) if text]


def _later_text(kind: str, study: Study, names: list[str]) -> str:
    """Which spring loses control later, of one kind of loss; none where one was not computed."""
    later, both, neither = LATER[kind]
    rows = [study.critical_speeds.of(kind, label) for label in study.labels[:2]]
    known = [one for one in rows if one is not None]
    if len(known) < 2:
        missing = [name for name, one in zip(names, rows, strict=True) if one is None]
        noun = "contact loss" if kind == "contact-loss" else kind
        return f"{noun} of {joined(missing)} not computed" if known else ""
    controls = [control_of(study, label) for label in study.labels[:2]]
    speeds = [one.begin(kind) for one in controls]
    last = f"{rpm(known[0].last_engine_speed):.5g} rpm"
    islands = [_islands_text(one) if kind == "contact-loss" else "" for one in controls]
    if all(map(math.isinf, speeds)) and not any(islands):
        return f"{neither} up to {last}"
    if all(one == 0 for one in speeds):
        return f"{both.removesuffix(WITHIN)} below {rpm(known[0].first_engine_speed):.5g} rpm"
    texts = [
        _speed_text(row, speed) + island
        for row, speed, island in zip(known, speeds, islands, strict=True)
    ]
    if texts[0] == texts[1]:
        return f"{both.removesuffix(WITHIN)} from {texts[0]}"
    if all(map(math.isinf, speeds)):
        return f"{neither} up to {last} but for short ranges ({texts[0]} against {texts[1]})"
    if abs(speeds[0] - speeds[1]) <= ALIKE * min(speeds):
        return f"{both} ({names[0]} from {texts[0]}, {names[1]} from {texts[1]})"
    place = 0 if speeds[0] > speeds[1] else 1
    if any(gap.lower_engine_speed < speeds[1 - place] for gap in controls[place].islands):
        # the one that keeps contact longer loses it first: neither is better
        own = [_losses_text(one) for one in controls]
        return f"{names[0]} loses contact {own[0]}, {names[1]} {own[1]}"
    if math.isinf(speeds[place]) and not islands[place] and speeds[1 - place] > 0:
        keeps, loses = NEVER[kind]
        return f"{names[place]} {keeps} up to {last}, {names[1 - place]} {loses} from {texts[1 - place]}"
    red_line = study.record.red_line
    mark = "" if red_line is None else f", red line {rpm(red_line):.6g}"
    return f"{names[place]} {later} ({texts[place]} against {texts[1 - place]}{mark})"


def _speed_text(one: CriticalSpeed, speed: float) -> str:
    """``7843 rpm``, ``below 4000 rpm`` or ``never up to 8000 rpm``."""
    if math.isinf(speed):
        return f"never up to {rpm(one.last_engine_speed):.5g} rpm"
    return f"{rpm(speed):.0f} rpm" if speed > 0 else f"below {rpm(one.first_engine_speed):.5g} rpm"


def _islands_text(one: Control) -> str:
    """`` but for 5218 to 5258 rpm``: short ranges of lost contact below the loss that stays."""
    return f" but for {joined([span_text(gap) for gap in one.islands])} rpm" if one.islands else ""


def _losses_text(one: Control) -> str:
    """``from 6781 to 6820 rpm and from 7300 rpm``, or ``from 11927 to 12070 rpm only``."""
    gaps = [f"from {span_text(gap)} rpm" for gap in one.islands]
    begin = one.begin("contact-loss")
    if math.isinf(begin):
        return f"{joined(gaps)} only"
    return joined([*gaps, f"from {rpm(begin):.0f} rpm"])


def _alike_speeds(pair: list[Runs]) -> list[Runs]:
    """Both over the same speeds, where a run of one did not complete: nothing is judged by what the
    other has alone.
    """
    swept = [{rpm(run.engine_speed) for run in runs.solutions} for runs in pair]
    common = swept[0] & swept[1]
    if not common:
        return [replace(runs, solutions=()) for runs in pair]
    low, high = min(common), max(common)
    return [
        replace(
            runs,
            solutions=tuple(run for run in runs.solutions if low <= rpm(run.engine_speed) <= high),
        )
        for runs in pair
    ]


def _named(text: str, study: Study, names: list[str]) -> str:
    """A sentence with the names of the springs in place of their labels."""
    for name, label in zip(names, study.labels[:2], strict=True):
        text = text.replace(label, name)
    return text
