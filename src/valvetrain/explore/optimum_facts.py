"""A search as its rules, rows and figures read it: numbers with error bars, what bounds hold, how far to trust them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from valvetrain.explore.limit_speed import BELOW, BEYOND, FOUND
from valvetrain.explore.measure import Measure
from valvetrain.explore.optimum import Design, Optimum
from valvetrain.explore.results import value_text
from valvetrain.explore.search import Trial
from valvetrain.findings.engine import Subject
from valvetrain.findings.words import Amount, Phrase, Said, digits_text
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import card_quantities

#: Values of the card of a design in addition to the varied ones: quantity -> name.
CARD = {"card_preload": "seat load", "card_rate": "rate", "card_open_force": "open load"}
#: Share of the case's own value below which a gain is slight.
SLIGHT = 0.02
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

    @property
    def slight(self) -> float:
        """By what share the best design is better than a case that meets every bound, where that is less than 2 %; else 0."""
        best, case = self.best, self.result.case
        before = abs(float(case.objectives[0]))
        share = (
            self.gain(best.trial, case) / before
            if best is not None and case.feasible and before
            else 1.0
        )
        return share if share < SLIGHT else 0.0

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
            each
            for each in self.result.trials
            if each.feasible and abs(each.costs[0] - cost) <= ALIKE * abs(cost)
        ]
        low, high = (
            float(end([each.values[place] for each in good])) for end in (np.nanmin, np.nanmax)
        )
        return (
            value_text(one.unit, low, high)
            if high - low >= OPEN * abs(np.subtract(*one.ends)) > 0
            else ""
        )

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
