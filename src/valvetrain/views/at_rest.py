"""Springs at rest: rows, tables and figures of ``static`` and ``modes``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.engine import Findings, Mark
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_rest import BIND, orders_of, speed_of
from valvetrain.findings.rules_spring import NEAR
from valvetrain.findings.springs_at_rest import State, marks_of, pair_of, states_of
from valvetrain.findings.words import RPM, Amount, Words, digits_text, speed_text
from valvetrain.solution.modes import TrainModes
from valvetrain.solution.static import POINT_QUANTITIES, RestPoint
from valvetrain.views.shown import ShownStudy
from valvetrain.views.style import BAD, OTHER, RIGID, SPEEDS, FigureSpec, line, panels, styled
from valvetrain.views.table import Line, TextTable

#: Springs that are columns of the first table, and axial modes that are its rows.
COLUMNS, MODES = 4, 4
#: The steep end of a solid spring is cut above this many times the median rate.
WALL = 4.0
STATES = {"closed": "valve closed", "full_lift": "full lift"}
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
        rows = chain(_modes(words), _meetings(facts, states))
    pair, lines = pair_of(states) if _together(facts) else None, list[Line]()
    for label, read, note in rows:
        cells = [read(one) for one in states]
        if not any(cells):
            continue
        if pair is not None:
            both = {
                "installed": pair.force(0.0),
                "full lift": pair.force(pair.lift),
                "rate": pair.rate(0.0),
            }
            amount = both.get(label)
            cells.append("" if amount is None else words.amount(amount))
        bind = label == "coil bind"
        lines.append(
            bind_line(cells, note, findings, words) if bind else Line(label, tuple(cells), "", note)
        )
    return lines


def bind_line(cells: Sequence[str], note: str, findings: Findings, words: Words) -> Line:
    """The row of coil bind: as its finding says, else with a tick and the limit."""
    about = [one for one in findings.about(BIND) if one.mark != "ok"]
    mark: Mark = about[0].mark if about else "ok"
    limit = "" if about else f"{note}, limit {words.amount(Amount('coil_bind_clearance', NEAR))}"
    return Line(
        "coil bind",
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

    def shear(one: State) -> str:
        ends = [one.shear(at) for at in (one.one.precompression, one.full_lift)]
        first, last = ends
        return words.span(first, last) if first and last else said(first)

    def left(one: State) -> str:
        return "" if one.left is None else f"{said(one.left)} left"

    def point(place: int) -> Read:
        def read(one: State) -> str:
            return _point(one.one.points[place], words) if place < len(one.one.points) else ""

        return read

    yield "height", height, "installed, between the seats"
    yield "installed", lambda one: said(one.force(one.one.precompression)), ""
    yield "full lift", lambda one: said(one.force(one.full_lift)), ""
    yield "rate", lambda one: said(one.rate(one.one.precompression)), "as installed"
    yield "coil bind", left, "at full lift"
    by = "in the section" if any(one.one.stress for one in states) else "EN 13906-1"
    yield "wire, shear", shear, f"installed to full lift; {by}"
    yield from _modes(words)
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


def _meetings(facts: Facts, states: Sequence[State]) -> Iterator[tuple[str, Read, str]]:
    """The engine speeds at which cam orders meet the first axial mode, from the lowest order below the top speed."""

    def read(order: int) -> Read:
        def cell(one: State) -> str:
            return speed_text(speed_of(order, one.surge.value)) if one.surge else ""

        return cell

    first = min((one.surge.value for one in states if one.surge), default=math.nan)
    orders = orders_of(facts, first) if math.isfinite(first) else ()
    step = (orders[1] - orders[0]) // 3 if len(orders) > 1 else 1
    for k in range(MODES) if orders else ():
        yield (
            f"cam order {orders[0] + k * step}",
            read(orders[0] + k * step),
            "" if k else "meets axial mode 1",
        )


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


# -- figures ---------------------------------------------------------------------------------------


def static_curves(facts: Facts) -> go.Figure | None:
    """Force (N) and rate (N/mm) over compression (mm) of every spring, with what is marked on its curve."""
    some = [one for one in states_of(facts.study) if one.one.curve is not None]
    if not some or facts.study.command == "modes":
        return None
    fig, rates = panels((0.62, 0.38)), list[float]()
    for one, colour in zip(some, SPEEDS * len(some), strict=False):
        curve = one.one.curve
        if curve is None or len(curve.compression) < 2:
            continue
        name, at = one.name or one.one.spring, 1e3 * curve.compression
        fig.add_trace(line(at, curve.force, name, colour, legendgroup=name), 1, 1)
        more = line(at, 1e-3 * curve.stiffness, name, colour, legendgroup=name, showlegend=False)
        fig.add_trace(more, 2, 1)
        rates += (1e-3 * curve.stiffness).tolist()
    if not rates:
        return None
    top = min(max(rates), WALL * float(np.median(rates)))
    styled(fig, "compression, mm", ("force, N", "rate, N/mm"), 430)
    fig.update_yaxes(range=[0, 1.15 * top], row=2, col=1)
    for place, (word, compression) in enumerate(marks_of(some[0])):
        dash = {
            "color": BAD if word in ("solid", "buckles") else RIGID,
            "width": 1.2,
            "dash": "dot",
        }
        fig.add_vline(1e3 * compression, line=dash)
        fig.add_annotation(
            x=1e3 * compression, y=0.06 + 0.1 * place, yref="y domain", text=word, showarrow=False, xanchor="right",
            xshift=-3, font={"size": 11, "color": dash["color"]}, row=1, col=1,
        )  # fmt: skip
    return fig


def surge_orders(facts: Facts) -> go.Figure | None:
    """Where cam orders meet the first axial natural frequencies (Hz) over engine speed (rpm)."""
    states = [one for one in states_of(facts.study) if one.surge is not None]
    if not states:
        return None
    surges = [one.surge.value for one in states if one.surge is not None]
    orders = orders_of(facts, surges[0])
    first, last = (orders[0] + 4, max(orders[0] - 2, 1)) if len(orders) == 1 else orders
    low, high = 0.8 * min(surges), 1.25 * max(surges)
    least, most = 120 * min(surges) / first, 120 * max(surges) / last
    fig = go.Figure()
    for order in range(last, first + 1):
        ends = [max(least * 0.95, 120 * low / order), min(most * 1.05, 120 * high / order)]
        if ends[1] <= ends[0]:
            continue
        at = [one * order / 120 for one in ends]
        fig.add_trace(go.Scatter(
            x=ends, y=at, mode="lines+text", text=["", f"{order}"], textposition="middle right", name=f"cam order {order}",
            line={"color": OTHER, "width": 1}, showlegend=False, textfont={"size": 11, "color": OTHER},
        ))  # fmt: skip
    for one, value, colour in zip(states, surges, SPEEDS * len(states), strict=False):
        name = one.name or one.one.spring
        reach = [0.95 * least, 1.05 * most]
        fig.add_trace(line(reach, [value, value], name, colour))
        met = [120 * value / order for order in range(last, first + 1)]
        fig.add_trace(go.Scatter(
            x=met, y=[value] * len(met), mode="markers", marker={"color": colour, "size": 8}, name=name,
            showlegend=False, hovertemplate="%{x:.0f} rpm",
        ))  # fmt: skip
    styled(fig, "engine speed, rpm", ("frequency, Hz",), 380)
    red = facts.red_line / RPM
    if math.isfinite(red) and 0.95 * least < red < 1.05 * most:
        fig.add_vline(red, line={"color": BAD, "width": 1.4, "dash": "dash"})
    fig.update_layout(hovermode="closest")
    return fig.update_xaxes(tickformat="d").update_yaxes(range=[low, 1.04 * high])


def mode_shapes(facts: Facts) -> go.Figure | None:
    """Axial displacement (largest 1) along the wire of the first axial modes of the first wire."""
    for state in states_of(facts.study):
        modes = state.one.modes
        if modes is None or len(modes.coil_number) < 2:
            continue
        fig = go.Figure()
        for k, (place, colour) in enumerate(
            zip(modes.axial_modes[:MODES], SPEEDS, strict=False), 1
        ):
            frequency = digits_text(float(modes.natural_frequency[place]), 0, 4)
            along = modes.shape[place, :, 2]
            fig.add_trace(line(modes.coil_number, along, f"mode {k}, {frequency} Hz", colour))
        return styled(fig, "coil", ("axial displacement",), 320)
    return None


STATIC_CURVES = FigureSpec(
    "Force over compression",
    "from the free length; dotted: states of the first spring",
    static_curves,
)
SURGE_ORDERS = FigureSpec(
    "Where cam orders meet the surge",
    "cam order 1: once a cam revolution, two of the crank; dashed: red line",
    surge_orders,
)
MODE_SHAPES = FigureSpec("Shapes of the axial modes", "0 to peak, the largest is 1", mode_shapes)
