"""Spring force over the cam angle, with published values marked, and the spikes after the event close up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.quantities.compare import same_speed
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.filters import fine_filtered, fine_series
from valvetrain.quantities.stages import Stages, stages_of
from valvetrain.quantities.study import SpringStudy
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Layer, Line, Marks, Panel, thin
from valvetrain.report.table import Table, table
from valvetrain.report.words import number, rpm, speed_words
from valvetrain.solution.result import Solution

ANGLE_LABEL = "cam angle (cam degrees)"
SPIKE_BANDWIDTH = 10e3
#: The close-up begins this far (cam deg) before the end of Stage II and ends this far after it.
SPIKE_REACH = (8.0, 87.0)


def spike_window(stages: Stages) -> tuple[float, float]:
    """First and last cam angle (deg) of the close-up of Stage III."""
    end = float(np.degrees(stages.second_end))
    return round(end - SPIKE_REACH[0], 6), min(round(end + SPIKE_REACH[1], 6), 360.0)


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


def spike_table(study: SpringStudy, engine_speed: float) -> Table:
    """As :func:`force_table` about the end of Stage II, as finely as the runs hold it, with ``below 10 kHz`` (N).

    The last column is nan where the samples do not allow it and for models without coils to clash.
    A case without stages has no rows.
    """
    stages = stages_of(study.case.lift_law)
    window = (0.0, -1.0) if stages is None else spike_window(stages)
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
    stages = stages_of(study.case.lift_law)
    for value in values:
        if not value.quantity.startswith("stage_") or not value.quantity.endswith("_force"):
            continue
        wanted = value.quantity.removesuffix("_force") + "_cam_angle"
        whose = [value.model, *(model for model, name in angles if name == wanted)]
        angle = next(((angles[model, wanted], model) for model in whose if (model, wanted) in angles), None)
        if value.quantity == "stage_2_end_force" and stages is not None:
            angle = (stages.second_end, "the stage")
        if angle is not None:
            rows.append((value.model, value.quantity, float(np.degrees(angle[0])), value.value, angle[1]))
    columns = list(zip(*rows, strict=True)) or [(), (), (), (), ()]
    return table(
        ("origin", "", np.array(columns[0], dtype=object)), ("quantity", "", np.array(columns[1], dtype=object)),
        ("cam angle", "deg", np.array(columns[2], dtype=float)), ("force", "N", np.array(columns[3], dtype=float)),
        ("angle of", "", np.array(columns[4], dtype=object)),
    )  # fmt: skip


def stage_bands(stages: Stages | None = Stages()) -> tuple[Band, ...]:
    """The three stages as bands of a panel over the cam angle; nothing without stages."""
    if stages is None:
        return ()
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


def sampling_words(study: SpringStudy, engine_speed: float) -> str:
    """How densely the runs at a speed are sampled: ``every 0.5 cam degrees``; empty without runs."""
    steps = [float(np.degrees(np.median(np.diff(run.cam_angle)))) for run in runs_at(study, engine_speed)]
    return f"every {number(min(steps), 3)} cam degrees" if steps else ""


def source_sampled_so(study: SpringStudy) -> bool:
    """Whether the published values come from records known to be sampled every 0.5 cam degrees (gu2021)."""
    return any(value.source.startswith("gu2021") for value in study.case.published)


def force_chart(study: SpringStudy, data: Table, engine_speed: float) -> Chart:
    """Force of every model over one cam cycle with the published values."""
    published = published_forces(study, engine_speed)
    layers = (*model_lines(data, "force"), *published_marks(published))
    bands = stage_bands(stages_of(study.case.lift_law))
    panel = Panel(ANGLE_LABEL, "force on the lower seat (N)", layers, bands=bands, x_range=(0, 360), x_step=30)
    speed = speed_words(engine_speed)
    caption = f"Force on the lower seat over the reported cam cycle at {speed} (crank), cam speed half of it, drawn from its samples "
    caption += f"{sampling_words(study, engine_speed)}." + _origin_words(published)
    return Chart(f"force-{rpm(engine_speed):g}", f"Spring force at {speed}", caption, (panel,), height=430)


def _origin_words(published: Table) -> str:
    """What the open marks are, where there are any."""
    origins = dict.fromkeys(published["origin"].tolist())
    known = {"FE": "FE solid finite elements", "AN": "AN analytical modal model", "EX": "EX engine head test"}
    signs = [theme.origin_style(origin)[0] for origin in origins]
    return f" Open marks are published values: {', '.join(known.get(sign, sign) for sign in signs)}." if signs else ""


def spike_chart(study: SpringStudy, data: Table, engine_speed: float) -> Chart:
    """The same force close up after the event, raw and below 10 kHz; for a case with stages."""
    stages = stages_of(study.case.lift_law) or Stages()
    # Darker than the raw line, so that the two part where they lie on each other.
    filtered = model_lines(data, "below 10 kHz", ", below 10 kHz")
    smooth = [replace(line, colour=theme.mix(line.colour, theme.INK, 0.75), dash="dash") for line in filtered]
    layers = (*model_lines(data, "force"), *smooth, *published_marks(published_forces(study, engine_speed)))
    panel = Panel(ANGLE_LABEL, "force on the lower seat (N)", layers, x_range=spike_window(stages), x_step=5)
    speed = speed_words(engine_speed)
    caption = (
        f"Stage III at {speed} close up. A spike's height depends on the bandwidth it is seen in: the dashed line is the rod's force "
        "through a zero-phase low-pass (6 dB down at 10 kHz), the solid one is as computed, at every instant recorded."
    )
    return Chart(
        f"spikes-{rpm(engine_speed):g}", f"Stage III at {speed}", caption + _spike_words(study, engine_speed), (panel,), height=400
    )


def _spike_words(study: SpringStudy, engine_speed: float) -> str:
    """The two heights of the rod's spike and which sampling each is from."""
    sampled, highest = (rod_quantity(study, f"stage_3_{word}peak_force", engine_speed) for word in ("", "every_instant_"))
    if sampled is None:
        return ""
    words = f" The Stage III spike of cards and tables, {number(sampled, 4)} N, is the largest of the samples "
    words += sampling_words(study, engine_speed) + (", as the source sampled." if source_sampled_so(study) else ".")
    return words + (f" The highest instant recorded is {number(highest, 4)} N." if highest is not None else "")


def rod_quantity(study: SpringStudy, name: str, engine_speed: float) -> float | None:
    """A named quantity of the rod model at an engine speed (rad/s), SI, or None."""
    rod = ((key, value) for key, value in study.quantities.items() if key.name == name and key.label == "finite-element")
    return next((value for key, value in rod if same_speed(key.engine_speed, engine_speed)), None)
