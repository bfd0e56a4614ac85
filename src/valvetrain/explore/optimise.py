"""What a program calls: an optimisation file, or its text, to the best designs."""

from __future__ import annotations

import os
from pathlib import Path

from valvetrain.explore.objective import read_optimum
from valvetrain.explore.optimum import Optimum
from valvetrain.explore.optimum_file import OptimumText, read_optimum_file
from valvetrain.explore.search import run_search
from valvetrain.runs.cost import limits_of
from valvetrain.runs.workers import Progress, available_cores


def optimise(
    file: str | os.PathLike[str],
    *,
    workers: int | None = None,
    dask: str = "",
    output: str | os.PathLike[str] | None = None,
    limit: str = "",
    progress: Progress | None = None,
) -> Optimum:
    """Search springs and lift laws for the best values of any quantities within bounds on any
    others.

    Parameters
    ----------
    file : path of an optimisation file (docs/optimisation.md), or its text
    workers : points at a time; results do not depend on it
    dask : "local", the address of a Dask scheduler or the word of a queue ("slurm", "pbs"); empty
        for processes of this machine
    output : folder that keeps finished points, so that a search that was stopped or killed goes on
        there; nothing is kept by default
    limit : largest estimated time and memory, such as "2 h, 8 GB"; 10 min and 2 GB by default
    progress : told the share done and what was done

    Returns
    -------
    Optimum with every trial in SI, the case itself as trial 0, the best design or the front of
    several objectives, sensitivities at the
    best, and what other models say of it

    Raises
    ------
    InputError : one sentence on what is wrong in the file and where, or on a request that is too
        large
    MissingExtraError : the library of the search is not installed

    Examples
    --------
    The least force at rest with 20 mm of lift left until the coils are solid:

    >>> import valvetrain as vt
    >>> found = vt.optimise('''
    ... case = "job-c"
    ... vary = [{ key = "spring.precompression", low = "5 mm", high = "9 mm" }]
    ... objective = [{ quantity = "preload", direction = "minimise" }]
    ... constraint = [{ quantity = "installed_compression", at_least = "6 mm" }]
    ... rest_model = "massless"
    ... search = { trials = 12 }
    ... ''', workers=1)
    >>> round(1e3 * float(found.best.trial.values[0]), 1)
    6.0
    """
    if isinstance(file, str) and "=" in file and "\n" in file:
        text = OptimumText(file, "optimisation", Path())
    else:
        text = read_optimum_file(Path(file))
    folder = None if output is None else Path(output)
    return run_search(
        read_optimum(text),
        available_cores() if workers is None else workers,
        dask,
        folder,
        limits_of(limit),
        progress,
    )
