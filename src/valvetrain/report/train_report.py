"""Report pages of trains: the study of a case, a comparison of spring models, a speed sweep."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from valvetrain.quantities.valvetrain_study import TrainRun, TrainStudy
from valvetrain.quantities.valvetrain_traces import channels
from valvetrain.report.comparison_grid import comparison_grid, comparison_table
from valvetrain.report.earlier_files import remove_earlier
from valvetrain.report.figures import sweep as sweep_figures
from valvetrain.report.figures import train as train_figures
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, Tabs, text
from valvetrain.report.table import Table, table
from valvetrain.report.values import case_rows
from valvetrain.report.words import number, quantity_words, rpm, speed_words
from valvetrain.report.write import ReportFiles, write_page
from valvetrain.solution.atomic import write_text
from valvetrain.solution.netcdf import save_netcdf
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.studies.sweep import TrainSweep

#: Numbers of the summary table, with (unit shown, factor from SI).
SUMMARY: dict[str, tuple[str, float]] = {
    "nose_cam_contact_force": ("N", 1.0), "peak_open_cam_contact_force": ("N", 1.0), "minimum_cam_contact_force": ("N", 1.0),
    "peak_open_valve_tip_contact_force": ("N", 1.0), "peak_seat_contact_force": ("N", 1.0), "peak_retainer_force": ("N", 1.0),
    "minimum_retainer_force": ("N", 1.0), "peak_valve_lift": ("mm", 1e3), "lift_loss_displacement": ("mm", 1e3),
    "seating_velocity": ("m/s", 1.0),
    "bounce_height": ("mm", 1e3), "loft_gap": ("mm", 1e3), "peak_lever_speed": ("deg/s", 180 / np.pi),
    "outer_mean_peak_section_displacement": ("mm", 1e3), "minimum_piston_clearance_gap": ("mm", 1e3), "clash_count": ("", 1.0),
    "steady_cycles_count": ("", 1.0), "steady_residual_ratio": ("", 1.0), "steady_tolerance_ratio": ("", 1.0),
    "motion_period_count": ("", 1.0),
    "time_step_duration": ("µs", 1e6), "steps_per_cycle_count": ("", 1.0),
}  # fmt: skip
#: Names of the summary in the words people use; the rest are told by `quantity_words`.
SUMMARY_WORDS = {
    "nose_cam_contact_force": "Cam force at the nose", "peak_open_cam_contact_force": "Peak cam force",
    "minimum_cam_contact_force": "Least cam force",
    "peak_open_valve_tip_contact_force": "Peak force on the valve tip", "peak_seat_contact_force": "Peak seat force",
    "peak_retainer_force": "Peak spring force", "minimum_retainer_force": "Least spring force",
    "lift_loss_displacement": "Lift lost (rigid less computed)", "loft_gap": "Loft", "peak_lever_speed": "Peak lever rotation speed",
    "outer_mean_peak_section_displacement": "Outer spring, mean peak motion of the coils",
    "minimum_piston_clearance_gap": "Least clearance to the piston",
    "clash_count": "Coil clashes", "steady_cycles_count": "Cycles run until settled",
    "steady_residual_ratio": "Last change per cycle", "steady_tolerance_ratio": "Change accepted as settled",
    "motion_period_count": "Cycles per repetition (0: never repeats)",
    "time_step_duration": "Time step", "steps_per_cycle_count": "Steps per cycle",
}  # fmt: skip


def solution_of(study: TrainStudy, run: TrainRun) -> Solution:
    """A run as the package's one result object, ready to be saved."""
    assert run.traces is not None
    provenance = collect_provenance(study.case.name, run.spring_model, engine_speed=run.engine_speed, citations=study.provenance.citations)
    statistics = {name: float(value) for name, value in run.quantities.items()}
    return Solution(channels(run.traces), run.events, run.status, statistics, provenance)


def summary_table(runs: Sequence[TrainRun]) -> Table:
    """One column per run, one row per headline number, in the units shown."""
    names = [name for name in SUMMARY if any(name in run.quantities for run in runs)]
    words = np.array([SUMMARY_WORDS.get(name) or quantity_words(name) for name in names], dtype=object)
    units = np.array([SUMMARY[name][0] for name in names], dtype=object)
    columns = [("quantity", "", words), ("unit", "", units)]
    for run in runs:
        values = np.array([run.quantities.get(name, np.nan) * SUMMARY[name][1] for name in names])
        columns.append((f"{run.label}, {speed_words(run.engine_speed)}", "", values))
    return table(*columns)


def event_table(runs: Sequence[TrainRun]) -> Table:
    """Every event of every run: kind, place, cam angle, duration, size, cause."""
    rows = [
        (run.label, event.kind, event.where, float(np.degrees(event.cam_angle) % 360), event.duration * 1e3, event.size, event.unit,
         str(event.details.get("cause", "")))
        for run in runs for event in run.events
    ]  # fmt: skip
    names = (("run", ""), ("event", ""), ("place", ""), ("cam angle", "deg"), ("duration", "ms"), ("size", ""), ("unit", ""), ("cause", ""))
    return table(*((name, unit, np.array([row[place] for row in rows], dtype=object)) for place, (name, unit) in enumerate(names)))


def grid_of(data: Table, caption: str = "") -> Grid:
    """A table as a grid of the page."""
    rows = tuple((tuple(_cell(value) for value in row), "") for row in data.rows())
    return Grid(tuple(column.header for column in data.columns), rows, caption=caption)


def _cell(value: object) -> Cell:
    if isinstance(value, float):
        return Cell("–" if not np.isfinite(value) else number(value), "number")
    return Cell(str(value))


def train_page(study: TrainStudy) -> Page:
    """The whole report of a train study; parts without data are left out."""
    case, runs = study.case, study.runs
    sections = (
        Section("summary", "Summary", _summary(study)),
        Section("published", "Published and computed", _published(study)),
        Section("lift", "Lift and forces", _curves(runs)),
        Section("springs", "Springs", _springs(runs)),
        Section("events", "Events", (grid_of(event_table(runs)),) if any(run.events for run in runs) else ()),
        Section("kinematics", "Before dynamics", _kinematics(runs)),
        Section("case", "Values of the case", _case(study)),
        Section("references", "Papers to cite", tuple(text(reference, "reference") for reference in study.provenance.citations)),
    )
    completed = sum(run.status.completed for run in runs)
    facts = (
        ("case", case.name), ("engine speeds", ", ".join(dict.fromkeys(speed_words(run.engine_speed) for run in runs))),
        ("springs", ", ".join(dict.fromkeys(run.spring_model for run in runs))), ("runs", f"{completed} of {len(runs)} completed"),
    )  # fmt: skip
    zero = case.lift_law.zero_of_angle if case.lift_law is not None else ""
    footer = (
        "Angles are cam degrees"
        + (f" (zero: {zero})" if zero else "")
        + ". Engine speed is crank speed. Compressive forces and opening lift are positive."
    )
    return Page(case.title or case.name, "Valvetrain study", case.description, facts, tuple(s for s in sections if s.blocks), footer)


def _summary(study: TrainStudy) -> tuple[Block, ...]:
    blocks: list[Block] = [text(f"{run.label}: {run.status.sentence()}", "alert") for run in study.runs if not run.status.completed]
    blocks.append(grid_of(summary_table(study.runs)))
    return (*blocks, *(text(note, "note") for note in study.notes))


def _published(study: TrainStudy) -> tuple[Block, ...]:
    blocks: list[Block] = []
    if study.comparisons:
        blocks.append(comparison_grid(study.comparisons))
    if study.findings:
        rows = tuple(
            (tuple(Cell(words) for words in (item.place, item.statement, item.computed, item.verdict)), "") for item in study.findings
        )
        blocks.append(Grid(("place in the source", "finding of the source", "computed here", "verdict"), rows))
    return tuple(blocks)


def _curves(runs: Sequence[TrainRun]) -> tuple[Block, ...]:
    shown = [run for run in runs if run.traces is not None]
    if not shown:
        return ()
    lift = train_figures.curve_chart(
        shown, ("valve lift", "valve velocity", "valve acceleration"), "train-lift", "Valve motion",
        "Steady cycle; velocity and acceleration at the valve.",
    )  # fmt: skip
    forces = train_figures.curve_chart(
        shown, ("cam contact force", "force on the valve", "seat force", "cam torque"), "train-forces", "Contact forces",
        "Cam contact, force of lever or tappet on the valve, seat, and the torque that drives the cam.",
    )  # fmt: skip
    blocks: list[Block] = [Figure(forces), Figure(lift)]
    if any(run.traces is not None and run.traces.piston_clearance is not None for run in shown):
        caption = "Gap between piston crown and valve along the cylinder over the cam cycle (two crank turns)."
        blocks.append(Figure(train_figures.curve_chart(shown, ("piston clearance",), "piston-clearance", "Piston to valve", caption)))
    return tuple(blocks)


def _springs(runs: Sequence[TrainRun]) -> tuple[Block, ...]:
    shown = [run for run in runs if run.traces is not None]
    if not shown:
        return ()
    caption = "Force of all springs on the retainer, and what a spring without inertia would give at the same lift."
    blocks: list[Block] = [
        Figure(train_figures.curve_chart(shown, ("spring force", "static spring force"), "spring-force", "Spring force", caption))
    ]
    sections = train_figures.section_chart(shown)
    return (*blocks, Figure(sections)) if sections is not None else tuple(blocks)


def _kinematics(runs: Sequence[TrainRun]) -> tuple[Block, ...]:
    table_of = next((run.table for run in runs if run.table is not None), None)
    return () if table_of is None else (Figure(train_figures.kinematics_chart(table_of)),)


def _case(study: TrainStudy) -> tuple[Block, ...]:
    rows = tuple((tuple(Cell(word) for word in row), row[2]) for row in case_rows(study.case))
    return (Grid(("key", "value", "status", "source"), rows),) if rows else ()


def write_train_report(study: TrainStudy, folder: str | os.PathLike[str], page: bool = True) -> ReportFiles:
    """NetCDF and CSV per run, comparison, events, findings, and (``page``) the page with its figures; each file whole or not at all."""
    target, data = Path(folder), []
    for run in study.runs:
        if run.traces is not None:
            stem = f"{_slug(run.label)}-{rpm(run.engine_speed):g}rpm"
            data.append(save_netcdf(solution_of(study, run), target / f"{stem}.nc"))
            data.append(write_text(target / f"{stem}.csv", train_figures.cycle_table(run).csv()))
    data.append(write_text(target / "summary.csv", summary_table(study.runs).csv()))
    data.append(write_text(target / "events.csv", event_table(study.runs).csv()))
    if study.comparisons:
        data.append(write_text(target / "comparison.csv", comparison_table(study.comparisons).csv()))
    written, figures = write_page(train_page(study), target) if page else (target / "report.html", ())
    remove_earlier(target, "report", (*data, *figures, *((written,) if page else ())))
    return ReportFiles(target, written, tuple(data), figures)


def sweep_page(sweep: TrainSweep) -> Page:
    """The report of a sweep: where each spring floats, curves over speed, order maps, all numbers."""
    speeds_of = ("contact_loss_engine_speed", "rigid_engine_speed", "float_engine_speed")
    rows = np.array([[rpm(getattr(item, name)) for name in speeds_of] for item in sweep.series]).reshape(-1, 3)
    lone = [", ".join(f"{rpm(speed):g}" for speed in item.lone_float_engine_speeds) or "–" for item in sweep.series]
    floats = table(
        ("springs", "", np.array([item.label for item in sweep.series], dtype=object)), ("contact first lost", "rpm", rows[:, 0]),
        ("by rigid theory", "rpm", rows[:, 1]), ("floats from", "rpm", rows[:, 2]),
        ("floats at single speeds", "rpm", np.array(lone, dtype=object)),
    )  # fmt: skip
    lead = text(
        "A train floats from the speed at which it runs above its rigid lift there and at the next speed of the sweep; a resonance that "
        "lets go at one speed only is named apart. A dash means that no speed of the sweep does so. Rigid theory: the speed at which "
        "inertia first exceeds the spring force, no elasticity, no surge."
    )
    maps = tuple((item.label, (Figure(sweep_figures.order_chart(item, f"orders-{_slug(item.label)}")),)) for item in sweep.series)
    tables = tuple((item.label, (grid_of(sweep_figures.sweep_table(item)),)) for item in sweep.series)
    sections = (
        Section("float", "Where control is lost", (grid_of(floats), lead, *(text(words, "alert") for words in sweep.failures))),
        Section("curves", "Over engine speed", (Figure(sweep_figures.sweep_chart(sweep)),)),
        Section("orders", "Order maps", (Tabs(maps, "orders"),)),
        Section("numbers", "All numbers", (Tabs(tables, "numbers"),)),
    )
    speeds = sweep.series[0].engine_speeds
    facts = (("case", sweep.case.name), ("engine speeds", f"{len(speeds)} from {speed_words(speeds[0])} to {speed_words(speeds[-1])}"))
    return Page(
        sweep.case.title or sweep.case.name,
        "Speed sweep",
        sweep.case.description,
        facts,
        sections,
        "Engine speed is crank speed; orders count per cam turn.",
    )


def write_sweep_report(sweep: TrainSweep, folder: str | os.PathLike[str], page: bool = True) -> ReportFiles:
    """CSV of every series and order map, and (``page``) the page."""
    target, data = Path(folder), []
    for series in sweep.series:
        data.append(write_text(target / f"sweep-{_slug(series.label)}.csv", sweep_figures.sweep_table(series).csv()))
        data.append(write_text(target / f"orders-{_slug(series.label)}.csv", sweep_figures.order_table(series).csv()))
    written, figures = write_page(sweep_page(sweep), target, "sweep.html") if page else (target / "sweep.html", ())
    remove_earlier(target, "sweep", (*data, *figures, *((written,) if page else ())))
    return ReportFiles(target, written, tuple(data), figures)


def _slug(words: str) -> str:
    return "-".join("".join(char if char.isalnum() or char == "." else " " for char in words).split())
