"""Tables of a study as text for its data files, and what was written of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import RunFailedError
from valvetrain.parameters.summary import rpm
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.runs.stored_error_bars import numbers_of
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.quantity import unit_of
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import Comparison, Uncertainty
from valvetrain.units.text import to_unit
from valvetrain.views.files import csv_of


def by_columns(columns: Mapping[str, ArrayLike]) -> str:
    """Columns of equal length by their heads as CSV text."""
    values = (np.asarray(column).tolist() for column in columns.values())
    return csv_of(columns, zip(*values, strict=True))


def comparison_table(rows: Sequence[Comparison]) -> str:
    """All rows in the units shown, for ``comparison.csv``."""
    plain = {
        "quantity": "quantity", "engine speed": "engine_speed", "given by": "origin", "given": "published", "computed by": "model",
        "computed": "computed", "blind": "blind", "difference": "difference", "unit": "unit",
        "relative difference": "relative_difference", "tolerance": "tolerance", "role": "role", "verdict": "verdict",
        "source": "source", "used for": "used_for", "reading": "reading",
    }  # fmt: skip
    sampled = {"low over phases": "low", "high over phases": "high", "share at or above": "share", "phases": "phases"}  # fmt: skip
    cells = {name: [getattr(row, key) for row in rows] for name, key in plain.items()}
    cells |= {
        name: [row.samples and getattr(row.samples, key) for row in rows]
        for name, key in sampled.items()
    }
    cells["engine speed"] = [one if one is None else rpm(one) for one in cells["engine speed"]]
    for name in ("given", "computed", "blind", "difference", "tolerance", *[*sampled][:2]):
        cells[name] = [
            one if one is None else to_unit(one, row.unit)
            for one, row in zip(cells[name], rows, strict=True)
        ]
    heads = (f"{name} [rpm]" if name == "engine speed" else name for name in cells)
    return csv_of(heads, zip(*cells.values(), strict=True))


#: Wire points of the CSV files, in turns; the NetCDF files hold every one.
CSV_SPACING = 0.5


@dataclass(frozen=True, slots=True)
class StudyFiles:
    """What was written: the page (None where none was requested), data files and pictures;
    ``gaps``: a sentence per part that was not.
    """

    folder: Path
    page: Path | None
    data: tuple[Path, ...]
    figures: tuple[Path, ...] = ()
    gaps: tuple[str, ...] = ()


def files_of(folder: Path, files: Sequence[Path], gaps: Sequence[str] = ()) -> StudyFiles:
    """The ``files`` of a result, its page among them. Raises :class:`RunFailedError` where some could
    not be written, with ``gaps``, a sentence for each.
    """
    if gaps:
        raise RunFailedError(
            f"not all of the result could be written to '{folder}', the rest is there: {'; '.join(gaps)}"
        )
    page = next((path for path in files if path.name == "report.html"), None)
    return StudyFiles(folder, page, tuple(path for path in files if path != page))


def at_wire_points(solution: Solution, spacing: float) -> Solution:
    """The solution with the wire points nearest to every ``spacing`` turns only, of each spring;
    unchanged without wire points.
    """
    places: dict[str, list[int]] = {}
    for coordinate in solution.arrays.coords.values():
        dimension = coordinate.dims[0] if len(coordinate.dims) == 1 else ""
        if dimension.endswith("wire_point") and dimension not in places and len(coordinate.values):
            coils = np.asarray(coordinate.values, dtype=float)
            targets: Iterable[float] = (
                np.arange(np.ceil(coils.min() / spacing), np.floor(coils.max() / spacing) + 1)
                * spacing
            )
            places[dimension] = sorted(
                {int(np.argmin(np.abs(coils - coil))) for coil in targets}
            ) or [0]
    return replace(solution, channels=solution.arrays.at(places)) if places else solution


def static_table(rest: SpringAtRest, curve: StaticCurve) -> str:
    """``compression`` (mm), ``force`` (N), ``stiffness`` (N/mm), ``closed turns`` (turns of wire lying on the turn
    below); ``height`` (mm), ``nominal shear`` by EN 13906-1 and ``wire shear`` (MPa), each where it is known.
    """
    pairs = curve.coil_gap.shape[1]
    span = float(np.ptp(curve.upper_coil)) / max(pairs - 1, 1) if pairs else 0.0
    closed = np.sum(curve.coil_contact_force > 0, axis=1) * span
    columns = {
        "compression [mm]": curve.compression * 1e3, "force [N]": curve.force, "stiffness [N/mm]": curve.stiffness * 1e-3,
        "closed turns": closed.astype(float),
    }  # fmt: skip
    installed, per_force = rest.installed, rest.stress_per_force
    if installed is not None and installed.height is not None:
        free = installed.height + installed.compression
        columns["height [mm]"] = (free - curve.compression) * 1e3
    if per_force is not None:
        columns["nominal shear [MPa]"] = per_force * curve.force * 1e-6
    if rest.stress is not None:
        along = rest.stress.shear_at(curve.compression).max(axis=1) * (curve.force > 0)
        columns["wire shear [MPa]"] = along * 1e-6
    return by_columns(columns)


def frequency_table(result: ModalResult) -> str:
    """``natural frequency`` (Hz), ``transmission`` (size of the axial force-transmission residue,
    largest 1) and ``axial`` of all modes.
    """
    residue = np.abs(np.asarray(result.axial_transmission, dtype=float))
    axial = np.isin(np.arange(len(residue)), result.axial_modes)
    share = residue / max(float(residue.max(initial=0.0)), 1e-300)
    return by_columns(
        {"natural frequency [Hz]": result.natural_frequency, "transmission": share, "axial": axial}
    )


def quantity_table(study: Study) -> str:
    """Every named number: ``label``, ``engine speed`` (rpm; empty where none applies), ``quantity``,
    ``value`` and ``unit`` in SI, and both as terminal and page show them (speeds in rpm, angles in deg).
    """
    rows = [
        (
            key.label, None if key.engine_speed is None else rpm(key.engine_speed), key.name, float(value),
            definition_of(key.name).si_unit, *shown(key.name, float(value)),
        )
        for key, value in study.quantities.items()
    ]  # fmt: skip
    heads = (
        "label",
        "engine speed [rpm]",
        "quantity",
        "value [SI]",
        "unit",
        "shown value",
        "shown unit",
    )
    return csv_of(heads, rows)


def event_table(study: Study) -> str:
    """Every event of every run, details included where they are given."""
    rows = [
        (
            run.label,
            rpm(run.engine_speed),
            event.kind,
            event.where,
            float(np.degrees(event.cam_angle) % 360),
            event.duration * 1e3,
            event.size,
            event.unit,
            event.details.get("lower_coil"),
            event.details.get("upper_coil"),
            event.details.get("impulse"),
            event.details.get("energy"),
            event.details.get("cause", ""),
        )
        for run in study.solutions
        for event in run.events
    ]
    heads = (
        "label", "engine speed [rpm]", "event", "place", "cam angle [deg]", "duration [ms]", "size", "unit", "lower coil",
        "upper coil", "impulse [N s]", "energy [J]", "cause",
    )  # fmt: skip
    return csv_of(heads, rows)


def sweep_table(study: Study, label: str) -> str:
    """All quantities of one label over the engine speed in the units shown."""
    runs = study.runs(label)
    names = dict.fromkeys(name for run in runs for name in run.quantities)
    columns: dict[str, ArrayLike] = {
        "engine speed [rpm]": [rpm(run.engine_speed) for run in runs],
        "status": [run.status.code for run in runs],
    }
    for name in names:
        values, unit = shown(name, np.array([run.quantities.get(name, np.nan) for run in runs]))
        columns[f"{label_of(name)} [{unit}]" if unit else label_of(name)] = values
    return by_columns(columns)


def uncertainty_table(rows: Sequence[Uncertainty]) -> str:
    """All rows in SI for ``uncertainty.csv``; speed in rpm of the crank, nan for statics and modes."""
    several = any(row.label for row in rows)
    heads = (
        "quantity", *["variant"] * several, "engine speed [rpm]", "unit", "value", "numerical uncertainty", "observed order",
        "extrapolated", "part of the step", "least over contact stiffness", "largest over contact stiffness",
        "least over damping", "largest over damping",
    )  # fmt: skip
    return csv_of(heads, (
        (row.quantity, *[row.label] * several, _speed(row.engine_speed), unit_of(row.quantity), *numbers_of(row)) for row in rows
    ))  # fmt: skip


def levels_table(study: UncertaintyStudy) -> str:
    """Every number (SI) of every run behind the error bars for ``levels.csv``, as
    :func:`uncertainty_table`.
    """
    rows = (
        (level, _speed(speed), name, unit_of(name), value)
        for level, by_speed in study.values.items()
        for speed, numbers in by_speed.items()
        for name, value in numbers.items()
    )
    return csv_of(("level", "engine speed [rpm]", "quantity", "unit", "value"), rows)


def _speed(engine_speed: float | None) -> float:
    return float("nan") if engine_speed is None else rpm(engine_speed)
