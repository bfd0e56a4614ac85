"""From a recording of a test rig to cycles over the cam angle."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.rig.channels import (
    QUESTIONS,
    RigAnswers,
    RigQuantity,
    chosen_channels,
    dimension_due,
)
from valvetrain.rig.cutting import (
    CycleGrid,
    LowPass,
    band_of,
    dwell_of,
    grid_of,
    outliers_of,
    set_to_zero,
)
from valvetrain.rig.recording import Recording, read_recording
from valvetrain.rig.result import (
    APART,
    LiftAlignment,
    RigChannelCycles,
    RigResult,
    align_lift,
    mean_spread,
)
from valvetrain.rig.shaft import TURN, ShaftAngle, shaft_of
from valvetrain.system.build import build
from valvetrain.units import parse_quantity

Array = NDArray[np.float64]
#: Angles at which the dwell is looked for.
DWELL_ANGLES = 720
#: Share by which speeds of cycles may differ before it is told.
STEADY = 0.05
Lift = Callable[[Array], Array]


class _Filtered(NamedTuple):
    raw: RigQuantity
    filter: LowPass
    values: Array


def cycles_in(
    recording: Recording, name: str, answers: RigAnswers, case_lift: Lift | None = None
) -> RigResult:
    """The cycles in a recording.

    Parameters: ``name`` of the file for messages; ``case_lift`` (m of cam rad, periodic), by which
    the angle is aligned where no
    offset is stated. Raises :class:`InputError` for open questions (all in one sentence) and
    recordings without a whole cycle.
    """
    chosen = chosen_channels(recording, answers, name)
    shaft, notes = shaft_of(chosen, answers), list(chosen.notes)
    notes += shaft.notes
    slowest = float(np.min(np.diff(shaft.cam_angles) / np.diff(shaft.times)))
    bands = [band_of(one, answers.band, answers.angle_count, slowest) for one in chosen.measured]  # type: ignore[arg-type]
    notes += [note for _, _, note in bands if note]
    angles = max(points for _, points, _ in bands)
    filters = [filter_ for filter_, _, _ in bands]
    reach = max(filter_.reach for filter_ in filters)
    span = (
        max(one.start for one in chosen.measured),
        min(one.start + one.step * (len(one.values) - 1) for one in chosen.measured),
    )

    def cut(offset: float) -> tuple[CycleGrid, list[_Filtered]]:
        grid = grid_of(shaft, angles, offset, reach, span)
        return grid, [
            _Filtered(one, by, by.at(one.values, one.start, grid.times))
            for one, by in zip(chosen.measured, filters, strict=True)
        ]

    offset, alignment = _offset(answers, case_lift, chosen.measured, cut, notes)
    grid, filtered = cut(offset)
    outliers = _outliers(filtered)
    kept = tuple(
        place for place in range(grid.cycles) if answers.keep_outliers or place not in outliers
    )
    if not kept or (
        answers.keep_outliers and any(why.startswith("was not") for why in outliers.values())
    ):
        kept = tuple(
            place
            for place in range(grid.cycles)
            if not outliers.get(place, "").startswith("was not")
        )
    if not kept:
        raise InputError(
            f"no cycle of {name[:80]} was measured as a whole; cut the gaps out of the recording"
        )
    uncertainty = alignment.uncertainty if alignment else 0.0
    channels = _channels(
        filtered,
        grid,
        kept,
        outliers,
        answers,
        shaft,
        (offset, uncertainty),
        recording.synthetic,
        name,
        notes,
    )
    return RigResult(
        name,
        recording.form,
        channels,
        shaft,
        grid,
        kept,
        tuple(sorted(outliers.items())),
        offset,
        uncertainty,
        alignment,
        recording.synthetic,
        tuple(dict.fromkeys(notes)),
    )


def _offset(
    answers: RigAnswers,
    lift: Lift | None,
    measured: tuple[RigQuantity, ...],
    cut: Callable[[float], tuple[CycleGrid, list[_Filtered]]],
    notes: list[str],
) -> tuple[float, LiftAlignment | None]:
    """Cam angle of the case at the mark: stated, or told by the lift."""
    if answers.offset is not None:
        return float(answers.offset), None
    if lift is None:
        notes.append(
            "cam angles count from the mark of the rig: give a case and a lift, or an offset, to lay them on the cam"
        )
        return 0.0, None
    if not any(one.quantity.endswith("lift") for one in measured):
        raise InputError(
            "there is no lift to align to the case by; name its channel, or state the offset of the mark",
            "offset",
        )
    grid, filtered = cut(0.0)
    lifts = next(one.values for one in filtered if one.raw.quantity.endswith("lift"))
    found = align_lift(grid.cam_angle, np.nanmedian(lifts, axis=0), lift)
    if abs(found.opening - found.closing) > APART:
        notes.append(
            f"the flanks lie {np.degrees(found.opening - found.closing):.2g} cam deg apart from those of the case: wear, lash or a valve "
            "that does not follow the cam; the offset is their middle"
        )
    if abs(found.gain - 1) > 0.03:
        notes.append(
            f"the measured lift is {100 * (found.gain - 1):+.1f} % of the lift of the case; check calibration, lash and cam"
        )
    return found.offset, found


def _outliers(filtered: list[_Filtered]) -> dict[int, str]:
    found: dict[int, str] = {}
    for one in filtered:
        for place, why in outliers_of(_level(one.values)):
            found.setdefault(place, f"{why} ({one.raw.quantity})")
    return found


def _level(values: Array) -> Array:
    """Cycles about their own medians, so that a drift makes no outlier."""
    level: Array = values - np.median(values, axis=1)[:, np.newaxis]
    return level


def _channels(
    filtered: list[_Filtered],
    grid: CycleGrid,
    kept: tuple[int, ...],
    left_out: Collection[int],
    answers: RigAnswers,
    shaft: ShaftAngle,
    offset: tuple[float, float],
    synthetic: bool,
    name: str,
    notes: list[str],
) -> tuple[RigChannelCycles, ...]:
    dwell = _dwell(filtered, shaft, grid, offset[0], answers, notes)
    edges = None if dwell is None else _dwell_times(dwell, shaft, grid, offset[0], left_out)
    speeds = grid.cam_speeds[list(kept)]
    speed = float(np.mean(speeds))
    if np.ptp(speeds) > STEADY * speed:
        notes.append(
            f"the cam speed of the cycles differs by {100 * np.ptp(speeds) / speed:.2g} %: a mean over them is none of one speed; cut the "
            "recording where one is wanted"
        )
    found = []
    for raw, by, values in filtered:
        level = _zero(raw.quantity, answers)
        taken_off = np.zeros(0)
        if level is not None:
            if edges is None:
                if raw.quantity in answers.zero:
                    raise InputError(
                        f"{name[:80]} does not say {QUESTIONS['dwell']}; answer it", "dwell"
                    )
            else:
                values, taken_off = set_to_zero(values, raw, grid, edges, level)
        values = np.ascontiguousarray(values[list(kept)])
        told = [
            f"low-passed without phase, flat to {by.pass_band:.5g} Hz and down by 80 dB from {by.stop_band:.5g} Hz on"
        ]
        if len(taken_off):
            told.append(
                f"zero taken off in the dwell: {taken_off.min():.4g} to {taken_off.max():.4g} {raw.unit}"
            )
        spread = mean_spread(
            values, float(grid.cam_angle[1]), float(np.hypot(offset[1], shaft.repeated))
        )
        cycles = MeasuredCycles(
            raw.quantity, raw.unit, grid.cam_angle, values, speed, name, synthetic, tuple(told)
        )
        found.append(RigChannelCycles(cycles, raw, by.pass_band, spread, taken_off))
    return tuple(found)


def _zero(quantity: str, answers: RigAnswers) -> float | None:
    """What a quantity is in the dwell, None where nobody says."""
    if quantity in answers.zero:
        return parse_quantity(
            answers.zero[quantity], dimension_due(quantity), f"zero of {quantity}"
        )
    return 0.0 if quantity.endswith("lift") else None


def _dwell(
    filtered: list[_Filtered],
    shaft: ShaftAngle,
    grid: CycleGrid,
    offset: float,
    answers: RigAnswers,
    notes: list[str],
) -> tuple[float, float] | None:
    """First and last cam angle (rad) of the dwell: told, or found from the lift on a grid of its
    own.
    """
    if answers.dwell is not None:
        first, last = (float(angle) for angle in answers.dwell)
        if not 0 < last - first < TURN:
            raise InputError(
                "the dwell ends before it begins, or is longer than a turn; give first and last cam angle",
                "dwell",
            )
        return first, last
    one = next((one for one in filtered if one.raw.quantity.endswith("lift")), None)
    if one is None:
        return None
    angles = np.linspace(0.0, TURN, DWELL_ANGLES, endpoint=False)
    begins = shaft.angle_at(grid.cut_times[:-1, np.newaxis])
    lifts = one.filter.at(one.raw.values, one.raw.start, shaft.times_at(begins + angles))
    found = dwell_of(np.nanmedian(lifts, axis=0), angles)
    if found is not None:
        notes.append(
            f"the dwell is taken from {np.degrees(found[0]):.1f} to {np.degrees(found[1]):.1f} cam deg, where the lift rests"
        )
    return found


def _dwell_times(
    dwell: tuple[float, float],
    shaft: ShaftAngle,
    grid: CycleGrid,
    offset: float,
    left_out: Collection[int],
) -> Array:
    """Times (s) at which each dwell within the recording begins and ends, shape (dwells, 2); none
    of a cycle that is an outlier.
    """
    turns = np.round((shaft.angle_at(grid.cut_times) + offset) / TURN)
    edges = TURN * np.arange(turns[0] - 1, turns[-1] + 1)[:, np.newaxis] + np.array(dwell) - offset
    inside = (edges[:, 0] >= shaft.cam_angles[0]) & (edges[:, 1] <= shaft.cam_angles[-1])
    times: Array = shaft.times_at(edges[inside])
    begins, ends = grid.cut_times[:-1], grid.cut_times[1:]
    good = [
        not any(first < ends[place] and last > begins[place] for place in left_out)
        for first, last in times
    ]
    return times[good] if any(good) else times


def rig_cycles(
    file: str | Path, answers: RigAnswers | None = None, case: AnyCase | None = None
) -> RigResult:
    """Force, lift, strain and motion that a test rig recorded, cycle by cycle over the cam angle.

    Parameters
    ----------
    file : recording: text of columns, MDF 4, TDMS, MAT, HDF5 or NetCDF, universal file 58; the
        content decides, not the name
    answers : what the file does not say itself, such as
        ``RigAnswers(angle_of="crank", teeth=60, missing=2)``
    case : Case, name of a library case, or path of a case file, whose valve lift tells what cam
        angle the rig's mark is

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
    path = Path(file)
    given = answers or RigAnswers()
    recording = read_recording(path)
    return cycles_in(
        recording,
        path.name,
        given,
        None if case is None or given.offset is not None else valve_lift_of(case),
    )


def valve_lift_of(case: AnyCase) -> Lift:
    """The lift (m over cam rad) that a probe at the valve of a case shows where all parts are rigid
    and follow the cam.

    Raises :class:`InputError` for a case without a lift.
    """
    found = case_of(case)
    problem = build(found)
    if not problem.moves:
        raise InputError(
            f"case '{found.name}' has no lift law to align to; add one, or state the offset of the mark",
            "case",
        )
    gear = problem.members[0].gear
    if gear is not None:
        kinematics = gear.mechanism.kinematics
        return lambda angle: np.asarray(kinematics.valve_lift(angle), dtype=float)
    return lambda angle: np.asarray(problem.valve_lift.lift(angle), dtype=float)
