"""A recording of a test rig laid over the cam of a case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measurements.reader_process import read_recording
from valvetrain.measurements.rig_answers import RigAnswers
from valvetrain.measurements.rig_cycles import Lift, cycles_in
from valvetrain.measurements.rig_result import RigResult
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.system.build import build

Array = NDArray[np.float64]


def rig_cycles(file: str | Path, answers: RigAnswers | None = None, case: AnyCase | None = None) -> RigResult:
    """Force, lift, strain and motion that a test rig recorded, cycle by cycle over the cam angle.

    Parameters
    ----------
    file : recording: text of columns, MDF 4, TDMS, MAT, HDF5 or NetCDF, universal file 58; the content decides, not the name
    answers : what the file does not say itself, such as ``RigAnswers(angle_of="crank", teeth=60, missing=2)``
    case : Case, name of a library case, or path of a case file, whose valve lift tells what cam angle the rig's mark is

    Returns
    -------
    RigResult with MeasuredCycles of every channel (SI), where they were cut, and what was found on the way

    Raises
    ------
    InputError : a file that cannot be read, one sentence with all questions that are open, a recording without a whole cycle

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
    return cycles_in(recording, path.name, given, None if case is None or given.offset is not None else valve_lift_of(case))


def valve_lift_of(case: AnyCase) -> Lift:
    """The lift (m over cam rad) that a probe at the valve of a case shows where all parts are rigid and follow the cam.

    Raises :class:`InputError` for a case without a lift.
    """
    found = case_of(case)
    problem = build(found)
    if not problem.moves:
        raise InputError(f"case '{found.name}' has no lift law to align to; add one, or state the offset of the mark", "case")
    gear = problem.members[0].gear
    if gear is not None:
        kinematics = gear.mechanism.kinematics
        return lambda angle: np.asarray(kinematics.valve_lift(angle), dtype=float)
    return lambda angle: np.asarray(problem.valve_lift.lift(angle), dtype=float)
