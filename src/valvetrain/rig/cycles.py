"""Turns a recording of a test rig into cycles over the cam angle: the steps from file to result."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.parameters.loading import AnyCase
from valvetrain.rig.alignment import Lift, align_lift
from valvetrain.rig.channels import (
    DWELL,
    RigQuantity,
    choose_channels,
    dimension_due,
)
from valvetrain.rig.cutting import (
    CycleGrid,
    LowPass,
    band_of,
    drift_of,
    dwell_of,
    grid_of,
    is_clipped,
    outliers_of,
    set_to_zero,
)
from valvetrain.rig.reader import Recording, read_recording
from valvetrain.rig.request import RigAnswers
from valvetrain.rig.result import RigChannelCycles, RigResult, mean_spread
from valvetrain.rig.shaft import REVOLUTION, ShaftAngle, shaft_of
from valvetrain.system.build import valve_lift_of
from valvetrain.units import parse_quantity

#: Angles at which the dwell is looked for.
DWELL_ANGLES = 720


class _Filtered(NamedTuple):
    raw: RigQuantity
    low_pass: LowPass
    values: Array


def rig_cycles(
    file: str | Path, answers: RigAnswers | None = None, case: AnyCase | None = None
) -> RigResult:
    """Force, lift, strain and motion that a test rig recorded, cycle by cycle over the cam angle.

    Parameters
    ----------
    file : recording: text of columns, MDF, TDMS, MAT, HDF5 or universal file 58; the content
        decides, not the name
    answers : what the file does not say itself, such as
        ``RigAnswers(angle_of="crank", teeth=60, missing=2)``
    case : Case, name of a library case, or path of a case file, whose valve lift gives the cam
        angle of the rig's mark

    Returns
    -------
    RigResult with MeasuredCycles of every channel (SI), where they were cut, and what was found on
    the way

    Raises
    ------
    InputError : a file that cannot be read, one sentence with all questions that are open, a
        recording without a whole cycle

    Examples
    --------
    >>> import pathlib, tempfile
    >>> times = np.arange(0, 0.5, 1e-4)
    >>> rows = [f"{t:.4f}; {360 * ((25 * t) % 1):.3f}; {500 + 200 * np.cos(50 * np.pi * t):.3f}" for t in times]
    >>> file = pathlib.Path(tempfile.mkdtemp(), "own.txt")
    >>> _ = file.write_text(chr(10).join(["time [s]; cam angle [deg]; spring force [N]", *rows]))
    >>> rig_cycles(file, RigAnswers(angle_of="cam")).cycles[0].mean.max().round(1)
    np.float64(700.0)
    """
    path, answers = Path(file), answers or RigAnswers()
    recording = read_recording(path)
    lift = None if case is None or answers.offset is not None else valve_lift_of(case)
    return cycles_in(recording, path.name, answers, lift)


def cycles_in(
    recording: Recording, file_name: str, answers: RigAnswers, case_lift: Lift | None = None
) -> RigResult:
    """The cycles in a recording.

    Parameters: ``file_name`` for messages; ``case_lift`` (m of cam rad, periodic), by which the
    angle is aligned where no offset is stated. Raises :class:`InputError` for open questions (all
    in one sentence) and recordings without a whole cycle.
    """
    chosen = choose_channels(recording, answers, file_name)
    measured, shaft = chosen.measured, shaft_of(chosen, answers)
    notes = [*chosen.notes, *shaft.notes]
    min_cam_speed = float(np.min(np.diff(shaft.cam_angles) / np.diff(shaft.times)))
    band = None if answers.band is None else float(answers.band)
    bands = [band_of(channel, band, answers.angle_count, min_cam_speed) for channel in measured]
    notes += [note for _, _, note in bands if note]
    angles = max(points for _, points, _ in bands)
    reach = max(low_pass.reach for low_pass, _, _ in bands)
    span = (
        max(channel.start for channel in measured),
        min(channel.start + channel.step * (len(channel.values) - 1) for channel in measured),
    )

    def cut(offset: float) -> tuple[CycleGrid, list[_Filtered]]:
        grid = grid_of(shaft, angles, offset, reach, span)
        return grid, [
            _Filtered(channel, low_pass, low_pass.at(channel.values, channel.start, grid.times))
            for channel, (low_pass, _, _) in zip(measured, bands, strict=True)
        ]

    offset, alignment = float(answers.offset or 0.0), None
    if answers.offset is None and case_lift is not None:
        grid, filtered = cut(0.0)
        if (lift := _lift_of(filtered)) is None:
            raise InputError(
                "there is no lift to align to the case by; name its channel, or state the offset of the mark",
                "offset",
            )
        alignment = align_lift(grid.cam_angle, np.nanmedian(lift.values, axis=0), case_lift)
        offset = alignment.offset
    grid, filtered = cut(offset)
    outliers: dict[int, str] = {}
    for channel in filtered:
        # about the median of each cycle, so that a drift makes no outlier
        about_median = channel.values - np.median(channel.values, axis=1)[:, np.newaxis]
        for cycle, why in outliers_of(about_median):
            outliers.setdefault(cycle, f"{why} ({channel.raw.quantity})")
    # never a cycle with gaps; outliers where they are requested or all are
    whole = [k for k in range(grid.cycles) if not outliers.get(k, "").startswith("was not")]
    alike = [cycle for cycle in whole if cycle not in outliers]
    retained = whole if answers.keep_outliers else alike or whole
    if not retained:
        raise InputError(
            f"no cycle of {file_name[:80]} was measured as a whole; cut the gaps out of the recording"
        )
    uncertainty = alignment.uncertainty if alignment else 0.0
    dwells = _dwell_times(filtered, shaft, grid, offset, answers, outliers, notes)
    cam_speed = float(np.mean(grid.cam_speeds[retained]))
    channels = []
    for raw, low_pass, values in filtered:
        zero, quantity, taken_off = answers.zero.get(raw.quantity), raw.quantity, np.zeros(0)
        if zero and dwells is None:
            raise InputError(f"{file_name[:80]} does not say {DWELL}; answer it", "dwell")
        if dwells is not None and (zero or quantity.endswith("lift")):
            due, where = dimension_due(quantity), f"zero of {quantity}"
            level = parse_quantity(zero, due, where) if zero else 0.0
            values, taken_off = set_to_zero(values, raw, grid, dwells, level)
        values = np.ascontiguousarray(values[retained])
        remarks = [
            f"low-passed without phase, flat to {low_pass.pass_band:.5g} Hz and down by 80 dB from {low_pass.stop_band:.5g} Hz on"
        ]
        if len(taken_off):
            remarks.append(
                f"zero taken off in the dwell: {taken_off.min():.4g} to {taken_off.max():.4g} {raw.unit}"
            )
        cycles = MeasuredCycles(
            raw.quantity,
            raw.unit,
            grid.cam_angle,
            values,
            cam_speed,
            file_name,
            recording.synthetic,
            tuple(remarks),
        )
        spread = mean_spread(
            values, float(grid.cam_angle[1]), float(np.hypot(uncertainty, shaft.repeated))
        )
        channels.append(
            RigChannelCycles(
                cycles,
                raw,
                low_pass.pass_band,
                spread,
                taken_off,
                is_clipped(raw.values),
                drift_of(values),
            )
        )
    return RigResult(
        file_name,
        recording.form,
        tuple(channels),
        shaft,
        grid,
        tuple(retained),
        tuple(sorted(outliers.items())),
        offset,
        uncertainty,
        alignment,
        recording.synthetic,
        tuple(dict.fromkeys(notes)),
        answers.offset is not None or alignment is not None,
    )


def _lift_of(filtered: list[_Filtered]) -> _Filtered | None:
    return next((channel for channel in filtered if channel.raw.quantity.endswith("lift")), None)


def _dwell_times(
    filtered: list[_Filtered],
    shaft: ShaftAngle,
    grid: CycleGrid,
    offset: float,
    answers: RigAnswers,
    left_out: Collection[int],
    notes: list[str],
) -> Array | None:
    """Times (s) at which each dwell within the recording begins and ends, shape (dwells, 2), none
    of a cycle that is an outlier; None where no dwell is stated or found from a lift.
    """
    if answers.dwell is not None:
        first, last = (float(angle) for angle in answers.dwell)
        if not 0 < last - first < REVOLUTION:
            raise InputError(
                "the dwell ends before it begins, or is longer than a revolution; give first and last cam angle",
                "dwell",
            )
    else:
        if (lift := _lift_of(filtered)) is None:
            return None
        angles = np.linspace(0.0, REVOLUTION, DWELL_ANGLES, endpoint=False)
        times = shaft.times_at(shaft.angle_at(grid.cut_times[:-1, np.newaxis]) + angles)
        lifts = lift.low_pass.at(lift.raw.values, lift.raw.start, times)
        dwell = dwell_of(np.nanmedian(lifts, axis=0), angles)
        if dwell is None:
            return None
        first, last = dwell
        notes.append(
            f"the dwell is taken from {np.degrees(first):.1f} to {np.degrees(last):.1f} cam deg, where the lift rests"
        )
    turns = np.round((shaft.angle_at(grid.cut_times) + offset) / REVOLUTION)
    starts = REVOLUTION * np.arange(turns[0] - 1, turns[-1] + 1)[:, np.newaxis]
    edges = starts + np.array([first, last]) - offset
    inside = (edges[:, 0] >= shaft.cam_angles[0]) & (edges[:, 1] <= shaft.cam_angles[-1])
    dwells: Array = shaft.times_at(edges[inside])
    begins, ends = grid.cut_times[:-1], grid.cut_times[1:]
    good = [
        not any(first < ends[cycle] and last > begins[cycle] for cycle in left_out)
        for first, last in dwells
    ]
    return dwells[good] if any(good) else dwells
