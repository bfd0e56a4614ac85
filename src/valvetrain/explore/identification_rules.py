"""Rules on an identification (I): what the data determine, what they leave open, and how well they are met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from valvetrain.explore.identified import Branch, Identified, Predicted
from valvetrain.explore.least_squares import MET, ON_BOUND
from valvetrain.explore.posterior import Datum
from valvetrain.explore.results import value_text
from valvetrain.explore.space import Varied
from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import digits_text, joined

#: What the data say of an unknown: its value, only a combination with others, little, or that it lies beyond its bound.
State = Literal["determined", "tied", "open", "bound"]
#: Share of the prior's variance that the data must remove of an unknown that they determine.
LEARNED = 0.5
#: Ratio of the ends of a 95 % interval above which an unknown with a logarithmic prior is not determined.
WIDE = 2.0
#: Percentiles (0 to 100) between which a measured value lies that agrees with its prediction.
ODD = (2.5, 97.5)


def plain_name(name: str) -> str:
    """A name of a file as it is read: ``wire diameter`` for ``wire_diameter``."""
    return name.replace("_", " ")


def data_name(datum: Datum) -> str:
    """A measurement, with the value of it where it has several."""
    return ": ".join(dict.fromkeys(map(plain_name, (datum.name, datum.key))))


def few(names: Sequence[str]) -> str:
    """Names in a sentence, of more than three the first two.

    >>> few(["a", "b", "c", "d"])
    'a, b and 2 more'
    """
    return joined(names if len(names) <= 3 else [*names[:2], f"{len(names) - 2} more"])


@dataclass(frozen=True)
class IdentificationFacts(Subject):
    """An identification as rules, rows and figures read it; ``name``: path of the case file with its values."""

    result: Identified
    name: str = ""

    @cached_property
    def first(self) -> Branch:
        """The likeliest branch."""
        return self.result.branches[0]

    @cached_property
    def states(self) -> dict[str, State]:
        """What the data say of each unknown; of a search that was stopped nothing is judged."""
        return {
            one.title: self._state(place, one) for place, one in enumerate(self.result.unknowns)
        }

    def _state(self, place: int, one: Varied) -> State:
        if not self.result.whole:
            return "determined"
        best = float(one.prior.work(self.first.quantities[one.title].best))
        if min(np.abs(best - np.array(one.prior.work_bounds))) <= ON_BOUND * one.prior.work_spread:
            return "bound"
        if self.partners(place):
            return "tied"
        interval = self.first.quantities[one.title]
        wide = one.prior.logarithmic and interval.high > WIDE * interval.low
        vague = self.first.information.determined[place] < LEARNED or wide
        return "open" if vague else "determined"

    def partners(self, place: int) -> list[str]:
        """Names of the unknowns with which the one at ``place`` can only be told together."""
        group = next((one for one in self.first.information.groups if place in one), ())
        return [plain_name(self.result.names[one]) for one in group if one != place]

    def those(self, *states: State) -> list[str]:
        """Names of the unknowns of which the data say such."""
        return [plain_name(name) for name, state in self.states.items() if state in states]

    def value(self, one: Varied, branch: int = 0) -> str:
        """The likeliest value of an unknown in the digits of its interval."""
        found = self.result.branches[branch].quantities[one.title]
        return value_text(one.unit, found.best, bar=(found.high - found.low) / 4)

    def interval(self, one: Varied) -> str:
        """Its 95 % interval; of an unknown that the data do not determine in two digits."""
        found = self.first.quantities[one.title]
        vague = self.states[one.title] in ("tied", "open")
        bar, digits = (0.0, 2) if vague else ((found.high - found.low) / 4, 4)
        return value_text(one.unit, found.low, found.high, bar=bar, digits=digits)

    def data(self, used: bool) -> list[Predicted]:
        """Values that were fitted, or that were compared alone, the one that is missed most first."""
        chosen = (one for one in self.result.predicted if one.datum.used == used)
        return sorted((one for one in chosen if np.isfinite(one.off)), key=lambda one: -abs(one.off))  # fmt: skip

    @property
    def command(self) -> str:
        """What computes the case with the values; ``static`` for a spring without a lift law."""
        text = self.result.case_file
        return "" if not text else "run" if "[lift_law" in text or "[train" in text else "static"


def off_text(one: Predicted) -> str:
    """How many scatters a computed value is off."""
    return digits_text(abs(one.off), 0.1)


def _about(one: Predicted, **more: str) -> Hit:
    return Hit(fields={"name": data_name(one.datum), "off": off_text(one)} | more)


def stopped(facts: IdentificationFacts) -> Hits:
    """The search was stopped before its end."""
    if not facts.result.whole:
        yield Hit(fields={"count": str(facts.result.evaluations + facts.result.reused)})


def refused(facts: IdentificationFacts) -> Hits:
    """The misfit is larger than in 99 of 100 cases with a correct model."""
    if facts.result.fit is not None and facts.result.fit.missed:
        yield _about(facts.data(True)[0])


def undetermined(facts: IdentificationFacts) -> Hits:
    """Data that leave half of a prior's variance or a factor of two, or show a combination of unknowns alone."""
    if vague := facts.those("tied", "open"):
        names = "any unknown" if len(vague) == len(facts.states) else few(vague)
        why = "only combinations show" if facts.those("tied") else "the range is too wide"
        yield Hit(fields={"names": names, "why": why, "first": vague[0]})


def on_bound(facts: IdentificationFacts) -> Hits:
    """The likeliest value of an unknown lies on a bound of its prior."""
    if there := facts.those("bound"):
        yield Hit(fields={"names": few(there)})


def branches(facts: IdentificationFacts) -> Hits:
    """The posterior has separate parts, between which it falls by a factor of seven or more."""
    every = facts.result.branches
    if len(every) > 1:
        one = max(
            facts.result.unknowns,
            key=lambda one: np.ptp([one.prior.work(each.quantities[one.title].best) for each in every]) / one.prior.work_spread,
        )  # fmt: skip
        values = joined([facts.value(one, branch) for branch in range(len(every))], "or")
        yield Hit(
            fields={"count": str(len(every)), "name": plain_name(one.title), "values": values}
        )


def determined(facts: IdentificationFacts) -> Hits:
    """Every unknown is determined: the data remove half of the variance of its prior or more."""
    unknowns, used = facts.result.unknowns, facts.data(True)
    several, more = len(unknowns) > 1, len(used) > len(unknowns)
    values = [
        f"{plain_name(one.title) if several else ''} {facts.value(one)}" for one in unknowns[:3]
    ]
    yield Hit(fields={
        "subject": f"all {len(unknowns)} unknowns" if several else plain_name(unknowns[0].title), "values": joined(values).strip(),
        "met": f"{sum(abs(one.off) <= MET for one in used)} of {len(used)}" if more else "",
        "interval": "" if several else facts.interval(unknowns[0]), "command": facts.command, "file": facts.name or "identified.toml",
    })  # fmt: skip


def missed(facts: IdentificationFacts) -> Hits:
    """A fitted value is more than two of its scatters off."""
    for one in facts.data(True)[:1]:
        if abs(one.off) > MET:
            yield _about(one)


def unlike(facts: IdentificationFacts) -> Hits:
    """Values that were not fitted lie outside 2.5 to 97.5 % of what would be measured."""
    rest = facts.data(False)
    if odd := [one for one in rest if not ODD[0] <= one.percentile <= ODD[1]]:
        yield _about(odd[0], count=f"{len(odd)} of {len(rest)}")


def as_many(facts: IdentificationFacts) -> Hits:
    """There are no more fitted values than unknowns, so that almost any model meets them, and no others."""
    used, count = len(facts.data(True)), len(facts.states)
    if used <= count and not facts.data(False):
        yield Hit(fields={"used": str(used), "count": str(count)})


def notes(facts: IdentificationFacts) -> Hits:
    """The draws of a linearised posterior disagree with it."""
    if facts.result.note:
        yield Hit(fields={"said": facts.result.note})


GUIDE = "identification.md"
RULES = (
    Rule("I101", "decides", "the search was stopped before its end: {count} points are computed", stopped, (),
         "these values are the best of them", "start the same command again, it continues", mark="warn", guide=GUIDE),
    Rule("I102", "decides", "the model does not meet the data: {name} is {off} scatters off", refused, (),
         "fewer than 1 in 100 correct models are this far off",
         "check the scatter of {name}; where it is right, the model lacks something", guide=GUIDE, unless=("I101",)),
    Rule("I103", "decides", "the data do not determine {names}", undetermined, (), "{why}",
         "measure {first} by itself, or give it a narrower prior", mark="warn", guide=GUIDE),
    Rule("I104", "decides", "on a bound of the prior: {names}", on_bound, (), "the data ask for more than it allows",
         "widen the prior, or look for what else moves the data", mark="warn", guide=GUIDE),
    Rule("I105", "decides", "{count} solutions meet the data alike: {name} {values}", branches, (), "",
         "add a measurement that tells them apart", mark="warn", guide=GUIDE),
    Rule("I112", "decides", "fitted, not checked", as_many, (),
         "measured {used}, unknown {count}, so almost any model meets the data",
         "add a measurement with fit = false, which the values must predict", mark="warn", guide=GUIDE),
    Rule("I106", "decides", "the data determine {subject}: {values}[ (95 %: {interval})]", determined, (),
         "[{met} measured values are met]", "[valvetrain {command} {file}]", mark="ok", guide=GUIDE, unless=("I10", "I112")),
    Rule("I110", "warns", "{name} is {off} scatters off", missed, guide=GUIDE, unless=("I102",)),
    Rule("I111", "warns", "{count} values not used lie outside their predictions: {name} is {off} scatters off", unlike, guide=GUIDE),
    Rule("I113", "warns", "{said}", notes, guide=GUIDE),
)  # fmt: skip
