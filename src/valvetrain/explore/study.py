"""What a program calls: a study file, or its text, to a table of points."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.executors import executor_for
from valvetrain.explore.experiment import run_points
from valvetrain.explore.plan import StudyPlan, read_plan
from valvetrain.explore.sensitivity import sensitivity_of, surrogate_of
from valvetrain.explore.study_file import StudyText, read_study_file
from valvetrain.explore.table import Array, StudyTable
from valvetrain.runs.cost import Limits, read_limits
from valvetrain.runs.workers import Progress, available_cores


def study(
    file: str | os.PathLike[str],
    *,
    workers: int | None = None,
    dask: str = "",
    output: str | os.PathLike[str] | None = None,
    limit: str = "",
    progress: Progress | None = None,
) -> StudyTable:
    """Points of a study over any quantities of a case: how outputs scatter, what makes them
    scatter, what lies between.

    Parameters
    ----------
    file : path of a study file (docs/studies.md), or its text
    workers : points at a time; results do not depend on it
    dask : "local", the address of a Dask scheduler or the word of a queue ("slurm", "pbs"); empty
        for processes of this machine
    output : folder that keeps finished points, so that a study that was stopped or killed goes on
        there; nothing is kept by default
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    progress : told the share done and what was done

    Returns
    -------
    StudyTable with a row per point: inputs (n, d) and outputs (n, m) in SI, how each ended, Sobol
    indices and surrogates where asked for

    Raises
    ------
    InputError : one sentence on what is wrong in the file and where, or on a request that is too
        large
    MissingExtraError : Dask or a surrogate is asked for and not installed

    Examples
    --------
    >>> import valvetrain as vt
    >>> table = vt.study('''
    ... case = "job-c"
    ... engine_speeds = "4000 rpm"
    ... spring_models = "massless"
    ... outputs = "peak_spring_force"
    ... points = { sampler = "list" }
    ... vary = [{ key = "spring.precompression", values = "6, 8 mm" }]
    ... ''', workers=1)
    >>> bool(table.column("peak_spring_force")[1] > table.column("peak_spring_force")[0])
    True
    """
    if isinstance(file, str) and "=" in file and "\n" in file:
        text = StudyText(file, "study", Path())
    else:
        text = read_study_file(Path(file))
    limits = read_limits((limit,) if limit else (), "limit")
    return study_of(
        read_plan(text),
        available_cores() if workers is None else workers,
        dask,
        None if output is None else Path(output),
        limits,
        progress,
    )


def study_of(
    plan: StudyPlan,
    workers: int,
    dask: str = "",
    folder: Path | None = None,
    limits: Limits = Limits(),
    progress: Progress | None = None,
) -> StudyTable:
    """The table of a plan, analysed as its kind says; see :func:`study`."""
    if workers < 1:
        raise InputError(f"workers must be 1 or more; it is {workers}", "--workers")
    executor = executor_for(workers, dask)
    try:
        table = run_points(plan, executor, folder, limits, progress)
    finally:
        executor.close()
    return analysed(table)


def analysed(table: StudyTable) -> StudyTable:
    """The table with what its kind asks for: Sobol indices, surrogates."""
    plan = table.plan
    rows = {run: table.rows_of(run) for run in plan.runs}
    if plan.kind == "tolerance":
        names = [one.words for one in plan.varied]
        found = [
            sensitivity_of(name, run, names, _sound(table, name)[rows[run]])
            for run in plan.runs
            for name in table.outputs
        ]
        return replace(table, sensitivities=tuple(one for one in found if one is not None))
    if plan.kind == "surrogate":
        made = [
            surrogate_of(name, run, table.inputs[rows[run]], _sound(table, name)[rows[run]])
            for run in plan.runs
            for name in table.outputs
        ]
        return replace(table, surrogates=tuple(one for one in made if one is not None))
    return table


def _sound(table: StudyTable, name: str) -> Array:
    """An output with nan where the point did not complete."""
    return np.where(table.completed, table.column(name), np.nan)
