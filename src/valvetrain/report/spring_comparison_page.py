"""The page of spring models side by side, and the files beside it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from valvetrain.quantities.spring_comparison import Difference, ModelStatics, SpringComparison
from valvetrain.report import theme
from valvetrain.report.figures import spring_models as figures
from valvetrain.report.page import Block, Card, Cards, Cell, Figure, Grid, Page, Section, text
from valvetrain.report.table import Table
from valvetrain.report.words import number
from valvetrain.report.write import ReportFiles, write_page, write_solution
from valvetrain.solution.atomic import write_text
from valvetrain.solution.netcdf import save_modal_result, save_static_curve

#: Axial modes on the cards.
MODES_ON_CARDS = 3


def comparison_page(study: SpringComparison) -> Page:
    """The whole page; parts without data are left out."""
    case = study.case
    sections = (
        Section("summary", "Summary", _summary(study)),
        Section("statics", "Static curves", _statics(study)),
        Section("modes", "Natural frequencies", _modes(study)),
        Section("ride", "Ride", _ride(study)),
        Section("models", "How it was computed", _models(study)),
        Section("references", "Papers to cite", tuple(text(words, "reference") for words in study.provenance.citations)),
    )
    failed = len(study.failures)
    facts = (
        ("case", case.name), ("models", ", ".join(theme.model_words(name) for name in study.models)),
        ("installed", f"{study.installed * 1e3:g} mm"), ("parts", "all completed" if not failed else f"{failed} did not complete"),
    )  # fmt: skip
    footer = "Differences are shares of the value of the first model. Compressive forces are positive."
    shown = tuple(section for section in sections if section.blocks)
    return Page(case.title or case.name, "Spring models side by side", case.description, facts, shown, footer)


def share_words(share: float | None) -> str:
    """A relative difference in percent with its sign; a dash for None."""
    return "–" if share is None else f"{100 * share:+.2f} %".replace("-", "−")


def headlines(study: SpringComparison) -> tuple[tuple[str, Difference], ...]:
    """What a reader looks for first: force as installed, mean stiffness, the first axial modes."""
    forces = [row for row in study.differences if row.quantity == "force"]
    found = []
    if forces and study.installed > 0:
        found.append(("force as installed", min(forces, key=lambda row: abs(row.place - study.installed))))
    found += [("mean stiffness from half way", row) for row in study.differences if row.quantity == "mean stiffness"]
    return (*found, *((f"axial mode {row.axial}", row) for row in study.differences if 0 < row.axial <= MODES_ON_CARDS))


def _summary(study: SpringComparison) -> tuple[Block, ...]:
    cards = []
    for title, row in headlines(study):
        factor, unit = (1e-3, "N/mm") if row.unit == "N/m" else (1.0, row.unit)
        lines = []
        for name in study.models:
            if name in row.values:
                beside = "" if name == study.reference else share_words(row.relative(name, study.reference))
                lines.append((theme.model_words(name), f"{number(row.values[name] * factor, 5)} {unit}", beside))
        cards.append(Card(title[:1].upper() + title[1:], tuple(lines)))
    blocks: list[Block] = [Cards(tuple(cards))] if cards else []
    blocks += [text(sentence, "alert") for sentence in study.failures]
    return (*blocks, *(text(note, "note") for note in study.notes))


def _statics(study: SpringComparison) -> tuple[Block, ...]:
    if not any(len(item.curve.compression) > 1 for item in study.members):
        return ()
    data = figures.difference_table(study)
    chart = Figure(figures.curve_chart(figures.curve_table(study), data, study))
    words = "At increments of the first model; straight lines between the points of the others."
    return (chart, _grid(data, words)) if len(data) else (chart,)


def _modes(study: SpringComparison) -> tuple[Block, ...]:
    data = figures.frequency_table(study)
    if not len(data):
        return ()
    words = "Shape agreement: modal assurance criterion of the wire's motion, 1 for the same shape; pairs of near modes share theirs."
    return (Figure(figures.frequency_chart(data, study)), _grid(data, words))


def _ride(study: SpringComparison) -> tuple[Block, ...]:
    data = figures.ride_table(study)
    return (Figure(figures.ride_chart(data, study)),) if len(data) else ()


def _models(study: SpringComparison) -> tuple[Block, ...]:
    rows = tuple((_model_cells(item), "") for item in study.members)
    grid = Grid(("model", "mesh", "static curve", "modes", "wall time"), rows)
    rides = tuple(
        text(f"Ride, {theme.model_words(run.model)}: {run.status.sentence()}; {_facts_words(run.statistics)}.") for run in study.rides
    )
    source = study.provenance
    versions = {"valvetrain": source.package_version, "Python": source.python_version, **source.dependencies}
    listed = ", ".join(f"{name} {version}" for name, version in versions.items() if version)
    when = f" Computed {source.created_at}." if source.created_at else ""
    return (grid, *rides, text(f"Versions: {listed or 'not recorded'}.{when}", "quiet"))


def _model_cells(item: ModelStatics) -> tuple[Cell, ...]:
    wall_time = f"{number(item.wall_time, 3)} s" if item.wall_time else "–"
    states = (Cell(one.status.sentence(), "good" if one.status.completed else "bad") for one in (item.curve, item.modes))
    return (Cell(theme.model_words(item.model)), Cell(_facts_words(item.facts), "quiet"), *states, Cell(wall_time, "number"))


def _facts_words(facts: Mapping[str, float | int | str]) -> str:
    return ", ".join(f"{key.replace('_', ' ')} {number(value) if isinstance(value, float) else value}" for key, value in facts.items())


def _grid(data: Table, caption: str) -> Grid:
    rows = tuple((tuple(_cell(column.name, value) for column, value in zip(data.columns, row, strict=True)), "") for row in data.rows())
    return Grid(tuple(column.header for column in data.columns), rows, caption=caption)


def _cell(name: str, value: object) -> Cell:
    if name == "axial":
        return Cell(f"axial {value}" if value else "", "quiet")
    if isinstance(value, float):
        if not np.isfinite(value):
            return Cell("–", "number")
        digits = 2 if name.startswith("shape agreement") else 5
        return Cell(f"{value:+.2f}".replace("-", "−") if name.endswith("difference") else number(value, digits), "number")
    return Cell(str(value), "number")


def write_comparison(study: SpringComparison, folder: str | os.PathLike[str], page: bool = True) -> ReportFiles:
    """NetCDF of every curve, modes and ride, CSV tables and (``page``) the page with its figures; each file whole or not at all."""
    target, data = Path(folder), []
    for item in study.members:
        data.append(save_static_curve(item.curve, target / f"{item.model}-static.nc", study.provenance))
        data.append(save_modal_result(item.modes, target / f"{item.model}-modes.nc", study.provenance))
    data += [path for run in study.rides for path in write_solution(run, target)]
    tables = {
        "static-curves.csv": figures.curve_table(study), "force-differences.csv": figures.difference_table(study),
        "natural-frequencies.csv": figures.frequency_table(study),
    }  # fmt: skip
    data += [write_text(target / name, content.csv()) for name, content in tables.items() if len(content)]
    written, pictures = write_page(comparison_page(study), target) if page else (target / "report.html", ())
    return ReportFiles(target, written, tuple(data), pictures)
