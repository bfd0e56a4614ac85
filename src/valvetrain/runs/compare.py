"""A case by several spring models side by side: at rest and in motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.prepared import law_lift
from valvetrain.runs.requests import Compare, Watch
from valvetrain.runs.run import run_problem
from valvetrain.runs.statics import STEPS, reach_of, statics_by_model
from valvetrain.runs.stopping import StudyStopped
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import PartialFailures
from valvetrain.solution.study import Study
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import COMPARED_ALONE, COMPARED_IN_TRAIN, build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Problem

SOLID = "solid"


def compare_study(request: Compare, watch: Watch = Watch()) -> Study:
    """A case by each of the models requested (:data:`COMPARED_ALONE` or :data:`COMPARED_IN_TRAIN` by
    default): its runs, and every spring at rest by each model.

    A model that cannot represent a spring is a status in its runs. Raises :class:`InputError` for
    what cannot be built and when no model can run.
    """
    case = request.case
    chosen = request.models or _default_models(case, request.spring_sets)
    if SOLID in chosen and case.train is None and case.lift_law is None:
        raise InputError(
            f"case '{case.name}' holds no lift law, and solid finite elements are compared in motion; add a [lift_law] table or leave solid out",
            "models",
        )
    if case.train is not None and SOLID in chosen:
        raise InputError(
            f"solid finite elements are compared as a spring alone, and case '{case.name}' is a train; leave solid out, or run it by them",
            "models",
        )
    moving = tuple(word for word in chosen if not spring_model(word, "models").no_motion)
    problem = build(
        case, spring_models=moving or ("finite-element",), spring_set=request.spring_sets
    )
    given = request.engine_speeds
    speeds = (problem.engine_speeds if given is None else given) if moving else ()
    study = run_problem(problem, speeds, request, watch)
    if problem.kind == TRAIN:
        return study
    lift = law_lift(problem)
    rest: list[SpringAtRest] = []
    failures, stopped = PartialFailures(study.gaps), False
    try:
        for spring in problem.springs:
            _by_each_model(study, problem, spring, chosen, lift, (rest, failures))
    except KeyboardInterrupt:
        stopped = True
    done = replace(
        study,
        rest=tuple(rest) or study.rest,
        gaps=failures.sentences,
    )
    if stopped:
        raise StudyStopped(done)
    return done


def _default_models(case: Case, spring_sets: Sequence[str]) -> tuple[str, ...]:
    """The default models that can represent the springs."""
    models: tuple[str, ...] = COMPARED_ALONE
    springs = case.springs
    if (train := case.train) is not None:
        sets = tuple(spring_sets) or ("",)
        models = COMPARED_IN_TRAIN
        springs = tuple(spring for name in sets for spring in train.spring_parts(name))
    return tuple(
        word for word in models if not any(spring_model(word).why_not(spring) for spring in springs)
    )


def _by_each_model(
    study: Study,
    problem: Problem,
    spring: InstalledSpring,
    chosen: tuple[str, ...],
    lift: float,
    into: tuple[list[SpringAtRest], PartialFailures],
) -> None:
    """One spring at rest by every model that can represent it, the rod first."""
    rest, failures = into
    reach = reach_of(spring, lift) if spring.wire is not None else spring.precompression + lift
    compressions = np.linspace(0.0, max(reach, 1e-6), STEPS + 1)
    own = next((one for one in study.rest if one.spring == spring.name), None)

    def by(word: str) -> SpringAtRest:
        return statics_by_model(spring, word, problem.model_of(word, spring, own), compressions, 12)

    order = [word for word in ("finite-element", *chosen) if word in chosen]
    for word in dict.fromkeys(order):
        spec = spring_model(word)
        if not spec.no_statics and not spec.why_not(spring):
            one = failures.part(f"spring '{spring.name}' at rest by {word}", None, by, word)
            rest += [one] if one is not None else []
