"""Which spring model is good enough where: all models over engine speed, each beside the reference
with the numerical error of both.

Every model runs as the case has it and once more with its springs divided more finely; the change
gives its error bar (Roache 1994, two
grids). A model without a division, such as a spring without mass, has none.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.runs.cost import Cost, Limits, limits_of, refuse_cost
from valvetrain.runs.error_bars import two_grids
from valvetrain.runs.refine_trains import divided
from valvetrain.runs.request_cost import RunRequest, request_cost
from valvetrain.runs.run import run_problem
from valvetrain.runs.stopping import StudyStopped
from valvetrain.runs.train_runs import Finished
from valvetrain.runs.workers import Progress, worker_count
from valvetrain.solution.fidelity import FidelityMap, FidelityRow
from valvetrain.solution.study import Study
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.problem import Problem
from valvetrain.units import Given, si_speeds

#: Elements, masses or modes of the second run of a model over those of its first.
FINER = 1.5
#: The model that others are judged by, where the springs' wire is known, and where only their cards
#: are.
REFERENCES = {"wire": "finite-element", "card": "wave-rod"}
#: Share of the reference's largest value up to which a model is good enough.
TOLERANCE = 0.05
#: What models are judged by, where the reference tells it.
JUDGED = (
    "peak_spring_force", "minimum_spring_force", "peak_retainer_force", "surge_amplitude_force", "clash_energy",
    "seating_velocity", "peak_cam_contact_force", "minimum_cam_contact_force", "peak_seat_contact_force", "lift_loss_displacement",
    "bounce_height", "cycle_work_energy",
)  # fmt: skip
#: What is zero where a run that could tell it does not: nothing clashed, nothing bounced.
NONE_IS_ZERO = ("clash_energy", "bounce_height", "lift_loss_displacement")
#: A reference that is nowhere larger than this (SI) gives nothing to compare with.
NOTHING = 1e-9


def fidelity(
    case: AnyCase,
    engine_speeds: Given | Sequence[Given] = "1000:9000:500 rpm",
    *,
    spring_models: Sequence[str] = (),
    spring_set: str = "",
    reference: str = "",
    tolerance: float = TOLERANCE,
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
) -> Study:
    """All spring models over engine speed beside a reference: up to which speed each is good
    enough, for which quantity, at which cost.

    Parameters
    ----------
    case, workers, progress, limit, implausible : as for :func:`simulate`
    engine_speeds : speeds of the crank, "1000:9000:500 rpm" (first:last:step), rad/s or pint
        quantities
    spring_models : models that are judged; all that can run by default
    spring_set : spring set of a train, its own by default
    reference : the model they are judged by; finite elements where the wire is known, else the
        equivalent rod
    tolerance : share of the reference's largest value over the speeds up to which a model is good
        enough

    Returns
    -------
    Study of the runs, whose ``fidelity`` holds the comparison and its verdicts

    Raises
    ------
    InputError : as :func:`simulate`; a reference that cannot run, a tolerance that is no share

    Examples
    --------
    >>> import valvetrain as vt
    >>> found = vt.fidelity("job-t", "2000, 4000 rpm", spring_models=["massless", "multi-mass"], reference="wave-rod").fidelity
    >>> found.models, found.reach("peak_spring_force", "multi-mass").words
    (('massless', 'multi-mass'), 'all')
    """
    chosen, speeds, limits = case_of(case), si_speeds(engine_speeds), limits_of(limit)
    refuse_tolerance(tolerance)
    words = fidelity_models(chosen, spring_models, spring_set, reference)
    refuse_cost(
        fidelity_cost(chosen, speeds, words, spring_set, worker_count(workers)), limits, "limit="
    )
    return fidelity_study(
        chosen,
        speeds,
        spring_models=words,
        spring_set=spring_set,
        tolerance=tolerance,
        workers=workers,
        progress=progress,
        limits=limits,
        implausible=implausible,
    )


def refuse_tolerance(tolerance: float) -> None:
    """Raise :class:`InputError` for a tolerance that is no share."""
    if not 0 < tolerance < 1:
        meant = f"write '{tolerance:g} %'" if 1 <= tolerance < 100 else "write it such as '5 %'"
        raise InputError(
            f"a tolerance is a share between 0 and 1, and {tolerance:g} is none; {meant}",
            "--tolerance",
        )


def fidelity_cost(
    case: Case,
    engine_speeds: tuple[float, ...],
    spring_models: tuple[str, ...],
    spring_set: str,
    workers: int,
) -> Cost:
    """Estimated cost: every model at every speed, and once more with :data:`FINER` times the parts."""
    sets = (spring_set,) if spring_set else _own_set(case)
    once = request_cost(
        RunRequest("sweep", case, engine_speeds, spring_models, sets, workers), whole=False
    )
    return Cost((1 + FINER**2) * once.seconds, FINER * once.bytes)


def fidelity_models(
    case: Case, spring_models: Sequence[str] = (), spring_set: str = "", reference: str = ""
) -> tuple[str, ...]:
    """Words of the models that run, the cheapest first and the reference last. Raises
    :class:`InputError` where it cannot run, for a case
    in which nothing moves, and for a spring set that it has not."""
    if case.lift_law is None:
        raise InputError(
            f"case '{case.name}' holds no lift law, so its spring does not move; add a [lift_law] table",
            "lift_law",
        )
    if case.train is None and spring_set:
        raise InputError(
            f"case '{case.name}' is a spring alone and has no spring sets; leave them out",
            "--spring-set",
        )
    if case.train is not None and spring_set and spring_set not in case.train.springs:
        raise InputError(
            f"there is no spring set '{spring_set[:40]}'; use one of {', '.join(case.train.springs)}",
            "--spring-set",
        )
    springs = (
        case.springs
        if case.train is None
        else case.train.spring_parts(*((spring_set,) if spring_set else _own_set(case)))
    )
    specs = {word: spring_model(word) for word in registry.words("springs")}

    def refusal(word: str) -> str:
        return specs[word].no_motion or next(
            (why for spring in springs if (why := specs[word].why_not(spring))), ""
        )

    kind = "card" if any(spring.wire is None for spring in springs) else "wire"
    best = reference or REFERENCES[kind]
    if not springs:
        raise InputError(
            f"case '{case.name}' has no spring whose models could be compared; add one", "spring"
        )
    spring_model(best, "--reference")
    if why := refusal(best):
        raise InputError(f"the reference cannot run: {why}; name another", "--reference")
    made_up = (
        REFERENCES["wire"] if kind == "card" else ""
    )  # its wire is invented from the card, so it judges nothing
    wanted = tuple(dict.fromkeys(spring_models)) or tuple(
        word for word in specs if not refusal(word) and word != made_up
    )
    for word in wanted:
        spring_model(word, "--spring")
        if why := refusal(word):
            raise InputError(f"{why}; leave {word} out", "--spring")
    judged = sorted(
        (word for word in wanted if word != best), key=lambda word: specs[word].processor_time
    )
    if not judged:
        raise InputError("there is no model beside the reference; name one more", "--spring")
    return (*judged, best)


def fidelity_study(
    case: Case,
    engine_speeds: Sequence[float],
    *,
    spring_models: Sequence[str],
    spring_set: str = "",
    tolerance: float = TOLERANCE,
    workers: int | None = None,
    progress: Progress | None = None,
    created_at: str = "",
    finished: Finished | None = None,
    limits: Limits = Limits(),
    implausible: bool = False,
) -> Study:
    """The study of :func:`fidelity` at ``engine_speeds`` (rad/s of the crank) by ``spring_models``,
    the last of which is the reference.
    """
    speeds = tuple(sorted({float(speed) for speed in engine_speeds}))
    if not speeds:
        raise InputError(
            "a comparison over speed needs at least one engine speed; write such as '1000:9000:500 rpm'",
            "--engine-speed",
        )
    problem = build(
        case,
        spring_models=spring_models,
        spring_sets=(spring_set,) if spring_set else _own_set(case),
    )

    def part(begin: float, end: float) -> Progress | None:
        return (
            None
            if progress is None
            else lambda done, words: progress(begin + (end - begin) * done, words)
        )

    def study(of: Problem, told: Finished | None, share: tuple[float, float]) -> Study:
        return run_problem(
            of,
            speeds,
            workers=workers,
            progress=part(*share),
            created_at=created_at,
            command="sweep",
            whole=False,
            finished=told,
            limits=limits,
            implausible=implausible,
        )

    parts = _finer(problem)
    ends = [0.4 + 0.6 * place / max(1, len(parts)) for place in range(len(parts) + 1)]
    own, fine = None, []
    try:
        own = study(problem, finished, (0.0, 0.4))
        for one, share in zip(parts, itertools.pairwise(ends), strict=True):
            fine.append(study(one, None, share))
    except StudyStopped as cut:
        own = own or cut.study
        raise StudyStopped(
            _judged(
                problem, own, [*fine, cut.study] if own is not cut.study else [], parts, tolerance
            )
        ) from None
    return _judged(problem, own, fine, parts, tolerance)


def _judged(
    problem: Problem, own: Study, fine: Sequence[Study], parts: Sequence[Problem], tolerance: float
) -> Study:
    """The runs with their comparison; a bar whose finer run of ``parts`` is not among ``fine`` is
    unknown.
    """
    words = tuple(member.model.word for one in parts for member in one.members)
    return replace(
        own, command="fidelity", fidelity=_compared(problem, own, fine, words, tolerance)
    )


def _own_set(case: Case) -> tuple[str, ...]:
    if case.train is None:
        return ()
    return (case.train.spring_set or next(iter(case.train.springs)),)


def _finer(problem: Problem) -> list[Problem]:
    """A problem for each member whose springs can be divided more finely, with them so divided."""
    made = []
    for member in problem.members:
        springs = tuple(divided(member, spring, FINER) for spring in member.springs)
        made += (
            [replace(problem, members=(replace(member, springs=springs),), built={})]
            if springs != member.springs
            else []
        )
    return made


def _compared(
    problem: Problem, own: Study, fine: Sequence[Study], divided: tuple[str, ...], tolerance: float
) -> FidelityMap:
    labels = {member.model.word: member.label for member in problem.members}
    specs = {member.model.word: member.model for member in problem.members}
    *judged, best = labels
    rows = []
    for name in JUDGED:
        told = {
            word: _series(
                own,
                fine,
                label,
                name,
                word in divided,
                name in NONE_IS_ZERO and (name != "clash_energy" or "clash" in specs[word].shows),
            )
            for word, label in labels.items()
        }
        scale = max(
            (abs(value) for value, _ in told[best].values() if math.isfinite(value)), default=0.0
        )
        if scale <= NOTHING:
            continue
        for word in judged:
            for speed, (value, error) in told[word].items():
                rows.append(
                    FidelityRow(
                        name,
                        word,
                        speed,
                        value,
                        error,
                        *told[best].get(speed, (math.nan, math.nan)),
                        scale,
                    )
                )
    costs = sorted(
        ((word, specs[word].processor_time) for word in labels), key=lambda pair: pair[1]
    )
    return FidelityMap(best, tolerance, tuple(rows), tuple(costs), divided)


def _series(
    own: Study, fine: Sequence[Study], label: str, name: str, divided: bool, zero: bool
) -> dict[float, tuple[float, float]]:
    """Engine speed -> value and half width of its error bar, of the runs of one label; ``zero``:
    what is not told is zero.

    The bar is NaN for a model that is not ``divided``, infinite where one that is has no value of
    its finer run.
    """
    usual = 0.0 if zero else math.nan
    finer = {run.engine_speed: run for one in fine for run in one.runs(label)}
    found = {}
    for run in own.runs(label):
        value = run.quantities.get(name, usual) if run.status.completed else math.nan
        other = finer.get(run.engine_speed)
        finer_value = (
            other.quantities.get(name, usual)
            if other is not None and other.status.completed
            else math.nan
        )
        error = math.inf if divided and math.isfinite(value) else math.nan
        if math.isfinite(finer_value) and math.isfinite(value):
            error = two_grids(value, finer_value, FINER).uncertainty
        found[run.engine_speed] = (float(value), float(error))
    return found
