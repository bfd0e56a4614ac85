"""Rules on a refinement (X): which numbers other meshes and contact constants move."""

from __future__ import annotations

import math
from dataclasses import dataclass

from valvetrain.findings.engine import Fields, Hit, Hits, Rule, Subject
from valvetrain.findings.words import UNRESOLVED, Amount, Phrase, joined, percent, speed_text
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.definition import label_of
from valvetrain.solution.uncertainty import Uncertainty

#: Error bar, and half the range over contact constants, up to which a number is resolved; from there to half of it, it is rough.
RESOLVED = 0.1
#: Quantities by which verdicts on a motion are made, the gravest first.
DECIDE = (
    "float_excess_lift",
    "loft_gap",
    "bounce_height",
    "minimum_cam_contact_force",
    "peak_retainer_force",
)


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
        return f" --rpm '{', '.join(texts)}'" if texts else ""

    def place(self, row: Uncertainty, template: str = "at {}") -> str:
        """``at 6000 rpm, stock``: the speed, and the variant where there are several; empty of statics and modes."""
        labels = len({one.label for one in self.study.rows if one.label}) > 1
        where = "" if row.engine_speed is None else template.format(speed_text(row.engine_speed))
        return ", ".join(filter(None, (where, row.label * labels)))

    @property
    def rows(self) -> list[Uncertainty]:
        """Rows with an error bar of a number that is not zero."""
        return [row for row in self.study.rows if row.value and math.isfinite(row.numerical)]


def share_of(row: Uncertainty) -> float:
    """The error bar as a share of the value."""
    return abs(row.numerical / row.value)


def reach_of(row: Uncertainty) -> float:
    """Half the range over contact constants as a share of the value."""
    return (
        (row.contact_range.high - row.contact_range.low) / 2 / abs(row.value)
        if row.contact_range
        else 0.0
    )


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
    rows = sorted((row for row in facts.rows if low <= share_of(row) < high), key=share_of)[::-1]
    if rows:
        fine = sum(share_of(row) < RESOLVED for row in facts.rows)
        names = list(dict.fromkeys(label_of(row.quantity) for row in rows))
        yield Hit(Amount("clash_count", len(names)), fields={
            "count": f"{fine} of {len(facts.rows)} numbers", "names": joined(names[:2], "nor"),
            "speeds": facts.speeds, **_moved(facts),
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
        yield Hit(Amount(row.quantity, row.value, row.numerical), fields={
            "name": label_of(row.quantity), "share": percent(share_of(row)), "place": facts.place(row),
            "speeds": facts.speeds, **moved,
        })  # fmt: skip


def resolved(facts: RefineFacts) -> Hits:
    """The largest error bar of a refinement in which neither meshes nor contact constants move a number by a tenth."""
    return _resolved(facts, moves=False)


def on_constants(facts: RefineFacts) -> Hits:
    """Contact constants move a number by more than a tenth, which meshes do not."""
    return _resolved(facts, moves=True)


def _moved(facts: RefineFacts) -> Fields:
    """A number that contact constants move by more than a tenth either way, as a field: the one by which a verdict
    of this motion is made, else the one that they move most.
    """
    rows = [row for row in facts.rows if reach_of(row) > RESOLVED]
    if not rows:
        return {}
    ranks = {name: len(DECIDE) - place for place, name in enumerate(DECIDE)}
    row = max(rows, key=lambda one: (ranks.get(one.quantity, 0), reach_of(one)))
    assert row.contact_range is not None
    ends = {end: Amount(row.quantity, getattr(row.contact_range, end)) for end in ("low", "high")}
    moved: Fields = {"name": label_of(row.quantity), "place": facts.place(row), **ends}
    return {"moved": Phrase("{name} {low..high}[ {place}]", moved)}


CONSTANTS, COMPARE = "[other contact constants make {moved}]", "valvetrain compare {case}[{speeds}]"
RULES = (
    Rule("X101", "decides", "no error bar was found", without, mark="bad"),
    Rule("X102", "decides", "{count} hold within 10 %, but not {names}: bars above 50 %", unresolved, (),
         CONSTANTS, COMPARE, mark="warn", guide="uncertainty.md"),
    Rule("X104", "decides", "{count} hold within 10 %, but not {names}", rough, (), CONSTANTS, COMPARE, mark="warn",
         guide="uncertainty.md", unless=("X102",)),
    Rule("X105", "decides", "finer numerics move no number by more than {share}", on_constants, (), "but {moved} rests on contact constants",
         "valvetrain run {case}[{speeds}]", mark="warn", guide="uncertainty.md", unless=("X10",)),
    Rule("X103", "decides", "every number is resolved: at most ± {share}, of {name}[ {place}]", resolved,
         step="valvetrain run {case}[{speeds}]", mark="ok", unless=("X10",)),
    Rule("X110", "warns", "not all runs ended: {said}[; {more}]", failed),
)  # fmt: skip
