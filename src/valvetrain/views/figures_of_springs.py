"""Figures of springs: gaps between coils, cam orders of surge, strength, at rest."""

from __future__ import annotations

import math

import numpy as np
import plotly.graph_objects as go

from valvetrain.findings.engine import SPRINGS
from valvetrain.findings.facts import Facts, over_turn
from valvetrain.findings.rules_rest import IN_USE, lift_of, orders_of, strongest
from valvetrain.findings.springs_at_rest import marks_of, pair_of, states_of
from valvetrain.findings.words import RPM, digits_text, speed_text
from valvetrain.parameters.material import FATIGUE_RANGES
from valvetrain.units import to_unit
from valvetrain.units.reader import shown_system
from valvetrain.views.style import (
    BAD,
    OTHER,
    RIGID,
    SPEEDS,
    FigureSpec,
    angle_title,
    degrees,
    line,
    panels,
    red_line,
    styled,
    window,
)

#: Cam orders that are drawn, from the first that a valve spring answers to.
ORDERS = range(3, 31)
#: The steep end of a solid spring is cut above this many times the median rate.
WALL = 4.0
#: Share by which surge frequencies differ whose cam orders are both labelled.
APART = 0.02
#: Share of the largest lift of an order in use from which one is labelled, so that no label covers another.
LABELLED = 0.25
#: Opacity of an order above the speeds in use.
PALE = 0.3
#: Axial modes whose shapes are drawn.
MODES = 4


def coils(facts: Facts) -> go.Figure | None:
    """Gap (mm) between neighbouring coils over the cam angle, of the fastest run that knows its coils."""
    every = (
        (run, run.channel_of(one, "coil_gap"))
        for run in reversed(facts.runs)
        for one in run.springs
    )
    run, name = next(((run, name) for run, name in every if run.has(name)), (None, ""))
    if run is None:
        return None
    gaps, uppers = over_turn(run, name), run.arrays.along(name)
    if uppers is None or gaps.ndim != 2:
        return None
    coil_numbers = np.unique(uppers.round())  # one point of the wire stands for a coil
    places = [int(np.argmin(np.abs(uppers - one))) for one in coil_numbers]
    fig = go.Figure()
    for place, colour in zip(places, SPEEDS * len(places), strict=False):
        upper = uppers[place]
        values = 1e3 * gaps[:, place]
        fig.add_trace(line(degrees(run), values, f"{upper - 1:.3g}–{upper:.3g}", colour))
    return styled(fig, angle_title(facts, run), ("gap, mm",)).update_xaxes(range=window(run))


def orders(facts: Facts) -> go.Figure | None:
    """Amplitude (N) of each cam order of the spring force, of up to four runs."""
    runs = [run for run in facts.runs if "surge_order_3_force" in run.quantities][-4:]
    if not runs:
        return None
    fig = go.Figure()
    for run, colour in zip(runs, SPEEDS, strict=False):
        sizes = [run.quantities.get(f"surge_order_{one}_force", 0.0) for one in ORDERS]
        name = f"{run.label * facts.several}, {speed_text(run.engine_speed)}".lstrip(", ")
        fig.add_trace(go.Bar(x=list(ORDERS), y=sizes, name=name, marker_color=colour))
    fig.update_layout(barmode="group")
    return styled(fig, "cam order", ("N",), 300)


def strength(facts: Facts) -> go.Figure | None:
    """Largest over least corrected shear (MPa) of every run, with the swings that spring steels bore without end and the
    static limit of the wire; None where the strength of no wire is known.
    """
    names = ("closed_nominal", "open_nominal", "open_uncorrected", "permitted")
    fig, bounds, top = go.Figure(), dict[str, float](), 0.0
    fig.add_trace(line([0.0, 1.0], [0.0, 1.0], "no change of stress", RIGID, "dot"))
    for prefix in SPRINGS:
        runs = (*facts.runs, *facts.beyond)
        found = [
            [1e-6 * facts.value(run, f"{prefix}{name}_shear_stress") for name in names]
            for run in runs
        ]
        known = [(one, run) for one, run in zip(found, runs, strict=True) if np.isfinite(one).all()]
        if not known or (
            not prefix and any("outer_open_nominal_shear_stress" in run.quantities for run in runs)
        ):
            continue
        spring = prefix.rstrip("_") or "spring"
        texts = [f"{run.label}, {speed_text(run.engine_speed)}" for _, run in known]
        least, peak = ([one[place] for one, _ in known] for place in (0, 1))
        fig.add_trace(go.Scatter(
            x=least, y=peak, mode="markers", name=spring, text=texts, hovertemplate="%{text}: %{x:.0f} to %{y:.0f} MPa",
            marker={"size": 8},
        ))  # fmt: skip
        one = known[0][0]
        bounds[spring] = one[3] * one[1] / one[2]
        top = max(top, *peak, bounds[spring])
    if not bounds:
        return None
    borne = [(1e-6 * low, 1e-6 * high) for low, high in FATIGUE_RANGES.values()]
    fig.add_trace(go.Scatter(
        x=[low for low, _ in borne], y=[high for _, high in borne], mode="markers+text", name="borne without end (Zimmerli 1957)",
        text=list(FATIGUE_RANGES), textposition="top right", marker={"size": 8, "symbol": "diamond-open", "color": OTHER},
    ))  # fmt: skip
    for spring, bound in bounds.items():
        fig.add_hline(
            bound, line={"color": BAD, "width": 1.2}, annotation_text=f"static limit, {spring}"
        )
    top = 1.08 * max(top, *(high for _, high in borne))
    fig.data[0].update(x=[0.0, top], y=[0.0, top])
    styled(fig, "least shear of the cycle, MPa", ("largest shear, MPa",), 400)
    return fig.update_layout(hovermode="closest").update_yaxes(range=[0.0, top])


COILS = FigureSpec("Gaps between coils", "smallest gap of each pair; 0: the coils touch", coils)
ORDERS_OF_SURGE = FigureSpec(
    "What makes the spring surge",
    "amplitude (0 to peak) of each cam order of the spring force less its static value",
    orders,
)
STRENGTH = FigureSpec(
    "Stress and strength of the wire",
    "corrected shear by EN 13906-1; the higher above the dotted line, the larger the swing",
    strength,
)


def static_curves(facts: Facts) -> go.Figure | None:
    """Force (N) and rate (N/mm) over compression (mm) of every spring, of a pair over the lift (mm) and with both
    together, with what is marked on the curve of the first.
    """
    some = [one for one in states_of(facts.study) if one.one.curve is not None]
    if not some or facts.study.command == "modes":
        return None
    pair = pair_of(tuple(some))
    from_installed = pair is not None  # else from the free length
    curves = [
        (one.name or one.one.spring, one.one.curve.compression - from_installed * one.one.precompression,
         one.one.curve.force, one.one.curve.stiffness)
        for one in some
        if one.one.curve is not None and len(one.one.curve.compression) > 1
    ]  # fmt: skip
    if not curves:
        return None
    if pair is not None:
        curves.insert(0, (pair.name, *pair.curve()))
    fig, rates = panels((0.62, 0.38)), np.concatenate([1e-3 * rate for *_, rate in curves])
    for (name, at, force, rate), colour in zip(curves, SPEEDS * len(curves), strict=False):
        fig.add_trace(line(1e3 * at, force, name, colour, legendgroup=name), 1, 1)
        more = line(1e3 * at, 1e-3 * rate, name, colour, legendgroup=name, showlegend=False)
        fig.add_trace(more, 2, 1)
    top = min(float(rates.max()), WALL * float(np.median(rates)))
    title = "compression, mm" if pair is None else "lift, mm"
    styled(fig, title, ("force, N", "rate, N/mm"), 430)
    fig.update_yaxes(range=[0, 1.15 * top], row=2, col=1)
    marked = (
        some[0]
        if pair is None
        else min(pair.pair, key=lambda one: one.left.value if one.left else math.inf)
    )
    for place, (word, compression) in enumerate(marks_of(marked)):
        dash = {
            "color": BAD if word in ("solid", "buckles") else RIGID,
            "width": 1.2,
            "dash": "dot",
        }
        here = 1e3 * (compression - from_installed * marked.one.precompression)
        fig.add_vline(here, line=dash)
        fig.add_annotation(
            x=here, y=0.06 + 0.1 * place, yref="y domain", text=word, showarrow=False, xanchor="right",
            xshift=-3, font={"size": 11, "color": dash["color"]}, row=1, col=1,
        )  # fmt: skip
    return fig


def surge_orders(facts: Facts) -> go.Figure | None:
    """Where cam orders meet the first axial natural frequencies (Hz) over engine speed (rpm), and how much of the lift (µm or
    thou) each of them has there.
    """
    states = [one for one in states_of(facts.study) if one.surge is not None]
    if not states:
        return None
    surges = [one.surge.value for one in states if one.surge is not None]
    first, *more = orders_of(facts, min(surges))
    last = more[0] if more else max(first - 2, 1)
    best = [order for one in surges for order in strongest(facts, one)]
    first = first if more else max(first + 4, *best)
    low, high = 0.8 * min(surges), 1.25 * max(surges)
    least, most = 120 * min(surges) / first, 120 * max(surges) / last
    orders = {order: lift_of(facts, order) for order in range(last, first + 1)}
    unit = "µm" if shown_system() == "si" else "thou"
    lifts = {order: to_unit(one.value, unit) for order, one in orders.items() if one is not None}
    top = (facts.study.record.top_speed or math.inf) / RPM
    tall = max((lifts[order] for order in best if lifts), default=0.0)
    fig = panels((0.62, 0.38) if lifts else (1.0,))
    for order in orders:
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
        fig.add_trace(line(reach, [value, value], name, colour), 1, 1)
        met = [120 * value / order for order in orders]
        far = value == surges[0] or abs(value / surges[0] - 1) > APART
        fig.add_trace(go.Scatter(
            x=met, y=[value] * len(met), mode="markers", name=name, showlegend=False, marker={"color": colour, "size": 8},
            hovertemplate="%{x:.0f} rpm",
        ), 1, 1)  # fmt: skip
        for speed, order in zip(met, orders, strict=True) if lifts else ():
            size = lifts[order]
            named = far and size > LABELLED * tall
            fig.add_trace(go.Scatter(
                x=[speed, speed], y=[0.0, size], mode="lines+markers+text", text=["", f"{order}" * named], textposition="top center", name=name,
                line={"color": colour, "width": 2}, marker={"size": [0, 6]}, showlegend=False, textfont={"size": 11, "color": colour},
                opacity=1.0 if speed <= top else PALE,
            ), 2, 1)  # fmt: skip
    titles = ("frequency, Hz", f"lift, {unit}")
    styled(fig, "engine speed, rpm", titles[: 1 + bool(lifts)], 430)
    if 0.95 * least < top < 1.05 * most:
        red_line(fig, top, IN_USE[facts.study.record.red_line is None])
    fig.update_layout(hovermode="closest")
    fig.update_yaxes(range=[low, 1.04 * high], row=1, col=1)
    if lifts:
        fig.update_yaxes(range=[0.0, 1.25 * tall], row=2, col=1)
    return fig.update_xaxes(tickformat="d")


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
    "Force at rest",
    "from the free length, of a pair from the closed valve; dotted: states of the spring that binds first",
    static_curves,
)
SURGE_ORDERS = FigureSpec(
    "Where cam orders meet the surge",
    "cam order 1: once a cam revolution, two of the crank; below how much of the lift has the order, 0 to peak, pale above the speeds in use",
    surge_orders,
)
MODE_SHAPES = FigureSpec("Shapes of the axial modes", "0 to peak, the largest is 1", mode_shapes)
