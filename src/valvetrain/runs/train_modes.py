"""Natural frequencies and modes of a whole train with its springs, valve closed and at full lift."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.loading import AnyCase
from valvetrain.runs.run import member_rest
from valvetrain.solution.modes import TrainModes
from valvetrain.system.build import build
from valvetrain.system.problem import Member, Problem
from valvetrain.system.train_modes import modes_of_train
from valvetrain.system.train_system import TrainSystem

#: State -> words of tables.
STATES = {"closed": "valve closed", "full_lift": "full lift"}


def train_modes(
    case: AnyCase, spring_models: Sequence[str] = (), *, spring_sets: Sequence[str] = ()
) -> tuple[TrainModes, ...]:
    """Undamped natural frequencies and modes of a train with its springs, about rest with the valve
    closed and at full lift.

    Contacts that press at rest count with their stiffness there; one that does not (the lash, valve
    closed) has none. A multi-mass
    spring brings its own masses, a massless one its share of mass, any other the modes of the
    uniform spring of equal rate, mass and
    first frequency.

    Parameters
    ----------
    case : Case, name of a library case, or path of a case file; it holds a train
    spring_models : words of spring models, such as "multi-mass"; the case's own by default
    spring_sets : names of spring sets; the one in use by default

    Returns
    -------
    tuple of TrainModes, two per variant: ``state`` closed and full_lift, frequencies (Hz), shapes
    and shares of kinetic energy

    Raises
    ------
    InputError : a case without a train, an unknown word, what parts refuse

    Examples
    --------
    >>> import valvetrain as vt
    >>> closed, lifted = vt.train_modes("tdi-pushrod", ["massless"], spring_sets=["stock"])
    >>> closed.state, lifted.moving(0)
    ('closed', 'valve 53 %, pushrod 24 %, lever 23 %')
    """
    problem = build(case, spring_models=spring_models, spring_sets=spring_sets)
    return problem_modes(problem)


def problem_modes(problem: Problem) -> tuple[TrainModes, ...]:
    """Modes of every train of a problem that differs from the others; see :func:`train_modes`."""
    found: dict[tuple[object, ...], tuple[TrainModes, ...]] = {}
    for member in problem.members:
        if member.gear is None:
            raise InputError(
                f"case '{problem.record.name}' holds no train, only springs; its modes are those of the springs"
            )
        key = (member.gear, member.model.word, member.springs)
        if key not in found:
            found[key] = _member_modes(problem, member)
    return tuple(one for pair in found.values() for one in pair)


def _member_modes(problem: Problem, member: Member) -> tuple[TrainModes, ...]:
    system = member.system(member_rest(problem, member), problem.built)
    assert isinstance(system, TrainSystem)
    angle = np.linspace(0.0, 2 * np.pi, 1441)
    top = float(angle[np.argmax(system.mechanism.kinematics.valve_lift(angle))])
    low = float(angle[np.argmin(problem.valve_lift.lift(angle))])
    places = {"closed": low, "full_lift": top}
    return tuple(
        modes_of_train(system, member.springs, place, state, member.label)
        for state, place in places.items()
    )
