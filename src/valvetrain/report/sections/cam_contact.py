"""Over the cam angle what the cam contact has to carry: spring margin by rigid theory, and its Hertz
pressure.
"""

from __future__ import annotations

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel, Rule, thin
from valvetrain.report.page import Block, SectionSpec, Tabs, figure_or_gap, text
from valvetrain.report.run_charts import (
    ANGLE_LABEL,
    Array,
    angle_panels,
    by_speed,
    drawable,
    event_bands,
    line_styles,
    over_angle,
    panels_chart,
)
from valvetrain.report.sections.lift_by_speed import picked
from valvetrain.report.text import amount, number, speed_text
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

MARGIN, PRESSURE, RIGID_PRESSURE = (
    "rigid_spring_margin",
    "cam_contact_pressure",
    "rigid_hertz_pressure",
)
#: Share of the largest margin up to which two labels, as of two models of one spring, share a figure.
ALIKE = 2e-3
NEEDS = (
    "The contact pressure of cam and follower needs bodies in the plane and a follower with a face: train.model = 'planar', "
    "train.cam.base_radius and train.cam.width, train.follower.shape = 'flat', 'domed' or 'roller' with its radius."
)


def margin_blocks(study: Study) -> tuple[Block, ...]:
    """A figure per label, a line per engine speed; labels with the same margin share one."""
    known, seen, items = line_styles(study), list[Array](), []
    for place, label in enumerate(study.labels, start=1):
        runs = picked([run for run in study.runs(label) if over_angle(run, MARGIN) is not None])
        values = np.concatenate([run.channel(MARGIN) for run in runs]) if runs else np.zeros(0)
        alike = (
            np.max(np.abs(one - values)) < ALIKE * np.max(np.abs(one))
            for one in seen
            if one.shape == values.shape
        )
        if not values.size or any(alike):
            continue
        seen.append(values)
        title = f"Spring margin: {known[label].label}"
        found = figure_or_gap(title, margin_chart, study, runs, f"spring-margin-{place}", title)
        items.append((known[label].label, found))
    if len(items) < 2:
        return items[0][1] if items else ()
    return (Tabs(tuple(items), "spring-margin"),)


def margin_chart(study: Study, runs: list[Solution], key: str, title: str) -> Chart | None:
    """Surplus of the spring (N) while the rigid valve is open, a line per engine speed, and the
    spring force at rest; None where no valve opens.
    """
    colours, layers, least = theme.ramp(len(runs), "#66a3d2", "#12294f"), list[Layer](), []
    strongest = 0.0
    for run, colour in zip(runs, colours, strict=True):
        found, lift = over_angle(run, MARGIN), over_angle(run, "rigid_valve_lift")
        if found is None or lift is None or not np.any(lift[1] > 0):
            continue
        margin = np.where(lift[1] > 0, found[1], np.nan)
        layers.append(Line(*thin(found[0], margin), speed_text(run.engine_speed), colour, 1.5))
        place = int(np.nanargmin(margin))
        least.append((float(margin[place]), float(found[0][place]) % 360, run.engine_speed))
        still = over_angle(run, "static_retainer_force")
        if still is not None:
            strongest = max(strongest, float(np.max(still[1])))
            if len(layers) == 1:
                layers.insert(
                    0, Line(*thin(*still), "spring force at rest", theme.MUTED, 1.2, "dash")
                )
    if not least:
        return None
    low, at, speed = min(least)
    span = max(strongest, low, 1.0)
    panel = Panel(
        ANGLE_LABEL,
        "spring margin (N)",
        tuple(layers),
        bands=event_bands(study),
        rules=(Rule("y", 0.0, "contact is lost below"),),
        x_range=(0, 360),
        x_step=30,
        y_range=(min(0.0, low) - 0.08 * span, 1.15 * span),
    )
    caption = (
        "Spring force at rest and inertia of rigid parts at the valve, less weight and gas: what presses the train on its cam. Least: "
        f"{amount(low, 'N')} at {number(at, 4)} cam degrees and {speed_text(speed)}; on the flanks the cam pushes, and the line leaves the figure."
    )
    return Chart(key, title, caption, (panel,), height=330)


MARGIN_SPEC = SectionSpec("spring-margin", "Spring margin", margin_blocks)


def pressure_blocks(study: Study) -> tuple[Block, ...]:
    """A figure per engine speed, behind tabs; a sentence where a train's contact has no pressure."""

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        title = f"Contact pressure of the cam at {speed_text(engine_speed)}"
        return figure_or_gap(title, pressure_chart, study, runs, key, title)

    found = by_speed(study, "cam-pressure", at)
    trains = any(drawable(run) and run.has("cam_contact_force") for run in study.solutions)
    return found or ((text(NEEDS, "note"),) if trains else ())


def pressure_chart(study: Study, runs: list[Solution], key: str, title: str) -> Chart | None:
    """Hertz pressure (MPa) of every run, and that of rigid parts, dashed; None without any."""
    panels = angle_panels(
        study, runs, PRESSURE, "contact pressure", still=RIGID_PRESSURE, static_label="rigid parts"
    )
    peaks = [
        (float(np.max(found[1])), float(found[0][int(np.argmax(found[1]))]) % 360)
        for run in runs
        if (found := over_angle(run, PRESSURE)) is not None
    ]
    if not peaks:
        return None
    top, angle = max(peaks)
    caption = (
        "Line contact of cam and follower by Hertz over the width of the cam, p0 = sqrt(F E* / (pi b R)), both with the cam's elastic data, "
        f"edges and crowning left out. Largest: {amount(top * 1e-6, 'MPa')} at {number(angle, 4)} cam degrees."
    )
    return panels_chart(key, title, caption, panels, 270)


PRESSURE_SPEC = SectionSpec("cam-pressure", "Contact pressure of the cam", pressure_blocks)
