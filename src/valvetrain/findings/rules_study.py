"""Rules on any study: runs that did not end (R), models that disagree (M), run-ups (U)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from valvetrain.findings.engine import Fields, Hit, Hits, Rule
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_train import (
    CONTACT,
    FLOAT,
    LIMIT,
    NEAR,
    cause,
    near_limit,
)
from valvetrain.findings.words import COARSE, Amount, Phrase, Said, joined, speed_text, speeds_text
from valvetrain.quantities.loss_cause import FLIGHT
from valvetrain.solution.definition import label_of
from valvetrain.solution.result import Solution
from valvetrain.solution.study import INTERRUPTED

#: Status -> what a run did.
ENDED = {
    "diverged": "diverged", "out-of-range": "left the range of its tables", "coil-bind": "reached coil bind",
    "solid": "ran solid", "buckled": "buckled", "refused": "was refused", "interrupted": "was interrupted",
    "worker-lost": "lost its process",
}  # fmt: skip
#: A number of things, which no quantity names.
COUNT = "clash_count"
#: The model that knows no surge, and so has no vote on control.
MASSLESS = "massless"


# -- runs ------------------------------------------------------------------------------------------


def ended(facts: Facts) -> Hits:
    """Runs that did not end, the kind of the slowest one first."""
    some = sorted(facts.ended, key=lambda run: run.engine_speed)
    if some:
        first = some[0].status
        alike = [run.engine_speed for run in some if run.status.code == first.code][:3]
        yield Hit(None, some[0], None, {
            "did": ENDED.get(first.code, first.code), "message": first.message, "remedy": first.remedy,
            "at": f"at {speeds_text(sorted(set(alike)))}",
        })  # fmt: skip


def nothing(facts: Facts) -> Hits:
    """No run ended."""
    return iter(()) if facts.runs else ended(facts)


def at_rest(facts: Facts) -> Hits:
    """Nothing was run: the case names no engine speed."""
    if not facts.study.solutions and not facts.study.at_rest_only:
        yield Hit()


def unsettled(facts: Facts) -> Hits:
    """Runs whose motion does not repeat."""
    return (Hit(None, run) for run in facts.runs if run.status.code == "not-converged")


def pulls(facts: Facts) -> Hits:
    """A model with fixed ends shows a pull where the spring would leave its seat."""
    for run in facts.runs:
        if any(one.kind == "end-pull" for one in run.events):
            yield Hit(None, run, None, {"model": run.model}, -run.engine_speed)


def too_hard(facts: Facts) -> Hits:
    """The forces of a reduced rod are further from those of its rod than it is made for, as its error bars show."""
    for one in facts.study.error_bars.facts:
        if one.code != "too-hard":
            continue
        share = max(float(one.fields["peak_share"]), float(one.fields["minimum_share"]))
        speed = speed_text(float(one.fields["engine_speed"]))
        yield Hit(fields={"speed": speed, "share": f"{100 * share:.0f} %"}, severity=share)


def unsure(facts: Facts) -> Hits:
    """Numbers that move by more than a twentieth on other meshes."""
    rows = [one for one in facts.study.error_bars.rows if one.numerical > COARSE * abs(one.value)]
    names = list(dict.fromkeys(label_of(one.quantity) for one in rows))
    if names:
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        yield Hit(Amount(COUNT, len(names)), fields={"first": names[0], "more": more})


def stopped(facts: Facts) -> Hits:
    """The study was stopped before its end, so that what is missing judges nothing."""
    for one in facts.study.gaps:
        if one.startswith(INTERRUPTED):
            yield Hit(fields={"said": one})


def missing(facts: Facts) -> Hits:
    """Parts of the study that failed."""
    for one in dict.fromkeys((*facts.study.gaps, *(gap for run in facts.runs for gap in run.gaps))):
        yield Hit(fields={"said": one})


# -- models ----------------------------------------------------------------------------------------


def _says(facts: Facts, run: Solution) -> Phrase | None:
    """What a model says of control; None where it computes no contact."""
    left = facts.amount(run, CONTACT[0])
    if facts.losses(run):
        flies = run.quantities.get("float_excess_lift", 0.0) > FLOAT
        gap = facts.amount(run, "loft_gap") or ""
        return Phrase("floats" if flies else "loses contact[, {gap} open]", {"gap": gap})
    words = "leaves {left} on the cam" if left and left.resolved else "keeps contact"
    return Phrase(words, {"left": left}) if left else None


def _votes(facts: Facts) -> tuple[list[Solution], list[Solution]]:
    """Models that keep contact at the speed that decides, and those that lose it; a massless spring has no vote."""
    models = [run for run in facts.models if run.model != MASSLESS]
    lost = [run for run in models if facts.losses(run)]
    return [run for run in models if run not in lost], lost


def disagree(facts: Facts) -> Hits:
    """Some models lose contact at one speed and some do not; a massless spring, which knows no surge, has no vote."""
    held, lost = _votes(facts)
    if held and lost:
        lead = next(run for run in facts.models if run.model != MASSLESS)
        others = held if lead in lost else lost
        losses = facts.losses(lead)
        state = "contact is lost" if losses else NEAR if near_limit(facts, lead) else "in control"
        yield Hit(facts.amount(lead, CONTACT[0]), lead, 0.0, {
            "state": LIMIT if losses and losses[0].size <= FLIGHT else state, "said": _says(facts, lead) or "",
            "lead": lead.model, "does": f"{'keep' if losses else 'lose'}{'s' * (len(others) == 1)}",
            "others": joined([run.model for run in others]), "speed": speed_text(lead.engine_speed),
        })  # fmt: skip


def _agree(facts: Facts, little: bool) -> Hits:
    held, lost = _votes(facts)
    if facts.study.command != "compare" or lost or len(held) < 2:
        return
    known = [one for run in held if (one := facts.amount(run, CONTACT[0])) and one.resolved]
    if known and near_limit(facts, held[0]) is little:
        least, most = (way(known, key=lambda one: one.value) for way in (min, max))
        yield Hit(least, None, 0.0, _range(facts, held, least, most))


def _range(facts: Facts, runs: Sequence[Solution], least: Amount, most: Amount) -> dict[str, Said]:
    """Both ends of a range over models, with the number of the model that decides."""
    own = facts.amount(runs[0], least.name)
    return {
        "least": least, "most": most, "count": str(len(runs)), "lead": runs[0].model, "own": own or "",
        "speed": speed_text(facts.speeds[-1]),
    }  # fmt: skip


def all_hold(facts: Facts) -> Hits:
    """Every model that a comparison ran keeps contact at one speed, and the one that decides leaves enough force."""
    return _agree(facts, little=False)


def all_barely(facts: Facts) -> Hits:
    """Every model keeps contact at one speed, and the one that decides leaves little force."""
    return _agree(facts, little=True)


def all_lose(facts: Facts) -> Hits:
    """Every model that a comparison ran loses contact at one speed."""
    held, lost = _votes(facts)
    gaps = [one for run in lost if (one := facts.amount(run, "loft_gap"))]
    if facts.study.command == "compare" and len(lost) > 1 and not held and gaps:
        least, most = (way(gaps, key=lambda one: one.value) for way in (min, max))
        why = cause(lost[0], facts.losses(lost[0]))
        fields = _range(facts, lost, least, most) | {"cause": why}
        if not (least.resolved and most.resolved):
            fields["least"] = ""  # how far it opens is not resolved
        yield Hit(most, None, 0.0, fields)


def some_bounce(facts: Facts) -> Hits:
    """Every model of a comparison keeps contact at one speed, and by one of them the valve bounces."""
    held, lost = _votes(facts)
    if facts.study.command != "compare" or lost or len(held) < 2:
        return
    every = {run.model: facts.amount(run, "bounce_height") for run in held}
    limit = facts.value(held[0], "permitted_bounce_height")
    over = {model: one for model, one in every.items() if one and one.value - one.bar > limit}
    if over:
        least, most = (way(over.values(), key=lambda one: one.value) for way in (min, max))
        yield Hit(most, None, limit, {
            "least": least, "most": most, "lost": joined(list(over)), "speed": speed_text(facts.speeds[-1]),
            "kept": joined([model for model in every if model not in over]),
        })  # fmt: skip


def peaks(facts: Facts) -> Hits:
    """The range of the peak force that a spring alone has by the models of a comparison, and which one decides."""
    runs = () if facts.train else facts.models
    amounts = (facts.amount(run, "peak_retainer_force") for run in runs)
    known = [one for one in amounts if one and one.resolved]
    if len(known) > 1:
        least, most = (way(known, key=lambda one: one.value) for way in (min, max))
        yield Hit(most, None, None, _range(facts, runs, least, most))


def other_models(facts: Facts) -> Hits:
    """What the other models say of the same train."""
    own, said = {run.model for run in facts.runs}, list[Said]()
    for run in facts.models:
        if run.model not in own and (one := _says(facts, run)):
            said.append(Phrase("{model} {said}", {"model": run.model, "said": one}))
    if said:
        yield Hit(Amount(COUNT, len(said)), fields={"said": said})


def spread(facts: Facts) -> Hits:
    """Another model of a spring alone, next to the one that decides."""
    for run in facts.others:
        for mine in facts.runs:
            peaks = [facts.amount(one, "peak_retainer_force") for one in (run, mine)]
            if mine.engine_speed == run.engine_speed and peaks[0] and peaks[1]:
                fields: Fields = {"model": run.model, "best": peaks[1], "lead": mine.model}
                yield Hit(peaks[0], run, None, fields, abs(peaks[0].value - peaks[1].value))


# -- run-ups ---------------------------------------------------------------------------------------


def _lost(facts: Facts) -> list[Solution]:
    """Revolutions of a run-up in which control is lost, in their order of speed."""
    return [run for run in facts.runs if _without_contact(facts, run) > 0]


def _without_contact(facts: Facts, run: Solution) -> float:
    """Time (s) without contact of a revolution; its largest gap (m) where that is all it has."""
    values = (facts.value(run, name) for name in ("loss_of_contact_duration", "loft_gap"))
    return next((one for one in values if math.isfinite(one)), 0.0)


def _reach(facts: Facts) -> str:
    """The speeds of a run-up in rpm as a command takes them."""
    return f"{speed_text(min(facts.speeds), '')}-{speed_text(max(facts.speeds))}"


def loses_running_up(facts: Facts) -> Hits:
    """The first revolution of a run-up in which the cam is left, up to the red line."""
    lost = _lost(facts)
    if lost:
        red, first = facts.red_line, lost[0]
        short = f"{speed_text(red - first.engine_speed)}" if math.isfinite(red) else ""
        gap = max((facts.value(run, "loft_gap") for run in lost), default=math.nan)
        yield Hit(facts.amount(first, "loft_gap"), first, 0.0, {
            "speed": speed_text(first.engine_speed), "short": short,
            "gap": Amount("loft_gap", gap) if math.isfinite(gap) else "", "label": first.label if facts.several else "",
            "reach": _reach(facts), "set": first.spring_set if facts.several else "",
        })  # fmt: skip


def _kept_running_up(facts: Facts, whole: bool) -> Hits:
    if not facts.runs or _lost(facts):
        return
    red, top = facts.study.record.red_line, max(facts.speeds)
    # the mean speed of the last revolution lies below the speed at which the run-up ends
    short = 0.0 if red is None else red - top
    if (short <= NEARLY * top) is whole:
        least = min(
            facts.amounts(CONTACT[0]),
            key=lambda pair: pair[0].value,
            default=(None, facts.runs[-1]),
        )
        fields: Fields = {
            "speed": speed_text(top), "least": least[0] or "", "there": speed_text(least[1].engine_speed),
            "short": speed_text(short), "red": speed_text(red or top, ""), "reach": _reach(facts),
        }  # fmt: skip
        yield Hit(least[0], least[1], 0.0, fields)


def kept_running_up(facts: Facts) -> Hits:
    """A run-up to the red line, where one is stated, in which the cam is never left."""
    return _kept_running_up(facts, whole=True)


def kept_to_its_end(facts: Facts) -> Hits:
    """A run-up that ends below the red line, and in which the cam is never left."""
    return _kept_running_up(facts, whole=False)


#: By how much of its speed the last revolution of a run-up may be slower than the red line it ran up to.
NEARLY = 0.02
SWEEP, RUN = "valvetrain sweep {case}", "valvetrain run {case} --rpm '{speed}'"
DECIDES = "[{own} ]by {lead}"
FIRST = (
    Rule("R101", "decides", "nothing to judge: the run {did}[ {at}]", nothing, step="[{message}: ][{remedy}]"),
    Rule("R100", "decides", "nothing moves: the case names no engine speed", at_rest, mark="",
         step="valvetrain static {case}"),
)  # fmt: skip
#: The speeds of a run-up in steady motion, of the spring set that decides.
AGAIN = "valvetrain sweep {case} --rpm '{reach}'[ --spring-set {set}]"
RUN_UP = (
    Rule("U101", "decides", "[{label}: ]loses the cam from {speed} on[, {short} short of the red line]",
         loses_running_up, (*CONTACT, "float_excess_lift"), "[at most {gap} off the cam]", AGAIN, "[from {speed}]",
         "how-to/02-power-drops.md"),
    Rule("U102", "decides", "in control up to {speed}", kept_running_up, CONTACT,
         "[at least {least} on the cam][, at {there}]", AGAIN, mark="ok"),
    Rule("U103", "decides", "in control to {speed}, where the run-up ends, {short} below the red line", kept_to_its_end, CONTACT,
         "[at least {least} on the cam][, at {there}]", "valvetrain run-up {case} --to '{red} rpm'", mark=""),
)  # fmt: skip
MODELS = (
    Rule("M101", "decides", "{state} at {speed}: {lead}, the model that decides, {said}; {others} {does} contact", disagree,
         CONTACT[:1], "", SWEEP, guide="models.md", mark="warn"),
    Rule("M106", "decides", "the valve bounces {least..most} at {speed} by {lost}", some_bounce, ("bounce_height",),
         "[by {kept} it stays on its seat]", RUN, guide="how-to/10-seating.md"),
    Rule("M102", "decides", "in control by {count} models with surge: {least..most} left on the cam at {speed}", all_hold, CONTACT[:1],
         DECIDES, RUN, guide="models.md", mark="ok", unless=("M106",)),
    Rule("M103", "decides", f"{NEAR} by {{count}} models with surge: {{least..most}} left on the cam at {{speed}}", all_barely,
         CONTACT[:1], DECIDES, RUN, guide="models.md", mark="warn", unless=("M106",)),
    Rule("M104", "decides", "{count} models with surge lose contact at {speed}[: {least..most} open]", all_lose, CONTACT,
         "[{cause}, ]by {lead}", RUN, guide="models.md"),
)  # fmt: skip
PEAKS = (
    Rule("M105", "decides", "[{own} ]at most on the retainer at {speed}, by {lead}", peaks, ("peak_retainer_force",),
         "{count} models say {least..most}", SWEEP, guide="models.md", mark=""),
)  # fmt: skip

ENDS = (
    Rule("R102", "warns", "a run {did} {at}", ended, step="[{remedy}]", unless=("R101",)),
    Rule("R103", "warns", "stopped before its end: {said}", stopped),
    Rule("R110", "warns", "the motion does not repeat[ {where}]: cycles differ", unsettled),
    Rule("R120", "warns", "doubtful[ {where}]: the spring's ends would lift, which {model} cannot show", pulls,
         ("minimum_spring_force",), step="valvetrain run {case} --model wave-rod", remark="ends would lift", unless=("W114",)),
    Rule("R121", "warns", "doubtful at {speed}: spring forces of the reduced rod are {share} from those of its rod", too_hard,
         step="valvetrain run {case} --model finite-element"),
)  # fmt: skip
OTHERS = (Rule("M110", "notes", "other models: {said}", other_models),)
SPREAD = (Rule("M111", "notes", "the {model} model says {value}[ {at}] where {lead} has {best}", spread),)  # fmt: skip
LAST = (
    Rule("R130", "notes", "unsure by more than 5 % on other meshes: {first}[{more}]", unsure, guide="uncertainty.md"),
    Rule("R140", "notes", "not computed: {said}", missing),
)  # fmt: skip
