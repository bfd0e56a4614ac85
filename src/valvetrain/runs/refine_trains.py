"""Error bars of trains: step halved twice, finer springs, fewer samples, other contact constants,
for every variant of the case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from valvetrain.contact.dissipative import damping_number, rebound
from valvetrain.integrate.contract import Periodic, RunOptions
from valvetrain.integrate.run import run
from valvetrain.parameters.case import Case
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.runs.error_bars import (
    OWN,
    ROUNDING,
    STIFFNESS_FACTORS,
    TRAIN_HEADLINES,
    Numbers,
    Stages,
    UncertaintyStudy,
    contact_ranges,
    convergence,
    damped,
    divided,
    stiffened,
)
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    prepare,
    provenance_of,
    with_quantities,
)
from valvetrain.runs.refusals import checked_speeds
from valvetrain.runs.train_runs import member_statics
from valvetrain.runs.workers import LOST, LOST_REMEDY, Progress
from valvetrain.solution.critical import DAMPING_FACTORS
from valvetrain.solution.result import Solution
from valvetrain.solution.status import reason
from valvetrain.solution.uncertainty import CONSTANTS, Uncertainty
from valvetrain.system.build import build
from valvetrain.system.problem import Problem

#: Elements, masses or modes of a spring over those of the case; steps over the default one; samples
#: per cam revolution, half the default.
SPRINGS, STEPS, SAMPLES = (1.5, 2.25), (0.5, 0.25), 720
#: The variant that finite-element springs leave out: their elements and steps would both be 2.25
#: times as many.
TOO_FINE = "springs 3"


class _Job(NamedTuple):
    """One run: variant of the study, index of the member, engine speed (rad/s), step over the
    default, samples per revolution.
    """

    variant: str
    member: int
    engine_speed: float
    step: float = 1.0
    samples: int | None = None


def refine_trains(
    case: Case,
    engine_speeds: Sequence[float] | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
    implausible: bool = False,
) -> UncertaintyStudy:
    """Error bars of every variant of a train: see :func:`valvetrain.runs.refine.refined`; runs over
    ``workers`` processes.

    A run on finite-element springs takes seconds and a finer one many times as long: those get two
    grids of each kind instead of three (:func:`two_grids`).
    """
    problem = build(case).settled()
    speeds = checked_speeds(problem, engine_speeds, implausible)
    variants, failures = _prepare_variants(case, problem)
    jobs = [
        job
        for speed in speeds
        for index in variants[OWN]
        for job in _jobs(variants, index, speed, _is_large(problem, index))
    ]
    labels = [member.label for member in problem.members]

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress(done / total, f"run {done} of {total}")

    def lost(job: _Job) -> tuple[Numbers, str]:
        return {}, f"{labels[job.member]}, {job.variant}: {LOST}; {LOST_REMEDY}"

    stages = Stages()
    found = stages.map(
        _run, (problem, variants, implausible), jobs, workers, processes=True, tell=tell, lost=lost
    )
    by_member: dict[tuple[float, int], dict[str, Numbers]] = {}
    values: dict[str, dict[float | None, Numbers]] = {}
    for number, (numbers, failure) in sorted(found.items()):
        job = jobs[number]
        by_member.setdefault((job.engine_speed, job.member), {})[job.variant] = numbers
        values.setdefault(f"{labels[job.member]}, {job.variant}", {})[job.engine_speed] = numbers
        failures += [failure] if failure else []
    missing = {
        (job.engine_speed, job.member) for number, job in enumerate(jobs) if number not in found
    }
    rows = [
        row
        for (speed, index), numbers_of in by_member.items()
        if (speed, index) not in missing
        for row in _rows(numbers_of, speed, labels[index])
    ]
    study = UncertaintyStudy(
        problem.record,
        (),
        tuple(rows),
        values,
        tuple(failures),
        STIFFNESS_FACTORS,
        DAMPING_FACTORS,
        len(jobs),
        len(found),
    )
    return stages.closed(study)


def _prepare_variants(
    case: Case, problem: Problem
) -> tuple[dict[str, dict[int, PreparedRun]], list[str]]:
    """The runs of every variant by the index of their member, and why others cannot run; a member
    that cannot run at all is reported once.
    """
    found: dict[str, dict[int, PreparedRun]] = {OWN: {}}
    failures: list[str] = []
    for name, (other, factor) in _problems(case, problem).items():
        found[name] = {}
        try:
            built = build(other).settled() if isinstance(other, Case) else other
        except FAILURES as error:
            failures.append(f"{name}: {reason(error)}")
            continue
        for index, member in enumerate(problem.members):
            if name != OWN and (
                index not in found[OWN] or (name == TOO_FINE and _is_large(problem, index))
            ):
                continue
            try:
                prepared = _prepare(built, index, factor)
                refusal = "" if prepared is None else prepared.refusal
                if built.members[index].instead != member.instead:
                    refusal = built.members[index].instead  # another model is no variant
            except FAILURES as error:
                prepared, refusal = None, reason(error)
            if refusal:
                failures.append(f"{member.label}{'' if name == OWN else f', {name}'}: {refusal}")
            elif prepared is not None:
                found[name][index] = prepared
    return found, failures


def _problems(case: Case, problem: Problem) -> dict[str, tuple[Problem | Case, float]]:
    """Problem, or the case to build it from, and division of the springs of every variant."""
    assert case.train is not None
    found: dict[str, tuple[Problem | Case, float]] = {OWN: (problem, 1.0)}
    for n, factor in enumerate(SPRINGS, start=2):
        found[f"springs {n}"] = problem, factor
    own = dict(case.train.contacts)
    for constant, factors in zip(CONSTANTS, (STIFFNESS_FACTORS, DAMPING_FACTORS), strict=True):
        change = stiffened if constant == CONSTANTS[0] else damped
        for n, factor in enumerate(factors, start=1):
            contacts = {name: _with(contact, constant, factor) for name, contact in own.items()}
            springs = {
                name: tuple(change(one, factor) for one in group)
                for name, group in case.train.springs.items()
            }
            changed = case.train.replace(contacts=contacts, springs=springs)
            found[f"{constant} {n}"] = case.replace(train=changed), 1.0
    return found


def _with(contact: ContactParameters, constant: str, factor: float) -> ContactParameters:
    """A contact with another stiffness, or with another damping, which its restitution may replace."""
    values: Mapping[str, Any] = contact.values
    name = "contact_stiffness" if constant == CONSTANTS[0] else "damping"
    if name in values:
        return contact.replace(**{name: factor * values[name]})
    if constant == "damping" and 0 < values.get("restitution", 0.0) < 1:
        return contact.replace(restitution=rebound(factor * damping_number(values["restitution"])))
    return contact


def _prepare(problem: Problem, index: int, factor: float) -> PreparedRun | None:
    """A member with its springs divided more finely, prepared or with its refusal; None where that
    changes nothing.
    """
    member = problem.members[index]
    if factor != 1.0:
        springs = tuple(divided(member, spring, factor) for spring in member.springs)
        if springs == member.springs:
            return None
        member = replace(member, springs=springs)
    return prepare(problem, member, member_statics(problem, member), problem.record.study)


def _is_large(problem: Problem, index: int) -> bool:
    """Whether the springs of a member are too large for many runs."""
    return problem.members[index].model.word == "finite-element"


def _jobs(
    variants: Mapping[str, Mapping[int, PreparedRun]], index: int, speed: float, large: bool
) -> list[_Job]:
    own = [_Job(OWN, index, speed), _Job("step 2", index, speed, STEPS[0])]
    if not large:
        own.append(_Job("step 3", index, speed, STEPS[1]))
        own.append(_Job("samples", index, speed, samples=SAMPLES))
    return own + [
        _Job(name, index, speed)
        for name, members in variants.items()
        if name != OWN and index in members
    ]


def _run(
    shared: tuple[Problem, Mapping[str, Mapping[int, PreparedRun]], bool], job: _Job
) -> tuple[Numbers, str]:
    """Headline numbers of one run and, where it failed, why."""
    problem, variants, implausible = shared
    prepared = variants.get(job.variant, variants[OWN])[job.member]
    position = f"{prepared.member.label}, {job.variant}"
    try:
        solution = _solution(problem, prepared, job, implausible)
    except FAILURES as error:
        return {}, f"{position}: {reason(error)}"
    if not solution.status.completed:
        return {}, f"{position}: {solution.status.sentence()}"
    names = (*TRAIN_HEADLINES, *(f"cycle_scatter_{name}" for name in TRAIN_HEADLINES))
    found = solution.quantities
    return {name: float(found[name]) for name in names if name in found}, ""


def _solution(problem: Problem, prepared: PreparedRun, job: _Job, implausible: bool) -> Solution:
    from valvetrain.integrate.train_leapfrog import LARGE_SAMPLES
    from valvetrain.integrate.train_leapfrog import SAMPLES as TRAIN_SAMPLES
    from valvetrain.integrate.train_run import TrainOptions, runner
    from valvetrain.system.train_system import TrainSystem

    system, cam_speed = prepared.system, job.engine_speed / 2
    assert isinstance(system, TrainSystem)
    step = None
    if job.step != 1.0 or job.samples is not None:
        large = system.has_large_springs
        chosen = TrainOptions(LARGE_SAMPLES if large else TRAIN_SAMPLES)
        default = runner(system, cam_speed, chosen, rest=prepared.rest).time_step
        step = default * job.step * (1 + 1e-9)
    options = RunOptions(
        job.samples,
        time_step=step,
        rest=prepared.rest,
        window=prepared.window,
        nose=prepared.nose,
    )
    provenance = provenance_of(problem, prepared.member, job.engine_speed, "")
    found = run(system, cam_speed, Periodic(problem.cycles_to_settle), options, provenance)
    return with_quantities(prepared, found, Plan(implausible=implausible), {})


def _rows(values: Mapping[str, Numbers], speed: float, label: str) -> list[Uncertainty]:
    rows = []
    for name, value in values[OWN].items():
        if name not in TRAIN_HEADLINES or 0 < abs(value) < ROUNDING:
            continue

        def of(variant: str, name: str = name) -> float | None:
            return values.get(variant, {}).get(name)

        halved, sampled = of("step 2"), of("samples")
        if halved is None:
            continue
        steps = convergence(value, (halved, of("step 3")), (1.0, *(1 / step for step in STEPS)))
        assert steps is not None
        springs = convergence(value, (of("springs 2"), of("springs 3")), (1.0, *SPRINGS))
        meshes = 0.0 if springs is None else springs.uncertainty
        scatter = values[OWN].get(f"cycle_scatter_{name}", 0.0)
        others = (0.0 if sampled is None else abs(sampled - value)) + scatter
        rows.append(
            Uncertainty(
                name,
                speed,
                value,
                steps.uncertainty + meshes + others,
                steps.observed_order,
                steps.extrapolated,
                steps.uncertainty,
                *contact_ranges(value, of),
                label,
            )
        )
    return rows
