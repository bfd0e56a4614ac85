"""Everything that a run builds and finds before it integrates in time, without the run: what is
wrong may only show there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.errors import InputError
from valvetrain.quantities.plausible import refuse_implausible_motion, refuse_implausible_parts
from valvetrain.studies.ready import make_ready
from valvetrain.system.problem import Problem

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
    from valvetrain.springs.finite_element import (
        FiniteElementRod,  # which a sweep of a train never needs
    )
    from valvetrain.studies.rest import reach_of

    refuse_speeds(problem, problem.engine_speeds)
    if not implausible:
        refuse_implausible(problem, problem.engine_speeds)
    lift = float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))
    found = {}
    for member in problem.members:
        if member.refusal:
            found[member.label] = member.refusal
        elif not member.model.needs_rest and (
            refusal := make_ready(problem, member, {}, problem.record.study).refusal
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
