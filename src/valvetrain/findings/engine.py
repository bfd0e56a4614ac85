"""Findings: what a result shows, by a table of rules as a linter has them.

A :class:`Rule` has a stable code, reads quantities or events and yields :class:`Hit` objects, which are numbers and
names. :func:`judge` takes the worst hit of each rule, names the runs in which it holds, fills the templates and
orders by importance: the level, then the place in the table. The first finding is the verdict.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Literal, Protocol, overload

from valvetrain.findings.words import RPM, Amount, Phrase, Said, Words
from valvetrain.solution.definition import definition_of

if TYPE_CHECKING:  # facts load kernels, which lists of files never need
    from valvetrain.findings.facts import Facts
    from valvetrain.solution.result import Solution

Level = Literal["decides", "warns", "notes"]
Mark = Literal["bad", "warn", "ok", ""]
LEVELS: tuple[Level, ...] = ("decides", "warns", "notes")
#: The mark of a row that a finding of each level reads, where its rule sets no other.
MARKS: dict[Level, Mark] = {"decides": "bad", "warns": "warn", "notes": ""}
#: Parts of a rule that are templates.
PARTS = ("text", "reason", "step", "remark")
Fields = Mapping[str, Said]
_VERBS = re.compile("^valvetrain (run|sweep|compare) ")
#: Prefixes of the quantities of a single spring and of the springs of a pair.
SPRINGS = ("", "outer_", "inner_")


@dataclass(frozen=True)
class Hit:
    """One place where a rule holds: an ``amount`` in a ``run`` next to a ``limit`` (SI), and named ``fields``.

    ``severity``: the hit with the largest one is reported; that of the amount where none is given.

    >>> Hit(Amount("loft_gap", 3e-4)).rank
    0.0003
    """

    amount: Amount | None = None
    run: Solution | None = None
    limit: float | None = None
    fields: Fields = field(default_factory=dict)
    severity: float = math.nan

    @property
    def rank(self) -> float:
        """How bad the hit is next to the other hits of its rule."""
        if math.isfinite(self.severity):
            return self.severity
        return self.amount.value if self.amount else 0.0


#: What a rule gives: each place where it holds.
Hits = Iterator[Hit]


class Subject(Protocol):
    """What the engine asks of anything that rules judge: a study, a case. What is inherited suits a result without runs."""

    @property
    def case(self) -> str:
        """What a command takes for the case."""
        return ""

    @property
    def verb(self) -> str:
        """The only command that takes this case, such as that on two springs; empty where every command does."""
        return ""

    def at(self, run: Solution) -> str:
        """Where a run is, as text."""
        return ""

    def where(self, runs: Sequence[Solution]) -> str:
        """In which of its runs a rule holds, as text."""
        return ""


Condition = Callable[[Any], Iterable[Hit]]


@dataclass(frozen=True)
class Rule:
    """What is said where ``hits`` yields anything.

    Parameters
    ----------
    code : letter of the topic and number, which never changes
    level : whether it decides the verdict, warns or notes
    text : the fact; ``reason``: why; ``step``: what to do or run next; ``remark``: a few words behind the row of the
        table that shows what the rule ``reads``. Templates: every rule has the fields ``value``, ``limit``, ``at`` (the
        worst run), ``where`` (all runs in which it holds), ``case`` as a command takes it and ``file``, the same of a case
        without options
    hits : the condition
    reads : names of the quantities that the rule looks at
    guide : page of the documentation
    mark : that of the row, by default that of the level
    unless : beginnings of codes that make the rule superfluous

    >>> rule = Rule("XX1", "warns", "the valve bounces {value}", above("bounce_height", 1e-4), ("bounce_height",))
    >>> rule.level
    'warns'
    """

    code: str
    level: Level
    text: str
    hits: Condition
    reads: tuple[str, ...] = ()
    reason: str = ""
    step: str = ""
    remark: str = ""
    guide: str = ""
    mark: Mark | None = None
    unless: tuple[str, ...] = ()


@dataclass(frozen=True)
class Finding:
    """A rule that holds, as data with its text: ``quantity`` in the run of ``label`` at ``engine_speed`` (rad/s);
    ``value``, ``bar`` and ``limit`` in SI. From ``fields`` the same text is made in other units or another language.

    >>> Finding("C110", "warns", "warn", "the valve bounces").to_dict()
    {'code': 'C110', 'level': 'warns', 'mark': 'warn', 'text': 'the valve bounces'}
    """

    code: str
    level: Level
    mark: Mark
    text: str
    reason: str = ""
    step: str = ""
    remark: str = ""
    guide: str = ""
    quantity: str = ""
    label: str = ""
    engine_speed: float | None = None
    value: float | None = None
    bar: float = 0.0
    limit: float | None = None
    reads: tuple[str, ...] = ()
    fields: Fields = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.text}: {self.reason}" if self.reason else self.text

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON, every number with its unit; what is empty is left out."""
        name, speed = self.quantity, self.engine_speed
        found: dict[str, Any] = {
            one: getattr(self, one)
            for one in ("code", "level", "mark", *PARTS, "guide", "quantity", "label")
        }
        found["engine_speed"] = None if speed is None else measured(speed / RPM, "rpm")
        if name:
            unit, bar = definition_of(name).si_unit, self.bar or None
            for key, number in (("value", self.value), ("bar", bar), ("limit", self.limit)):
                found[key] = None if number is None else measured(number, unit)
        found |= {"reads": list(self.reads), "fields": _plain(self.fields)}
        return {key: one for key, one in found.items() if one not in ("", None, [], {})}


@dataclass(frozen=True)
class Findings(Sequence[Finding]):
    """The findings of a result by importance; the first is the verdict.

    >>> Findings((Finding("C110", "warns", "warn", "the valve bounces"),)).codes
    ('C110',)
    """

    items: tuple[Finding, ...] = ()

    @overload
    def __getitem__(self, place: int) -> Finding: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[Finding, ...]: ...
    def __getitem__(self, place: int | slice) -> Finding | tuple[Finding, ...]:
        return self.items[place]

    def __len__(self) -> int:
        return len(self.items)

    def __repr__(self) -> str:
        return "\n".join(f"{one.code} {one}" for one in self.items)

    @property
    def codes(self) -> tuple[str, ...]:
        """The codes in order."""
        return tuple(one.code for one in self.items)

    @property
    def verdict(self) -> Finding | None:
        """The first finding; None without any."""
        return self.items[0] if self.items else None

    def by(self, code: str) -> list[Finding]:
        """Those of a topic or of one rule, by the beginning of their ``code``."""
        return [one for one in self.items if one.code.startswith(code)]

    def about(self, names: Iterable[str]) -> list[Finding]:
        """Those that read any of these quantities."""
        known = set(names)
        return [one for one in self.items if known & set(one.reads)]


def judge(facts: Subject, rules: Iterable[Rule], words: Words) -> Findings:
    """The findings of a result.

    Parameters
    ----------
    facts : what the conditions read
    rules : each is asked once, in this order
    words : units and language

    Returns
    -------
    Findings ordered by level, then by the place of their rule
    """
    found: list[Finding] = []
    for rule in rules:
        if rule.unless and any(one.code.startswith(rule.unless) for one in found):
            continue
        if hits := list(rule.hits(facts)):
            found.append(_finding(rule, hits, facts, words))
    return Findings(tuple(sorted(found, key=lambda one: LEVELS.index(one.level))))


def _finding(rule: Rule, hits: Sequence[Hit], facts: Subject, words: Words) -> Finding:
    """The worst hit of a rule with the templates filled."""
    hit = max(hits, key=lambda one: one.rank)
    amount, run = hit.amount, hit.run
    case = words.case or facts.case
    file = "" if facts.verb or " --" in case else case
    values: dict[str, Said] = {"case": case, "file": file, "stem": PurePath(file).stem}
    if amount is not None:
        values["value"] = amount
        if hit.limit is not None:
            values["limit"] = Amount(amount.name, hit.limit)
    if run is not None:
        values["at"] = facts.at(run)
        values["where"] = facts.where([one.run for one in hits if one.run is not None])
    values |= hit.fields
    templates = words.templates.get(rule.code, {})
    texts = {part: words.fill(templates.get(part, getattr(rule, part)), values) for part in PARTS}
    if facts.verb:
        texts["step"] = _VERBS.sub(f"valvetrain {facts.verb} ", texts["step"])
    mark = MARKS[rule.level] if rule.mark is None else rule.mark
    return Finding(
        rule.code, rule.level, mark, **texts, guide=rule.guide, quantity=amount.name if amount else "",
        label=run.label if run else "", engine_speed=run.engine_speed if run else None, value=amount.value if amount else None,
        bar=amount.bar if amount else 0.0, limit=hit.limit, reads=rule.reads, fields=values,
    )  # fmt: skip


def _plain(one: Any) -> Any:
    """A field as plain values."""
    if isinstance(one, Amount):
        unit = definition_of(one.name).si_unit
        numbers = {"value": measured(one.value, unit), "bar": measured(one.bar, unit)}
        return {"quantity": one.name, **numbers} | (
            {"rests_on": one.rests_on} if one.rests_on else {}
        )
    if isinstance(one, Phrase):
        return {"template": one.template, "fields": _plain(one.fields)}
    if isinstance(one, Mapping):
        return {name: _plain(value) for name, value in one.items() if value not in ("", ())}
    return one if isinstance(one, str) else [_plain(part) for part in one]


def measured(number: float | None, unit: str) -> dict[str, Any]:
    """A number with its unit, as JSON gives every number; null for what could not be computed."""
    known = number is not None and math.isfinite(number)
    return {"value": float(number) if known else None, "unit": unit}  # type: ignore[arg-type]


# -- conditions ------------------------------------------------------------------------------------


def above(name: str, limit: float | str, springs: bool = False, sign: int = 1) -> Condition:
    """Runs in which a quantity is above a limit by more than its error bar.

    Parameters
    ----------
    name : name of the quantity
    limit : a number (SI), or the name of another quantity of the run
    springs : of a pair the quantity of each spring as well
    sign : -1 for a quantity below the limit
    """

    def hits(facts: Facts) -> Hits:
        found: list[Hit] = []
        for prefix in SPRINGS if springs else ("",):
            for amount, run in facts.amounts(prefix + name):
                bound = facts.value(run, prefix + limit) if isinstance(limit, str) else limit
                excess = sign * (amount.value - bound)
                if excess > amount.bar:
                    more: Fields = {
                        "spring": prefix.rstrip("_"), "excess": Amount(name, abs(amount.value - bound)),
                    }  # fmt: skip
                    found.append(Hit(amount, run, bound, more, excess))
        named = [one for one in found if one.fields["spring"]]
        return iter(named or found)  # of a pair the spring is named

    return hits


def below(name: str, limit: float | str, springs: bool = False) -> Condition:
    """As :func:`above`, for a quantity below a limit."""
    return above(name, limit, springs, -1)


def per_run(function: Callable[[Facts, Solution], Hit | None]) -> Condition:
    """A condition from a function of one run, which gives None where it does not hold."""

    def hits(facts: Facts) -> Hits:
        return (hit for run in facts.runs if (hit := function(facts, run)) is not None)

    hits.__doc__ = function.__doc__
    return hits
