"""Writes the folder of a study: data files first, then the one page that shows them; each whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from valvetrain.report.build import study_page
from valvetrain.report.comparison_grid import comparison_table
from valvetrain.report.earlier_files import remove_earlier
from valvetrain.report.page import Page, charts, render
from valvetrain.report.sections.sweep import order_table
from valvetrain.report.svg_chart import svg
from valvetrain.report.table import Table, table
from valvetrain.report.words import rpm
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.netcdf import save_modal_result, save_netcdf, save_static_curve
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.study import Study
from valvetrain.solution.textfile import save_csv

#: Wire points of the CSV files, in turns; the NetCDF files hold every one.
CSV_SPACING = 0.5


@dataclass(frozen=True, slots=True)
class StudyFiles:
    """What was written: the page (None where none was asked for), data files and pictures."""

    folder: Path
    page: Path | None
    data: tuple[Path, ...]
    figures: tuple[Path, ...] = ()


@dataclass
class _Names:
    """Free file names: labels that differ only in signs or case still get files of their own."""

    taken: set[str] = field(default_factory=set)

    def free(self, words: str) -> str:
        """A name of letters, digits, points and dashes that was not given before."""
        plain = "-".join("".join(char if char.isalnum() or char in ".+" else " " for char in words).split()).strip(".") or "run"
        plain = plain.encode()[:120].decode(errors="ignore")
        name = next(one for n in range(1, len(self.taken) + 2) if (one := plain if n == 1 else f"{plain}-{n}").lower() not in self.taken)
        self.taken.add(name.lower())
        return name


def write_study(study: Study, folder: str | os.PathLike[str], page: bool = True, figures: bool = False) -> StudyFiles:
    """Write the data files of a study and, on request, its page and pictures.

    Parameters
    ----------
    study : what ``simulate``, ``compare`` or ``sweep`` gave
    folder : made if absent; files of an earlier study there that nobody changed are removed
    page : write report.html, one file that needs no network
    figures : write every chart of the page as an SVG picture too

    Returns
    -------
    StudyFiles with the paths: folder, page (None without), data, figures

    Raises
    ------
    InputError : a folder that cannot be written

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.simulate("job-t", "2000 rpm", spring_models=["massless"])
    >>> written = vt.write_study(study, "results", page=False)
    >>> sorted(file.name for file in written.data)[:3]
    ['massless-2000rpm.csv', 'massless-2000rpm.nc', 'modes-job-t-finite-element.csv']
    """
    target, names = Path(folder), _Names()
    data: list[Path] = []
    for run in study.solutions:
        if run.arrays.variables and len(run.time):
            stem = names.free(f"{run.label}-{rpm(run.engine_speed):.10g}rpm")
            data.append(save_netcdf(run, target / f"{stem}.nc"))
            data.append(save_csv(at_wire_points(run, CSV_SPACING), target / f"{stem}.csv"))
    data += _write_rest(study, target, names)
    tables = {"quantities": quantity_table(study), "events": event_table(study)}
    if study.comparisons:
        tables["comparison"] = comparison_table(study.comparisons)
    if study.over_speed:
        for label in study.labels:
            tables[names.free(f"sweep-{label}")] = sweep_table(study, label)
            speeds, orders, sizes = order_table(study, label)
            if len(orders):
                columns = [(f"order {order:g}", "N", row) for order, row in zip(orders, sizes, strict=True)]
                tables[names.free(f"orders-{label}")] = table(("engine speed", "rpm", [rpm(speed) for speed in speeds]), *columns)
    data += [write_text(target / f"{name}.csv", content.csv()) for name, content in tables.items() if len(content)]
    written, pictures = write_page(study_page(study), target, figures=figures) if page else (None, ())
    remove_earlier(target, "report", (*data, *pictures, *((written,) if written else ())))
    return StudyFiles(target, written, tuple(data), pictures)


def write_page(page: Page, folder: Path, name: str = "report.html", figures: bool = True) -> tuple[Path, tuple[Path, ...]]:
    """Write a page and, where ``figures`` are asked for, each of its charts as SVG; a chart that fails is left out (the page names it)."""
    pictures = []
    for chart in charts(page) if figures else ():
        try:
            drawing = svg(chart)
        except Exception:  # one picture must not cost the others
            continue
        pictures.append(write_text(folder / "figures" / f"{chart.key}.svg", drawing))
    return write_text(folder / name, render(page)), tuple(pictures)


def at_wire_points(solution: Solution, spacing: float) -> Solution:
    """The solution with the wire points nearest to every ``spacing`` turns only, of each spring; unchanged without wire points."""
    channels = solution.channels
    for coordinate in list(channels.coords.values()):
        dimension = str(coordinate.dims[0]) if len(coordinate.dims) == 1 else ""
        if dimension.endswith("wire_point") and channels.sizes[dimension]:
            coils = np.asarray(coordinate.values, dtype=float)
            wanted: Iterable[float] = np.arange(np.ceil(coils.min() / spacing), np.floor(coils.max() / spacing) + 1) * spacing
            channels = channels.isel({dimension: sorted({int(np.argmin(np.abs(coils - coil))) for coil in wanted}) or [0]})
    return replace(solution, channels=channels)


def _write_rest(study: Study, folder: Path, names: _Names) -> list[Path]:
    """Static curve, modes and mode shapes of every spring at rest, NetCDF and CSV each."""
    written = []
    for one in study.rest:
        whose = f"{one.spring}-{one.model}"
        if one.curve is not None:
            stem = names.free(f"static-{whose}")
            written.append(save_static_curve(one.curve, folder / f"{stem}.nc", study.provenance))
            written.append(write_text(folder / f"{stem}.csv", static_table(one.curve).csv()))
        if one.modes is not None:
            stem = names.free(f"modes-{whose}")
            written.append(save_modal_result(one.modes, folder / f"{stem}.nc", study.provenance))
            written.append(write_text(folder / f"{stem}.csv", frequency_table(one.modes).csv()))
    return written


def static_table(curve: StaticCurve) -> Table:
    """``compression`` (mm), ``force`` (N), ``stiffness`` (N/mm), ``closed turns`` (turns of wire lying on the turn below)."""
    pairs = curve.coil_gap.shape[1]
    span = float(np.ptp(curve.upper_coil)) / max(pairs - 1, 1) if pairs else 0.0
    closed = np.sum(curve.coil_contact_force > 0, axis=1) * span
    return table(
        ("compression", "mm", curve.compression * 1e3), ("force", "N", np.asarray(curve.force)),
        ("stiffness", "N/mm", curve.stiffness * 1e-3), ("closed turns", "", closed.astype(float)),
    )  # fmt: skip


def frequency_table(result: ModalResult) -> Table:
    """``natural frequency`` (Hz), ``transmission`` (size of the axial force-transmission residue, largest 1) and ``axial`` of all modes."""
    residue = np.abs(np.asarray(result.axial_transmission, dtype=float))
    axial = np.isin(np.arange(len(residue)), result.axial_modes)
    share = residue / max(float(residue.max(initial=0.0)), 1e-300)
    return table(("natural frequency", "Hz", np.asarray(result.natural_frequency)), ("transmission", "", share), ("axial", "", axial))


def quantity_table(study: Study) -> Table:
    """Every named number in SI: ``label``, ``engine speed`` (rpm; empty where none applies), ``quantity``, ``value``, ``unit``."""
    items = list(study.quantities.items())
    speeds = [None if key.engine_speed is None else rpm(key.engine_speed) for key, _ in items]
    words = {"label": [key.label for key, _ in items], "quantity": [key.name for key, _ in items]}
    units = [definition_of(key.name).si_unit for key, _ in items]
    return table(
        ("label", "", np.array(words["label"], dtype=object)), ("engine speed", "rpm", np.array(speeds, dtype=object)),
        ("quantity", "", np.array(words["quantity"], dtype=object)), ("value", "SI", np.array([float(value) for _, value in items])),
        ("unit", "", np.array(units, dtype=object)),
    )  # fmt: skip


def event_table(study: Study) -> Table:
    """Every event of every run, details included where they are told."""
    rows = [
        (run.label, rpm(run.engine_speed), event.kind, event.where, float(np.degrees(event.cam_angle) % 360), event.duration * 1e3,
         event.size, event.unit, event.details.get("lower_coil"), event.details.get("upper_coil"), event.details.get("impulse"),
         event.details.get("energy"), event.details.get("cause", ""))
        for run in study.solutions for event in run.events
    ]  # fmt: skip
    names = (
        ("label", ""), ("engine speed", "rpm"), ("event", ""), ("place", ""), ("cam angle", "deg"), ("duration", "ms"), ("size", ""),
        ("unit", ""), ("lower coil", ""), ("upper coil", ""), ("impulse", "N s"), ("energy", "J"), ("cause", ""),
    )  # fmt: skip
    return table(*((name, unit, np.array([row[place] for row in rows], dtype=object)) for place, (name, unit) in enumerate(names)))


def sweep_table(study: Study, label: str) -> Table:
    """All quantities of one label over the engine speed in the units shown; cam orders stand in a table of their own."""
    runs = study.runs(label)
    names = [name for name in dict.fromkeys(name for run in runs for name in run.quantities) if not name.startswith("surge_order_")]
    columns = [("engine speed", "rpm", np.array([rpm(run.engine_speed) for run in runs]))]
    columns.append(("status", "", np.array([run.status.code for run in runs], dtype=object)))
    for name in names:
        values, unit = shown(name, study.series(label, name)[1])
        columns.append((label_of(name), unit, values))
    return table(*columns)
