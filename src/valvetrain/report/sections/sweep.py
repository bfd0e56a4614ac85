"""Over engine speed: forces, clash, surge, seating and lift by label, and the order map of the
surge.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.forces import order_spectrum
from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Marks, Panel, Rule
from valvetrain.report.page import (
    Block,
    Cell,
    Details,
    Grid,
    SectionSpec,
    Tabs,
    figure_or_gap,
    text,
)
from valvetrain.report.run_charts import (
    MAX_LINES,
    Array,
    bars,
    line_styles,
    panels_chart,
    runs_at,
    with_between,
)
from valvetrain.report.run_summary import CRITICAL_LEGEND, critical_notes, critical_rows, searched
from valvetrain.report.text import axis_label, number, rpm, speed_text
from valvetrain.solution.definition import definition_of, names_for, shown
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

MAX_ORDER = 40


def orders_blocks(study: Study) -> tuple[Block, ...]:
    """One figure, a panel per engine speed."""
    return figure_or_gap("Cam orders of the spring force", order_chart, study)


def dynamic_orders(run: Solution) -> tuple[Array, Array] | None:
    """Cam orders and amplitudes (N, 0 to peak) of the retainer force less its value at rest at the
    same lift; None without a whole cycle.

    Quantities ``surge_order_n_force`` are taken where the run gives them, so that page and numbers
    are the same.
    """
    named = {
        n: run.quantities[f"surge_order_{n}_force"]
        for n in range(1, MAX_ORDER + 1)
        if f"surge_order_{n}_force" in run.quantities
    }
    if named:
        return np.array(list(named), dtype=float), np.array(list(named.values()))
    if not run.has("retainer_force", "static_retainer_force") or not reported_cycle(run).whole:
        return None
    force = run.arrays["retainer_force"]
    dynamic = force._replace(values=force.values - run.channel("static_retainer_force"))
    spectrum = order_spectrum(
        reported_cycle(run.with_channels({"dynamic": dynamic})), "dynamic", MAX_ORDER
    )
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
    nested = {line: order for line, order in found.items() if not line.startswith("surge")}
    return nested or found  # of a pair its own springs


def order_chart(study: Study) -> Chart | None:
    """Bars of the dynamic force per cam order; None where no run gives them."""
    known, panels = line_styles(study), []
    for engine_speed in study.engine_speeds:
        found = [
            (run, *given)
            for run in runs_at(study, engine_speed)
            if (given := dynamic_orders(run)) is not None
        ]
        for start in range(0, len(found), MAX_LINES):
            part = found[start : start + MAX_LINES]
            layers: list[Layer] = []
            for place, (run, orders, sizes) in enumerate(part):
                x, y = bars(orders, sizes, place, len(part))
                layers.append(
                    Line(
                        x,
                        y,
                        known[run.label].label,
                        known[run.label].colour,
                        max(2.0, 8.0 / len(part)),
                    )
                )
            last = max(float(orders.max()) for _, orders, _ in part)
            marks = {
                round(order, 3): label
                for run, _, _ in part
                for label, order in surge_orders(study, run).items()
                if order <= last
            }
            rules = tuple(Rule("x", order, label) for order, label in list(marks.items())[:3])
            tall = max(float(np.nanmax(sizes)) for _, _, sizes in part)
            y_label, span = "dynamic spring force (N, 0 to peak)", (0.0, 1.12 * tall or 1.0)
            panels.append(
                Panel(
                    "cam order (oscillations per cam revolution)",
                    y_label,
                    tuple(layers),
                    speed_text(engine_speed),
                    (),
                    rules,
                    (0.0, last + 1),
                    span,
                )
            )
    caption = "Force on the retainer less its value at rest at the same lift, by cam order; dotted: order of the surge frequency."
    return panels_chart("orders", "Cam orders of the spring force", caption, panels, 260)


ORDERS_SPEC = SectionSpec("orders", "Cam orders", orders_blocks)


#: Engine speeds from which curves over them say something.
MIN_SPEEDS = 3
#: Topics of quantities as titles of tabs.
_SHORT = {
    "Spring force and coil bind": "Forces", "Coil clash": "Clash", "Seating and contact": "Contact", "Wire stress": "Stress",
    "Loss of control": "Control",
}  # fmt: skip
_ORDER = re.compile(r"surge_order_(\d+)_force")


def sweep_blocks(study: Study) -> tuple[Block, ...]:
    """Curves, then an order map per label."""
    if len(study.engine_speeds) < MIN_SPEEDS:
        return ()
    known, maps = line_styles(study), []
    for place, label in enumerate(study.labels, start=1):
        title = f"Order map: {known[label].label}"
        found = figure_or_gap(title, order_map, study, label, f"order-map-{place}", title)
        if found:
            maps.append((known[label].label, found))
    curves = [
        (title, figure_or_gap(title, sweep_chart, study, title, names, place))
        for place, (title, names) in enumerate(curve_topics().items())
    ]
    orders = [(f"Orders: {label}" if len(maps) > 1 else "Orders", found) for label, found in maps]
    shown = tuple((title, found) for title, found in (*curves, *orders) if found)
    return (shown[0][1] if shown else ()) if len(shown) < 2 else (Tabs(shown, "sweep"),)


def curve_topics() -> dict[str, tuple[str, ...]]:
    """Short title -> quantities that are drawn over engine speed, in the order of the topics."""
    found: dict[str, list[str]] = {}
    for name in names_for("curve"):
        topic = definition_of(name).topic
        found.setdefault(_SHORT.get(topic, topic or "Contact"), []).append(name)
    return {title: tuple(names) for title, names in found.items()}


def sweep_chart(study: Study, topic: str, names: Sequence[str], place: int) -> Chart | None:
    """One panel per quantity of a topic, a line per label; open marks where the motion did not
    settle.
    """
    panels = []
    for name in names:
        given = [
            label for label in study.labels if np.any(np.isfinite(study.series(label, name)[1]))
        ]
        panels += [
            _panel(study, name, given[start : start + MAX_LINES])
            for start in range(0, len(given), MAX_LINES)
        ]
    if not panels:
        return None
    caption = "Each engine speed on its own, those between the swept ones too. Open marks: the motion did not repeat there, its last cycle is shown."
    key = f"sweep-{place}" if place else "sweep"
    columns = min(len(panels), 2)
    height = 240 * (-(-len(panels) // 2)) + 30
    return Chart(key, f"{topic} over engine speed", caption, tuple(panels), columns, height)


def _panel(study: Study, name: str, labels: list[str]) -> Panel:
    known, unit = line_styles(study), ""
    layers: list[Layer] = []
    for label in labels:
        speeds, values = with_between(study, label, name)
        values, unit = shown(name, values)
        x, look = np.array([rpm(speed) for speed in speeds]), known[label]
        layers.append(Line(x, values, look.label, look.colour, 1.6, look.dash))
        open_runs = [run.engine_speed for run in study.runs(label) if not run.status.completed]
        restless = np.isin(speeds, open_runs) & np.isfinite(values)
        if restless.any():
            layers.append(
                Marks(
                    x[restless],
                    values[restless],
                    f"{look.label}, not settled",
                    look.colour,
                    size=6,
                    in_legend=False,
                )
            )
    return Panel(
        "engine speed (rpm)",
        f"{axis_label(name)} ({unit})" if unit else axis_label(name),
        tuple(layers),
    )


def order_table(study: Study, label: str) -> tuple[Array, Array, Array]:
    """Engine speeds (rad/s), cam orders and amplitudes (N; order, speed) of a label, nan where a
    run does not give one.
    """
    runs = study.runs(label)
    orders = sorted(
        {
            int(found[1])
            for run in runs
            for name in run.quantities
            if (found := _ORDER.fullmatch(name))
        }
    )
    sizes = [
        [run.quantities.get(f"surge_order_{order}_force", np.nan) for run in runs]
        for order in orders
    ]
    return (
        np.array([run.engine_speed for run in runs]),
        np.array(orders, dtype=float),
        np.array(sizes).reshape(len(orders), len(runs)),
    )


def order_map(study: Study, label: str, key: str, title: str) -> Chart | None:
    """Surge amplitude (N) over engine speed and cam order, surge lines over it, thin lines of equal
    frequency in Hz.
    """
    speeds, orders, sizes = order_table(study, label)
    if len(orders) < 2 or len(speeds) < 2:
        return None
    x, top = np.array([rpm(speed) for speed in speeds]), float(orders[-1]) + 0.5
    hertz = orders[:, None] * (speeds / (4 * np.pi))[None, :]
    heat = HeatMap(
        x,
        orders,
        np.nan_to_num(sizes),
        "surge amplitude, 0 to peak",
        "N",
        y_tick_labels="cam order",
        second=hertz,
        second_unit="Hz",
    )
    layers: list[Layer] = [heat]
    fine = np.linspace(speeds[0], speeds[-1], 200)
    for value in _round_steps(float(hertz.max())):
        layers.append(_frequency_line(fine, value, top, f"{value:g} Hz", "#7b8794", 0.9, "dot"))
    surges = {
        line: order * run.engine_speed / (4 * np.pi)
        for run in study.runs(label)
        for line, order in surge_orders(study, run).items()
    }
    for line, value in surges.items():
        layers.append(
            _frequency_line(
                fine, value, top, line.partition("surge")[0] + "surge", theme.ALERT, 1.8, "dash"
            )
        )
    panel = Panel(
        "engine speed (rpm)", "cam order", tuple(layers), x_range=(x[0], x[-1]), y_range=(0.5, top)
    )
    caption = (
        "Amplitude (0 to peak) of the spring force less its value at rest at the same lift, by cam order. Dashed: surge frequency; dotted: "
        "lines of equal frequency. Ridges rise where a cam order meets the surge."
    )
    return Chart(key, title, caption, (panel,), height=440, legend=False)


def _frequency_line(
    speeds: Array, frequency: float, top: float, label: str, colour: str, width: float, dash: str
) -> Line:
    """Cam order of ``frequency`` (Hz) over engine speed (rad/s), drawn up to order ``top``, in rpm."""
    order = frequency * 4 * np.pi / speeds
    inside = order <= top
    return Line(
        speeds[inside] * 30 / np.pi,
        order[inside],
        label,
        colour,
        width,
        dash,
        in_legend=False,
        direct=label,
    )


def _round_steps(top: float) -> list[float]:
    """Round frequencies (Hz) below ``top``, four to eight of them."""
    decade = 10.0 ** np.floor(np.log10(top / 4))
    step = next((size * decade for size in (5, 2) if size * decade <= top / 4), decade)
    return [float(step * n) for n in range(1, 9) if step * n < top]


SWEEP_SPEC = SectionSpec("sweep", "Over engine speed", sweep_blocks)


def critical_blocks(study: Study) -> tuple[Block, ...]:
    """A table of critical speeds, a column per label, and how they were searched."""
    if not searched(study) or not len(study.critical_speeds):
        return ()
    known, labels = line_styles(study), study.labels
    rows = tuple(
        (
            (
                Cell(row.label if row.main else f"\u00a0\u00a0{row.label}"),
                *(Cell(cell, "number wraps" if row.main else "number") for cell in row.cells),
            ),
            (),
        )
        for row in critical_rows(study, labels)
    )
    headers = (
        "engine speed (rpm)",
        *(known[label].label if label in known else label for label in labels),
    )
    notes = tuple(text(sentence, "note") for sentence in critical_notes(study))
    return (
        Grid(headers, rows),
        text(CRITICAL_LEGEND, "quiet"),
        *((Details("How they were searched", notes),) if notes else ()),
    )


CRITICAL_SPEC = SectionSpec("critical-speeds", "Critical speeds", critical_blocks)
