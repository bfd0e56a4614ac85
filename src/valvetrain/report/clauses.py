"""Clauses of a verdict: what was found in the worst of several runs, and which run that was."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

from valvetrain.report.text import number, rpm, unit_text
from valvetrain.solution.definition import shown
from valvetrain.solution.result import Solution
from valvetrain.solution.uncertainty import NOT_RESOLVED, ErrorBars
from valvetrain.units.reader import reader_factor, reader_unit

#: How the names of the stresses by EN 13906-1 begin, but for their spring.
STRESS = "open_nominal"
#: What is said of a stress by EN 13906-1 of a force beyond solid.
#: Least number that is written with noughts in place of a power of ten.
TINY = 1e-6
#: Share of a value above which its error bar is named.
COARSE = 0.05
#: Words of the first sentence of a verdict over engine speed, which pages show in bold.
MAX_LEAD = 60
#: Status -> what the run did.
ENDED = {
    "not-converged": "did not settle", "diverged": "diverged", "out-of-range": "left the range of its tables",
    "coil-bind": "reached coil bind", "solid": "ran solid", "buckled": "buckled", "refused": "was refused",
    "interrupted": "was interrupted", "worker-lost": "lost its process",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Clause:
    """Part of a verdict; ``run`` is the one that it is about, None where it holds for all. ``lost``: it
    reports contact lost or met again, which comes before what is well.
    """

    text: str
    run: Solution | None = None
    lost: bool = False


@dataclass(frozen=True)
class Worst:
    """The value (SI) of a quantity in the run where it is worst; ``run`` None where all agree."""

    name: str
    value: float
    run: Solution | None = None


@dataclass(frozen=True)
class Runs:
    """Runs that are judged together. ``still``: quantities of no run, by label, model or "".
    ``bars``: known error bars.
    """

    solutions: tuple[Solution, ...]
    still: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    bars: ErrorBars = ErrorBars()

    def value(self, run: Solution, name: str) -> float:
        """A quantity of a run, or of its spring at rest; NaN where neither has it."""
        if name in run.quantities:
            return run.quantities[name]
        labels = (run.label, run.spring_set, run.model, "")
        places = (self.still.get(label, {}) for label in labels)
        return next((one[name] for one in places if name in one), math.nan)

    def worst(
        self, name: str, least: bool, prefer: Solution | None = None, only: Solution | None = None
    ) -> Worst | None:
        """The least or the largest value over the runs, or of the ``only`` one; of equal ones that of
        ``prefer``; None where no run gives it.
        """
        judged = self.solutions if only is None else (only,)
        known = [(value, run) for run in judged if math.isfinite(value := self.value(run, name))]
        if not known:
            return None
        value, run = (min if least else max)(
            known, key=lambda pair: (pair[0], (pair[1] is prefer) != least)
        )
        # a number that runs of one spring set alone have is reported of that set
        every = {one.spring_set for _, one in known} == {one.spring_set for one in self.solutions}
        alike = (
            only is None
            and every
            and all(abs(one - value) <= 1e-9 * max(abs(value), 1e-12) for one, _ in known)
        )
        return Worst(name, value, None if alike else run)

    def reads_alike(self, found: Worst) -> bool:
        """Whether a quantity reads the same of every run, so that none is the worst."""
        values = [self.value(run, found.name) for run in self.solutions]
        return (
            all(map(math.isfinite, values))
            and len({quantity_text(found.name, one) for one in values}) == 1
        )

    def text(self, found: Worst, digits: int = 3) -> str:
        """Value and unit as tables print them, with an error bar above 5 %; one above the value in words,
        for of a force it would reach below zero.
        """
        value, bar = quantity_text(found.name, found.value, digits), self.bar(found)
        if not bar:
            return value
        # both in the unit of the larger, so that neither has needless noughts
        unit = quantity_text(found.name, max(abs(found.value), bar)).partition(" ")[2]
        value, size = (
            quantity_text(found.name, one, count, whole=unit == "mm")
            for one, count in ((found.value, digits), (bar, 2))
        )
        if bar > abs(found.value):
            return f"{value} ({NOT_RESOLVED})"
        return f"{value.removesuffix(f' {unit}') if unit else value} ± {size}"

    def bounded(self, found: Worst) -> str:
        """A value; of a stress by EN 13906-1 its range, and the
        uncorrected one next to what the wire is permitted, as far as these are known.
        """
        text, run = self.text(found), found.run or self.solutions[0]
        if STRESS not in found.name:
            return text
        least, plain, bound = (
            self.value(run, found.name.replace(STRESS, one))
            for one in ("closed_nominal", "open_uncorrected", "permitted")
        )
        if math.isfinite(least):
            text = f"{quantity_text(found.name, least).partition(' ')[0]} to {text}"
        if not math.isfinite(plain - bound):
            return text
        known = quantity_text(found.name, plain).partition(" ")[0]
        return f"{text}, uncorrected {known} of {quantity_text(found.name, bound)} permitted"

    def bar(self, found: Worst, above: float = COARSE) -> float:
        """The known error bar of a value where it is ``above`` that share of it, else 0."""
        run = found.run or (self.solutions[0] if len(self.solutions) == 1 else None)
        row = None if run is None else self.bars.of(found.name, run.label, run.engine_speed)
        if row is not None and found.value and row.numerical > above * abs(found.value):
            return row.numerical
        return 0.0

    def place(self, run: Solution) -> str:
        """Which of the runs one is: ``at 6000 rpm (modal-varied)``, as far as they differ in it."""
        speed = f"at {rpm(run.engine_speed):.6g} rpm" if self.speeds > 1 else ""
        return " ".join(filter(None, (speed, f"({self.name(run)})" if self.labels > 1 else "")))

    def name(self, run: Solution) -> str:
        """The spring set of a run where that distinguishes the labels, else its label."""
        sets = {(one.spring_set, one.label) for one in self.solutions}
        known = {name for name, _ in sets} - {""}
        return run.spring_set if len(known) == len(sets) == self.labels else run.label

    @property
    def speeds(self) -> int:
        """How many engine speeds."""
        return len({rpm(run.engine_speed) for run in self.solutions})

    @property
    def labels(self) -> int:
        """How many labels."""
        return len({run.label for run in self.solutions})


def figure(value: float, digits: int = 3) -> str:
    """A number as a sentence gives it: three digits, whole ones never rounded away, small ones without powers
    of ten.

    >>> figure(7.283e-5), figure(0.01234), figure(12345.6)
    ('0.000073', '0.0123', '12346')
    """
    if TINY <= abs(value) < 1e-4:
        return f"{value:.6f}".rstrip("0").replace("-", "−")
    return number(float(round(value)), 12) if abs(value) >= 10**digits else number(value, digits)


def amount_text(value: float, unit: str, digits: int = 3) -> str:
    """A number in a metric ``unit`` with the unit of the reader, rounded as :func:`figure` does."""
    return f"{figure(value * reader_factor(unit), digits)} {unit_text(reader_unit(unit))}".strip()


def quantity_text(name: str, value: float, digits: int = 3, whole: bool = False) -> str:
    """An SI value with the unit of its tables; below a tenth of a millimetre in µm, unless it is
    shown next to ``whole`` ones.
    """
    found, unit = shown(name, value)
    number_shown = float(found)
    if unit == "mm" and not whole and 0 < abs(number_shown) < 0.1:
        number_shown, unit = 1e3 * number_shown, "um"
    return f"{figure(number_shown, digits)} {unit_text(unit)}".strip()


def counted(count: int, noun: str, plural: str = "") -> str:
    """``no bounce``, ``one bounce``, ``3 bounces``."""
    word = {0: "no", 1: "one"}.get(count, f"{count}")
    return f"{word} {noun if count < 2 else plural or noun + 's'}"


def joined(parts: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {last} {parts[-1]}"


def one_bracket(text: str) -> str:
    """Brackets behind each other as one.

    >>> one_bracket("2.2 mm (at rest) (wave-rod)")
    '2.2 mm (at rest; wave-rod)'
    """
    return text.replace(") (", "; ")


def sentence(parts: Sequence[str], condition: str = "") -> str:
    """Parts behind each other, as a sentence under a ``condition``; empty without any."""
    text = "; ".join(part for part in parts if part)
    text = f"{condition}, {text}" if condition and text else text
    return f"{text[:1].upper()}{text[1:]}." if text else ""


def parted(lead: Sequence[str], more: Sequence[str]) -> tuple[list[str], list[str]]:
    """Parts of a first sentence of at most :data:`MAX_LEAD`, of one part at least, and all others.

    >>> parted(["word " * 40, "word " * 30], ["more"])[1][1:]
    ['more']
    """
    first, count = list[str](), 0
    lead = [part for part in lead if part]
    for part in lead:
        count += len(part.split())
        if first and count > MAX_LEAD:
            break
        first.append(part)
    return first, [*lead[len(first) :], *filter(None, more)]


def clause_texts(clauses: Sequence[Clause], runs: Runs) -> list[str]:
    """Clauses as text: neighbours about one run together, with its place; those about the one run
    that is worst throughout, or about one engine speed, under that.
    """
    about = {id(one.run): one.run for one in clauses if one.run is not None}
    several = len(runs.solutions) > 1
    if several and len(about) == 1 and len(clauses) > 1:
        place = runs.place(next(iter(about.values())))
        # the place is said, so that a clause need not repeat it
        text = ", ".join(one.text for one in clauses).replace(f" {place})", ")")
        return [f"worst {place}: {text}"]
    speeds = {rpm(run.engine_speed) for run in about.values()}
    if runs.speeds > 1 and len(speeds) == 1 and len(clauses) > 1:
        there = [run for run in runs.solutions if rpm(run.engine_speed) in speeds]
        place = f"at {speeds.pop():.6g} rpm"
        found = clause_texts(clauses, replace(runs, solutions=tuple(there)))
        first, *more = (one.replace(f" {place})", ")") for one in found)
        return [f"worst {place}: {first}", *more]
    found = []
    for _, group in groupby(clauses, key=lambda one: id(one.run)):
        some = list(group)
        text = ", ".join(one.text for one in some)
        run = some[0].run
        where = runs.place(run) if several and run is not None else ""
        found.append(one_bracket(f"{text} {where}".strip()))
    return found


def ended_clauses(runs: Sequence[Solution]) -> list[str]:
    """What the runs did that did not complete, by kind, with their places."""
    found, every = [], Runs(tuple(runs))
    failed = [run for run in runs if not run.status.completed]
    for code in dict.fromkeys(run.status.code for run in failed):
        some = [run for run in failed if run.status.code == code]
        did = ENDED.get(code, code)
        if len(runs) == 1:
            said = some[0].status.message
            found.append(f"the run {did}{f' ({said})' if said else ''}")
            continue
        places = [every.place(run) for run in some]
        if every.labels == 1 and 1 < len(places) <= 3:
            speeds = [one.removeprefix("at ").removesuffix(" rpm") for one in places]
            places = [f"at {joined(speeds)} rpm"]
        named = (
            f"{'; '.join(places[:3])}{f' and {len(places) - 3} more' if len(places) > 3 else ''}"
        )
        count = "one" if len(some) == 1 else f"{len(some)}"
        found.append(f"{count} of {len(runs)} runs {did} {named}".strip())
    return found
