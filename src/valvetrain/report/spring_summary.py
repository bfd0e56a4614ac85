"""Summary of a spring study: headline numbers on a card per engine speed and, for a case of one's own, a table of its quantities."""

from __future__ import annotations

from valvetrain.quantities.compare import same_speed
from valvetrain.quantities.study import SpringStudy
from valvetrain.report import theme
from valvetrain.report.figures.force import rod_quantity, sampling_words, source_sampled_so
from valvetrain.report.page import Card, Cell, Grid
from valvetrain.report.words import in_unit, number, quantity_words, speed_words
from valvetrain.solution.quantity import Quantity, unit_of

#: Quantities on the cards of the summary.
HEADLINES = {
    "stage_2_peak_force": "Stage II peak",
    "stage_2_second_peak_force": "Stage II second peak",
    "stage_3_peak_force": "Stage III spike",
}
#: Quantities in the table of a case without published values, those that the runs gave.
SHOWN = (
    "preload", "installed_rate", "mode_1_frequency", "mode_2_frequency", "stage_1_minimum_force", "stage_1_maximum_force",
    "stage_2_peak_force", "stage_2_peak_cam_angle", "stage_2_first_peak_force", "stage_2_valley_force", "stage_2_second_peak_force",
    "stage_2_end_force", "stage_3_peak_force", "stage_3_peak_cam_angle", "stage_3_every_instant_peak_force",
    "stage_3_below_10_khz_peak_force", "main_clash_peak_force", "main_clash_cam_angle", "clash_interval_cam_angle",
    "peak_shear_stress", "largest_amplitude_shear_stress", "dynamic_to_static_stress_ratio", "energy_imbalance_ratio",
)  # fmt: skip
_SHOWN_IN = {"rad": "deg", "Pa": "MPa", "N/m": "N/mm"}


def speed_card(study: SpringStudy, engine_speed: float) -> Card:
    """The rod's headline forces at one engine speed (rad/s) beside the published ones, where there are any."""
    lines = []
    for name, words in HEADLINES.items():
        rows = [row for row in study.comparisons if row.quantity == name and same_speed(row.engine_speed, engine_speed)]
        rod = rod_quantity(study, name, engine_speed)
        if rod is None or (study.comparisons and not rows):
            continue
        beside = ", ".join(f"{theme.origin_style(row.origin)[0]} {number(in_unit(row.published, row.unit))}" for row in rows)
        notes = [f"published {beside}"] if rows else []
        if name == "stage_3_peak_force":
            notes += _sampling(study, engine_speed)
        lines.append((words, f"{number(rod, 4)} N", "; ".join(notes)))
    return Card(speed_words(engine_speed), tuple(lines))


def _sampling(study: SpringStudy, engine_speed: float) -> list[str]:
    highest = rod_quantity(study, "stage_3_every_instant_peak_force", engine_speed)
    words = [f"sampled {sampling_words(study, engine_speed)}" + (" as in the source" if source_sampled_so(study) else "")]
    return words + ([f"highest instant {number(highest, 4)} N"] if highest is not None else [])


def quantity_grid(study: SpringStudy) -> list[Grid]:
    """Main quantities by model and engine speed; nothing for a case whose published values stand in the comparison."""
    if study.comparisons:
        return []
    caption = "Stage III peak: largest of the samples; every instant: largest of the whole record. Definitions: docs/quantities.md."
    statics = tuple((row, "") for name in SHOWN if (row := _row(name, [study.quantities.get(Quantity(name))])))
    grids = [Grid(("statics and modes", "value", "unit"), statics)] if statics else []
    speeds = study.engine_speeds
    for model in study.models:
        found = (_row(name, [_at(study, name, model, speed) for speed in speeds]) for name in SHOWN)
        rows = tuple((row, "") for row in found if row)
        if rows:
            headers = (theme.model_words(model), *(speed_words(speed) for speed in speeds), "unit")
            grids.append(Grid(headers, rows, caption=caption))
    return grids


def _row(name: str, values: list[float | None]) -> tuple[Cell, ...] | None:
    si = unit_of(name)
    unit = _SHOWN_IN.get(si, "" if si == "1" else si)
    if all(value is None for value in values):
        return None
    words = [number(None if value is None else in_unit(value, unit), 4) for value in values]
    return Cell(quantity_words(name), hint=name), *(Cell(word, "number") for word in words), Cell(unit, "quiet")


def _at(study: SpringStudy, name: str, model: str, engine_speed: float) -> float | None:
    mine = ((key.engine_speed, value) for key, value in study.quantities.items() if (key.name, key.label) == (name, model))
    return next((value for speed, value in mine if same_speed(speed, engine_speed)), None)
