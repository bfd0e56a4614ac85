"""Figures of a speed sweep: forces, seating and loft over engine speed, order map of the surge."""

from __future__ import annotations

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Panel, Rule
from valvetrain.report.table import Table, table
from valvetrain.report.words import rpm
from valvetrain.studies.sweep import SweepSeries, TrainSweep

#: Column -> (words, unit, factor from SI).
SHOWN: dict[str, tuple[str, str, float]] = {
    "peak_open_cam_contact_force": ("peak cam contact force", "N", 1.0), "minimum_cam_contact_force": ("least cam contact force", "N", 1.0),
    "peak_open_valve_tip_contact_force": ("peak force on the valve", "N", 1.0),
    "minimum_valve_tip_contact_force": ("least force on the valve", "N", 1.0), "peak_seat_contact_force": ("peak seat force", "N", 1.0),
    "lift_loss_displacement": ("lift loss", "mm", 1e3), "seating_velocity": ("seating velocity", "m/s", 1.0),
    "bounce_height": ("bounce height", "mm", 1e3), "bounce_count": ("bounces", "", 1.0), "loft_gap": ("loft", "mm", 1e3),
    "float_excess_lift": ("lift above rigid (float)", "mm", 1e3), "peak_retainer_force": ("peak spring force", "N", 1.0),
    "minimum_retainer_force": ("least spring force", "N", 1.0), "motion_period_count": ("period in cycles (0: none)", "", 1.0),
    "steady_cycles_count": ("cycles to steady state", "", 1.0),
}  # fmt: skip
PANELS = (
    "peak_open_cam_contact_force", "minimum_cam_contact_force", "lift_loss_displacement", "seating_velocity",
    "bounce_height", "float_excess_lift",
)  # fmt: skip


def sweep_table(series: SweepSeries) -> Table:
    """All columns of one series over the engine speed."""
    columns = [("engine speed", "rpm", np.array([rpm(speed) for speed in series.engine_speeds]))]
    columns += [("status", "", np.array([status.code for status in series.statuses], dtype=object))]
    columns += [(SHOWN[name][0], SHOWN[name][1], values * SHOWN[name][2]) for name, values in series.columns.items()]
    return table(*columns)


def order_table(series: SweepSeries) -> Table:
    """Surge amplitude (N, 0 to peak) by cam order, one row per engine speed."""
    speeds = ("engine speed", "rpm", np.array([rpm(speed) for speed in series.engine_speeds]))
    return table(speeds, *((f"order {order}", "N", series.orders[:, order]) for order in range(1, series.orders.shape[1])))


def sweep_chart(sweep: TrainSweep) -> Chart:
    """Six panels over engine speed, one line per series; the float speeds are ruled."""
    tables = [sweep_table(series) for series in sweep.series]
    panels = []
    for name in PANELS:
        words, unit, _ = SHOWN[name]
        layers: list[Layer] = [
            Line(data["engine speed"], data[words], series.label, theme.SERIES[place % len(theme.SERIES)])
            for place, (series, data) in enumerate(zip(sweep.series, tables, strict=True))
        ]
        floats = sorted({round(rpm(series.float_engine_speed)) for series in sweep.series if np.isfinite(series.float_engine_speed)})
        rules = tuple(Rule("x", float(value), f"float {value}") for value in floats)
        panels.append(Panel("engine speed (rpm)", f"{words} ({unit})" if unit else words, tuple(layers), rules=rules))
    caption = (
        "Steady state at each speed; where the motion does not repeat (status 'not-converged'), the last cycle computed. Rules mark the "
        "speed from which the train floats: it runs more than 0.05 mm above its rigid lift."
    )
    return Chart("sweep", "Forces, seating and float over engine speed", caption, tuple(panels), columns=2, height=780)


def order_chart(series: SweepSeries, key: str) -> Chart:
    """Campbell map: surge amplitude over engine speed and cam order."""
    data = order_table(series)
    orders = np.arange(1, series.orders.shape[1])
    z = np.array([data[f"order {order}"] for order in orders])
    layer = HeatMap(data["engine speed"], orders.astype(float), np.nan_to_num(z), "surge amplitude", "N")
    caption = (
        "Amplitude (0 to peak) of the spring force less its static value at the same lift, per cam order. Ridges rise where an "
        "order meets a surge mode."
    )
    return Chart(key, f"Order map, {series.label}", caption, (Panel("engine speed (rpm)", "cam order", (layer,)),), height=420)
