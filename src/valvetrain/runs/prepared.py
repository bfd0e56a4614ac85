"""One prepared run: system, static equilibrium and reference motion of a member, each computed
once; its runs in time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles, Keep, Periodic, RunOptions, Until
from valvetrain.integrate.run import run_to_orbit
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.kinematics import RigidMotion, rigid_motion
from valvetrain.quantities.limits import bound, plausible_run
from valvetrain.quantities.signal import ring_top
from valvetrain.quantities.valve_events import open_window
from valvetrain.runs.cost import Limits, duration_text
from valvetrain.runs.stopping import noted
from valvetrain.solution.channels import empty_channels
from valvetrain.solution.force_peak import BANDWIDTH
from valvetrain.solution.provenance import Option, Provenance, collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import PartialFailures, Status, reason
from valvetrain.springs.contract import LargeSpring, SpringWithModes
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.spec import spring_model
from valvetrain.system.driven import DrivenSprings
from valvetrain.system.prescribed import PrescribedSpring, names_of
from valvetrain.system.problem import Member, Problem, Rest
from valvetrain.system.train_rest import TrainRest, rest_of
from valvetrain.system.train_system import TrainSystem

if TYPE_CHECKING:
    from valvetrain.integrate.contract import Orbit

#: Seconds that a step takes at least, and cam revolutions of a run at least.
STEP_TIME, LEAST_CYCLES = 0.5e-6, 2
#: Cam revolutions of a spring alone that nothing damps.
UNDAMPED_CYCLES = 2
#: Exceptions that fail one run and not its study: all of them.
FAILURES = (Exception,)


@dataclass(frozen=True, eq=False)
class Plan:
    """Options of every run of a study.

    ``keep`` of its channels (``contacts`` for a sweep), ``samples`` per cam revolution (None: the
    default), ``whole``: the solution has channels at all, ``cycles`` of prescribed motion, most
    ``cycles_to_settle`` of a train, ``created_at`` (ISO 8601), ``max_seconds`` of one run;
    ``implausible`` results pass; ``watch``, ``coil_contacts``: as in :class:`RunOptions`.
    """

    keep: Keep = "all"
    samples: int | None = None
    whole: bool = True
    cycles: int | None = None
    cycles_to_settle: int | None = None
    created_at: str = ""
    max_seconds: float = Limits().seconds
    implausible: bool = False
    watch: Callable[[float], bool] | None = None
    coil_contacts: bool = True


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """A member with everything that its runs share; ``refusal``: why it cannot run, empty where it
    can. Of a train ``window``: begin and end (cam rad) of the open rigid valve (:func:`open_window`), and ``nose``: cam angle
    (rad) of the largest rigid lift.
    """

    member: Member
    frame: Frame
    system: PrescribedSpring | TrainSystem | DrivenSprings | None = None
    rest: TrainRest | None = None
    motion: RigidMotion | None = None
    refusal: str = ""
    window: tuple[float, float] | None = None
    nose: float | None = None


def largest_lift(problem: Problem) -> float:
    """Largest valve lift (m): of the rigid train, or of the law that drives the spring."""
    gears = (member.gear for member in problem.members)
    lifts = [float(gear.mechanism.kinematics.maximum_lift) for gear in gears if gear is not None]
    return max(lifts) if lifts else law_lift(problem)


def spring_lift(problem: Problem) -> Callable[[Array], Array]:
    """Lift (m) of the springs over the cam angle: of the first rigid train, or of the law that drives a spring."""
    gears = (member.gear for member in problem.members)
    moved = (gear.mechanism.kinematics.valve_lift for gear in gears if gear is not None)
    return next(moved, problem.valve_lift.lift)


def law_lift(problem: Problem) -> float:
    """Largest lift (m) of the lift law."""
    return float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))


def prepare(problem: Problem, member: Member, rest: Rest, source: str) -> PreparedRun:
    """The member assembled with its springs at ``rest``; what its parts refuse is its ``refusal``."""
    gear = member.gear
    permitted = None if gear is None else gear.parameters.valve.permitted_seating_velocity
    frame = Frame(
        member.springs,
        tuple(rest[spring] for spring in member.springs if spring in rest),
        (),
        problem.lift_event,
        problem.valve_lift.lift,
        source,
        points=problem.record.points,
        permitted_seating_velocity=permitted,
        top_dead_centre=None if gear is None else gear.top_dead_centre,
    )
    try:
        system = member.system(rest, problem.built)
        if isinstance(system, PrescribedSpring):
            for spring in system.springs:
                if isinstance(spring, LargeSpring):
                    spring.prepare()
            return PreparedRun(member, frame, system)
        assert gear is not None
        train = system.train if isinstance(system, DrivenSprings) else system
        equilibrium = rest_of(train)
        # Rigid theory has no surge: springs count with the Rayleigh share of their mass, whatever model runs.
        massless = replace(member, model=spring_model("massless"), rubbing=None)
        own = member.model.word == massless.model.word or bool(massless.refusal)
        plain = train if own else massless.system({}, problem.built)
        assert isinstance(plain, TrainSystem)
        motion = rigid_motion(plain, gear.parameters)
        frame = replace(
            frame,
            valve_lift=train.mechanism.kinematics.valve_lift,
            surge_frequencies=_surge_frequencies(member, train, rest),
        )
        window = open_window(motion.kinematics)
        nose = ring_top(motion.cam_angle, motion.derivatives[0])
        return PreparedRun(member, frame, system, equilibrium, motion, window=window, nose=nose)
    except FAILURES as error:
        return PreparedRun(member, frame, refusal=reason(error))


def statics_of(member: Member, rest: Rest) -> tuple[tuple[SpringAtRest, ...], tuple[float, ...]]:
    """The springs of a member at rest, and the first surge frequencies (Hz) that are known."""
    found = tuple(rest[spring] for spring in member.springs if spring in rest)
    frequencies = (surge_frequency(spring, rest.get(spring)) for spring in member.springs)
    return found, tuple(value for value in frequencies if value is not None)


def _surge_frequencies(member: Member, train: TrainSystem, rest: Rest) -> tuple[float, ...]:
    """First surge frequencies (Hz) with the valve closed: those of the models where all have modes, else those of the springs at rest."""
    models = [one for row in train.springs for one in getattr(row, "members", (row,))]
    known = [model.surge_frequency(0.0) for model in models if isinstance(model, SpringWithModes)]
    return tuple(known) if len(known) == len(models) else statics_of(member, rest)[1]


def surge_frequency(spring: InstalledSpring, rest: SpringAtRest | None = None) -> float | None:
    """First surge frequency (Hz), both ends fixed, as installed, or of the uniform spring; None
    where neither is known.
    """
    if rest is not None and rest.modes is not None and len(rest.modes.axial_modes):
        return float(rest.modes.axial_frequencies[0])
    if spring.card is not None and spring.card.mass is None:
        return None
    try:
        return EquivalentSpring.from_installed(spring).surge_frequency
    except InputError:  # a wire that no uniform spring represents still runs
        return None


def provenance_of(
    problem: Problem, member: Member, engine_speed: float, created_at: str
) -> Provenance:
    """Provenance of a run of ``member``, its options with their values (SI)."""
    first = member.springs[0] if member.springs else None
    options: dict[str, Option] = {BANDWIDTH: problem.force_bandwidth}
    if first is not None:
        table = member.model.read_options(first.options_of(member.model.word))
        unused = table.wire_only if first.wire is None else table.card_only
        options |= {name: value for name, value in table.model_dump().items() if name not in unused}
        options |= {
            "coil_contact_stiffness": first.contact.stiffness,
            "coil_contact_damping_time": first.contact.damping_time,
            "mass_damping": first.damping.mass_damping,
            "stiffness_damping": first.damping.stiffness_damping,
        }
    if member.gear is None:
        options |= {} if problem.cycles is None else {"cycles": problem.cycles}
        options |= {"output_step": problem.output_step}
    count = 1 if member.rubbing is not None and len(member.springs) == 2 else len(member.springs)
    return collect_provenance(
        problem.record.name,
        member.model.word,
        engine_speed=engine_speed,
        case_digest=problem.record.digest,
        options=options,
        created_at=created_at,
        citations=problem.record.citations,
        label=member.label,
        spring_set=member.spring_set,
        system=member.kind,
        springs=names_of(member.springs[:count]),
    )


def integrate_point(
    ready: PreparedRun, engine_speed: float, plan: Plan, provenance: Provenance
) -> Solution:
    """One run in time (rad/s of the crank); a failure of any kind is its status."""
    return integrate_from(ready, engine_speed, plan, provenance)[0]


def integrate_from(
    ready: PreparedRun,
    engine_speed: float,
    plan: Plan,
    provenance: Provenance,
    start: Orbit | None = None,
    *,
    time_step: float | None = None,
    periodic: Periodic = Periodic(),
) -> tuple[Solution, Orbit | None]:
    """As :func:`integrate_point`, of a train from the motion ``start`` of another speed, and the
    final motion (None without one). ``time_step`` (s): other than the default one; ``periodic``: how its
    periodic state is searched, in no more cycles than the plan allows.
    """
    if ready.system is None:
        remedy = "choose another model, or give more of the spring"
        return without_channels(Status("refused", ready.refusal, remedy=remedy), provenance), None
    prescribed = isinstance(ready.system, PrescribedSpring)
    if prescribed and (status := _too_many_steps(ready, engine_speed / 2, plan)) is not None:
        return without_channels(status, provenance), None
    until: Until = periodic
    if not prescribed and plan.cycles_to_settle is not None:
        most = plan.cycles_to_settle
        until = replace(periodic, cycles=min(most, periodic.cycles or most))
    if prescribed and (cycles := plan.cycles or _without_end(ready.member)):
        until = Cycles(cycles)
    options = RunOptions(
        plan.samples,
        time_step=time_step,
        keep=plan.keep,
        rest=ready.rest,
        window=ready.window,
        nose=ready.nose,
        start=start,
        coil_contacts=plan.coil_contacts,
        watch=plan.watch or (lambda share: not noted()),  # until a signal asks it to stop
    )
    try:
        return run_to_orbit(ready.system, engine_speed / 2, until, options, provenance)
    except FAILURES as error:
        status = Status("diverged", reason(error), remedy="look at this run alone")
        return without_channels(status, provenance), None


def _without_end(member: Member) -> int | None:
    """Cam revolutions of springs without damping, whose motion never settles; None of others."""
    damped = (one.damping.mass_damping or one.damping.stiffness_damping for one in member.springs)
    return None if any(damped) else UNDAMPED_CYCLES


def without_channels(
    status: Status, provenance: Provenance, quantities: Mapping[str, float] = {}
) -> Solution:
    """A solution of a run that gave no channels."""
    return Solution(empty_channels(), (), status, {}, provenance, quantities)


def _too_many_steps(ready: PreparedRun, cam_speed: float, plan: Plan) -> Status | None:
    """Refusal of a run whose steps take too long; None where they do not.

    The step depends on coil contact and wire by orders of magnitude, not only on the count of
    elements.
    """
    assert isinstance(ready.system, PrescribedSpring)
    for spring in ready.system.springs:
        step = float(spring.stable_time_step()) if hasattr(spring, "stable_time_step") else np.inf
        steps = 2 * np.pi / cam_speed / max(step, 1e-300)
        seconds = steps * STEP_TIME * (plan.cycles or LEAST_CYCLES)
        if not seconds <= plan.max_seconds:
            message = (
                f"{spring.name} needs steps of {step:.3g} s, {steps:.3g} in a cam revolution, which take more than "
                f"{duration_text(seconds)}, beyond the bound of {duration_text(plan.max_seconds)}"
            )
            remedy = "give a softer coil contact, fewer elements or a higher speed, or raise the bound (--limit, limit=)"
            return Status("refused", message, remedy=remedy)
    return None


def with_quantities(ready: PreparedRun, solution: Solution, plan: Plan, rest: Rest) -> Solution:
    """The run with events and named quantities, without channels where the plan stores none."""
    frame = ready.frame
    if rest:
        found, frequencies = statics_of(ready.member, rest)
        frame = replace(frame, rest=found, surge_frequencies=frequencies)
    if ready.motion is not None:
        frame = replace(frame, rigid=ready.motion.table(solution.engine_speed / 2))
    # outside the range of its model the numbers of a run mean nothing, so it has none
    if len(solution.time) and solution.status.code != "out-of-range":
        failures = PartialFailures()
        solution = failures.part("all numbers", solution, evaluate, solution, frame)
        solution = failures.part("coil bind", solution, bound, solution, ready.member.springs)
        if not plan.implausible:
            solution = failures.part("plausible values", solution, plausible_run, solution)
        if failures.sentences:
            solution = replace(solution, gaps=(*solution.gaps, *failures.sentences))
    return solution if plan.whole else solution.reduced()


def unfinished(
    problem: Problem, member: Member, engine_speed: float, plan: Plan, status: Status
) -> Solution:
    """The solution of a run (rad/s of the crank) that was stopped before its end, or whose worker
    was lost.
    """
    return without_channels(status, provenance_of(problem, member, engine_speed, plan.created_at))
