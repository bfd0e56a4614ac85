"""Rules on a scanned spring (Y101 to Y121): whether the scan covers it, and how far it is from its design."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.findings.engine import Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, digits_text
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.summary import percent
from valvetrain.scan.compare import ComparedNumber, ScanComparison
from valvetrain.scan.result import ScannedSpring
from valvetrain.solution.definition import label_of

#: Sector (rad) without points that counts, and least share of points on the wire.
BRIDGED, EXPLAINED = 0.04 * math.tau, 0.8
#: Share up to which a quantity is as drawn, and the quantities that decide it.
AS_DRAWN, DECIDING = 0.02, ("installed_rate", "preload")
#: Share by which a size may be off the design.
SIZE = 0.01


class Size(NamedTuple):
    """A size (SI) by its label: measured, with standard deviation, and of the design where there is one; one number, or
    many over the coil.
    """

    label: str
    values: Array
    spread: Array
    drawn: Array | None

    @property
    def quantity(self) -> str:
        """The quantity in whose unit it is read."""
        return "total_coil_count" if self.label == "turns" else "free_length"


@dataclass(frozen=True)
class ScanFacts(Subject):
    """A scanned spring as rules read it, with the comparison with its design where there is one."""

    scan: ScannedSpring
    compared: ScanComparison | None = None

    @property
    def case(self) -> str:
        """The case file that is written."""
        return "spring.toml"

    @property
    def design(self) -> SpringDefinition | None:
        """The wire of the design."""
        return None if self.compared is None else self.compared.cases[0].springs[0].wire

    @property
    def sizes(self) -> list[Size]:
        """Sizes in the order of the first table; diameter and pitch where the curves are sharp."""
        scan, curves, design = self.scan, self.scan.curves, self.design
        sharp = curves.mean_diameter_spread < 3 * np.median(curves.mean_diameter_spread)
        coil = curves.coil[sharp]
        drawn: tuple[ArrayLike | None, ...] = (None,) * 5 if design is None else (
            design.free_length, np.mean(design.wire_diameter.value(coil)), design.mean_diameter.value(coil), design.total_coils,
            design.pitch.value(coil),
        )  # fmt: skip
        made: tuple[tuple[str, ArrayLike, ArrayLike], ...] = (
            ("free length", *scan.free_length), ("wire diameter", *scan.section.diameter),
            ("mean diameter", curves.mean_diameter[sharp], curves.mean_diameter_spread[sharp]), ("turns", *scan.total_coils),
            ("pitch", curves.pitch[sharp], curves.pitch_spread[sharp]),
        )  # fmt: skip
        return [
            Size(label, np.atleast_1d(values), np.atleast_1d(spread), None if law is None else np.atleast_1d(law))
            for (label, values, spread), law in zip(made, drawn, strict=True)
        ]  # fmt: skip

    @property
    def numbers(self) -> tuple[ComparedNumber, ...]:
        """What is compared."""
        return () if self.compared is None else self.compared.numbers

    @property
    def deciding(self) -> list[ComparedNumber]:
        """Of rate and preload the one that differs more."""
        rows = [number for number in self.numbers if number.quantity in DECIDING]
        return sorted(rows, key=lambda number: -abs(number.difference))[:1]


def length(value: float, bar: float = 0.0) -> Amount:
    """A length (m) of a spring, in the units that its free length is read in."""
    return Amount("free_length", value, bar)


def degrees(radians: float) -> str:
    """An angle as text, in degrees."""
    return f"{digits_text(math.degrees(radians), 0, 2)} deg"


def sector(facts: ScanFacts) -> Hits:
    """No point lies in a sector about the axis that is wider than 14 degrees."""
    seen = facts.scan.coverage
    if seen.sector > BRIDGED:
        yield Hit(fields={"sector": degrees(seen.sector), "tips": " and ".join(seen.hidden_tips)})


def strays(facts: ScanFacts) -> Hits:
    """Fewer than four fifths of the points are on the wire."""
    share = facts.scan.points_on_wire / max(1, facts.scan.points_fitted)
    if share < EXPLAINED:
        yield Hit(fields={"share": f"{100 * share:.0f} %"})


def covered(facts: ScanFacts) -> Hits:
    """A scan without a design."""
    scan = facts.scan
    if facts.compared is None:
        yield Hit(length(scan.noise), fields={
            "wire": length(*scan.section.diameter), "turns": digits_text(*scan.total_coils, 4), "length": length(*scan.free_length),
        })  # fmt: skip


def failed(facts: ScanFacts) -> Hits:
    """Analyses of the design or of the scanned spring did not complete."""
    for sentence in () if facts.compared is None else facts.compared.failures[:1]:
        yield Hit(fields={"first": sentence})


def apart(number: ComparedNumber, **more: str) -> Hit:
    """A quantity of the scanned spring next to that of its design."""
    share = f"{percent(abs(number.difference))[1:]} {'above' if number.difference > 0 else 'below'}"
    return Hit(Amount(number.quantity, number.scanned), fields={
        "name": label_of(number.quantity), "share": share, "design": Amount(number.quantity, number.design), **more,
    }, severity=abs(number.difference))  # fmt: skip


def causes(
    number: ComparedNumber, made: InstalledSpring, drawn: InstalledSpring
) -> dict[str, float]:
    """Size -> share by which its difference changes the rate of a round wire, G d^4 / (8 D^3 n), or the preload."""
    new, old = made.wire, drawn.wire
    assert new is not None and old is not None
    wire, coil = (
        np.mean([getattr(spring, law).value(spring.total_coils * np.linspace(0, 1, 99)) for spring in (new, old)], axis=1)
        for law in ("wire_diameter", "mean_diameter")
    )  # fmt: skip
    longer = (new.free_length - old.free_length) * (number.quantity == "preload")
    return {
        "wire diameter": 4 * (wire[0] / wire[1] - 1), "mean diameter": 3 * (1 - coil[0] / coil[1]),
        "number of turns": 1 - new.total_coils / old.total_coils, "free length": longer / (drawn.precompression or math.inf),
    }  # fmt: skip


def not_as_drawn(facts: ScanFacts) -> Hits:
    """Rate or preload differs from the design by more than 2 %."""
    for number in facts.deciding:
        if abs(number.difference) > AS_DRAWN and facts.compared is not None:
            drawn, made = (case.springs[0] for case in facts.compared.cases)
            cause, part = max(causes(number, made, drawn).items(), key=lambda item: abs(item[1]))
            yield apart(number, cause=cause, part=percent(part))


def size_off(facts: ScanFacts) -> Hits:
    """A size is off that of the design by more than its interval and 1 %."""
    for size in facts.sizes:
        if size.drawn is not None and size.label != "pitch":
            value, drawn = float(np.mean(size.values)), float(np.mean(size.drawn))
            bar, off = 2 * float(np.median(size.spread)), abs(value - drawn)
            if off > max(bar, SIZE * drawn):
                yield Hit(Amount(size.quantity, value, bar), None, drawn, {"name": size.label}, off / drawn)  # fmt: skip


def as_drawn(facts: ScanFacts) -> Hits:
    """Rate and preload are those of the design within 2 %."""
    yield from map(apart, facts.deciding)


def others(facts: ScanFacts) -> Hits:
    """Other quantities differ from the design by more than 2 %."""
    rows = [number for number in facts.numbers if abs(number.difference) > AS_DRAWN and number not in facts.deciding]  # fmt: skip
    for number in rows:
        yield apart(number, more=f"{len(rows) - 1} more" * (len(rows) > 1))


def oval(facts: ScanFacts) -> Hits:
    """The section of the wire is an ellipse, which no case takes."""
    section = facts.scan.section
    if section.ovate:
        longer = facts.scan.definition.free_length - facts.scan.free_length[0]
        mass = section.diameter[0] ** 2 / (section.long_axis[0] * section.short_axis[0]) - 1
        yield Hit(length(section.diameter[0]), fields={
            "long": length(section.long_axis[0]), "short": length(section.short_axis[0]), "longer": length(max(longer, 0.0)),
            "mass": percent(mass),
        })  # fmt: skip


AGAIN, STATIC = "run `valvetrain scan` again", "valvetrain static {case}"
RULES = (
    Rule("Y101", "decides", "the scan does not cover the spring: no point lies in a sector of {sector} about the axis", sector, (),
         "every coil is bridged there[, and the {tips} tip may be in it]", f"scan that side as well, merge the clouds and {AGAIN}"),
    Rule("Y102", "decides", "only {share} of the points are on the wire", strays, (), "the others are strays, a holder or missed coils",
         f"remove from the cloud what is not the spring and {AGAIN}", mark="warn"),
    Rule("Y110", "decides", "not all of it was computed: {first}", failed),
    Rule("Y111", "decides", "not as drawn: the {name} is {share} the design's {design:4}", not_as_drawn, DECIDING,
         "the {cause} alone moves it by {part}", STATIC, mark="warn"),
    Rule("Y114", "decides", "not as drawn: {name} {value:4}, {limit:4} in the design", size_off, (), "", STATIC, mark="warn"),
    Rule("Y112", "decides", "as drawn: the {name} is {share} the design's {design:4}", as_drawn, DECIDING, "", STATIC,
         mark="ok", unless=("Y111", "Y114")),
    Rule("Y113", "decides", "the scan covers the spring: points scatter by {value:2} about the wire", covered, (),
         "{turns} turns of {wire:4} wire, {length:4} long", STATIC, mark="ok", unless=("Y101", "Y102")),
    Rule("Y120", "warns", "the {name} is {share} the design[; {more} are off by more than 2 %]", others),
    Rule("Y121", "warns", "the wire is oval, {long:4} by {short:4}: the case takes {value:4} round wire, which twists alike", oval, (),
         "[its spring is {longer:2} longer, ]its wire's mass differs by {mass}"),
)  # fmt: skip
