"""Figures of a train's steady cycle: lift, forces, springs, coil sections, kinematics; each from a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.quantities.kinematics import RigidTable
from valvetrain.quantities.valvetrain_study import TrainRun
from valvetrain.quantities.valvetrain_traces import CycleTraces
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel, thin
from valvetrain.report.table import Table, table

Array = NDArray[np.float64]
ANGLE_LABEL = "cam angle (deg)"

#: Curve -> (unit, how it is read from the traces); what a run lacks is left out of its table.
CURVES: dict[str, tuple[str, Callable[[CycleTraces], Array | None]]] = {
    "valve lift": ("mm", lambda t: t.valve_lift * 1e3),
    "rigid valve lift": ("mm", lambda t: t.rigid_lift * 1e3),
    "valve velocity": ("m/s", lambda t: t.valve_velocity),
    "valve acceleration": ("m/s²", lambda t: t.valve_acceleration),
    "cam contact force": ("N", lambda t: t.forces.get("cam")),
    "force on the valve": ("N", lambda t: t.forces.get("valve tip")),
    "seat force": ("N", lambda t: t.forces.get("seat")),
    "spring force": ("N", lambda t: t.spring_force),
    "static spring force": ("N", lambda t: t.static_spring_force),
    "cam torque": ("N m", lambda t: t.cam_torque),
    "piston clearance": ("mm", lambda t: None if t.piston_clearance is None else t.piston_clearance * 1e3),
    "lever speed": ("deg/s", lambda t: None if t.lever_speed is None else np.degrees(t.lever_speed)),
}  # fmt: skip


def cycle_table(run: TrainRun) -> Table:
    """Every curve of one cycle over the cam angle, for the CSV beside the page."""
    assert run.traces is not None
    columns: list[tuple[str, str, Array]] = [("cam angle", "deg", np.degrees(run.traces.cam_angle))]
    for name, (unit, read) in CURVES.items():
        values = read(run.traces)
        if values is not None:
            columns.append((name, unit, values))
    return table(*columns)


def curve_chart(runs: Sequence[TrainRun], names: Sequence[str], key: str, title: str, caption: str) -> Chart:
    """One panel per curve, one line per run; both from :func:`cycle_table`."""
    tables = [(run, cycle_table(run)) for run in runs if run.traces is not None]
    panels = []
    for name in names:
        layers: list[Layer] = []
        for place, (run, data) in enumerate(tables):
            if name in data:
                rounds, hue = divmod(place, len(theme.SERIES))
                dash = ("solid", "dash", "dot")[rounds % 3]
                layers.append(Line(*thin(data["cam angle"], data[name]), run.label, theme.SERIES[hue], 1.4, dash))
        if layers:
            panels.append(Panel(ANGLE_LABEL, f"{name} ({CURVES[name][0]})", tuple(layers), x_range=(0, 360), x_step=30))
    return Chart(key, title, caption, tuple(panels), height=230 * len(panels) + 60)


def section_table(run: TrainRun, spring: int = 0) -> Table:
    """Peak displacement of every section of a spring over the cycle, share of the length from the seat."""
    assert run.traces is not None
    traces = run.traces.springs[spring]
    share = traces.coil_number / max(float(np.max(traces.coil_number)), 1e-12)
    return table(("share of the spring", "", share), ("peak displacement", "mm", traces.peak_section_displacement * 1e3))


def section_chart(runs: Sequence[TrainRun]) -> Chart | None:
    """Peak motion of the outer spring's sections along its length, all runs that tell it."""
    layers: list[Layer] = []
    for place, run in enumerate(runs):
        if run.traces is None or not run.traces.springs or not run.traces.springs[0].coil_number.size:
            continue
        data = section_table(run)
        layers.append(Line(data["share of the spring"], data["peak displacement"], run.label, theme.SERIES[place % len(theme.SERIES)]))
    if not layers:
        return None
    caption = "Largest displacement of each section over the cycle, from the seat (0) to the retainer (1)."
    panel = Panel("share of the spring's turns", "peak displacement (mm)", tuple(layers), x_range=(0, 1))
    return Chart("sections", "Motion of the coil sections of the outer spring", caption, (panel,))


def kinematics_table(rigid: RigidTable) -> Table:
    """Rigid kinematics and quasi-statics over the cam angle in the units of the trade."""
    degree = np.pi / 180
    speed = rigid.cam_speed
    columns: list[tuple[str, str, Array]] = [
        ("cam angle", "deg", np.degrees(rigid.cam_angle)), ("lift", "mm", rigid["valve_lift"] * 1e3),
        ("velocity", "mm/deg", rigid["valve_velocity"] / speed * degree * 1e3),
        ("acceleration", "mm/deg²", rigid["valve_acceleration"] / speed**2 * degree**2 * 1e3),
        ("jerk", "mm/deg³", rigid["valve_jerk"] / speed**3 * degree**3 * 1e3), ("inertia force", "N", rigid["inertia_force"]),
        ("spring force", "N", rigid["spring_force"]), ("spring margin", "N", rigid["spring_margin"]),
        ("contact force", "N", rigid["contact_force"]),
        ("cam torque", "N m", rigid["cam_torque"]), ("motion ratio", "", rigid["motion_ratio"]),
    ]  # fmt: skip
    if "contact_radius" in rigid.columns:
        columns += [("sliding velocity", "m/s", rigid["sliding_velocity"]), ("Hertz pressure", "MPa", rigid["hertz_pressure"] / 1e6)]
        columns.append(("cam radius", "mm", np.clip(rigid["contact_radius"] * 1e3, -1e3, 1e3)))
    return table(*columns)


def kinematics_chart(rigid: RigidTable) -> Chart:
    """Lift, velocity, acceleration, jerk, spring margin and Hertz pressure, stacked."""
    data = kinematics_table(rigid)
    panels = []
    for name in ("lift", "velocity", "acceleration", "jerk", "spring margin", "Hertz pressure"):
        if name in data:
            column = data.column(name)
            line = Line(*thin(data["cam angle"], column.values), name, theme.INK, 1.4, in_legend=False)
            panels.append(Panel(ANGLE_LABEL, column.header.replace("[", "(").replace("]", ")"), (line,), x_range=(0, 360), x_step=30))
    caption = (
        "Rigid parts, closed contacts: what the geometry asks for before any dynamics. The margin is spring force and weight plus "
        "inertia at the valve."
    )
    return Chart("kinematics", "Kinematics and quasi-statics", caption, tuple(panels), height=170 * len(panels) + 60, legend=False)
