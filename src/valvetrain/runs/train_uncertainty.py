"""Error bars of trains: step halved twice, finer springs, fewer samples, other contact constants,
for every variant of the case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from valvetrain.contact.dissipative import damping_number, rebound
from valvetrain.integrate.contract import Periodic, RunOptions
from valvetrain.integrate.run import run
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.train import ContactParameters
from valvetrain.runs.engine import LOST, LOST_REMEDY, Progress
from valvetrain.runs.error_bars import (
    CONTACT_FACTORS,
    Numbers,
    Range,
    Uncertainty,
    UncertaintyStudy,
    grid_convergence,
    two_grids,
)
from valvetrain.runs.notes import refuse_implausible, refuse_speeds
from valvetrain.runs.prepared import FAILURES, Plan, PreparedRun, judge, prepare, provenance_of
from valvetrain.runs.run import member_rest
from valvetrain.runs.uncertainty import OWN, Stages
from valvetrain.solution.partial_failures import reason
from valvetrain.solution.result import Solution
from valvetrain.springs.contract import LargeSpring
from valvetrain.system.build import build
from valvetrain.system.problem import Member, Problem

#: Elements, masses or modes of a spring over the case's; step over the usual one; samples per cam
#: turn beside the usual 1440.
SPRINGS, STEPS, SAMPLES = (1.5, 2.25), (0.5, 0.25), 720
#: What is below (SI) is rounding: the surge of a spring without mass.
ROUNDING = 1e-9
#: Options of spring models that say how finely a spring is divided.
DIVISIONS = ("elements", "masses_per_coil", "modes", "elements_per_coil")
#: The variant that is not run of finite-element springs, whose elements and steps would both be
#: 2.25 times as many.
TOO_FINE = "springs 3"
#: Headline numbers of a train; those that a run does not have are left out.
HEADLINES = (
    "peak_spring_force", "minimum_spring_force", "peak_retainer_force", "minimum_retainer_force", "surge_amplitude_force",
    "peak_cam_contact_force", "peak_tappet_contact_force", "peak_rocker_contact_force", "peak_valve_tip_contact_force",
    "peak_seat_contact_force", "nose_cam_contact_force", "minimum_cam_contact_force", "peak_valve_lift", "lift_loss_displacement",
    "seating_velocity", "seating_cam_angle", "bounce_count", "bounce_height", "loft_gap", "loss_of_contact_duration",
    "minimum_piston_clearance_gap", "cycle_work_energy", "peak_valve_acceleration", "clash_count", "clash_energy", "largest_clash_impulse",
)  # fmt: skip


@dataclass(frozen=True)
class _Job:
    """One run: variant of the study, place of the member, engine speed (rad/s), step over the usual
    one, samples per cam turn.
    """

    variant: str
    place: int
    engine_speed: float
    step: float = 1.0
    samples: int | None = None


def train_uncertainty(
    case: Case,
    engine_speeds: Sequence[float] | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
    implausible: bool = False,
) -> UncertaintyStudy:
    """Every variant of a train's case at ``engine_speeds`` (rad/s of the crank; None: the case's
    own), each number with its uncertainty.

    Runs go over ``workers`` processes. A run on finite-element springs takes seconds and a finer
    one many times as long: those get two
    grids of each kind instead of three (:func:`two_grids`). A run that fails is one of the
    ``failures``. Raises :class:`InputError` for
    a case that cannot be built and what :func:`valvetrain.runs.run.run_study` refuses;
    :class:`RefinementStopped` when it is stopped.
    """
    problem = build(case)
    speeds = (
        problem.engine_speeds
        if engine_speeds is None
        else tuple(float(speed) for speed in engine_speeds)
    )
    refuse_speeds(problem, speeds)
    if not implausible:
        refuse_implausible(problem, speeds)
    places = range(len(problem.members))
    variants, failures = _all_variants(case, problem)
    jobs = [
        job
        for speed in speeds
        for place in places
        if place in variants[OWN]
        for job in _jobs(variants, place, speed, _is_large(problem, place))
    ]

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress(done / total, f"run {done} of {total}")

    def lost(job: _Job) -> tuple[Numbers, str]:
        return {}, f"{problem.members[job.place].label}, {job.variant}: {LOST}; {LOST_REMEDY}"

    stages = Stages()
    found = stages.map(
        _one, (problem, variants, implausible), jobs, workers, processes=True, tell=tell, lost=lost
    )
    values: dict[tuple[float, int], dict[str, Numbers]] = {}
    for place, (numbers, failed) in sorted(found.items()):
        job = jobs[place]
        values.setdefault((job.engine_speed, job.place), {})[job.variant] = numbers
        failures += [failed] if failed else []
    missing = {
        (job.engine_speed, job.place) for place, job in enumerate(jobs) if place not in found
    }
    rows = [
        row
        for (speed, place), here in values.items()
        if (speed, place) not in missing
        for row in _rows(here, speed, problem.members[place].label)
    ]
    whole: dict[str, dict[float | None, Numbers]] = {}
    for (speed, place), here in values.items():
        for name, numbers in here.items():
            whole.setdefault(f"{problem.members[place].label}, {name}", {})[speed] = numbers
    return stages.closed(
        UncertaintyStudy(
            problem.record,
            (),
            tuple(rows),
            whole,
            tuple(failures),
            CONTACT_FACTORS,
            CONTACT_FACTORS,
            len(jobs),
            len(found),
        )
    )


def _all_variants(
    case: Case, problem: Problem
) -> tuple[dict[str, dict[int, PreparedRun]], list[str]]:
    """What can run of every variant by the place of its member, and why the others cannot; members
    that cannot run at all are told once.
    """
    found: dict[str, dict[int, PreparedRun]] = {OWN: {}}
    failures: list[str] = []
    for name, (other, factor) in _problems(case, problem).items():
        found[name] = {}
        try:
            built = build(other) if isinstance(other, Case) else other
        except FAILURES as error:
            failures.append(f"{name}: {reason(error)}")
            continue
        for place, member in enumerate(problem.members):
            if name != OWN and (
                place not in found[OWN] or (name == TOO_FINE and _is_large(problem, place))
            ):
                continue
            try:
                ready = _ready(built, place, factor)
                refusal = "" if ready is None else ready.refusal
            except FAILURES as error:
                ready, refusal = None, reason(error)
            if refusal:
                failures.append(f"{member.label}{'' if name == OWN else f', {name}'}: {refusal}")
            elif ready is not None:
                found[name][place] = ready
    return found, failures


def _problems(case: Case, problem: Problem) -> dict[str, tuple[Problem | Case, float]]:
    """Problem, or the case that it is to be built of, and division of the springs of every variant."""
    assert case.train is not None
    found: dict[str, tuple[Problem | Case, float]] = {OWN: (problem, 1.0)}
    for n, factor in enumerate(SPRINGS, start=2):
        found[f"springs {n}"] = problem, factor
    for word in ("stiffness", "damping"):
        for n, factor in enumerate(CONTACT_FACTORS, start=1):
            contacts = {
                place: _with(contact, word, factor)
                for place, contact in case.train.contacts.items()
            }
            if contacts != dict(case.train.contacts):
                found[f"contact {word} {n}"] = (
                    case.replace(train=case.train.replace(contacts=contacts)),
                    1.0,
                )
    return found


def _with(contact: ContactParameters, word: str, factor: float) -> ContactParameters:
    """A contact with another stiffness, or with another damping, which a restitution stands for."""
    values: Mapping[str, Any] = contact.values
    if word == "stiffness":
        return (
            contact.replace(contact_stiffness=factor * values["contact_stiffness"])
            if "contact_stiffness" in values
            else contact
        )
    if "damping" in values:
        return contact.replace(damping=factor * values["damping"])
    if 0 < values.get("restitution", 0.0) < 1:
        return contact.replace(restitution=rebound(factor * damping_number(values["restitution"])))
    return contact


def _ready(problem: Problem, place: int, factor: float) -> PreparedRun | None:
    """A member with its springs divided more finely, ready or with its refusal; None where that
    changes nothing.
    """
    member = problem.members[place]
    if factor != 1.0:
        finer = replace(
            member, springs=tuple(divided(member, spring, factor) for spring in member.springs)
        )
        if finer.springs == member.springs:
            return None
        member = finer
    return prepare(problem, member, member_rest(problem, member), problem.record.study)


def divided(member: Member, spring: InstalledSpring, factor: float) -> InstalledSpring:
    """A spring with ``factor`` times the parts that its kind of data counts."""
    word, options = member.model.word, member.model.options
    off = options.card_only if spring.card is None else options.wire_only
    known = member.model.read_options(spring.options_of(word)).model_dump()
    finer = {
        key: round(factor * known[key])
        for key in DIVISIONS
        if key in known and key not in off and known[key]
    }
    return spring.with_options(word, **finer) if finer else spring


def _is_large(problem: Problem, place: int) -> bool:
    """Whether the springs of a member are too large for many runs."""
    return problem.members[place].model.word == "finite-element"


def _jobs(
    variants: Mapping[str, Mapping[int, PreparedRun]], place: int, speed: float, large: bool
) -> list[_Job]:
    if large:
        own = [_Job(OWN, place, speed), _Job("step 2", place, speed, STEPS[0])]
    else:
        own = [
            _Job(OWN, place, speed),
            *(_Job(f"step {n}", place, speed, step) for n, step in enumerate(STEPS, start=2)),
        ]
        own.append(_Job("samples", place, speed, samples=SAMPLES))
    return own + [
        _Job(name, place, speed)
        for name, members in variants.items()
        if name != OWN and place in members
    ]


def _one(
    shared: tuple[Problem, Mapping[str, Mapping[int, PreparedRun]], bool], job: _Job
) -> tuple[Numbers, str]:
    """Headline numbers of one run and, where it failed, why."""
    problem, variants, implausible = shared
    ready = variants.get(job.variant, variants[OWN])[job.place]
    try:
        solution = _solution(problem, ready, job, implausible)
    except FAILURES as error:
        return {}, f"{ready.member.label}, {job.variant}: {reason(error)}"
    if not solution.status.completed:
        return {}, f"{ready.member.label}, {job.variant}: {solution.status.sentence()}"
    names = (*HEADLINES, *(f"cycle_scatter_{name}" for name in HEADLINES))
    return {
        name: float(solution.quantities[name]) for name in names if name in solution.quantities
    }, ""


def _solution(problem: Problem, ready: PreparedRun, job: _Job, implausible: bool) -> Solution:
    from valvetrain.integrate.train_leapfrog import LARGE_SAMPLES
    from valvetrain.integrate.train_leapfrog import SAMPLES as TRAIN_SAMPLES
    from valvetrain.integrate.train_run import TrainOptions, runner
    from valvetrain.system.train_system import TrainSystem

    assert isinstance(ready.system, TrainSystem)
    step = None
    if job.step != 1.0 or job.samples is not None:
        large = any(isinstance(spring, LargeSpring) for spring in ready.system.springs)
        chosen = TrainOptions(LARGE_SAMPLES if large else TRAIN_SAMPLES)
        usual = runner(ready.system, job.engine_speed / 2, chosen, rest=ready.rest).time_step
        step = usual * job.step * (1 + 1e-9)
    options = RunOptions(
        job.samples, time_step=step, rest=ready.rest, window=ready.window, nose=ready.nose
    )
    provenance = provenance_of(problem, ready.member, job.engine_speed, "")
    found = run(
        ready.system, job.engine_speed / 2, Periodic(problem.cycles_to_settle), options, provenance
    )
    return judge(ready, found, Plan(implausible=implausible), {})


def _rows(values: Mapping[str, Numbers], speed: float, label: str) -> list[Uncertainty]:
    rows = []
    for name, value in values[OWN].items():
        if name not in HEADLINES or 0 < abs(value) < ROUNDING:
            continue

        def of(variant: str, name: str = name) -> float | None:
            return values.get(variant, {}).get(name)

        halved, quarter, sampled = of("step 2"), of("step 3"), of("samples")
        if halved is None:
            continue
        one = two_grids(value, halved, 1 / STEPS[0])
        steps = (
            one if quarter is None else grid_convergence((value, halved, quarter), (1.0, *STEPS))
        )
        springs = [other for n in (2, 3) if (other := of(f"springs {n}")) is not None]
        sizes = (1.0, 1 / SPRINGS[0], 1 / SPRINGS[1])
        meshes = 0.0
        if springs:
            whole = (
                grid_convergence((value, springs[0], springs[1]), sizes)
                if len(springs) == 2
                else two_grids(value, springs[0], SPRINGS[0])
            )
            meshes = whole.uncertainty
        others = (0.0 if sampled is None else abs(sampled - value)) + values[OWN].get(
            f"cycle_scatter_{name}", 0.0
        )
        ranges: list[Range] = []
        for word in ("contact stiffness", "contact damping"):
            known = [value, *(other for n in (1, 2) if (other := of(f"{word} {n}")) is not None)]
            ranges.append((min(known), max(known)))
        rows.append(
            Uncertainty(
                name,
                speed,
                value,
                steps.uncertainty + meshes + others,
                steps.observed_order,
                steps.extrapolated,
                steps.uncertainty,
                ranges[0],
                ranges[1],
                label,
            )
        )
    return rows
