"""A case over engine speed: reduced runs at many speeds, and the critical speeds between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.runs.cost import Limits
from valvetrain.runs.critical_speeds import CriticalOptions
from valvetrain.runs.engine import Progress
from valvetrain.runs.run import Finished, run_problem
from valvetrain.runs.stopping import StudyStopped
from valvetrain.solution.study import Study
from valvetrain.system.build import build


def sweep_study(
    case: Case,
    engine_speeds: Sequence[float],
    *,
    spring_models: Sequence[str] = (),
    spring_sets: Sequence[str] = (),
    whole: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    created_at: str = "",
    critical: CriticalOptions | None = CriticalOptions(),
    finished: Finished | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> Study:
    """A case over ``engine_speeds`` (rad/s of the crank): solutions, reduced unless ``whole``, and
    of a train its critical speeds between
    the lowest and the highest of them (``critical`` None: not searched).

    By default every spring set of a train by its own model, a spring alone by its usual models.
    Raises :class:`InputError` for no speed
    at all and for what cannot be built.
    """
    speeds = tuple(sorted({float(speed) for speed in engine_speeds}))
    if not speeds:
        raise InputError(
            "a sweep needs at least one engine speed; write such as '1000:9000:100 rpm'",
            "--engine-speed",
        )
    sets = tuple(spring_sets) or (tuple(case.train.springs) if case.train is not None else ())
    problem = build(case, spring_models=spring_models, spring_sets=sets)
    try:
        return _with_critical(
            run_problem(
                problem,
                speeds,
                workers=workers,
                progress=progress,
                created_at=created_at,
                command="sweep",
                whole=whole,
                critical=critical,
                finished=finished,
                limits=limits,
                implausible=implausible,
            )
        )
    except StudyStopped as cut:
        raise StudyStopped(_with_critical(cut.study)) from None


def _with_critical(study: Study) -> Study:
    """The study with its critical speeds among the numbers of no single run."""
    still = {**study.still}
    for label in study.critical_speeds.labels:
        still[label] = {**still.get(label, {}), **study.critical_speeds.quantities(label)}
    return replace(study, still=still)
