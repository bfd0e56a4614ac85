"""Rules on springs from cards and testers (Z101 and up): whether card and wire agree, what the spring is, what was assumed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from valvetrain.findings.engine import Condition, Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, digits_text, percent
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.quantities.statics import design_quantities
from valvetrain.solution.definition import label_of
from valvetrain.spring_card.card import GROUND, INACTIVE, doubt_of
from valvetrain.spring_card.fit import CardDeviation, SpringFit
from valvetrain.spring_card.tester import MISFIT, PitchStations, TesterFit

#: Share from which a number of the card counts as missed.
MISSED = 0.01


@dataclass(frozen=True)
class CardFacts(Subject):
    """A spring as rules read it: its ``fit`` to a card or to a table of forces, and the case ``file`` that holds it."""

    fit: SpringFit | TesterFit
    file: str = ""

    @property
    def case(self) -> str:
        """What a command takes for the spring."""
        return self.file

    @property
    def wire(self) -> SpringDefinition | None:
        """The spring itself; None of a table without sizes."""
        return self.fit.spring.wire

    @property
    def stations(self) -> PitchStations | None:
        """The pitch law behind a table."""
        return self.fit.wire.stations if isinstance(self.fit, TesterFit) and self.fit.wire else None

    @property
    def quantities(self) -> dict[str, float]:
        """Geometry, estimates and the state of closed coils (SI)."""
        return design_quantities(self.fit.spring) if self.wire else {}

    @property
    def by_card(self) -> list[SpringFit]:
        """The fit to a card; empty of a table of forces."""
        return [self.fit] if isinstance(self.fit, SpringFit) else []


def apart(one: CardDeviation) -> float:
    """The number of the wire over that of the card, less one; 0 where the card is silent."""
    return one.found / one.requested - 1 if one.requested else 0.0


def doubted(facts: CardFacts) -> Hits:
    """The loads are hardly those of one spring with this wire."""
    for fit in facts.by_card:
        if doubt_of(fit.card):
            turns = Amount("total_coil_count", fit.definition.total_coils)
            yield Hit(
                Amount("active_coil_count", fit.definition.active_coils), fields={"turns": turns}
            )


def missed(height: bool) -> Condition:
    """The condition that the solid height of the card, or another of its numbers, is more than 1 % off."""

    def hits(facts: CardFacts) -> Hits:
        """The wire, by the other numbers, has another."""
        for one in (held for fit in facts.by_card for held in fit.held):
            if abs(apart(one)) > MISSED and height is (one.quantity == "solid_height"):
                name = {"name": label_of(one.quantity)}
                yield Hit(
                    Amount(one.quantity, one.found), None, one.requested, name, abs(apart(one))
                )

    return hits


def off_table(facts: CardFacts) -> Hits:
    """The wire is more than 3 % of the largest force off the table."""
    return (hit for hit in of_table(facts) if hit.severity > MISFIT)


def of_card(facts: CardFacts) -> Hits:
    """A wire has the numbers of the card."""
    for fit in facts.by_card:
        apart_by = [abs(apart(one)) for one in fit.held if one.requested]
        bind = "" if "turns" in fit.free else Amount("solid_height", fit.definition.solid_height)
        yield Hit(Amount("rate", fit.held[2].found), fields={
            "force": Amount("preload", fit.held[0].found), "bind": bind, "count": str(len(apart_by)), "share": percent(max(1e-3, *apart_by)),
        })  # fmt: skip


def of_table(facts: CardFacts) -> Hits:
    """A wire has the forces of the table."""
    if isinstance(fit := facts.fit, TesterFit) and fit.wire is not None:
        share = fit.wire.worst_by_rod / float(np.max(fit.table.forces))
        yield from (replace(hit, fields={**hit.fields, "share": percent(share), "off": Amount("force", fit.wire.worst_by_rod)}, severity=share)
                    for hit in by_table(facts))  # fmt: skip


def by_table(facts: CardFacts) -> Hits:
    """What the table says by itself."""
    if isinstance(fit := facts.fit, TesterFit):
        bind = Amount("solid_height", fit.solid_height[0]) if fit.bound and fit.solid_height else ""
        yield Hit(
            Amount("rate", *bar(fit.rate)),
            fields={"force": Amount("preload", *bar(fit.preload)), "bind": bind},
        )


def bar(estimate: tuple[float, float]) -> tuple[float, float]:
    """A value with half of its 95 % interval."""
    return estimate[0], 2 * estimate[1]


def doubts_of(code: str) -> Condition:
    """The condition that the table has a doubt of this code."""

    def hits(facts: CardFacts) -> Hits:
        """The table can hardly be that of the spring."""
        doubts = facts.fit.table.doubts if isinstance(facts.fit, TesterFit) else ()
        for doubt in (doubt for doubt in doubts if doubt.code == code):
            yield Hit(fields={"said": doubt.what, "step": doubt.step})

    return hits


def noted(facts: CardFacts) -> Hits:
    """Something was found in the table, such as unloading besides loading."""
    if isinstance(facts.fit, TesterFit) and facts.fit.table.notes:
        yield Hit(fields={"said": facts.fit.table.notes})


def left(code: str, text: str, remark: str, *words: str) -> Rule:
    """The rule that says what is assumed where a fit leaves any of ``words`` open."""

    def hits(facts: CardFacts) -> Hits:
        """The card or the table leaves it open."""
        fit = facts.fit.wire if isinstance(facts.fit, TesterFit) else facts.fit
        for word in set(words).intersection(fit.free if fit else ()):
            assert facts.wire is not None
            steel, ends = facts.wire.material, facts.wire.lower_end
            yield Hit(Amount("shear_modulus_pressure", steel.shear_modulus), fields={
                "steel": steel.name, "closes": word, "ground": digits_text(ends.ground_coils),
            })  # fmt: skip

    return Rule(code, "notes", text, hits, remark=remark)


CHECK = "[valvetrain check {case}]"
GUIDE = "springs-from-cards.md"
RULES = (
    Rule("Z101", "decides", "hardly the card of one spring: its loads make {value:2} active turns of {turns:2}", doubted, ("active_coil_count",),
         "", "enter a dual spring as two, each with its own wire; else check wire, diameters and loads", guide=GUIDE),
    Rule("Z102", "decides", "card and wire disagree: {name} {limit:4} on the card, {value:4} by its other numbers", missed(height=False), (), "",
         "measure the spring, or give this command the table of a spring tester", guide=GUIDE, mark="warn"),
    Rule("Z108", "decides", "card and wire agree, but not in the solid height: {limit:4} on the card, {value:4} of the wire", missed(height=True),
         ("solid_height",), "the height of the card counts", CHECK, guide=GUIDE, mark="warn", unless=("Z101", "Z102")),
    Rule("Z103", "decides", "the wire is up to {off:2} off the table", off_table, (), "{share} of its largest force",
         "check wire, diameters, material and units, or give --total-coils", guide=GUIDE, mark="warn"),
    *(Rule(code, "decides", "{said}", doubts_of(code), (), "", "{step}", guide=GUIDE, mark="warn") for code in ("Z104", "Z105", "Z106", "Z107")),
    Rule("Z110", "decides", "card and wire agree, rate {value:3}, {force:3} installed[, coil bind at {bind:3}]", of_card, (),
         "all {count} numbers of the card are met within {share}", CHECK, mark="ok", unless=("Z10",)),
    Rule("Z111", "decides", "table and wire agree, rate {value:3}, {force:3} installed[, coil bind at {bind:3}]", of_table, (),
         "the wire meets the table within {off:2}, {share} of its largest force", CHECK, mark="ok", unless=("Z10",)),
    Rule("Z112", "decides", "the table makes a rate of {value:4}, {force:4}[, coil bind at {bind:3}]", by_table, (),
         "no wire is known", "give --wire-diameter and --outer-diameter for the wire", mark="ok", unless=("Z10", "Z111")),
    Rule("Z121", "notes", "{said}", noted),
    left("Z130", "no material is given: {steel} with G = {value}; 1 % of G is 1 % of the active turns", "{steel}", "material"),
    left("Z131", f"no turns, mass or solid height are given: {INACTIVE:g} inactive turn at either end, so mass and bind are open",
         "inactive end turns", "turns"),
    left("Z132", f"the turns are those of the solid height with {GROUND:g} ground turns at either end; a mass would check them",
         "turns by the solid height", "mass"),
    left("Z133", "no solid height is given: {ground} turns are ground at either end", "{ground} ground turns", "ground"),
    left("Z134", "no solid height is given: {ground} turns are ground at either end, since with fewer the coils would close before the second load",
         "{ground} ground turns", "early"),
    left("Z135", "turns and solid height do not fit together with ends ground over 0.2 to 1 turn", "", "solid"),
    left("Z136", "no start of the taper is given: half of the turns are taken", "taper from half way", "taper"),
    left("Z137", "the pitch is constant between the closed ends; only a table of forces gives a progressive one", "constant pitch", "pitch"),
    left("Z138", "damping is on no card: copy that of your engine's spring", "no damping", "damping"),
    left("Z139", "no free length is given: it follows from both loads", "", "free_length"),
    left("Z140", "the table does not reach coil bind: gaps that never close in it follow from the free length alone", "open gaps", "gaps"),
    left("Z141", "a table of forces does not say where the close coils are: at the {closes}", "close coils at the {closes}",
         "lower end", "upper end", "both ends"),
)  # fmt: skip
