"""The page of a spring study, put together from parts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from valvetrain.quantities.stages import stages_of
from valvetrain.quantities.study import SpringStudy
from valvetrain.report import theme
from valvetrain.report.chart import Chart
from valvetrain.report.comparison_grid import comparison_grid, tone
from valvetrain.report.figures import coils, energy, force, lift, modes, nodes, statics
from valvetrain.report.page import Block, Cards, Cell, Figure, Grid, Page, Section, Tabs, text
from valvetrain.report.spring_summary import quantity_grid, speed_card
from valvetrain.report.stress_section import stress_blocks
from valvetrain.report.uncertainty_section import uncertainty_blocks
from valvetrain.report.values import case_rows
from valvetrain.report.words import number, speed_words
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.result import Solution


def spring_page(study: SpringStudy) -> Page:
    """The whole report of a spring study; parts without data are left out."""
    case = study.case
    sections = (
        Section("summary", "Summary", _summary(study)),
        Section("force", "Spring force", _force(study)),
        Section("spikes", "Spikes after the event", _spikes(study)),
        Section("statics", "Static curve and modes", _statics(study)),
        Section("motion", "Motion of the coils", _motion(study)),
        Section("stress", "Wire stress", stress_blocks(study)),
        Section("balance", "Energy and orders", _balance(study)),
        Section("comparison", "Computed and published", _comparison(study)),
        Section("uncertainty", "Numbers with error bars", uncertainty_blocks(study)),
        Section("case", "Values of the case", _case(study)),
        Section("runs", "How it was computed", _runs(study)),
        Section("references", "Papers to cite", _references(study)),
    )
    facts = (
        ("case", case.name), ("engine speeds", ", ".join(speed_words(speed) for speed in study.engine_speeds) or "none run"),
        ("models", ", ".join(theme.model_words(model) for model in study.models) or "none run"), ("runs", _ended(study)),
    )  # fmt: skip
    zero = _zero_words(study)
    footer = "Angles are cam degrees" + (f" ({zero})" if zero else "") + ". Engine speed is crank speed."
    shown = tuple(section for section in sections if section.blocks)
    return Page(case.title or case.name, "Spring study", case.description, facts, shown, footer)


def _zero_words(study: SpringStudy) -> str:
    return str(getattr(study.case.lift_law, "zero_of_angle", "") or "")


def _ended(study: SpringStudy) -> str:
    whole = sum(run.status.completed for run in study.solutions)
    return f"{whole} of {len(study.solutions)} completed"


def fe_runs(study: SpringStudy) -> list[Solution]:
    """Runs of models that show their coils, by engine speed."""
    runs = [run for run in study.solutions if run.has("axial_position") and len(run.time) > 2]
    return sorted(runs, key=lambda run: run.engine_speed)


def _summary(study: SpringStudy) -> tuple[Block, ...]:
    cards = [speed_card(study, speed) for speed in study.engine_speeds]
    blocks: list[Block] = [Cards(tuple(card for card in cards if card.lines))] if any(card.lines for card in cards) else []
    blocks += quantity_grid(study)
    decided = [row for row in study.comparisons if tone(row) in ("good", "bad")]
    missing = sum(row.computed is None for row in study.comparisons)
    if study.comparisons:
        good = sum(tone(row) == "good" for row in decided)
        words = f"{len(study.comparisons)} published values are set beside computed ones. "
        words += f"A tolerance is stated for {len(decided)}; {good} of these hold. "
        words += f"{missing} have no computed value. " if missing else ""
        blocks.append(text(words + _prediction_words(study.comparisons)))
    for run in study.solutions:
        if not run.status.completed:
            blocks.append(text(f"{theme.model_words(run.model)} at {speed_words(run.engine_speed)}: {run.status.sentence()}", "alert"))
    blocks += [text(note, "note") for note in study.notes]
    return tuple(blocks)


def _prediction_words(rows: tuple[Comparison, ...]) -> str:
    forces = [
        abs(row.relative_difference) for row in rows
        if row.role == "prediction" and row.unit == "N" and row.model == "finite-element" and row.relative_difference is not None
    ]  # fmt: skip
    if not forces:
        return ""
    return (
        f"Over the {len(forces)} forces that the rod model predicts (nothing identified from them) the median difference is "
        f"{100 * float(np.median(forces)):.1f} %, the largest {100 * max(forces):.1f} %."
    )


def _force(study: SpringStudy) -> tuple[Block, ...]:
    blocks = []
    for speed in study.engine_speeds:
        data = force.force_table(study, speed)
        if len(data):
            blocks.append(Figure(force.force_chart(study, data, speed)))
    return tuple(blocks)


def _spikes(study: SpringStudy) -> tuple[Block, ...]:
    blocks = []
    for speed in study.engine_speeds:
        data = force.spike_table(study, speed)
        if len(data):
            blocks.append(Figure(force.spike_chart(study, data, speed)))
    return tuple(blocks)


def _statics(study: SpringStudy) -> tuple[Block, ...]:
    blocks: list[Block] = []
    curve, result, case = study.static_curve, study.modal_result, study.case
    if curve is not None and len(curve.compression) > 1:
        blocks.append(Figure(statics.static_chart(statics.static_table(curve), case.published, case.installation.precompression)))
        if not curve.status.completed:
            blocks.append(text(f"Static curve: {curve.status.sentence()}", "alert"))
    if result is not None and len(result.natural_frequency):
        blocks.append(Figure(modes.modes_chart(modes.shape_table(result), modes.frequency_table(result), case.published)))
        if not result.status.completed:
            blocks.append(text(f"Modes: {result.status.sentence()}", "alert"))
    return tuple(blocks)


def _tabs(study: SpringStudy, key: str, of_run: Callable[[SpringStudy, Solution], list[Chart]]) -> tuple[Block, ...]:
    items = []
    for run in fe_runs(study):
        figures = of_run(study, run)
        if figures:
            items.append((speed_words(run.engine_speed), tuple(Figure(chart) for chart in figures)))
    if not items:
        return ()
    return items[0][1] if len(items) == 1 else (Tabs(tuple(items), key),)


def motion_charts(study: SpringStudy, run: Solution) -> list[Chart]:
    """Coil positions, clash map and node motion of one run, those that it has data for."""
    found = []
    positions, clashes, motion = coils.position_table(run), coils.clash_table(run), nodes.node_table(run)
    if positions is not None:
        found.append(coils.position_chart(positions, run.engine_speed))
    if clashes is not None:
        found.append(coils.clash_chart(*clashes, run.engine_speed))
    if motion is not None:
        published, stages = nodes.published_motion(study, run.engine_speed), stages_of(study.case.lift_law)
        found.append(nodes.node_chart(motion, published, run.engine_speed, stages))
    return found


def balance_charts(study: SpringStudy, run: Solution) -> list[Chart]:
    """Energy balance and order spectrum at one engine speed."""
    found = []
    balance, orders = energy.energy_table(run), energy.spectrum_table(study, run.engine_speed)
    if balance is not None:
        found.append(energy.energy_chart(balance, run.engine_speed))
    if len(orders):
        axial = study.modal_result.axial_frequencies if study.modal_result is not None else np.zeros(0)
        found.append(energy.spectrum_chart(orders, axial, run.engine_speed))
    return found


def _motion(study: SpringStudy) -> tuple[Block, ...]:
    return _tabs(study, "motion", motion_charts)


def _balance(study: SpringStudy) -> tuple[Block, ...]:
    return _tabs(study, "balance", balance_charts)


def _comparison(study: SpringStudy) -> tuple[Block, ...]:
    if not study.comparisons:
        return ()
    lead = (
        "Role calibration: the value was open to the identification of the unpublished dimensions. Role prediction: it was not. "
        "The rod model stands beside the solid finite elements (FE) and the engine head test (EX), the modal model beside the "
        "analytical one (AN). "
        "Without a stated tolerance the verdict only says how far apart the two are."
    )
    return (text(lead, "quiet"), comparison_grid(study.comparisons))


def _case(study: SpringStudy) -> tuple[Block, ...]:
    rows = tuple((_value_cells(path, value, status, why), status) for path, value, status, why in case_rows(study.case))
    blocks: list[Block] = []
    if rows:
        statuses = tuple(dict.fromkeys(status for _, status in rows if status))
        blocks.append(Grid(("value of the case", "", "status", "source"), rows, statuses))
    data = next((table for run in study.solutions if (table := lift.lift_table(run)) is not None), None)
    if data is not None:
        blocks.append(Figure(lift.lift_chart(data)))
    return tuple(blocks)


def _value_cells(path: str, value: str, status: str, why: str) -> tuple[Cell, ...]:
    name = path.replace(".", " / ").replace("_", " ")
    return Cell(name), Cell(value), Cell(status, "tag" if status else ""), Cell(why, "quiet long")


def _runs(study: SpringStudy) -> tuple[Block, ...]:
    rows = []
    for run in study.solutions:
        facts = {**run.provenance.options, **run.statistics}
        words = ", ".join(f"{key.replace('_', ' ')} {_plain(value)}" for key, value in facts.items() if value is not None)
        state = Cell(run.status.sentence(), "good" if run.status.completed else "bad")
        speed = Cell(speed_words(run.engine_speed), "number")
        rows.append(((Cell(theme.model_words(run.model)), speed, state, Cell(words, "quiet long")), ""))
    source = study.solutions[0].provenance if study.solutions else study.provenance
    versions = {"valvetrain": source.package_version, "Python": source.python_version, **source.dependencies}
    listed = ", ".join(f"{name} {version}" for name, version in versions.items() if version)
    when = f" Computed {source.created_at}." if source.created_at else ""
    digest = f" Case digest {source.case_digest}." if source.case_digest else ""
    blocks: list[Block] = [Grid(("model", "engine speed", "ended", "options and statistics"), tuple(rows))] if rows else []
    return (*blocks, text(f"Versions: {listed or 'not recorded'}.{digest}{when}", "quiet"))


def _plain(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value)


def _references(study: SpringStudy) -> tuple[Block, ...]:
    listed = dict.fromkeys(reference for run in study.solutions for reference in run.cite())
    known = listed or dict.fromkeys(_case_references(study))
    lead = text("Works behind the case and the methods of these runs.", "quiet")
    return (lead, *(text(reference, "reference") for reference in known)) if known else ()


def _case_references(study: SpringStudy) -> list[str]:
    from valvetrain.citations import references

    known = references()
    return [known[key].text() if key in known else key for key in study.case.cite()]
