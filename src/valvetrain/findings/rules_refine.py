"""Rules on a refinement (X): which numbers other meshes and contact constants move."""

from __future__ import annotations

import math
from dataclasses import dataclass

from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import UNRESOLVED, Amount, digits_text, speed_text
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.definition import label_of
from valvetrain.solution.uncertainty import Uncertainty

#: Error bars up to this share of a value count as small; a range over contact constants above this one is named.
SMALL, MOVED = 0.01, 0.05
#: Error bar, and half the range over contact constants, up to which a number is resolved; from there to half of it, it is rough.
RESOLVED = 0.1


@dataclass(frozen=True)
class RefineFacts(Subject):
    """A refinement as rules read it."""

    study: UncertaintyStudy
    name: str = ""

    @property
    def case(self) -> str:
        """What a command takes for its case."""
        return self.name or self.study.record.name

    @property
    def speeds(self) -> str:
        """Its engine speeds as an option of a command; empty of statics and modes."""
        found = dict.fromkeys(row.engine_speed for row in self.study.rows if row.engine_speed)
        texts = [speed_text(one, "") for one in found]
        return (
            f" --rpm '{', '.join(texts)}'"
            if texts[1:]
            else "".join(f" --rpm {one}" for one in texts)
        )

    @property
    def rows(self) -> list[Uncertainty]:
        """Rows with an error bar of a number that is not zero."""
        return [row for row in self.study.rows if row.value and math.isfinite(row.numerical)]


def share_of(row: Uncertainty) -> float:
    """The error bar as a share of the value."""
    return abs(row.numerical / row.value)


def place_of(row: Uncertainty) -> str:
    """``at 6000 rpm, stock``; empty of statics and modes."""
    speed = "" if row.engine_speed is None else f"at {speed_text(row.engine_speed)}"
    return ", ".join(filter(None, (speed, row.label)))


def failed(facts: RefineFacts) -> Hits:
    """Runs of the refinement that failed or were not finished."""
    for one in facts.study.failures[:1]:
        more = len(facts.study.failures) - 1
        yield Hit(fields={"said": one, "more": f"{more} more" if more else ""})


def without(facts: RefineFacts) -> Hits:
    """No number has an error bar."""
    if not facts.rows:
        yield Hit()


def _rough(facts: RefineFacts, low: float, high: float) -> Hits:
    """Numbers whose error bar is a share of them between two bounds."""
    rows = [row for row in facts.rows if low <= share_of(row) < high]
    if rows:
        names = list(dict.fromkeys(label_of(row.quantity) for row in rows))
        yield Hit(Amount("clash_count", len(names)), fields={
            "count": f"{len(rows)} of {len(facts.rows)} numbers", "first": names[0],
            "more": f"{len(names) - 1} more kinds" if len(names) > 1 else "", "speeds": facts.speeds, **_moved(facts),
        })  # fmt: skip


def unresolved(facts: RefineFacts) -> Hits:
    """Numbers whose error bar is half of them or more."""
    return _rough(facts, UNRESOLVED, math.inf)


def rough(facts: RefineFacts) -> Hits:
    """Numbers whose error bar is between a tenth and half of them."""
    return _rough(facts, RESOLVED, UNRESOLVED)


def _resolved(facts: RefineFacts, moves: bool) -> Hits:
    moved = _moved(facts)
    if facts.rows and bool(moved) is moves:
        row = max(facts.rows, key=share_of)
        small = sum(share_of(one) <= SMALL for one in facts.rows)
        yield Hit(Amount(row.quantity, row.value, row.numerical), fields={
            "name": label_of(row.quantity), "share": f"{digits_text(100 * share_of(row), 0, 2)} %", "place": place_of(row),
            "small": f"{small} of {len(facts.rows)} within 1 %", "speeds": facts.speeds, **moved,
        })  # fmt: skip


def resolved(facts: RefineFacts) -> Hits:
    """The largest error bar of a refinement in which neither meshes nor contact constants move a number by a tenth."""
    return _resolved(facts, moves=False)


def on_constants(facts: RefineFacts) -> Hits:
    """Contact constants move a number by more than a tenth, which meshes do not."""
    return _resolved(facts, moves=True)


def _moved(facts: RefineFacts) -> dict[str, str]:
    """The number that contact constants move most, as fields, where that is by more than a tenth either way."""
    widths = [
        (one.range.high - one.range.low) / abs(one.value) if one.range else 0.0
        for one in facts.rows
    ]
    most = max(widths, default=0.0)
    if most <= 2 * RESOLVED:
        return {}
    row = facts.rows[widths.index(most)]
    return {"moved": f"{label_of(row.quantity)} by {digits_text(100 * most, 0, 2)} %"}


def constants(facts: RefineFacts) -> Hits:
    """A number that moves by more than a twentieth over the contact constants."""
    for row in facts.rows:
        reach = row.range
        if reach is not None and (width := (reach.high - reach.low) / abs(row.value)) > MOVED:
            yield Hit(Amount(row.quantity, reach.high), None, None, {
                "name": label_of(row.quantity), "low": Amount(row.quantity, reach.low), "place": place_of(row),
                "by": " and ".join(reach.by),
            }, width)  # fmt: skip


RULES = (
    Rule("X101", "decides", "no error bar was found", without, mark="bad"),
    Rule("X102", "decides", "{count} are not resolved: {first}[, {more}]", unresolved, (),
         "other meshes move them by half or more[; contact constants move {moved}]", "valvetrain compare {case}[{speeds}]", mark="warn",
         guide="uncertainty.md"),
    Rule("X104", "decides", "{count} are rough, ± 10 to 50 %: {first}[, {more}]", rough, (),
         "[contact constants move {moved}]", "valvetrain compare {case}[{speeds}]", mark="warn", guide="uncertainty.md", unless=("X102",)),
    Rule("X105", "decides", "meshes move no number by more than {share}", on_constants, (),
         "but contact constants move {moved}", "valvetrain run {case}[{speeds}]", mark="warn", guide="uncertainty.md", unless=("X10",)),
    Rule("X103", "decides", "every number is resolved: at most ± {share}, of {name}[ {place}]", resolved, (), "{small}",
         "valvetrain run {case}[{speeds}]", mark="ok", unless=("X10",)),
    Rule("X110", "warns", "not all runs ended: {said}[; {more}]", failed),
    Rule("X120", "notes", "{name}[ {place}] rests on contact {by}: {low..value}", constants, guide="uncertainty.md"),
)  # fmt: skip
