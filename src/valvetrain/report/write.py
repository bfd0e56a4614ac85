"""Writes a report folder: data files first, then figures, then the one page that shows them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from valvetrain.quantities.study import SpringStudy
from valvetrain.report.comparison_grid import comparison_table
from valvetrain.report.earlier_files import remove_earlier
from valvetrain.report.figures import modes, statics
from valvetrain.report.page import Page, charts, render
from valvetrain.report.spring_page import spring_page
from valvetrain.report.svg_chart import svg
from valvetrain.report.words import rpm
from valvetrain.solution.atomic import write_text
from valvetrain.solution.netcdf import save_modal_result, save_netcdf, save_static_curve
from valvetrain.solution.result import Solution
from valvetrain.solution.textfile import save_csv

#: Wire points of the CSV files, in turns; the NetCDF files hold every one.
CSV_SPACING = 0.5


@dataclass(frozen=True, slots=True)
class ReportFiles:
    """What a report wrote: the page, data files and pictures."""

    folder: Path
    page: Path
    data: tuple[Path, ...]
    figures: tuple[Path, ...]


def write_report(study: SpringStudy, folder: str | os.PathLike[str]) -> ReportFiles:
    """Write the report of a spring study into ``folder`` (made if absent); each file whole or not at all.

    Raises :class:`valvetrain.errors.InputError` when the folder cannot be written.
    """
    target = Path(folder)
    data = [path for solution in study.solutions for path in write_solution(solution, target)]
    data += write_statics(study, target)
    if study.comparisons:
        data.append(write_text(target / "comparison.csv", comparison_table(study.comparisons).csv()))
    page, figures = write_page(spring_page(study), target)
    remove_earlier(target, "report", (*data, *figures, page))
    return ReportFiles(target, page, tuple(data), figures)


def write_page(page: Page, folder: Path, name: str = "report.html") -> tuple[Path, tuple[Path, ...]]:
    """Write a page and, under ``figures``, each of its charts as SVG."""
    figures = tuple(write_text(folder / "figures" / f"{chart.key}.svg", svg(chart)) for chart in charts(page))
    return write_text(folder / name, render(page)), figures


def write_solution(solution: Solution, folder: Path) -> list[Path]:
    """NetCDF with every channel, CSV with the wire points every half turn."""
    stem = f"{solution.model or 'run'}-{rpm(solution.engine_speed):g}rpm"
    return [
        save_netcdf(solution, folder / f"{stem}.nc"), save_csv(at_wire_points(solution, CSV_SPACING), folder / f"{stem}.csv"),
    ]  # fmt: skip


def at_wire_points(solution: Solution, spacing: float) -> Solution:
    """The solution with the wire points nearest to every ``spacing`` turns only; unchanged without wire points."""
    if "coil_number" not in solution.channels.coords or solution.channels.sizes.get("wire_point", 0) == 0:
        return solution
    coils = np.asarray(solution.channels["coil_number"].values)
    wanted: Iterable[float] = np.arange(np.ceil(coils.min() / spacing), np.floor(coils.max() / spacing) + 1) * spacing
    nearest = sorted({int(np.argmin(np.abs(coils - coil))) for coil in wanted}) or [0]
    return Solution(solution.channels.isel(wire_point=nearest), solution.events, solution.status, solution.statistics, solution.provenance)


def write_statics(study: SpringStudy, folder: Path) -> list[Path]:
    """Static curve and modes, NetCDF and CSV each."""
    written = []
    if study.static_curve is not None:
        written.append(save_static_curve(study.static_curve, folder / "static.nc", study.provenance))
        written.append(write_text(folder / "static.csv", statics.static_table(study.static_curve).csv()))
    if study.modal_result is not None:
        written.append(save_modal_result(study.modal_result, folder / "modes.nc", study.provenance))
        written.append(write_text(folder / "modes.csv", modes.frequency_table(study.modal_result).csv()))
        written.append(write_text(folder / "mode-shapes.csv", modes.shape_table(study.modal_result).csv()))
    return written
