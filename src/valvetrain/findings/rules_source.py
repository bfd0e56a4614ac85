"""Rules on what a result rests on (A): assumptions of its case, what its models leave out; and on published values (H):
what was fitted, how far the rest is off, and what a source prints otherwise.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable

from valvetrain.findings.engine import Condition, Fields, Hit, Hits, Rule
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_train import FLEX, SEAT
from valvetrain.findings.words import Amount, joined, speed_text
from valvetrain.solution.definition import definition_of, label_of
from valvetrain.solution.status import Fact
from valvetrain.solution.uncertainty import Comparison

#: Fields of a fact that its rule names, as text or amounts.
Reader = Callable[[Fact], Fields]


def rests_on(code: str, *texts: str, read: Reader = lambda _: {}) -> Condition:
    """A fact of the study, or of a run that decides, of this ``code``. The fields of the rule are the ``texts`` of the fact by
    name, and what ``read`` gives.
    """

    def hits(facts: Facts) -> Hits:
        for one in (*facts.study.facts, *(one for run in facts.runs for one in run.facts)):
            if one.code == code:
                yield Hit(fields={name: str(one.fields[name]) for name in texts} | dict(read(one)))

    hits.__doc__ = f"The result rests on: {code.replace('-', ' ')}."
    return hits


def _ramp(fact: Fact) -> Fields:
    return {"ramp": Amount("cam_closing_ramp_velocity", float(fact.fields["velocity"]))}


def _places(fact: Fact) -> Fields:
    places = str(fact.fields["places"]).replace("_", " ")
    return {"places": joined([one.strip() for one in places.split(",")])}


def _heights(fact: Fact) -> Fields:
    return {one: Amount("solid_height", float(fact.fields[one])) for one in ("stated", "computed")}


def _buckles(fact: Fact) -> Fields:
    return {"at": Amount("compression", float(fact.fields["compression"]))}


def _ratio(fact: Fact) -> Fields:
    return {"ratio": f"{float(fact.fields['ratio']):.3g}"}


def _driver(fact: Fact) -> Fields:
    return {"force": Amount("driver_difference_force", float(fact.fields["force_difference"]))}


def angles(facts: Facts) -> Hits:
    """The runs have angles: which ones, where the nose is, and what zero is where the case says so."""
    for run in [one for one in facts.runs if one.has("valve_lift")][-1:]:
        yield Hit(facts.nose(run), fields={"zero": facts.study.record.zero_of_angle})


def assumed(facts: Facts) -> Hits:
    """The file of a case of one's own calls values assumed: loads, masses and damping, which decide, are named first."""
    record = facts.study.record
    names = sorted(dict.fromkeys(record.assumed), key=lambda name: not name.endswith(FIRST))
    if names and not record.study:
        more = str(len(names) - MOST) if len(names) > MOST else ""
        yield Hit(fields={"values": ", ".join(names[:MOST]), "more": more})


def recut(facts: Facts) -> Hits:
    """The lash by which a cam is cut was changed, and with it the cam."""
    if LASH in facts.study.record.changed:
        yield Hit()


#: Most assumed values that are named, and how those end that are named first.
MOST, FIRST = 6, ("load", "rate", "mass", "damping", "duration")
#: Key path of the lash for which a card makes the ramp of its lobe.
LASH = "lift_law.lash"
RECUT = "another lift_law.lash is another cam, whose ramp is cut for it: train.lash alone moves the clearance"
ASSUMED = (
    Rule("A114", "warns", RECUT, recut, step="set train.lash", remark="a cam cut for another lash", guide="how-to/10-seating.md"),
    Rule("A104", "warns", "no damping in the spring {spring}, so surge lives on from cycle to cycle",
         rests_on("no-damping", "spring"), step="give the spring a damping", guide="how-to/15-damping.md"),
    Rule("A107", "warns", "the spring {spring} buckles at {at}, before full lift", rests_on("buckles", "spring", read=_buckles),
         guide="how-to/05-coil-bind.md"),
    Rule("A116", "warns", "solid at {stated:4} is stated for {spring}, and its wire binds at {computed:4}",
         rests_on("other-solid-height", "spring", read=_heights), ("coil_bind_clearance",), "the stated height counts",
         guide="how-to/05-coil-bind.md"),
    Rule("A101", "notes", "the ramp of the cam is assumed ({ramp} of the cam)", rests_on("assumed-ramp", read=_ramp),
         SEAT, step="measure your ramp: ramp_velocity, ramp_lift", remark="assumed ramp"),
    Rule("A117", "notes", "the file assumes: {values}[ and {more} more]", assumed,
         step="measure what decides: valvetrain study --parts {case}", remark="assumed {values}[ and {more} more]"),
    Rule("A102", "notes", "contacts at {places} have usual steel values", rests_on("default-contacts", read=_places),
         remark="default contacts"),
    Rule("A103", "notes", "springs known by card alone: no clash, no stress", rests_on("card-alone"),
         step="give them a wire: valvetrain spring-card", remark="springs by card (no clash, no stress)"),
    Rule("A115", "notes", "angles are those of the cam, half of the crank's; full lift at {value}[; zero: {zero}]", angles,
         remark="cam angles (full lift at {value}[; 0: {zero}])", guide="how-to/13-degrees-and-heights.md"),
    Rule("A119", "notes", "the rocker (ratio {ratio}) is rigid, so it takes no lift and no timing; a real one bends",
         rests_on("rigid-lever", read=_ratio),
         FLEX, step="give it a stiffness: train.lever.stiffness", remark="rigid rocker (ratio {ratio})", guide="how-to/08-flex.md"),
    Rule("A113", "notes", "no contact of the train has friction, so the power of the cam is too small", rests_on("no-friction", "place"),
         ("mean_cam_power",), "give it friction: --set train.contacts.{place}.friction_coefficient=0.06", remark="contacts without friction"),
    Rule("A105", "notes", "the total loads were split between the two springs by their wires", rests_on("split-loads"),
         remark="loads of the pair split by wire"),
    Rule("A106", "notes", "coil bind of the {spring} spring is unknown", rests_on("unknown-solid-height", "spring"),
         ("coil_bind_clearance",), remark="{spring} not checked"),
    Rule("A108", "notes", "a chain of masses stands for the rod: surge and clash are estimates",
         rests_on("chain-of-wire"), remark="a chain for the wire (estimates)"),
    Rule("A118", "notes", "{model} runs in place of the reduced rod, since {reason}", rests_on("not-the-default", "model", "reason"),
         remark="{model} since {reason}", guide="models.md"),
    Rule("A109", "notes", "the wire of the spring is assumed from its card", rests_on("assumed-wire"),
         step="fit the wire: valvetrain spring-card", remark="a wire assumed from the card"),
    Rule("A110", "notes", "the solid follows the train that runs with {driver}, which does not feel {force} of it",
         rests_on("follows-a-train", "driver", read=_driver), remark="a train that runs with {driver}"),
    Rule("A111", "notes", "the ends of the solid are bonded to their seats: where it pulls, a real spring would lift",
         rests_on("ends-bonded"), step="valvetrain run {case} --model finite-element", remark="bonded ends"),
)  # fmt: skip


FITTED = "calibration"
FORCES, MOTIONS = ("force",), ("length", "velocity", "acceleration")
#: Median difference (per cent) below which no number is printed.
LEAST = 0.1
#: Verdict on a finding of a source that the runs do not show.
NOT_SEEN = "not seen"


def off(
    rows: Iterable[Comparison],
    dimensions: tuple[str, ...],
    computed: Callable[[Comparison], float | None] = lambda row: row.computed,
) -> str:
    """``6.4 % off (8)``: the median difference from the printed values of some dimensions, and how many; empty of none."""
    shares = [
        abs(value / row.published - 1)
        for row in rows
        if row.published and (value := computed(row)) is not None
        and definition_of(row.quantity).dimension in dimensions
    ]  # fmt: skip
    if not shares:
        return ""
    middle = 100 * statistics.median(shares)
    return f"{f'{middle:.2g}' if middle >= LEAST else f'less than {LEAST}'} % off ({len(shares)})"


def compared(facts: Facts) -> list[Comparison]:
    """The printed values that have a computed one and are not in doubt."""
    return [row for row in facts.study.comparisons if row.difference is not None and not row.doubt]


def published(facts: Facts) -> Hits:
    """Printed values: how many a case was fitted to, and how far the others are off."""
    rows = compared(facts)
    free = [row for row in rows if row.role != FITTED]
    doubt = sum(bool(row.doubt) for row in facts.study.comparisons)
    if rows:
        yield Hit(Amount("clash_count", len(rows)), fields={
            "fitted": str(len(rows) - len(free)), "count": str(len(facts.study.comparisons)),
            "forces": off(free, FORCES), "motions": off(free, MOTIONS), "doubt": str(doubt or ""),
        })  # fmt: skip


def blind(facts: Facts) -> Hits:
    """How far the case that was not fitted is off the same printed values."""
    rows = [row for row in compared(facts) if row.blind is not None]
    if forces := off(rows, FORCES, lambda row: row.blind):
        yield Hit(Amount("clash_count", len(rows)), fields={"forces": forces})


def contradicted(facts: Facts) -> Hits:
    """A finding of the source that the runs do not show."""
    for one in facts.study.findings:
        if one.verdict == NOT_SEEN:
            yield Hit(fields={"said": one.statement, "place": one.place})


def by_phase(facts: Facts) -> Hits:
    """A printed value rests on the phase of the samples of its source, which a range over all phases shows."""
    for row in compared(facts):
        if row.samples is not None and row.samples.low < row.published < row.samples.high:
            fields: Fields = {
                "label": label_of(row.quantity), "at": speed_text(row.engine_speed or 0.0),
                "low": Amount(row.quantity, row.samples.low), "high": Amount(row.quantity, row.samples.high),
                "share": f"{100 * row.samples.share:.0f} %", "printed": Amount(row.quantity, row.published),
            }  # fmt: skip
            spread = (row.samples.high - row.samples.low) / abs(row.published)
            yield Hit(Amount(row.quantity, row.computed or 0.0), None, None, fields, spread)


PUBLISHED = (
    Rule("H101", "notes", "fitted to {fitted} of {count} printed values[; forces not fitted {forces}][; motions {motions}]",
         published, reason="[{doubt} in doubt]", guide="evidence.md"),
    Rule("H102", "notes", "predicted blind: forces {forces}", blind, guide="beehive.md"),
    Rule("H104", "notes", "{label} at {at}: {low..high} by the phase of the samples, {share} of the phases above {printed}",
         by_phase, guide="beehive.md"),
    Rule("H103", "notes", "not as printed: {said}", contradicted, remark="[{place}]"),
)  # fmt: skip
