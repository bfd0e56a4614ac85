"""Spring force over the cam angle, with published values marked, and the spikes after the event close up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.analysis.compare import same_speed
from valvetrain.analysis.cycle import reported_cycle
from valvetrain.analysis.filters import fine_filtered, fine_series
from valvetrain.analysis.stages import Stages
from valvetrain.analysis.study import SpringStudy
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Marks, Panel, thin
from valvetrain.report.table import Table, table
from valvetrain.report.words import number, rpm, speed_words
from valvetrain.solution.result import Solution

ANGLE_LABEL = "cam angle (cam degrees)"
SPIKE_BANDWIDTH = 10e3
SPIKE_WINDOW = (225.0, 320.0)


def runs_at(study: SpringStudy, engine_speed: float) -> list[Solution]:
    """Runs at one engine speed (rad/s), those with at least two samples."""
    return [run for run in study.solutions if same_speed(run.engine_speed, engine_speed) and len(run.time) > 2]


def force_table(study: SpringStudy, engine_speed: float) -> Table:
    """Columns ``run`` (model), ``cam angle`` (deg) and ``force`` (N) over the reported cycle."""
    models, angles, forces = [], [], []
    for run in runs_at(study, engine_speed):
        cycle = reported_cycle(run)
        models += [run.model] * len(cycle.cam_angle)
        angles.append(np.degrees(cycle.cam_angle))
        forces.append(cycle.channel("seat_force"))
    return table(("run", "", np.array(models, dtype=object)), ("cam angle", "deg", _joined(angles)), ("force", "N", _joined(forces)))


def spike_table(study: SpringStudy, engine_speed: float, window: tuple[float, float] = SPIKE_WINDOW) -> Table:
    """As :func:`force_table` within ``window`` (deg), as finely as the runs hold it, with ``below 10 kHz`` (N).

    The last column is nan where the samples do not allow it and for models without coils to clash.
    """
    models, angles, forces, smooth = [], [], [], []
    for run in runs_at(study, engine_speed):
        cycle = reported_cycle(run)
        turn = run.cam_angle[cycle.samples][0] - cycle.cam_angle[0]
        _, angle, values = fine_series(run)
        filtered = fine_filtered(run, SPIKE_BANDWIDTH) if run.has("coil_contact_force") else None
        degrees = np.degrees(angle - turn)
        near = (degrees >= window[0] - 1e-9) & (degrees <= window[1] + 1e-9)
        models += [run.model] * int(np.sum(near))
        angles.append(degrees[near])
        forces.append(values[near])
        smooth.append(np.full(int(np.sum(near)), np.nan) if filtered is None else filtered[near])
    return table(
        ("run", "", np.array(models, dtype=object)), ("cam angle", "deg", _joined(angles)),
        ("force", "N", _joined(forces)), ("below 10 kHz", "N", _joined(smooth)),
    )  # fmt: skip


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    return np.concatenate(parts) if parts else np.zeros(0)


def published_forces(study: SpringStudy, engine_speed: float) -> Table:
    """Published forces that have an angle: ``origin``, ``quantity``, ``cam angle`` (deg), ``force`` (N), ``angle of``.

    A force printed without its angle takes the angle that another origin prints for the same quantity; ``angle of`` says whose.
    """
    values = [value for value in study.case.published if same_speed(value.engine_speed, engine_speed)]
    angles = {(value.model, value.quantity): value.value for value in values if value.quantity.endswith("_cam_angle")}
    rows = []
    for value in values:
        if not value.quantity.startswith("stage_") or not value.quantity.endswith("_force"):
            continue
        wanted = value.quantity.removesuffix("_force") + "_cam_angle"
        whose = [value.model, *(model for model, name in angles if name == wanted)]
        angle = next(((angles[model, wanted], model) for model in whose if (model, wanted) in angles), None)
        if value.quantity == "stage_2_end_force":
            angle = (Stages().second_end, "the stage")
        if angle is not None:
            rows.append((value.model, value.quantity, float(np.degrees(angle[0])), value.value, angle[1]))
    columns = list(zip(*rows, strict=True)) or [(), (), (), (), ()]
    return table(
        ("origin", "", np.array(columns[0], dtype=object)), ("quantity", "", np.array(columns[1], dtype=object)),
        ("cam angle", "deg", np.array(columns[2], dtype=float)), ("force", "N", np.array(columns[3], dtype=float)),
        ("angle of", "", np.array(columns[4], dtype=object)),
    )  # fmt: skip


def stage_bands(stages: Stages = Stages()) -> tuple[Band, ...]:
    """The three stages as bands of a panel over the cam angle."""
    names = {1: "Stage I", 2: "Stage II", 3: "Stage III"}
    edges = {stage: np.degrees(stages.bounds(stage)) for stage in names}
    return tuple(Band(float(edges[stage][0]), float(edges[stage][1]), names[stage], shaded=stage == 2) for stage in names)


def model_lines(data: Table, column: str, suffix: str = "") -> list[Line]:
    """One line per model of a long table with columns ``run``, ``cam angle`` and ``column``."""
    lines: list[Line] = []
    for model in dict.fromkeys(data["run"].tolist()):
        mine = data["run"] == model
        x, y = thin(data["cam angle"][mine], data[column][mine])
        if np.any(np.isfinite(y)):
            lines.append(Line(x, y, theme.model_words(model) + suffix, theme.model_colour(model)))
    # The reference model is drawn last, on top of the simpler ones.
    return sorted(lines, key=lambda line: line.colour == theme.model_colour("finite-element"))


def published_marks(published: Table, with_words: bool = True) -> list[Layer]:
    """One set of marks per origin, labelled with the sign of the origin and the value."""
    marks: list[Layer] = []
    for origin in dict.fromkeys(published["origin"].tolist()):
        mine = published["origin"] == origin
        sign, words, colour, symbol = theme.origin_style(origin)
        labels = tuple(f"{sign} {number(force, 4)}" if with_words else "" for force in published["force"][mine].tolist())
        marks.append(Marks(published["cam angle"][mine], published["force"][mine], words, colour, symbol, labels))
    return marks


def force_chart(data: Table, published: Table, engine_speed: float) -> Chart:
    """Force of every model over one cam cycle with the published values."""
    layers = (*model_lines(data, "force"), *published_marks(published))
    panel = Panel(ANGLE_LABEL, "force on the lower seat (N)", layers, bands=stage_bands(), x_range=(0, 360), x_step=30)
    speed = speed_words(engine_speed)
    caption = (
        f"Force on the lower seat over the reported cam cycle at {speed} (crank), cam speed half of it. Open marks are published values: "
        "FE solid finite elements, AN analytical modal model, EX engine head test."
    )
    return Chart(f"force-{rpm(engine_speed):g}", f"Spring force at {speed}", caption, (panel,), height=430)


def spike_chart(data: Table, published: Table, engine_speed: float, window: tuple[float, float] = SPIKE_WINDOW) -> Chart:
    """The same force close up after the event, raw and below 10 kHz."""
    # Darker than the raw line, so that the two part where they lie on each other.
    filtered = model_lines(data, "below 10 kHz", ", below 10 kHz")
    smooth = [replace(line, colour=theme.mix(line.colour, theme.INK, 0.75), dash="dash") for line in filtered]
    layers = (*model_lines(data, "force"), *smooth, *published_marks(published))
    panel = Panel(ANGLE_LABEL, "force on the lower seat (N)", layers, x_range=window, x_step=5)
    speed = speed_words(engine_speed)
    caption = (
        f"Stage III at {speed} close up. A spike's height depends on the bandwidth it is seen in: the dashed line is the rod's force "
        "through a zero-phase low-pass (6 dB down at 10 kHz), the solid one is as computed, at every instant recorded."
    )
    return Chart(f"spikes-{rpm(engine_speed):g}", f"Stage III at {speed}", caption, (panel,), height=400)
