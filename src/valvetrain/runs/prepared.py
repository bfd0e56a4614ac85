"""A member of a problem made ready to run: its system, its state at rest and what its numbers are
judged by, each found once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles, Keep, Periodic, RunOptions
from valvetrain.integrate.run import run_to_orbit
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.kinematics import RigidMotion, rigid_motion
from valvetrain.quantities.plausible import REMEDY, implausible
from valvetrain.quantities.signal import ring_top
from valvetrain.quantities.valve_events import open_window
from valvetrain.runs.cost import Limits, memory_text
from valvetrain.solution.channels import empty_channels
from valvetrain.solution.partial_failures import PartialFailures, reason
from valvetrain.solution.provenance import Option, Provenance, collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import Status
from valvetrain.springs.contract import LargeSpring
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.system.prescribed import PrescribedSpring, names_of
from valvetrain.system.problem import Member, Problem, Rest
from valvetrain.system.train_rest import TrainRest, rest_of
from valvetrain.system.train_system import TrainSystem

if TYPE_CHECKING:
    from valvetrain.integrate.contract import Orbit

#: Bytes that one step of a cam turn takes while it is recorded (time, motion, forces and what is
#: made of them).
STEP_BYTES = 128.0
#: What a run can meet that is its own failure and not the study's: whatever it is, the other runs
#: are there.
FAILURES = (Exception,)


@dataclass(frozen=True, eq=False)
class Plan:
    """What is asked of every run: ``keep`` of its channels (``contacts`` for a sweep), samples per
    cam turn (None: the usual), whether
    the solution keeps its channels at all, cam turns of prescribed motion, most turns of a train,
    when (ISO 8601), the memory (bytes) that
    one run may take, and whether implausible results pass."""

    keep: Keep = "all"
    samples: int | None = None
    whole: bool = True
    cycles: int = 2
    cycles_to_settle: int | None = None
    created_at: str = ""
    most_bytes: float = Limits().bytes
    implausible: bool = False


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """A member with everything its runs share; ``refusal`` says why it cannot run, empty when it
    can.
    """

    member: Member
    frame: Frame
    system: PrescribedSpring | TrainSystem | None = None
    rest: TrainRest | None = None
    motion: RigidMotion | None = None
    refusal: str = ""

    @cached_property
    def window(self) -> tuple[float, float] | None:
        """Begin and end (cam rad) of the stretch in which a rigid valve counts as open
        (:func:`open_window`); none of prescribed motion.
        """
        return None if self.motion is None else open_window(self.motion.kinematics)

    @cached_property
    def nose(self) -> float | None:
        """Cam angle (rad) of the largest rigid lift; none of prescribed motion."""
        return (
            None
            if self.motion is None
            else ring_top(self.motion.cam_angle, self.motion.derivatives[0])
        )


def prepare(problem: Problem, member: Member, rest: Rest, source: str) -> PreparedRun:
    """The member assembled; what its parts refuse is kept as its ``refusal``."""
    found = tuple(rest[spring] for spring in member.springs if spring in rest)
    # under prescribed motion the springs' states at rest are found beside the first runs, and
    # judge() brings their frequencies
    told = (
        ()
        if member.gear is None
        else (surge_frequency(spring, rest.get(spring)) for spring in member.springs)
    )
    frequencies = tuple(value for value in told if value is not None)
    frame = Frame(
        member.springs,
        found,
        frequencies,
        problem.lift_event,
        problem.valve_lift.lift,
        source,
        points=problem.record.points,
    )
    try:
        system = member.system(rest, problem.built)
        if isinstance(system, PrescribedSpring):
            for spring in system.springs:
                if isinstance(spring, LargeSpring):
                    spring.prepare()
            return PreparedRun(member, frame, system)
        assert member.gear is not None
        still = rest_of(system)
        motion = rigid_motion(system, member.gear.parameters, rest=still)
        return PreparedRun(
            member,
            replace(frame, valve_lift=system.mechanism.kinematics.valve_lift),
            system,
            still,
            motion,
        )
    except FAILURES as error:
        return PreparedRun(member, frame, refusal=reason(error))


def surge_frequency(spring: InstalledSpring, rest: SpringAtRest | None = None) -> float | None:
    """First surge frequency (Hz), both ends fixed, as installed: at rest, else of the uniform
    spring; None where neither tells.
    """
    if rest is not None and rest.modes is not None and len(rest.modes.axial_modes):
        return float(rest.modes.axial_frequencies[0])
    if spring.card is not None and spring.card.mass is None:
        return None
    try:
        return EquivalentSpring.from_installed(spring).surge_frequency
    except InputError:  # a wire that no uniform spring stands for still runs
        return None


def provenance_of(
    problem: Problem, member: Member, engine_speed: float, created_at: str
) -> Provenance:
    """Where a run of ``member`` comes from, its options with their values (SI)."""
    first = member.springs[0] if member.springs else None
    options: dict[str, Option] = {}
    if first is not None:
        table = member.model.read_options(first.options_of(member.model.word))
        useless = table.wire_only if first.wire is None else table.card_only
        options |= {
            name: value for name, value in table.model_dump().items() if name not in useless
        }
        options |= {
            "coil_contact_stiffness": first.contact.stiffness,
            "coil_contact_damping_time": first.contact.damping_time,
            "mass_damping": first.damping.mass_damping,
            "stiffness_damping": first.damping.stiffness_damping,
        }
    if member.gear is None:
        options |= {"cycles": problem.cycles, "output_step": problem.output_step}
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
) -> tuple[Solution, Orbit | None]:
    """As :func:`integrate_point`, of a train from the motion ``start`` of another speed, and the
    motion it ended on (None for none).
    """
    if ready.system is None:
        remedy = "choose another model, or give more of the spring"
        return Solution(
            empty_channels(), (), Status("refused", ready.refusal, remedy=remedy), {}, provenance
        ), None
    prescribed = isinstance(ready.system, PrescribedSpring)
    if prescribed and (status := _too_many_steps(ready, engine_speed / 2, plan)) is not None:
        return Solution(empty_channels(), (), status, {}, provenance), None
    until = Cycles(plan.cycles) if prescribed else Periodic(plan.cycles_to_settle)
    options = RunOptions(
        plan.samples,
        keep=plan.keep,
        rest=ready.rest,
        window=ready.window,
        nose=ready.nose,
        start=start,
    )
    try:
        return run_to_orbit(ready.system, engine_speed / 2, until, options, provenance)
    except FAILURES as error:
        return Solution(
            empty_channels(),
            (),
            Status("diverged", reason(error), remedy="look at this run alone"),
            {},
            provenance,
        ), None


def _too_many_steps(ready: PreparedRun, cam_speed: float, plan: Plan) -> Status | None:
    """Why a run is not begun whose cam turn has more steps than the memory holds; None where it
    fits.

    The step is the spring's own: a hard coil contact or a light wire shortens it by orders that no
    count of elements tells.
    """
    assert isinstance(ready.system, PrescribedSpring)
    for spring in ready.system.springs:
        step = float(spring.stable_time_step()) if hasattr(spring, "stable_time_step") else np.inf
        steps = 2 * np.pi / cam_speed / max(step, 1e-300)
        if not steps * STEP_BYTES <= plan.most_bytes:
            words = (
                f"{spring.name} needs steps of {step:.3g} s, {steps:.3g} in a cam turn, which take about "
                f"{memory_text(steps * STEP_BYTES)}, beyond the bound of {memory_text(plan.most_bytes)}"
            )
            remedy = "give a softer coil contact, fewer elements or a higher speed, or raise the bound (--limit, limit=)"
            return Status("refused", words, remedy=remedy)
    return None


def plausible(solution: Solution) -> Solution:
    """The run, as ``diverged`` where a number of it is nonsense; its numbers stay."""
    if solution.status.code not in ("completed", "not-converged") or not (
        words := implausible(solution)
    ):
        return solution
    return replace(
        solution, status=Status("diverged", words, float(solution.time[-1]), remedy=REMEDY)
    )


def bound(solution: Solution, springs: tuple[InstalledSpring, ...]) -> Solution:
    """The run with status ``coil-bind`` where the retainer passed the lift at which the first of
    ``springs`` is solid.

    No spring model but those with coil contact feels it, so what follows in the run is not to be
    believed. A spring whose card does not
    tell installed and solid height is not judged; nor is a run that diverged.
    """
    told = [(spring.room, spring) for spring in springs if spring.room is not None]
    if (
        not told
        or solution.status.code not in ("completed", "not-converged")
        or not solution.has("valve_lift")
    ):
        return solution
    room, spring = min(told, key=lambda pair: pair[0])
    lift = solution.channel("valve_lift")
    past = lift >= room
    if not np.any(past):
        return solution
    place = int(np.argmax(past))
    angle = float(np.degrees(solution.cam_angle[place]) % 360)
    words = (
        f"spring '{spring.name}' is solid at {room * 1e3:.4g} mm of lift, which the retainer passes at {angle:.1f} cam degrees "
        f"and exceeds to {float(np.max(lift)) * 1e3:.4g} mm"
    )
    remedy = (
        "run slower, or fit a spring that holds the valve and has more room to its solid height"
    )
    return replace(
        solution,
        status=Status("coil-bind", words, float(solution.time[place]), spring.name, remedy),
    )


def judge(ready: PreparedRun, solution: Solution, plan: Plan, rest: Rest) -> Solution:
    """The run with events and named quantities, without channels where the plan keeps none."""
    frame = ready.frame
    if rest:
        found = tuple(rest[spring] for spring in ready.member.springs if spring in rest)
        frequencies = (surge_frequency(spring, rest.get(spring)) for spring in ready.member.springs)
        frame = replace(
            frame,
            rest=found,
            surge_frequencies=tuple(value for value in frequencies if value is not None),
        )
    if ready.motion is not None:
        frame = replace(frame, rigid=ready.motion.table(solution.engine_speed / 2))
    if len(solution.time):
        gaps = PartialFailures()
        solution = gaps.part("all numbers", solution, evaluate, solution, frame)
        solution = gaps.part("coil bind", solution, bound, solution, ready.member.springs)
        solution = (
            solution
            if plan.implausible
            else gaps.part("plausible values", solution, plausible, solution)
        )
        if gaps.sentences:
            solution = solution.with_found(
                solution.events, solution.quantities, (*solution.gaps, *gaps.sentences)
            )
    return solution if plan.whole else solution.reduced()


def unfinished(
    problem: Problem, member: Member, engine_speed: float, plan: Plan, status: Status
) -> Solution:
    """What stands for a run (rad/s of the crank) that was stopped before its end, or whose worker
    was lost.
    """
    return Solution(
        empty_channels(),
        (),
        status,
        {},
        provenance_of(problem, member, engine_speed, plan.created_at),
    )
