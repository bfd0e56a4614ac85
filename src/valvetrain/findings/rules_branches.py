"""Rules on branches of motion (W2): where a train is chaotic, and where its motion depends on where it comes from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import joined, speed_text
from valvetrain.solution.branches import Branches
from valvetrain.solution.critical import SpeedBracket

#: Ranges that a finding names.
NAMED = 4


@dataclass(frozen=True)
class BranchFacts(Subject):
    """Branches of the motion of a train as rules read them."""

    branches: Branches


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
                fields = {"spans": spans_text(spans), "motion": motion.removeprefix("period ")}
                yield Hit(fields=fields, severity=float(len(spans)))

    return hits


def two_motions(facts: BranchFacts) -> Hits:
    """Rising and falling speed show different motions."""
    if spans := facts.branches.hysteresis:
        yield Hit(fields={"spans": spans_text(spans)})


def simple(facts: BranchFacts) -> Hits:
    """The motion repeats with every revolution at all speeds."""
    if all(one.motion == "period 1" for one in facts.branches.points):
        yield Hit()


def cut(facts: BranchFacts) -> Hits:
    """The march took all the revolutions that it may."""
    if not facts.branches.complete:
        yield Hit(fields={"count": str(facts.branches.revolutions)})


RULES = (
    Rule("W201", "decides", "the motion is chaotic at {spans} rpm", moves("chaotic"),
         reason="a small disturbance grows from revolution to revolution"),
    Rule("W202", "decides", "at {spans} rpm a rising and a falling speed show different motions", two_motions, mark="warn"),
    Rule("W203", "decides", "the motion repeats with every revolution, and attracts, at all speeds", simple, mark="ok",
         unless=("W202",)),
    Rule("W211", "decides", "the motion repeats only every {motion} revolutions at {spans} rpm",
         moves(*(f"period {count}" for count in range(2, 9))), mark="warn"),
    Rule("W212", "decides", "the motion does not repeat at {spans} rpm, but disturbances do not grow", moves("irregular"), mark="warn"),
    Rule("W213", "notes", "an orbit that repeats with every revolution is unstable at {spans} rpm: it {motion}",
         moves("repels by fold", "repels by flip", "repels by torus")),
    Rule("W214", "warns", "the march ended after {count} revolutions, before all speeds", cut,
         step="allow more revolutions, or march fewer speeds"),
)  # fmt: skip
