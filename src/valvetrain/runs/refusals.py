"""Refusals before the runs of a study: engine speeds, implausible motions and parts, what cannot be integrated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.quantities.limits import PARTS, REMEDY, refuse_implausible_motion
from valvetrain.runs.prepared import law_lift, prepare
from valvetrain.solution.status import reason
from valvetrain.springs.contract import TabulatedSpring
from valvetrain.springs.spec import spring_model
from valvetrain.system.problem import CHAIN, Member, Problem

#: Parts of a train with friction.
RUBBING = ("follower", "valve")


def checked_speeds(
    problem: Problem, engine_speeds: Sequence[float] | None, implausible: bool
) -> tuple[float, ...]:
    """The engine speeds (rad/s of the crank; None: those of the problem), refused as the two
    functions below do.

    ``implausible`` motions and parts pass.
    """
    speeds = problem.engine_speeds if engine_speeds is None else tuple(map(float, engine_speeds))
    refuse_speeds(problem, speeds)
    if not implausible:
        refuse_implausible(problem, speeds)
    return speeds


def refuse_speeds(problem: Problem, engine_speeds: Sequence[float]) -> None:
    """Raise :class:`InputError` for engine speeds (rad/s of the crank) that are not positive, or
    without a lift.
    """
    if any(not (np.isfinite(speed) and speed > 0) for speed in engine_speeds):
        raise InputError(
            "every engine speed must be positive; give it as '4200 rpm'", "engine_speeds"
        )
    if engine_speeds and not problem.moves:
        remedy = "add a [lift_law] table, or leave the engine speed out for its statics and modes"
        raise InputError(
            f"case '{problem.record.name}' holds no lift law, so its spring does not move; {remedy}",
            "engine_speeds",
        )


def refuse_implausible(problem: Problem, engine_speeds: Sequence[float]) -> None:
    """Raise :class:`InputError` for an implausible motion or part."""
    if problem.moves:
        refuse_implausible_motion(problem.valve_lift, (speed / 2 for speed in engine_speeds))
    values: dict[str, float] = {}
    for member in problem.members:
        for spring in member.springs:
            if (wire := spring.wire) is not None:
                coil = np.linspace(0.0, wire.total_coils, 65)
                values[f"spring '{spring.name}'.wire_diameter"] = float(
                    np.min(wire.wire_diameter.value(coil))
                )
                values[f"spring '{spring.name}'.spring_index"] = float(np.max(wire.index(coil)))
        if member.rubbing is not None:
            values["rubbing.friction_coefficient"] = member.rubbing.coefficient
        if member.gear is not None:
            train = member.gear.parameters
            for part in RUBBING:
                values[f"train.{part}.friction"] = getattr(
                    getattr(train, part, None), "friction", 0.0
                )
            for place, contact in train.contacts.items():
                values[f"train.contacts.{place}.friction_coefficient"] = (
                    contact.friction_coefficient
                )
    for place, value in values.items():
        for limit in PARTS:
            if limit.holds(place.rpartition(".")[2]) and (sentence := limit.why_not(value)):
                raise InputError(f"{sentence}; {REMEDY}", place)


def refusals_before_run(problem: Problem, implausible: bool = False) -> dict[str, str]:
    """Label -> why the member cannot be integrated, for those that cannot; found by the parts that
    a run is made of.

    Springs under prescribed motion are also built for their statics. Raises :class:`InputError`
    with what refuses the whole run; ``implausible`` values pass.
    """
    # A sweep of a train never needs these.
    from valvetrain.runs.statics import reach_of
    from valvetrain.springs.finite_element import FiniteElementRod
    from valvetrain.system.build import default_model

    checked_speeds(problem, None, implausible)
    lift = law_lift(problem)
    found = {}
    for member in problem.members:
        if member.refusal:
            found[member.label] = member.refusal
        elif not member.model.needs_rest and (refusal := _refusal(problem, member)):
            found[member.label] = refusal
        for spring in member.springs:
            if spring.wire is None and member.gear is None:
                problem.model_of(default_model(spring), spring)
            elif spring.wire is not None and (member.gear is None or member.model.needs_rest):
                rod = problem.model_of("finite-element", spring)
                if spring.contact.stiffness > 0:
                    spring.wire.refuse_solid(reach_of(spring, lift))
                if isinstance(rod, FiniteElementRod):
                    _ = rod.installed  # its statics need no time step
    return found


def _refusal(problem: Problem, member: Member) -> str:
    """Why a member cannot be integrated, empty where it can. A train on springs of tables, which take seconds each, is
    prepared on massless ones, once their rods have reached its lift; a default model whose rods do not, on the chains that
    run in its place.
    """
    try:
        springs = member.system({}, problem.built).springs
        tabulated = [spring for spring in springs if isinstance(spring, TabulatedSpring)]
        for spring in tabulated:
            spring.refuse_unreached()
        light = "massless" if tabulated else member.model.word
    except (InputError, ArithmeticError, ValueError) as error:
        wires = all(spring.wire for spring in member.springs)
        if not (wires and member.by_default) or member.model.word == CHAIN:
            return reason(error)
        light = CHAIN
    prepared = replace(member, model=spring_model(light))
    if prepared.refusal:
        prepared = member
    return prepare(problem, prepared, {}, problem.record.study).refusal
