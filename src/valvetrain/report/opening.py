"""The picture that opens the page of a study: the worst run over the cam angle next to its motion,
regimes over engine speed, or the static curve of springs at rest.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.quantities.train_events import counted_losses
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Panel, Rule, thin
from valvetrain.report.clash_clauses import FINEST
from valvetrain.report.motion.parts import Variant
from valvetrain.report.motion.project import motion_json, still_svg
from valvetrain.report.motion.scene import moving_picture
from valvetrain.report.page import Block, Motion, figure_or_gap, gap
from valvetrain.report.run_charts import (
    MAX_LINES,
    STATIC_LABEL,
    angle_panels,
    from_zero,
    over_angle,
    runs_at,
)
from valvetrain.report.run_clauses import judged_runs, run_clauses, worst_run
from valvetrain.report.sections import at_rest
from valvetrain.report.sweep_chart import regime_chart
from valvetrain.report.text import amount, number, speed_text
from valvetrain.solution.partial_failures import reason
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.system.contract import TRAIN

#: What models are compared in; the verdict names the one that has least of it.
PEAK = "peak_spring_force"
#: Height of the panel of the lift next to that of the force, which shows more.
LIFT_WEIGHT = 0.6
#: A limit further above the curve than this share of its span is not drawn.
NEAR = 0.35


def opening_blocks(study: Study) -> tuple[Block, ...]:
    """The picture of a study, one or two blocks; nothing where nothing can be drawn."""
    if _is_over_speed(study):
        return figure_or_gap("Control over engine speed", regime_chart, study)
    if not study.solutions:
        return figure_or_gap("Spring at rest", at_rest.opening_chart, study)
    return (*figure_or_gap("Over the cam angle", run_chart, study), *motion_blocks(study))


def opening_chart(study: Study) -> Chart | None:
    """The figure that opens the page, without the moving picture; None without any."""
    if not study.solutions:
        return at_rest.opening_chart(study)
    return regime_chart(study) if _is_over_speed(study) else run_chart(study)


def _is_over_speed(study: Study) -> bool:
    return study.over_speed and len(study.engine_speeds) > 1


def run_chart(study: Study) -> Chart | None:
    """Lift and cam force of the worst speed of a train, the force of a spring alone; None without
    channels.
    """
    run, runs = _drawn_runs(study)
    if run is None or not runs:
        return None
    train = any(one.provenance.system == TRAIN for one in runs)
    panels = _train_panels(study, runs) if train else _spring_panels(study, runs)
    if not panels:
        return None
    worst = ", the worst speed" if len(study.engine_speeds) > 1 else ""
    what = "Valve lift and cam force" if train else "Spring force"
    caption = (
        "Dashed: rigid parts. Where the cam force reaches zero in the lift event, contact is lost."
        if train
        else "On the cylinder head."
    )
    if any(isinstance(one, Line) and one.name == STATIC_LABEL for one in panels[0].layers):
        caption += " Dashed: what a spring without inertia would give at the same lift."
    height = 50 + round(200 * sum(one.weight for one in panels)) if train else 340
    return Chart(
        "opening",
        f"{what} at {speed_text(run.engine_speed)}{worst}",
        caption,
        tuple(panels),
        1,
        height,
    )


def _drawn_runs(study: Study) -> tuple[Solution | None, list[Solution]]:
    """The worst run, else the last, and those of its speed that the figure draws."""
    run = worst_run(judged_runs(study)) or next(iter(study.solutions[::-1]), None)
    return run, [] if run is None else _shown_runs(study, run, runs_at(study, run.engine_speed))


def _shown_runs(study: Study, worst: Solution, runs: list[Solution]) -> list[Solution]:
    """At most :data:`MAX_LINES` of the runs of a speed: the worst one, others that the verdict names, then
    those by the finest models.
    """
    named = {id(one.run) for one in run_clauses(judged_runs(study))}
    if peaks := [(run.quantities[PEAK], id(run)) for run in runs if PEAK in run.quantities]:
        named.add(min(peaks)[1])
    fine = {model: place for place, model in enumerate(FINEST)}

    def key(run: Solution) -> tuple[bool, bool, int]:
        return run is not worst, id(run) not in named, fine.get(run.model, len(fine))

    chosen = {id(run) for run in sorted(runs, key=key)[:MAX_LINES]}
    return [run for run in runs if id(run) in chosen]


def _train_panels(study: Study, runs: list[Solution]) -> list[Panel]:
    lift = angle_panels(
        study,
        runs,
        "valve_lift",
        "valve lift",
        still="rigid_valve_lift",
        static_label="rigid parts",
    )[:1]
    force = angle_panels(
        study,
        runs,
        "cam_contact_force",
        "cam contact force",
        still="rigid_contact_force",
        static_label="rigid parts",
    )[:1]
    bind = [1e3 * value for value in _of_case(study, "coil_bind_lift")]
    lift = [_limited(panel, min(bind, default=np.nan), "coil bind") for panel in lift]
    lift = [replace(panel, weight=LIFT_WEIGHT) for panel in lift]
    return [*lift, *map(from_zero, force)]


def _spring_panels(study: Study, runs: list[Solution]) -> list[Panel]:
    panels = angle_panels(study, runs, "seat_force", "spring force", "", "static_retainer_force")[
        :1
    ]
    given = any(one.has("static_retainer_force") for one in runs)
    still = () if given else _static_line(study, runs[0])
    panels = [replace(one, layers=(*still, *one.layers)) for one in panels]
    preload = min(_of_case(study, "preload"), default=np.nan)
    solid = min(_of_case(study, "solid_force"), default=np.nan)
    marked = []
    for panel in panels:
        found = _limited(panel, solid, "solid")
        if np.isfinite(preload):
            rule = Rule("y", float(preload), f"preload {amount(float(preload), 'N', 3)}")
            found = replace(found, rules=(*found.rules, rule))
        marked.append(found)
    return marked


def _static_line(study: Study, run: Solution) -> tuple[Line, ...]:
    """What the static curve gives at the same lift; none for several springs or without a curve."""
    rest, lift = study.at_rest(run.model) or study.at_rest(), over_angle(run, "valve_lift")
    if rest is None or rest.curve is None or lift is None or len(run.springs) > 1:
        return ()
    compression = rest.precompression + lift[1]
    inside = (compression >= rest.curve.compression[0]) & (
        compression <= rest.curve.compression[-1]
    )
    force = np.interp(compression, rest.curve.compression, rest.curve.force)
    line = thin(lift[0], np.where(inside, force, np.nan))
    return (Line(*line, STATIC_LABEL, theme.MUTED, 1.2, "dash"),)


def _limited(panel: Panel, limit: float, label: str) -> Panel:
    """The panel with a limit across it, where that is near the curves."""
    values = np.concatenate([np.asarray(one.y, dtype=float) for one in panel.layers])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if not low < limit < high + NEAR * (high - low):
        return panel
    top = max(high, limit) + 0.09 * (high - low)
    rule = Rule("y", float(limit), f"{label} {number(float(limit), 3)}")
    return replace(panel, rules=(*panel.rules, rule), y_range=(low - 0.07 * (high - low), top))


def _of_case(study: Study, name: str) -> list[float]:
    """Finite values of a quantity, those of the springs of a pair included."""
    return [
        value
        for key, value in study.quantities.items()
        if (key.name == name or key.name.endswith(f"_{name}")) and np.isfinite(value)
    ]


def motion_blocks(study: Study) -> tuple[Block, ...]:
    """The moving picture; nothing where no run moves, a sentence where it fails."""
    try:
        worst = worst_run(judged_runs(study))
        moving = moving_picture(study, worst=worst)
        if moving is None:
            return ()
        first = _first_shown(study, moving.variants, worst)
        others = tuple(one for one in moving.variants if one is not first)
        moving = replace(moving, variants=(first, *others))
        caption = (
            f"{first.title}. The reported cam revolution, slowed. "
            "Drag or use the arrow keys on the picture to turn it; space plays, arrow keys step by one cam "
            "degree, with shift by ten, page keys go from mark to mark. Triangles on the slider are peaks of the force, orange strokes "
            "clashes."
        )
        return (Motion("in-motion", moving.title, caption, motion_json(moving), still_svg(first)),)
    except Exception as error:  # one picture must not cost the page
        return (gap(f"The moving picture could not be drawn: {reason(error)}"),)


def _first_shown(study: Study, variants: tuple[Variant, ...], worst: Solution | None) -> Variant:
    """The variant that shows most of its wire among those at the speed and of the spring set of the
    worst run that the figure draws and that lose contact if that does; the worst run itself where others show no
    more.
    """
    if worst is None:
        return variants[0]
    flies = bool(counted_losses(worst.events))
    alike = {
        run.label
        for run in _drawn_runs(study)[1]
        if run.spring_set == worst.spring_set and bool(counted_losses(run.events)) == flies
    }
    known = [
        one for one in variants if one.engine_speed == worst.engine_speed and one.label in alike
    ]
    return max(
        known or variants,
        key=lambda one: (
            sum(len(spring.colourings) for spring in one.springs),
            one.label == worst.label,
        ),
    )
