"""Sentences on what a study was given and does not use."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from valvetrain.errors import InputError
from valvetrain.quantities.plausible import refuse_implausible_motion, refuse_implausible_parts
from valvetrain.quantities.statics import formula_compression
from valvetrain.runs.prepared import prepare
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem


def largest_lift(problem: Problem) -> float:
    """Largest valve lift (m): of the rigid train, or of the law that drives the spring."""
    lifts = [
        float(member.gear.mechanism.kinematics.maximum_lift)
        for member in problem.members
        if member.gear is not None
    ]
    return max(
        lifts, default=float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))
    )


def undamped_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence per spring model without damping on the springs whose damping it leaves out."""
    left_out: dict[str, list[str]] = {}
    for member in members:
        for spring in member.springs:
            if not member.model.damped and (
                spring.damping.mass_damping
                or spring.damping.stiffness_damping
                or spring.damping.ratio
            ):
                names = left_out.setdefault(member.model.word, [])
                names += [] if spring.name in names else [spring.name]
    return tuple(
        f"A {word} spring has no inner motion: the damping of {' and '.join(repr(name) for name in names)} has no effect in it."
        for word, names in left_out.items()
    )


def ringing_note(members: Iterable[Member]) -> str:
    """A sentence on the springs to which the case gives no damping although their models have inner
    motion; empty where there are none.
    """
    names: dict[str, None] = {}
    for member in members:
        for spring in member.springs:
            damping = spring.damping
            if member.model.damped and not (
                damping.mass_damping or damping.stiffness_damping or damping.ratio
            ):
                names[repr(spring.name)] = None
    if not names:
        return ""
    springs, its = ("springs", "their") if len(names) > 1 else ("spring", "its")
    return (
        f"The case gives {springs} {' and '.join(names)} no damping, so that surge lives on from cycle to cycle: give {its} "
        "damping, such as 'damping = { ratio = 0.016, ratio_frequency = \"600 Hz\" }' at the first surge frequency (0.016: the beehive of "
        "gu2021)."
    )


def buckling_notes(problem: Problem) -> tuple[str, ...]:
    """A sentence on each wire of a train that buckles by the formula before the largest lift and
    stands in no guide.

    The rod at rest is not solved for a train's run; what it says is a command away.
    """
    found: list[str] = []
    if problem.kind != TRAIN:
        return ()
    for spring in dict.fromkeys(spring for member in problem.members for spring in member.springs):
        place = (
            None
            if spring.wire is None or spring.guide is not None
            else formula_compression(spring.wire)
        )
        if place is not None and place < (
            open_compression := spring.precompression + largest_lift(problem)
        ):
            found.append(
                f"Spring '{spring.name}' buckles at {place * 1e3:.4g} mm compression by the formula of EN 13906-1, before the "
                f"{open_compression * 1e3:.4g} mm at full lift: guide it, or make it shorter or wider; 'valvetrain static' "
                "finds the place by finite elements."
            )
    return tuple(found)


#: Parts of a train whose friction is a force.
RUBBING = ("follower", "valve")


def refuse_speeds(problem: Problem, engine_speeds: Sequence[float]) -> None:
    """Raise :class:`InputError` for engine speeds (rad/s of the crank) that are not positive, or at
    which nothing moves.
    """
    if any(not (np.isfinite(speed) and speed > 0) for speed in engine_speeds):
        raise InputError(
            "every engine speed must be positive; give it as '4200 rpm'", "--engine-speed"
        )
    if engine_speeds and not problem.moves:
        remedy = "add a [lift_law] table, or leave the engine speed out for its statics and modes"
        raise InputError(
            f"case '{problem.record.name}' holds no lift law, so its spring does not move; {remedy}",
            "--engine-speed",
        )


def refuse_implausible(problem: Problem, engine_speeds: Sequence[float]) -> None:
    """Raise :class:`InputError` for a motion or a part that is nonsense, whatever could be computed
    of it.
    """
    gears = {
        member.label: member.gear.parameters
        for member in problem.members
        if member.gear is not None
    }
    if engine_speeds and problem.moves:
        refuse_implausible_motion(problem.valve_lift, (speed / 2 for speed in engine_speeds))
    for train in gears.values():
        refuse_implausible_parts(
            {
                f"train.{part}.friction": getattr(getattr(train, part, None), "friction", 0.0)
                for part in RUBBING
            }
        )


def refusals_before_run(problem: Problem, implausible: bool = False) -> dict[str, str]:
    """Label -> why the member cannot be integrated, of those that cannot; made by the same parts as
    a run.

    Springs under prescribed motion are also built as their states at rest need them. Raises
    :class:`InputError` with what refuses the
    whole run; ``implausible``: nonsense passes.
    """
    from valvetrain.runs.statics import reach_of
    from valvetrain.springs.finite_element import (
        FiniteElementRod,  # which a sweep of a train never needs
    )

    refuse_speeds(problem, problem.engine_speeds)
    if not implausible:
        refuse_implausible(problem, problem.engine_speeds)
    lift = float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))
    found = {}
    for member in problem.members:
        if member.refusal:
            found[member.label] = member.refusal
        elif not member.model.needs_rest and (
            refusal := prepare(problem, member, {}, problem.record.study).refusal
        ):
            found[member.label] = refusal
        for spring in member.springs:
            if spring.wire is None and member.gear is None:
                assert spring.card is not None
                problem.model_of(
                    "modal-uniform" if spring.card.mass is not None else "massless", spring
                )
            elif spring.wire is not None and (member.gear is None or member.model.needs_rest):
                rod = problem.model_of("finite-element", spring)
                if spring.contact.stiffness > 0:
                    spring.wire.refuse_solid(reach_of(spring, lift))
                if isinstance(rod, FiniteElementRod):
                    _ = rod.installed  # at rest it needs no time step
    return found
