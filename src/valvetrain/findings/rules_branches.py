"""Rules on branches of motion (W2): where a train is chaotic, and where its motion depends on where it comes from."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, joined, speed_text
from valvetrain.solution.branches import DIFFERS, UNRESOLVED, Branches
from valvetrain.solution.critical import SpeedBracket
from valvetrain.solution.definition import definition_of, label_of

#: Ranges that a finding names, and length (m) by which revolutions may differ before it matters to a valve.
NAMED, SMALL = 4, 50e-6


@dataclass(frozen=True)
class BranchFacts(Subject):
    """Branches of the motion of a train as rules read them."""

    branches: Branches

    @property
    def reach(self) -> str:
        """The speeds that were marched, in rpm as a command takes them."""
        speeds = [one.engine_speed for one in self.branches.points]
        return f"{speed_text(min(speeds), '')}-{speed_text(max(speeds))}" if speeds else ""

    @property
    def spread(self) -> Amount:
        """By how much the quantity differs at most between revolutions, or rising and falling speed, at one speed."""
        values = dict[float, list[float]]()
        for one in self.branches.points:
            values.setdefault(one.engine_speed, []).extend(() if one.repels else one.values)
        sizes = (np.ptp([v for v in one if math.isfinite(v)] or [0.0]) for one in values.values())
        return Amount(self.branches.quantity, float(max(sizes)))

    @property
    def small(self) -> float:
        """A difference (SI) of the quantity that does not matter."""
        values = (abs(v) for one in self.branches.points for v in one.values if math.isfinite(v))
        length = definition_of(self.branches.quantity).dimension == "length"
        return max(DIFFERS * max(values, default=0.0), SMALL * length)

    @property
    def alike(self) -> bool:
        """Whether revolutions differ by less than matters to a valve."""
        return self.spread.value <= self.small

    @property
    def shown(self) -> Branches:
        """The branches as rows and picture show them: of alike revolutions the motions that attract, as if they repeated."""
        if not self.alike:
            return self.branches
        points = (replace(one, period=1) for one in self.branches.points if not one.repels)
        return replace(self.branches, points=tuple(points))


def spans_text(spans: Sequence[SpeedBracket]) -> str:
    """Ranges of speed in rpm: ``8630 and 8700 to 9080``."""
    texts = []
    for one in spans[:NAMED]:
        low, high = (
            speed_text(end, "") for end in (one.lower_engine_speed, one.upper_engine_speed)
        )
        texts.append(low if low == high else f"{low} to {high}")
    return joined([*texts, *(["others"] if len(spans) > NAMED else [])])


def moves(*motions: str) -> Callable[[BranchFacts], Hits]:
    """A condition on motions of these kinds: the speeds at which each is seen."""

    def hits(facts: BranchFacts) -> Hits:
        for motion in motions:
            spans = facts.branches.ranges(motion)
            if spans:
                fields = {
                    "spans": spans_text(spans), "motion": motion.removeprefix("period "), "name": label_of(facts.branches.quantity),
                    "first": speed_text(spans[0].lower_engine_speed, ""),
                }  # fmt: skip
                yield Hit(facts.spread, None, None, fields, float(len(spans)))

    return hits


def two_motions(facts: BranchFacts) -> Hits:
    """Rising and falling speed show different motions."""
    if spans := facts.branches.hysteresis:
        name = {"name": label_of(facts.branches.quantity), "reach": facts.reach}
        yield Hit(facts.spread, fields={"spans": spans_text(spans), **name})


def alike(facts: BranchFacts) -> Hits:
    """Revolutions are the same, or differ by less than matters to a valve, whether the speed rises or falls."""
    if facts.alike:
        fields = {"name": label_of(facts.branches.quantity), "reach": facts.reach}
        yield Hit(facts.spread, None, facts.small, fields)


def cut(facts: BranchFacts) -> Hits:
    """The march took all the revolutions that it may."""
    if not facts.branches.complete:
        yield Hit(fields={"count": str(facts.branches.revolutions)})


def grazes(facts: BranchFacts) -> Hits:
    """A contact begins or ends between two speeds."""
    if spans := facts.branches.grazing:
        yield Hit(fields={"spans": spans_text(spans)})


SWEEP, RUN = "[valvetrain sweep {case} --rpm '{reach}']", "[valvetrain run {case} --rpm {first}]"
BY = "{name} differs by up to {value}"
RULES = (
    Rule("W204", "decides", "rising and falling speed give the same motion in every revolution: {name} differs by at most {value}", alike, (),
         "below {limit} it does not matter", SWEEP, mark="ok"),
    Rule("W201", "decides", "the motion is chaotic at {spans} rpm", moves("chaotic"), (), f"{BY} from revolution to revolution", RUN,
         unless=("W204",)),
    Rule("W202", "decides", "at {spans} rpm a rising and a falling speed show different motions", two_motions, (), BY, SWEEP,
         mark="warn", unless=("W204",)),
    Rule("W211", "decides", "the motion repeats only every {motion} revolutions at {spans} rpm",
         moves(*(f"period {count}" for count in range(2, 9))), (), BY, RUN, mark="warn", unless=("W204",)),
    Rule("W212", "decides", "the motion does not repeat at {spans} rpm, but disturbances do not grow", moves("irregular"), (), BY, RUN,
         mark="warn", unless=("W204",)),
    Rule("W213", "warns", "whether the motion at {spans} rpm is stable is not resolved", moves(UNRESOLVED), (),
         "its multiplier depends on the size of the disturbance", RUN, unless=("W204",)),
    Rule("W215", "notes", "a contact of the motion just begins or ends (grazing) at {spans} rpm", grazes, unless=("W204",)),
    Rule("W214", "warns", "the march ended after {count} revolutions, before all speeds", cut,
         step="allow more revolutions, or march fewer speeds"),
)  # fmt: skip
