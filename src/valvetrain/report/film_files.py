"""Files of a film: displacements over the cam angle, one column a turn; tracks, peaks, lines; and the JSON answer."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.cycles_file import write_cycles
from valvetrain.measurements.film.result import CoilMotion
from valvetrain.measurements.measured_cycles import MeasuredCycles
from valvetrain.solution.atomic import write_text
from valvetrain.studies.film_model import FilmedModel

Array = NDArray[np.float64]


def named_cycles(motion: CoilMotion, model: FilmedModel | None) -> tuple[MeasuredCycles, ...]:
    """Measured cycles of every coil; beside a run under the names that the same curves have there."""
    if model is None:
        return motion.cycles
    return tuple(replace(one, quantity=name) for one, name in zip(motion.cycles, model.quantities, strict=True))


def write_film(motion: CoilMotion, model: FilmedModel | None, folder: Path) -> list[Path]:
    """``displacement-coil-N.csv`` (measured cycles), ``peaks.csv``, ``tracks.csv``, ``spectrum.csv`` and, with a model, ``model.csv``."""
    files = [
        write_cycles(folder / f"displacement-coil-{coil}.csv", [one]) for coil, one in enumerate(named_cycles(motion, model), start=1)
    ]  # fmt: skip
    coils = range(1, motion.coils + 1)
    columns = [1e3 * motion.time, *(() if motion.phase is None else (np.degrees(motion.phase.cam_angle),))]
    heads = ["time [ms]", *(() if motion.phase is None else ("cam angle [deg]",))]
    kinds = (("displacement of coil", "mm"), ("place of coil", "px"), ("standard deviation of coil", "px"))
    heads += [f"{word} {coil} [{unit}]" for word, unit in kinds
              for coil in coils]  # fmt: skip
    tracks = np.column_stack([*columns, 1e3 * motion.displacement, motion.places, motion.spread])
    files.append(write_text(folder / "tracks.csv", _csv(heads, tracks)))
    files.append(
        write_text(
            folder / "spectrum.csv",
            _csv(("frequency [Hz]", "amplitude [um]"), np.column_stack([motion.spectrum_frequency, 1e6 * motion.spectrum_amplitude])),
        )
    )
    if motion.peaks:
        rows = np.array([(one.coil, 1e3 * one.mean, 1e3 * one.spread, 1e3 * one.scatter, one.cycles) for one in motion.peaks])
        head = ("coil", "mean peak displacement [mm]", "standard deviation of the mean [mm]", "scatter of a turn [mm]", "turns")
        files.append(write_text(folder / "peaks.csv", _csv(head, rows)))
    if model is not None:
        heads = ["cam angle [deg]", *(f"coil {coil}, turn {turn:.2f} [mm]" for coil, turn in zip(coils, model.turns, strict=True))]
        files.append(
            write_text(folder / "model.csv", _csv(heads, np.column_stack([np.degrees(model.cam_angle), 1e3 * model.displacement])))
        )
    return files


def _csv(head: Iterable[str], rows: Array) -> str:
    # A head with a comma in it is quoted, as CSV has it.
    first = ",".join(f'"{one}"' if "," in one else one for one in head)
    lines = (",".join("" if np.isnan(value) else f"{value:.7g}" for value in row) for row in rows)
    return "\n".join([first, *lines]) + "\n"


def film_json(motion: CoilMotion, model: FilmedModel | None) -> dict[str, Any]:
    """The JSON answer, SI."""
    line = motion.seen.line
    data: dict[str, Any] = {
        "command": "film", "case": "" if model is None else model.case, "completed": True, "frames": len(motion.places),
        "coils": motion.coils,
        "frame_rate": motion.seen.frame_rate, "line": {"start": list(line.start), "end": list(line.end), "unit": "px"},
        "metres_per_pixel": {"value": motion.metres_per_pixel, "standard_deviation": motion.scale_spread},
        "place_standard_deviation": {"value": float(np.nanmedian(motion.spread)), "unit": "px"},
        "camera_drift": {"value": float(np.ptp(motion.drift)), "unit": "px"},
        "cam_speed": None if motion.phase is None else {
            "value": motion.phase.cam_speed, "standard_deviation": motion.phase.spread, "by": motion.phase.by},
        "dwell": None if motion.dwell is None else list(motion.dwell),
        "peaks": [{"coil": one.coil, "mean": one.mean, "standard_deviation": one.spread, "scatter": one.scatter, "turns": one.cycles}
                  for one in motion.peaks],
        "surge_lines": [
            {"frequency": {"value": one.natural_frequency, "standard_deviation": one.frequency_spread},
             "damping_ratio": {"value": one.damping_ratio, "standard_deviation": one.damping_spread},
             "decay_rate": one.decay_rate, "logarithmic_decrement": one.logarithmic_decrement, "amplitude": one.amplitude}
            for one in (() if motion.surge is None else motion.surge.lines)],
        "notes": list(motion.notes),
    }  # fmt: skip
    if model is not None:
        data["model"] = {
            "model": model.model, "spring": model.spring, "turns": model.turns, "quantities": list(model.quantities),
            "peaks": model.peaks, "root_mean_square_apart": model.apart,
            "surge_frequency": model.surge_frequency, "cam_angle_shift": model.shift, "notes": list(model.notes),
            "surge_lines": [{"frequency": one.natural_frequency, "damping_ratio": one.damping_ratio}
                            for one in (() if model.surge is None else model.surge.lines)],
        }  # fmt: skip
    return data
