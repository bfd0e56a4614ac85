"""Rules on a search (O): what the best design is and gains, what limits it, and why to trust it or not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.explore.limit_speed import BELOW, BEYOND, FOUND
from valvetrain.explore.measure import Measure
from valvetrain.explore.optimum import Confirmed, Design, Optimum
from valvetrain.explore.results import value_text
from valvetrain.explore.search import Trial
from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import (
    UNRESOLVED,
    Amount,
    Phrase,
    Said,
    digits_text,
    joined,
    speed_text,
)
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import card_quantities
from valvetrain.solution.definition import label_of

#: Values of the card of a design in addition to the varied ones: quantity -> name.
CARD = {"card_preload": "seat load", "card_rate": "rate", "card_open_force": "open load"}
#: Share of the best objective within which a design is as good, and share of its range over which such designs leave a
#: quantity open.
ALIKE, OPEN = 0.01, 0.1


@dataclass(frozen=True)
class SearchFacts(Subject):
    """A search as rules read it; ``file``: case file of the best design, empty where none was written."""

    result: Optimum
    file: str = ""
    called: str = ""

    @property
    def case(self) -> str:
        """What a command takes for its case."""
        return self.called or self.result.plan.case_name

    @property
    def step(self) -> str:
        """The command that draws the best springs of a train beside those of the case, else the run of the best design."""
        plan = self.result.plan
        springs = all(one.key.startswith("train.springs.") for one in plan.varied)
        if not self.file or plan.case is None or not springs or plan.case.changed:
            return f"valvetrain run {self.file}" if self.file else ""
        return f"valvetrain compare-springs {self.case} {self.file}"

    @property
    def several(self) -> bool:
        """Whether there are several objectives."""
        return len(self.result.plan.objectives) > 1

    @property
    def name(self) -> str:
        """What the design is that is set beside the case."""
        return "nearest" if self.result.best is None else "balanced" if self.several else "best"

    def number(self, one: Measure, value: float) -> float:
        """A number (SI) of a measure in its unit; as it is where a function gives it."""
        return value if self.result.plan.case is None else one.shown(value)

    @property
    def goal(self) -> Measure:
        """The first objective."""
        return self.result.plan.objectives[0].measure

    @property
    def best(self) -> Design | None:
        """The best design of one objective that is not the case itself."""
        best = self.result.best
        return best if best is not None and best.trial.number and not self.several else None

    @property
    def trial(self) -> Trial | None:
        """The best design, or where none meets every bound the one that comes nearest."""
        return self.result.nearest

    def gain(self, trial: Trial, case: Trial) -> float:
        """By how much (SI) the first objective of a design is better than that of a case."""
        return float(case.costs[0] - trial.costs[0])

    def objective(self, trial: Trial, place: int = 0) -> Said:
        """An objective of a design."""
        return self.said(self.result.plan.objectives[place].measure, float(trial.objectives[place]), trial)  # fmt: skip

    def bound(self, place: int) -> Phrase:
        """``estimated rate at least 40 N/mm``, by its place in ``Trial.missed``."""
        plan = self.result.plan
        if place >= len(plan.constraints):
            name = plan.objectives[place - len(plan.constraints)].measure.label
            return Phrase("{name} above the lowest speed searched", {"name": name})
        one = plan.constraints[place]
        sign = "at most" if one.upper else "at least"
        return Phrase("{name} {sign} {value:4}", {"name": one.measure.label, "sign": sign, "value": self.said(one.measure, one.bound)})  # fmt: skip

    def said(self, one: Measure, value: float, trial: Trial | None = None) -> Said:
        """A number (SI) of a measure, of a design with its error bar; as text where it is no quantity of the program; of a
        limit speed beyond the speeds that were searched, on which side.
        """
        if not np.isfinite(value):
            return ""
        if self.result.plan.case is None:
            return digits_text(value, 0.0, 4)
        amount = Amount(one.output, value, self.bar(one, value, trial))  # fmt: skip
        kinds = {each.kind for each in trial.measured.limits.get(one, ())} if trial is not None else set()  # fmt: skip
        side = "below {at:4}" if BELOW in kinds else "{at:4} or more" if kinds == {BEYOND} else ""
        return Phrase(side, {"at": amount}) if side else amount

    def bar(self, one: Measure, value: float, trial: Trial | None) -> float:
        """Error bar (SI) of a measure of a design: of a limit speed its bracket, else that of the best design; 0 for none."""
        if trial is None:
            return 0.0
        if one.limit is not None:
            return max((each.high - each.low for each in trial.measured.limits.get(one, ()) if each.kind == FOUND), default=0.0)  # fmt: skip
        rows = [row for row in self.result.error_bars if row.quantity == one.quantity and np.isfinite(row.numerical)]  # fmt: skip
        return min(rows, key=lambda row: abs(row.value - value)).numerical if rows else 0.0

    def alike(self, place: int) -> str:
        """``180 to 200 N``: how far a varied quantity may go with designs as good; empty where the search settles it."""
        one = self.result.plan.varied[place]
        if self.best is None:
            return ""
        cost = float(self.best.trial.costs[0])
        good = [
            each.values[place]
            for each in self.result.trials
            if each.feasible and abs(each.costs[0] - cost) <= ALIKE * abs(cost)
        ]
        low, high = float(np.nanmin(good)), float(np.nanmax(good))
        left_open = high - low >= OPEN * abs(np.subtract(*one.ends)) > 0
        return value_text(one.unit, low, high) if left_open else ""

    @property
    def ends(self) -> list[int]:
        """Places of varied quantities at an end of their range in the design, but those that designs as good leave open."""
        trial = self.trial
        return [] if trial is None else [place for place in self.result.at_ends(trial) if not self.alike(place)]  # fmt: skip


def card_values(result: Optimum, trial: Trial) -> Iterator[tuple[str, str, float, float]]:
    """Loads and rate of the spring cards that a design changes and that are neither varied nor searched: the name, of
    several springs with theirs, the quantity, and its value (SI) in the case and in the design.
    """
    if result.plan.case is None:
        return
    both = [_springs(case) for case in (result.plan.case, result.case_of(Design(trial, "")))]
    shown = [*trial.values, *trial.objectives, *trial.constraints]
    for one, other in zip(*both, strict=True):
        before, after = (
            {} if each.card is None else card_quantities(each.card) for each in (one, other)
        )
        for name in CARD:
            if (
                before.get(name) != after.get(name)
                and name in after
                and not np.any(np.isclose(shown, after[name], rtol=1e-9, atol=0.0))
            ):
                of = f" of {one.name}" if len(both[0]) > 1 else ""
                yield CARD[name] + of, name, before[name], after[name]


def _springs(case: Case) -> list[InstalledSpring]:
    sets = (case.springs,) if case.train is None else case.train.springs.values()
    return [one for springs in sets for one in springs]


#: Varied quantities and bounds that a sentence names at most.
NAMED = 2
#: Share of the gain that another model may lack and still confirm it.
CONFIRMED = 0.1


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
            "most": "most" if result.plan.objectives[0].maximise else "least", "step": facts.step,
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
    """Models that leave out parts of the spring, with no other to confirm them, where a finer one could."""
    result, finest = facts.result, facts.result.plan.unchecked
    if result.best is not None and finest and not result.confirmed:
        models = {run.spring_model for one in result.plan.measures for run in one.runs}
        named = joined(sorted(filter(None, models))) or "the model of the case"
        yield Hit(fields={"model": named, "finest": finest})


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
    Rule("O109", "decides", "{name} goes from {before:4} to {after:4}", better(lambda facts: True), (), "[{limits} {hold} it]",
         STEP, mark="ok", unless=("O106", "O107", "O108")),
    Rule("O120", "warns", "the search was stopped after {count} trials", cut, step="start the command again to continue"),
    Rule("O121", "warns", "by {by} the best design [misses {bound} by {off}][cannot be computed: {why}]", other_model),
    Rule("O122", "warns", "the best design is doubtful: {doubt}", doubtful),
    Rule("O123", "warns", "widen {wide}: the best is at its end", at_end, remark="end of its range"),
    Rule("O126", "warns", "{name} of the best is not resolved at {speed}", unresolved, guide="uncertainty.md"),
    Rule("O127", "warns", "only {model} computed it: confirm it by {finest}", alone, mark="", guide="optimisation.md"),
    Rule("O128", "warns", "designs as good within {share} have {ranges}", alike, remark="[{only} as good]", mark="", guide="optimisation.md"),
)  # fmt: skip
