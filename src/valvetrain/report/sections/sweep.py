"""Over engine speed: forces, clash, surge, seating and lift by label, and the order map of the surge."""

from __future__ import annotations

import re

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Marks, Panel
from valvetrain.report.figures.common import MOST_LINES, Array, looks
from valvetrain.report.page import Block, SectionSpec, Tabs, figure_or_gap
from valvetrain.report.sections.orders import surge_orders
from valvetrain.report.words import rpm
from valvetrain.solution.definition import label_of, shown
from valvetrain.solution.study import Study

#: Drawn over engine speed, those that a study gives.
CURVES = (
    "peak_spring_force", "minimum_spring_force", "peak_retainer_force", "minimum_retainer_force", "clash_energy", "surge_amplitude_force",
    "seating_velocity", "lift_loss_displacement", "bounce_height", "loft_gap", "float_excess_lift", "minimum_cam_contact_force",
    "peak_shear_stress",
)  # fmt: skip
#: Engine speeds from which curves over them say something.
LEAST_SPEEDS = 3
_ORDER = re.compile(r"surge_order_(\d+)_force")


def blocks(study: Study) -> tuple[Block, ...]:
    """Curves, then an order map per label."""
    if len(study.engine_speeds) < LEAST_SPEEDS:
        return ()
    known, maps = looks(study), []
    for place, label in enumerate(study.labels, start=1):
        title = f"Order map: {known[label].words}"
        found = figure_or_gap(title, order_map, study, label, f"order-map-{place}", title)
        if found:
            maps.append((known[label].words, found))
    tabs: tuple[Block, ...] = (maps[0][1] if maps else ()) if len(maps) < 2 else (Tabs(tuple(maps), "order-map"),)
    return (*figure_or_gap("Over engine speed", sweep_chart, study), *tabs)


def sweep_chart(study: Study) -> Chart | None:
    """One panel per quantity, a line per label; open marks where the motion did not settle."""
    panels = []
    for name in CURVES:
        given = [label for label in study.labels if np.any(np.isfinite(study.series(label, name)[1]))]
        panels += [_panel(study, name, given[start : start + MOST_LINES]) for start in range(0, len(given), MOST_LINES)]
    if not panels:
        return None
    caption = "Each engine speed on its own. Open marks: the motion did not repeat there, its last cycle is shown."
    if study.command == "run-up":
        caption = "One value per cam turn, at its mean engine speed: the envelope of the run-up."
    return Chart("sweep", "Over engine speed", caption, tuple(panels), 2, 240 * (-(-len(panels) // 2)) + 30)


def _panel(study: Study, name: str, labels: list[str]) -> Panel:
    known, unit = looks(study), ""
    layers: list[Layer] = []
    for label in labels:
        speeds, values = study.series(label, name)
        values, unit = shown(name, values)
        x, look = np.array([rpm(speed) for speed in speeds]), known[label]
        layers.append(Line(x, values, look.words, look.colour, 1.6, look.dash))
        restless = np.array([not run.status.completed for run in study.runs(label)]) & np.isfinite(values)
        if restless.any():
            layers.append(Marks(x[restless], values[restless], f"{look.words}, not settled", look.colour, size=6, in_legend=False))
    return Panel("engine speed (rpm)", f"{label_of(name)} ({unit})" if unit else label_of(name), tuple(layers))


def order_table(study: Study, label: str) -> tuple[Array, Array, Array]:
    """Engine speeds (rad/s), cam orders and amplitudes (N; order, speed) of a label, nan where a run does not give one."""
    runs = study.runs(label)
    orders = sorted({int(found[1]) for run in runs for name in run.quantities if (found := _ORDER.fullmatch(name))})
    sizes = [[run.quantities.get(f"surge_order_{order}_force", np.nan) for run in runs] for order in orders]
    return np.array([run.engine_speed for run in runs]), np.array(orders, dtype=float), np.array(sizes).reshape(len(orders), len(runs))


def order_map(study: Study, label: str, key: str, title: str) -> Chart | None:
    """Surge amplitude (N) over engine speed and cam order, surge lines over it, thin lines of equal frequency in Hz."""
    speeds, orders, sizes = order_table(study, label)
    if len(orders) < 2 or len(speeds) < 2:
        return None
    x, top = np.array([rpm(speed) for speed in speeds]), float(orders[-1]) + 0.5
    hertz = orders[:, None] * (speeds / (4 * np.pi))[None, :]
    heat = HeatMap(x, orders, np.nan_to_num(sizes), "surge amplitude", "N", y_words="cam order", second=hertz, second_unit="Hz")
    layers: list[Layer] = [heat]
    fine = np.linspace(speeds[0], speeds[-1], 200)
    for value in _round_steps(float(hertz.max())):
        layers.append(_frequency_line(fine, value, top, f"{value:g} Hz", "#7b8794", 0.9, "dot"))
    surges = {
        words: order * run.engine_speed / (4 * np.pi) for run in study.runs(label) for words, order in surge_orders(study, run).items()
    }
    for words, value in surges.items():
        layers.append(_frequency_line(fine, value, top, words.partition("surge")[0] + "surge", theme.ALERT, 1.8, "dash"))
    panel = Panel("engine speed (rpm)", "cam order", tuple(layers), x_range=(x[0], x[-1]), y_range=(0.5, top))
    caption = (
        "Amplitude (0 to peak) of the spring force less its value at rest at the same lift, by cam order. Dashed: surge frequency; dotted: "
        "lines of equal frequency. Ridges rise where a cam order meets the surge."
    )
    return Chart(key, title, caption, (panel,), height=440, legend=False)


def _frequency_line(speeds: Array, frequency: float, top: float, words: str, colour: str, width: float, dash: str) -> Line:
    """Cam order of ``frequency`` (Hz) over engine speed (rad/s), drawn up to order ``top``, in rpm."""
    order = frequency * 4 * np.pi / speeds
    inside = order <= top
    return Line(speeds[inside] * 30 / np.pi, order[inside], words, colour, width, dash, in_legend=False, direct=words)


def _round_steps(top: float) -> list[float]:
    """Round frequencies (Hz) below ``top``, four to eight of them."""
    decade = 10.0 ** np.floor(np.log10(top / 4))
    step = next(size * decade for size in (5, 2, 1) if size * decade <= top / 4)
    return [float(step * n) for n in range(1, 9) if step * n < top]


SPEC = SectionSpec("sweep", "Over engine speed", blocks)
