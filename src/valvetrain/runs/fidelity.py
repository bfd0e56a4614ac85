"""Fidelity of spring models: all models over engine speed, compared with a reference and the
numerical error of both.

Every model runs as the case has it and again with its springs divided more finely; the change gives
its error bar (Roache 1994, two grids). A model without a division, such as a spring without mass,
has none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.registry import names as registered_names
from valvetrain.runs.cost import Cost, Limits, limits_of, refuse_cost
from valvetrain.runs.error_bars import two_grids
from valvetrain.runs.refine_trains import divided
from valvetrain.runs.request_cost import RunRequest, request_cost
from valvetrain.runs.run import run_problem
from valvetrain.runs.stopping import StudyStopped
from valvetrain.runs.train_runs import Finished
from valvetrain.runs.watch import shows_progress
from valvetrain.runs.workers import Progress, worker_count
from valvetrain.solution.fidelity import FidelityMap, FidelityRow
from valvetrain.solution.later import replaced
from valvetrain.solution.study import Study
from valvetrain.springs.modal_uniform import oscillating_modes
from valvetrain.springs.own_spring import model_names
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.problem import Member, Problem
from valvetrain.units import Given, as_names, known_arguments, si_speeds

MODES_WORD = "modal-uniform"
#: Elements, masses or modes of the second run of a model over those of its first.
FINER = 1.5
#: Reference model for springs with a wire, for cards without and for cards with stiffness damping,
#: which the wave equation of the rod does not have.
REFERENCES = {"wire": "finite-element", "card": "wave-rod", "card, stiffness-damped": MODES_WORD}
#: Modes of a reference by modes, fewer where damping is critical before.
REFERENCE_MODES = 80
#: Share of the reference's largest value up to which a model is good enough.
TOLERANCE = 0.05
#: Quantities by which models are judged, where the reference has them.
JUDGED = (
    "peak_spring_force", "minimum_spring_force", "peak_retainer_force", "surge_amplitude_force", "clash_energy",
    "seating_velocity", "peak_cam_contact_force", "minimum_cam_contact_force", "peak_seat_contact_force", "lift_loss_displacement",
    "bounce_height", "cycle_work_energy",
)  # fmt: skip
#: Quantities that are zero in a run without the event: no clash, no bounce.
NONE_IS_ZERO = ("clash_energy", "bounce_height", "lift_loss_displacement")
#: A quantity of which the reference is nowhere larger than this (SI) is not compared.
NOTHING = 1e-9


@known_arguments
@shows_progress("fidelity")
def fidelity(
    case: AnyCase,
    engine_speeds: Given | Sequence[Given] = "1000:9000:500 rpm",
    spring_models: Sequence[str] | str = (),
    *,
    spring_set: Sequence[str] | str = "",
    reference: str = "",
    tolerance: float = TOLERANCE,
    workers: int | None = None,
    progress: Progress | None = None,
    limit: str = "",
    implausible: bool = False,
) -> Study:
    """All spring models over engine speed against a reference: up to which speed each is good
    enough, for which quantity, at which cost.

    Parameters
    ----------
    case, workers, progress, limit, implausible : as for :func:`simulate`
    engine_speeds : speeds of the crank, "1000:9000:500 rpm" (first:last:step), rad/s or pint
        quantities
    spring_models : a model that is judged, or several; all that can run by default
    spring_set : spring set of a train, its own by default
    reference : the model they are judged by; finite elements where the wire is known, else the
        equivalent rod, or 80 modes where the damping of the springs has a share by stiffness
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
    >>> found.models, found.reach("peak_spring_force", "multi-mass").text
    (('massless', 'multi-mass'), 'all')
    """
    chosen, speeds, limits = case_of(case), si_speeds(engine_speeds), limits_of(limit)
    refuse_tolerance(tolerance)
    if len(sets := as_names(spring_set)) > 1:
        raise InputError("models are compared on one spring set; name one of them", "spring_set")
    own = "".join(sets)
    models = fidelity_models(chosen, model_names(spring_models), own, reference)
    cost = fidelity_cost(chosen, speeds, models, own, worker_count(workers))
    refuse_cost(cost, limits, "limit=")
    return fidelity_study(
        chosen,
        speeds,
        spring_models=models,
        spring_set=own,
        tolerance=tolerance,
        workers=workers,
        progress=progress,
        limits=limits,
        implausible=implausible,
    )


def refuse_tolerance(tolerance: float) -> None:
    """Raise :class:`InputError` for a tolerance that is not a share."""
    if not 0 < tolerance < 1:
        meant = f"write '{tolerance:g} %'" if 1 <= tolerance < 100 else "write it such as '5 %'"
        raise InputError(
            f"a tolerance is a share between 0 and 1, and {tolerance:g} is none; {meant}",
            "tolerance",
        )


def fidelity_cost(
    case: Case,
    engine_speeds: tuple[float, ...],
    spring_models: tuple[str, ...],
    spring_set: str,
    workers: int,
) -> Cost:
    """Estimated cost: every model at every speed, and again with :data:`FINER` times the parts."""
    sets = (spring_set,) if spring_set else _own_set(case)
    once = request_cost(
        RunRequest("sweep", case, engine_speeds, spring_models, sets, workers), whole=False
    )
    return Cost((1 + FINER**2) * once.seconds, FINER * once.bytes)


def fidelity_models(
    case: Case, spring_models: Sequence[str] = (), spring_set: str = "", reference: str = ""
) -> tuple[str, ...]:
    """Names of the models that run, the cheapest first and the reference last.

    Raises :class:`InputError` where the reference cannot run, for a case without motion, and for an
    unknown spring set.
    """
    if case.lift_law is None:
        raise InputError(
            f"case '{case.name}' holds no lift law, so its spring does not move; add a [lift_law] table",
            "lift_law",
        )
    if case.train is None and spring_set:
        raise InputError(
            f"case '{case.name}' is a spring alone and has no spring sets; leave them out",
            "spring_set",
        )
    if case.train is not None and spring_set and spring_set not in case.train.springs:
        raise InputError(
            f"there is no spring set '{spring_set[:40]}'; use one of {', '.join(case.train.springs)}",
            "spring_set",
        )
    springs = case.springs
    if case.train is not None:
        springs = case.train.spring_parts(*((spring_set,) if spring_set else _own_set(case)))

    def refusal(name: str) -> str:
        reasons = (spring_model(name).why_not(spring) for spring in springs)
        spec = spring_model(name)
        alone = "" if case.train is None else spec.alone
        return spec.no_motion or alone or next(filter(None, reasons), "")

    kind = "card" if any(spring.wire is None for spring in springs) else "wire"
    if kind == "card" and any(spring.damping.stiffness_damping > 0 for spring in springs):
        kind = "card, stiffness-damped"
    best = reference or REFERENCES[kind]
    if not springs:
        raise InputError(
            f"case '{case.name}' has no spring whose models could be compared; add one", "spring"
        )
    spring_model(best, "reference")
    if why := refusal(best):
        raise InputError(f"the reference cannot run: {why}; name another", "reference")
    # The wire of a card is assumed, so its rod is not a default.
    assumed = "" if kind == "wire" else REFERENCES["wire"]
    chosen = tuple(dict.fromkeys(spring_models)) or tuple(
        name
        for name in registered_names("springs")
        if not (refusal(name) or spring_model(name).alone) and name != assumed
    )
    for name in chosen:
        spring_model(name, "spring_models")
        if why := refusal(name):
            raise InputError(f"{why}; leave {name} out", "spring_models")
    judged = sorted(
        (name for name in chosen if name != best or name == MODES_WORD),
        key=lambda name: spring_model(name).processor_time,
    )
    if not judged:
        raise InputError("there is no model but the reference; name one more", "spring_models")
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
    the reference last.
    """
    speeds = tuple(sorted({float(speed) for speed in engine_speeds}))
    if not speeds:
        raise InputError(
            "a comparison over speed needs at least one engine speed; write such as '1000:9000:500 rpm'",
            "engine_speeds",
        )
    sets = (spring_set,) if spring_set else _own_set(case)
    problem = _with_reference(
        build(case, spring_models=spring_models, spring_set=sets), spring_models
    )

    def study(of: Problem, tell: Finished | None, begin: float, end: float) -> Study:
        def part(done: float, text: str) -> None:
            if progress is not None:
                progress(begin + (end - begin) * done, text)

        return run_problem(
            of,
            speeds,
            workers=workers,
            progress=part,
            created_at=created_at,
            command="sweep",
            whole=False,
            finished=tell,
            limits=limits,
            implausible=implausible,
        )

    finer = _finer(problem)
    divided = tuple(member.label for one in finer for member in one.members)
    step = 0.6 / max(1, len(finer))
    studies: list[Study] = []
    stopped = False
    try:
        studies.append(study(problem, finished, 0.0, 0.4))
        for number, one in enumerate(finer):
            studies.append(study(one, None, 0.4 + step * number, 0.4 + step * (number + 1)))
    except StudyStopped as stop:
        studies, stopped = [*studies, stop.study], True
    own, *fine = studies
    compared = _compared(problem, own, fine, divided, tolerance)
    result = replaced(own, command="fidelity", fidelity=compared)
    if stopped:
        raise StudyStopped(result)
    return result


def _own_set(case: Case) -> tuple[str, ...]:
    if case.train is None:
        return ()
    return (case.train.spring_set or next(iter(case.train.springs)),)


def _with_reference(problem: Problem, spring_models: Sequence[str]) -> Problem:
    """The problem with the reference as its last member; modes are judged by many modes of their
    own, of which 1.5 times as many still oscillate where that leaves any.
    """
    *judged, best = spring_models
    if best != MODES_WORD:
        return problem
    own = next(member for member in problem.members if member.model.word == best)
    counts = [_reference_modes(own, spring) for spring in own.springs]
    springs = tuple(
        spring.with_options(best, modes=count)
        for spring, count in zip(own.springs, counts, strict=True)
    )
    reference = replace(own, label=f"{best}, {max(counts)} modes", springs=springs)
    others = problem.only(lambda member: member.model.word in judged)
    return replace(problem, members=(*others, reference), built={})


def _reference_modes(member: Member, spring: InstalledSpring) -> int:
    given = member.model.read_options(spring.options_of(MODES_WORD)).model_dump()["modes"]
    return max(
        1, int(oscillating_modes(spring, round(FINER * max(given, REFERENCE_MODES))) / FINER)
    )


def _finer(problem: Problem) -> list[Problem]:
    """A problem for each member whose springs can be divided more finely, with them so divided."""
    problems = []
    for member in problem.members:
        springs = tuple(divided(member, spring, FINER) for spring in member.springs)
        if springs != member.springs:
            finer = replace(member, springs=springs)
            problems.append(replace(problem, members=(finer,), built={}))
    return problems


def _compared(
    problem: Problem, own: Study, fine: Sequence[Study], divided: tuple[str, ...], tolerance: float
) -> FidelityMap:
    specs = {member.label: member.model for member in problem.members}
    *judged, best = specs
    rows = []
    for name in JUDGED:
        series = {}
        for model, spec in specs.items():
            zero = name != "clash_energy" or "clash" in spec.shows
            series[model] = _series(
                own, fine, model, name, model in divided, zero and name in NONE_IS_ZERO
            )
        sizes = (abs(value) for value, _ in series[best].values() if math.isfinite(value))
        scale = max(sizes, default=0.0)
        if scale <= NOTHING:
            continue
        for model in judged:
            for speed, (value, error) in series[model].items():
                reference = series[best].get(speed, (math.nan, math.nan))
                rows.append(FidelityRow(name, model, speed, value, error, *reference, scale))
    costs = sorted(
        ((model, spec.processor_time) for model, spec in specs.items()), key=lambda pair: pair[1]
    )
    return FidelityMap(best, tolerance, tuple(rows), tuple(costs), divided)


def _series(
    own: Study, fine: Sequence[Study], label: str, name: str, divided: bool, zero: bool
) -> dict[float, tuple[float, float]]:
    """Engine speed -> value and half width of its error bar, of the runs of one label; ``zero``: a
    missing value is zero.

    The bar is NaN for a model that is not ``divided``, infinite where one that is has no value of
    its finer run.
    """
    missing = 0.0 if zero else math.nan
    finer = {run.engine_speed: run for one in fine for run in one.runs(label)}
    found = {}
    for run in own.runs(label):
        value = run.quantities.get(name, missing) if run.status.completed else math.nan
        other = finer.get(run.engine_speed)
        finer_value = (
            other.quantities.get(name, missing)
            if other is not None and other.status.completed
            else math.nan
        )
        error = math.inf if divided and math.isfinite(value) else math.nan
        if math.isfinite(finer_value) and math.isfinite(value):
            error = two_grids(value, finer_value, FINER).uncertainty
        found[run.engine_speed] = (float(value), float(error))
    return found
