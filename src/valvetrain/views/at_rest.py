"""Springs at rest: rows and tables of ``static`` and ``modes``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain

from valvetrain.findings.engine import Findings, Mark
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_rest import (
    BIND,
    HALF,
    IN_USE,
    lift_of,
    orders_of,
    speed_of,
    strongest,
)
from valvetrain.findings.rules_spring import WOUND
from valvetrain.findings.springs_at_rest import State, pair_of, states_of
from valvetrain.findings.words import Amount, Words, digits_text, speed_text
from valvetrain.solution.critical import NEAR_BIND
from valvetrain.solution.modes import TrainModes
from valvetrain.solution.static import POINT_QUANTITIES, RestPoint
from valvetrain.views.shown import ShownStudy
from valvetrain.views.table import Line, TextTable

#: Springs that are columns of the first table, and axial modes and cam orders that are its rows.
COLUMNS, MODES, MET = 4, 2, 4
STATES = {"closed": "valve closed", "full_lift": "full lift"}
#: Rows of what is left to coil bind, and the quantities that findings read of it.
TO_BIND = {"coil bind": BIND, "by wire and turns": WOUND}
Read = Callable[[State], str]


def rest_headings(facts: Facts) -> list[str]:
    """What tells the columns apart: springs, models or both; of a pair also both together."""
    states = states_of(facts.study)[:COLUMNS]
    names = [one.name for one in states]
    return [*names, "together"] if _together(facts) else names


def _together(facts: Facts) -> bool:
    states = states_of(facts.study)
    return facts.study.command != "modes" and bool(states) and pair_of(states) is not None


def rest_lines(facts: Facts, findings: Findings, words: Words) -> list[Line]:
    """Rows of springs at rest; the mark of coil bind is that of its finding."""
    states = states_of(facts.study)[:COLUMNS]
    rows: Iterator[tuple[str, Read, str]] = _static(words, states)
    if facts.study.command == "modes":
        rows = chain(_modes(words), _meetings(facts, words, states))
    pair, lines = pair_of(states) if _together(facts) else None, list[Line]()
    for label, read, note in rows:
        cells = [read(one) for one in states]
        if not any(cells):
            continue
        if pair is not None:
            both = {
                "installed": (pair.force(0.0),),
                "full lift": (pair.force(pair.lift),),
                "rate": (pair.rate(0.0), pair.rate(pair.lift)),
            }
            known = [one for one in both.get(label, ()) if one is not None]
            cells.append(words.span(known[0], known[-1]) if known else "")
        bind = label in TO_BIND
        lines.append(
            bind_line(label, cells, note, findings, words)
            if bind
            else Line(label, tuple(cells), "", note)
        )
    return lines


def wound_text(read: Callable[[str], Amount | None], words: Words) -> str:
    """What is left to coil bind by wire and turns, least to most; empty where it is not known."""
    least, most = map(read, WOUND)
    return f"{words.span(least, most)} left" if least and most else ""


def bind_line(
    label: str,
    cells: Sequence[str],
    note: str,
    findings: Findings,
    words: Words,
    left: Amount | None = None,
) -> Line:
    """A row of :data:`TO_BIND`: as its finding says, else with the limit, and a tick unless what is ``left`` is below it."""
    about = [one for one in findings.about(TO_BIND[label]) if one.mark != "ok"]
    close = left is not None and left.value < NEAR_BIND
    mark: Mark = about[0].mark if about else "warn" if close else "ok"
    limit = (
        "" if about else f"{note}, limit {words.amount(Amount('coil_bind_clearance', NEAR_BIND))}"
    )
    return Line(
        label,
        tuple(cells),
        mark,
        next((one.remark for one in about if one.remark), limit or note),
    )


def _static(words: Words, states: tuple[State, ...]) -> Iterator[tuple[str, Read, str]]:
    def said(amount: Amount | None) -> str:
        return "" if amount is None else words.amount(amount)

    def height(one: State) -> str:
        installed = one.one.installed
        known = installed is not None and installed.height is not None
        return said(Amount("installed_height", installed.height) if known else None)  # type: ignore[union-attr, arg-type]

    def span(read: Callable[[float], Amount | None], one: State) -> str:
        first, last = read(one.one.precompression), read(one.full_lift)
        return words.span(first, last) if first and last else said(first)

    def left(one: State) -> str:
        return "" if one.left is None else f"{said(one.left)} left"

    def point(place: int) -> Read:
        def read(one: State) -> str:
            return _point(one.one.points[place], words) if place < len(one.one.points) else ""

        return read

    lifted = any(math.isfinite(one.lift) for one in states)
    over = "closed to full lift" if lifted else "as installed"
    yield "height", height, "installed, between the seats"
    yield "installed", lambda one: said(one.force(one.one.precompression)), ""
    yield "full lift", lambda one: said(one.force(one.full_lift)), ""
    yield "rate", lambda one: span(one.rate, one), over
    stated = any("computed_solid_height" in one.values for one in states)
    of_wire = "as stated" if stated else "end turns stack higher than turns times wire"
    yield "solid height", lambda one: said(one.amount("solid_height")), of_wire
    yield "coil bind", left, "at full lift"
    by_turns = "to coil bind at full lift"
    yield "by wire and turns", lambda one: wound_text(one.amount, words), by_turns
    by = "in the section" if any(one.one.stress for one in states) else "EN 13906-1"
    yield "wire, shear", lambda one: span(one.shear, one), f"{over}; {by}"
    for place in range(max((len(one.one.points) for one in states), default=0)):
        yield "as requested", point(place), ""


def _point(one: RestPoint, words: Words) -> str:
    name, at = (
        ("height", one.height) if one.height is not None else ("compression", one.compression)
    )
    force = words.amount(Amount("preload", one.force), 4)
    return f"{force} at {words.amount(Amount(f'installed_{name}', at), 4)}"


def _modes(words: Words) -> Iterator[tuple[str, Read, str]]:
    def axial(place: int) -> Read:
        def read(one: State) -> str:
            modes = one.one.modes
            if modes is None or place >= len(modes.axial_modes):
                return ""
            return words.amount(Amount("surge_frequency", float(modes.axial_frequencies[place])), 4)

        return read

    for place in range(MODES):
        yield f"axial mode {place + 1}", axial(place), "surge" if place == 0 else ""

    def halves(one: State) -> str:
        return words.amount(Amount(HALF, one.values[HALF])) if HALF in one.values else ""

    yield "surge halves in", halves, "by its damping, without rubbing"


def _meetings(
    facts: Facts, words: Words, states: Sequence[State]
) -> Iterator[tuple[str, Read, str]]:
    """The engine speeds at which cam orders meet the first axial mode: of those in use the ones with the largest lift, and
    the next above them.
    """

    def read(order: int) -> Read:
        def cell(one: State) -> str:
            return speed_text(speed_of(order, one.surge.value)) if one.surge else ""

        return cell

    first = min((one.surge.value for one in states if one.surge), default=math.nan)
    if not math.isfinite(first):
        return
    highest, *lowest = orders_of(facts, first)
    beyond = 0 if lowest or not facts.study.record.top_speed else highest - 1
    few = range(highest, lowest[0] - 1, -2) if lowest else strongest(facts, first, MET)
    for order in (*few, *[beyond] * (beyond > 0)):
        lift = lift_of(facts, order)
        size = "" if lift is None else f", {words.amount(lift)} of lift"
        place = (
            f"above the {IN_USE[facts.study.record.red_line is None]}"
            if order == beyond
            else "meets axial mode 1"
        )
        yield f"cam order {order}", read(order), f"{place}{size}"


# -- tables ----------------------------------------------------------------------------------------


def requested_table(answer: ShownStudy) -> TextTable | None:
    """All that is known of the heights and loads that were asked for."""
    facts, words = answer.facts, answer.words
    rows = [
        (state.one.spring, state.one.model, str(place), field.replace("_", " "), words.amount(Amount(name, value), 4))
        for state in states_of(facts.study)
        for place, point in enumerate(state.one.points, 1)
        for field, name in POINT_QUANTITIES.items()
        if (value := getattr(point, field)) is not None
    ]  # fmt: skip
    heads = ("spring", "model", "point", "quantity", "value")
    return TextTable("As requested", heads, tuple(rows)) if rows else None


def modes_table(answer: ShownStudy) -> TextTable | None:
    """Every natural mode of every spring."""
    rows = list[tuple[str, ...]]()
    for state in states_of(answer.study):
        modes = state.one.modes
        if modes is None:
            continue
        axial = {place: f"axial mode {k}" for k, place in enumerate(modes.axial_modes, 1)}
        rows.append((state.name or state.one.spring,))
        numbers = zip(modes.natural_frequency, modes.axial_transmission, strict=True)
        for place, (frequency, share) in enumerate(numbers):
            texts = digits_text(float(frequency), 0, 5), digits_text(float(share))
            rows.append((str(place + 1), *texts, axial.get(place, "")))
    heads = ("mode", "frequency, Hz", "axial push passed on", "kind")
    return TextTable("Natural modes", heads, tuple(rows)) if rows else None


def train_table(answer: ShownStudy) -> TextTable | None:
    """Modes of a train with its springs as one, valve closed and at full lift."""
    facts = answer.facts
    rows = list[tuple[str, ...]]()
    for one in facts.study.train_modes:
        rows.append((f"{one.label}, {STATES.get(one.state, one.state)}",))
        rows += [
            (str(place + 1), digits_text(float(frequency), 0, 5), *_followed(one, place), one.moving(place))
            for place, frequency in enumerate(one.natural_frequency)
        ]  # fmt: skip
        if one.open:
            rows.append((f"open there, without stiffness: {', '.join(one.open)}",))
    heads = ("mode", "frequency, Hz", "closed mode", "overlap", "moving (kinetic energy)")
    return TextTable("Whole train", heads, tuple(rows)) if rows else None


def _followed(one: TrainModes, place: int) -> tuple[str, str]:
    if not one.closed_mode:
        return "", ""
    return str(one.closed_mode[place] + 1), f"{100 * one.overlap[place]:.0f} %"
