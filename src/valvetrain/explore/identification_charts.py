"""Figures of an identification: marginals, pairs, measured against predicted, profiles."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.identification_summary import datum_label, density_label, title_of
from valvetrain.explore.identified import Branch, Identified
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.units import unit_factor

Array = NDArray[np.float64]
#: Bins of a marginal, correlation from which a pair is drawn, most pairs and most rows of the dot
#: plot, most points of a cloud.
BINS, STRONG, PAIRS, ROWS, CLOUD = 36, 0.5, 6, 60, 1200


def marginals_chart(found: Identified) -> Chart:
    """What the data make of each prior; of a linearised posterior its normal curve."""
    panels = []
    for place, one in enumerate(found.unknowns):
        scale = unit_factor(one.unit)
        low, high = _reach(found, place)
        at = np.linspace(low, high, 121)
        work = np.asarray(one.prior.work(at))
        slope = 1.0 / at if one.prior.logarithmic else 1.0
        prior = np.exp(one.prior.log_density(work)) * slope * scale
        layers: list[Layer] = [
            Line(at / scale, prior, "prior", theme.MUTED, 1.2, "dash", place == 0)
        ]
        for number, branch in enumerate(found.branches):
            name = "posterior" if len(found.branches) == 1 else f"branch {number + 1}"
            curve = _density(found, branch, number, place, low, high)
            layers.append(
                Line(
                    curve[0] / scale,
                    curve[1] * scale,
                    name,
                    theme.SERIES[number % len(theme.SERIES)],
                    1.7,
                    "solid",
                    place == 0,
                )
            )
        best = found.branches[0].quantities[one.name].best / scale
        panels.append(
            Panel(
                title_of(one),
                density_label(one),
                tuple(layers),
                x_range=(low / scale, high / scale),
                rules=(Rule("x", best),),
            )
        )
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    return Chart(
        "marginals",
        "Each quantity before and after the data",
        "Thin line: the likeliest value.",
        tuple(panels),
        columns,
        240 * rows,
    )


def _reach(found: Identified, place: int) -> tuple[float, float]:
    """Stretch of a quantity of its posterior, with a margin for the prior about it."""
    name, prior = found.names[place], found.unknowns[place].prior
    low = min(branch.quantities[name].low for branch in found.branches)
    high = max(branch.quantities[name].high for branch in found.branches)
    room = 0.8 * (high - low) if high > low else abs(high) or 1.0
    ends = prior.value(np.array(prior.work_bounds))
    return max(float(ends[0]), low - room), min(float(ends[1]), high + room)


def _density(
    found: Identified, branch: Branch, number: int, place: int, low: float, high: float
) -> tuple[Array, Array]:
    if found.evidence_kind == "linearised":
        interval, prior = branch.quantities[found.names[place]], found.unknowns[place].prior
        at = np.linspace(low, high, 241)
        work, middle = np.asarray(prior.work(at)), float(prior.work(interval.best))
        spread = interval.deviation / (interval.best if prior.logarithmic else 1.0)
        slope = 1.0 / at if prior.logarithmic else 1.0
        height = branch.share / (abs(spread) * np.sqrt(2 * np.pi)) if spread else 0.0
        return at, height * np.exp(-0.5 * ((work - middle) / (spread or 1.0)) ** 2) * slope
    here, interval = found.branch_of == number, branch.quantities[found.names[place]]
    room = 0.4 * (interval.high - interval.low)
    if room > 0:
        low, high = max(low, interval.low - room), min(high, interval.high + room)
    heights, edges = np.histogram(
        found.values[here, place], BINS, (low, high), weights=found.weights[here]
    )
    heights = heights / np.diff(edges)
    return np.repeat(edges, 2), np.concatenate([[0.0], np.repeat(heights, 2), [0.0]])


def pairs_chart(found: Identified) -> Chart | None:
    """Draws of the pairs that depend on each other most; None where none does."""
    strength = np.max([np.abs(branch.correlation) for branch in found.branches], axis=0)
    pairs = [
        pair
        for pair in itertools.combinations(range(len(found.names)), 2)
        if strength[pair] >= STRONG
    ]
    pairs = sorted(pairs, key=lambda pair: -strength[pair])[:PAIRS]
    if not pairs:
        return None
    order = np.random.default_rng(1).choice(
        len(found.weights), min(CLOUD, len(found.weights)), p=found.weights
    )
    panels = []
    for number, (one, other) in enumerate(pairs):
        first, second = found.unknowns[one], found.unknowns[other]
        layers = tuple(
            Marks(
                found.values[order][found.branch_of[order] == branch, one]
                / unit_factor(first.unit),
                found.values[order][found.branch_of[order] == branch, other]
                / unit_factor(second.unit),
                "draws" if len(found.branches) == 1 else f"branch {branch + 1}",
                theme.SERIES[branch % len(theme.SERIES)],
                size=3.0,
                filled=True,
                in_legend=number == 0,
            )
            for branch in range(len(found.branches))
        )
        correlation = found.branches[0].correlation[one, other]
        panels.append(
            Panel(title_of(first), title_of(second), layers, f"correlation {correlation:+.2f}")
        )
    columns = min(2, len(panels))
    caption = "Draws of the posterior. A narrow stretch says that the data know a combination of the two better than either."
    return Chart(
        "pairs",
        "Quantities that depend on each other",
        caption,
        tuple(panels),
        columns,
        300 * -(-len(panels) // columns),
    )


def dots_chart(found: Identified) -> Chart:
    """Every measurement and its prediction, in standard deviations of the measurement."""
    rows = list(found.predicted[:ROWS])
    height = np.arange(len(rows), 0, -1, dtype=float)
    off = np.array(
        [[one.datum.deviation(value) for value in (one.low, one.middle, one.high)] for one in rows],
        dtype=float,
    )
    gap = np.full(len(rows), np.nan)
    hints = tuple(f"{datum_label(one.datum)}: percentile {one.percentile:.1f}" for one in rows)
    layers: list[Layer] = [
        Line(
            np.stack([off[:, 0], off[:, 2], gap], 1).ravel(),
            np.stack([height, height, gap], 1).ravel(),
            "computed, 95 %",
            theme.SERIES[0],
            3.0,
        )
    ]
    for used, phrase, colour in (
        (True, "fitted", theme.SERIES[0]),
        (False, "compared only", theme.SERIES[1]),
    ):
        here = np.array([one.datum.used is used for one in rows])
        if here.any():
            reported = tuple(hint for hint, one in zip(hints, here, strict=True) if one)
            layers.append(
                Marks(
                    off[here, 1],
                    height[here],
                    f"median, {phrase}",
                    colour,
                    size=8.0,
                    filled=True,
                    hints=reported,
                )
            )
    reach = min(max(4.0, 1.1 * float(np.nanmax(np.abs(off), initial=0.0))), 40.0)
    along = tuple(
        (float(at), _short(datum_label(one.datum))) for at, one in zip(height, rows, strict=True)
    )
    panel = Panel(
        "off by (standard deviations)",
        "",
        tuple(layers),
        y_tick_labels=along,
        x_range=(-reach, reach),
        y_range=(0.3, len(rows) + 0.7),
        rules=(Rule("x", -2.0), Rule("x", 0.0, "measured"), Rule("x", 2.0)),
    )
    left = len(found.predicted) - len(rows)
    caption = "Computed less measured; the name of each shows on it. Thin lines: the measured value and two standard deviations."
    caption += f" {left} more are in the table." if left else ""
    return Chart(
        "dots",
        "In standard deviations of each measurement",
        caption,
        (panel,),
        1,
        120 + 26 * len(rows),
    )


def _short(phrase: str) -> str:
    return phrase if len(phrase) < 44 else f"{phrase[:20]} … {phrase[-20:]}"


def profiles_chart(found: Identified) -> Chart | None:
    """Least misfit over each profiled quantity; None without profiles."""
    if not found.profiles:
        return None
    panels = []
    for one in found.profiles:
        unknown = found.unknowns[found.names.index(one.name)]
        rise = one.misfit - np.nanmin(one.misfit)
        layer = Line(
            one.values / unit_factor(unknown.unit), rise, "", theme.SERIES[0], in_legend=False
        )
        marks = Marks(layer.x, layer.y, "", theme.SERIES[0], size=5.0, filled=True, in_legend=False)
        panels.append(
            Panel(
                title_of(unknown),
                "misfit above the minimum",
                (layer, marks),
                rules=(Rule("y", 1.0, "68 %"), Rule("y", 3.84, "95 %")),
            )
        )
    columns = min(2, len(panels))
    caption = "Least sum of squared scaled misses with the quantity at each value, all others free. A flat curve: the data do not determine it."
    return Chart(
        "profiles",
        "Profiles",
        caption,
        tuple(panels),
        columns,
        280 * -(-len(panels) // columns),
        legend=False,
    )
