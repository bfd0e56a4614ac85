"""What a program calls: simulate, compare, sweep. Speeds and cases in the forms people write them."""

from __future__ import annotations

import os
from collections.abc import Sequence

from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import load_case
from valvetrain.solution.study import Study
from valvetrain.studies.compare import compare_study
from valvetrain.studies.engine import Progress
from valvetrain.studies.run import run_study
from valvetrain.studies.sweep import sweep_study
from valvetrain.units import Given, si_speeds

#: A case, the name of a library case or the path of a case file.
AnyCase = Case | str | os.PathLike[str]
#: Engine speeds: ``"4200, 5600 rpm"``, ``"1000:9000:100 rpm"``, one or several numbers (rad/s of the crank), pint quantities.
Speeds = Given | Sequence[Given]


def simulate(
    case: AnyCase, engine_speeds: Speeds | None = None, *, spring_models: Sequence[str] = (), spring_sets: Sequence[str] = (),
    workers: int | None = None, progress: Progress | None = None,
) -> Study:  # fmt: skip
    """Run a case at its engine speeds, or at those given, by its variants or by the spring models asked for.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file
    engine_speeds : speeds of the crank, "4200 rpm", rad/s or pint quantities; the case's own by default
    spring_models : words of spring models, such as "multi-mass"; the case's own or the usual ones by default
    spring_sets : names of spring sets of a train
    workers : runs at a time; results do not depend on it
    progress : told the share done and what was done

    Returns
    -------
    Study with one solution per run; a run that fails is a status in it

    Raises
    ------
    InputError : one sentence on what cannot be built or run, and the remedy

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.simulate("job-t", "2000 rpm", spring_models=["massless"])
    >>> round(study.solution("massless").quantities["peak_spring_force"])
    522
    """
    return run_study(
        _case(case), engine_speeds=_speeds(engine_speeds), spring_models=spring_models, spring_sets=spring_sets, workers=workers,
        progress=progress,
    )  # fmt: skip


def compare(
    case: AnyCase, spring_models: Sequence[str] = (), engine_speeds: Speeds | None = None, *, spring_sets: Sequence[str] = (),
    workers: int | None = None, progress: Progress | None = None,
) -> Study:  # fmt: skip
    """A case by several spring models side by side, at rest and in motion; arguments as in :func:`simulate`.

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.compare("job-t", ["massless", "wave-rod"], "2000 rpm")
    >>> [round(one.curve.force_at(7e-3)) for one in study.rest]
    [215, 215]
    """
    return compare_study(
        _case(case), engine_speeds=_speeds(engine_speeds), spring_models=spring_models, spring_sets=spring_sets, workers=workers,
        progress=progress,
    )  # fmt: skip


def sweep(
    case: AnyCase, engine_speeds: Speeds = "1000:9000:100 rpm", *, spring_models: Sequence[str] = (), spring_sets: Sequence[str] = (),
    workers: int | None = None, progress: Progress | None = None,
) -> Study:  # fmt: skip
    """A case over engine speed; solutions are reduced to events and named quantities. Arguments as in :func:`simulate`.

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.sweep("job-t", "1000:3000:1000 rpm", spring_models=["massless"])
    >>> speeds, force = study.series("massless", "peak_spring_force")
    >>> len(speeds), round(force[0])
    (3, 522)
    """
    speeds = _speeds(engine_speeds)
    assert speeds is not None
    return sweep_study(
        _case(case), speeds, spring_models=spring_models, spring_sets=spring_sets, workers=workers, progress=progress
    )  # fmt: skip


def _case(case: AnyCase) -> Case:
    return case if isinstance(case, Case) else load_case(case)


def _speeds(engine_speeds: Speeds | None) -> tuple[float, ...] | None:
    return None if engine_speeds is None else si_speeds(engine_speeds)
