"""Cam orders of the spring force: bars by engine speed, the surge order marked."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.spectrum import order_spectrum
from valvetrain.report.chart import Chart, Layer, Line, Panel, Rule
from valvetrain.report.figures.common import MOST_LINES, Array, bars, looks, panels_chart, runs_at
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.words import number, speed_words
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

LARGEST_ORDER = 40


def blocks(study: Study) -> tuple[Block, ...]:
    """One figure, a panel per engine speed."""
    return figure_or_gap("Cam orders of the spring force", order_chart, study)


def dynamic_orders(run: Solution) -> tuple[Array, Array] | None:
    """Cam orders and amplitudes (N, 0 to peak) of the retainer force less its value at rest at the same lift; None without a whole cycle.

    Quantities ``surge_order_n_force`` are taken where the run gives them, so that page and numbers are the same.
    """
    named = {n: run.quantities[f"surge_order_{n}_force"] for n in range(1, LARGEST_ORDER + 1) if f"surge_order_{n}_force" in run.quantities}
    if named:
        return np.array(list(named), dtype=float), np.array(list(named.values()))
    if not run.has("retainer_force", "static_retainer_force") or not reported_cycle(run).whole:
        return None
    force = run.arrays["retainer_force"]
    dynamic = force._replace(values=force.values - run.channel("static_retainer_force"))
    spectrum = order_spectrum(reported_cycle(run.with_channels({"dynamic": dynamic})), "dynamic", LARGEST_ORDER)
    return spectrum.order[1:], spectrum.amplitude[1:]


def surge_orders(study: Study, run: Solution) -> dict[str, float]:
    """Words -> cam order of the surge frequencies that are known of a run."""
    found = {}
    places = (run.quantities, *(study.still.get(label, {}) for label in (run.label, run.model, "")))
    for name in ("surge_frequency", *(f"{spring}_surge_frequency" for spring in run.springs)):
        value = next((one[name] for one in places if name in one), None)
        if value is not None and run.engine_speed > 0:
            whose = name.removesuffix("surge_frequency").replace("_", " ")
            found[f"{whose}surge {number(value)} Hz"] = value * 4 * np.pi / run.engine_speed
    return found


def order_chart(study: Study) -> Chart | None:
    """Bars of the dynamic force per cam order; None where no run gives them."""
    known, panels = looks(study), []
    for engine_speed in study.engine_speeds:
        found = [(run, *given) for run in runs_at(study, engine_speed) if (given := dynamic_orders(run)) is not None]
        for start in range(0, len(found), MOST_LINES):
            part = found[start : start + MOST_LINES]
            layers: list[Layer] = []
            for place, (run, orders, sizes) in enumerate(part):
                x, y = bars(orders, sizes, place, len(part))
                layers.append(Line(x, y, known[run.label].words, known[run.label].colour, max(2.0, 8.0 / len(part))))
            last = max(float(orders.max()) for _, orders, _ in part)
            marks = {round(order, 3): words for run, _, _ in part for words, order in surge_orders(study, run).items() if order <= last}
            rules = tuple(Rule("x", order, words) for order, words in list(marks.items())[:3])
            tall = max(float(np.nanmax(sizes)) for _, _, sizes in part)
            y_label, span = "dynamic spring force (N, 0 to peak)", (0.0, 1.12 * tall or 1.0)
            panels.append(
                Panel(
                    "cam order (oscillations per cam turn)",
                    y_label,
                    tuple(layers),
                    speed_words(engine_speed),
                    (),
                    rules,
                    (0.0, last + 1),
                    span,
                )
            )
    caption = "Force on the retainer less its value at rest at the same lift, by cam order; dotted: order of the surge frequency."
    return panels_chart("orders", "Cam orders of the spring force", caption, panels, 260)


SPEC = SectionSpec("orders", "Cam orders", blocks)
