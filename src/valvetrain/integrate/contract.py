"""What every integrator answers, and how long a run lasts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Protocol, runtime_checkable

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.integrate.train_record import TrainState
from valvetrain.integrate.train_run import TrainRunner
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.nested import carried_state
from valvetrain.system.contract import System
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.train_rest import TrainRest

#: Longest run-up that is taken for meant.
MAX_TURNS = 10_000
#: Share of a spring's stable time step that is used; here, where it is read without the kernels.
STEP_FRACTION = 0.8


@dataclass(frozen=True, slots=True)
class Cycles:
    """A number of cam revolutions from the state at rest; the last one is the result."""

    count: int = 2


@dataclass(frozen=True, slots=True)
class Periodic:
    """Until the motion repeats. ``cycles``: maximum of cam revolutions (None: the default of the system);
    ``method``: ``anderson`` or ``repeat`` (the classical one); ``tolerance``: change per turn
    relative to lift and lift times cam speed (None: the default one); ``probed``: four revolutions
    more test whether an orbit found by acceleration attracts, where that is in doubt, or a few whether a train of
    rods rattles. ``compared``: eight more give the scatter of what does not settle; without them, what comes no nearer to
    repeating is given up soon, its period perhaps unknown.
    """

    cycles: int | None = None
    method: str = "anderson"
    tolerance: float | None = None
    probed: bool = True
    compared: bool = True


@dataclass(frozen=True, slots=True)
class RunUp:
    """From the run's cam speed to ``last_cam_speed`` (rad/s) at ``cam_acceleration`` (rad/s2, of
    the sign of the change).
    """

    last_cam_speed: float
    cam_acceleration: float

    def duration(self, first_cam_speed: float) -> float:
        """Time (s) from ``first_cam_speed`` (rad/s) to the last. Raises :class:`InputError` for an
        acceleration that does not lead there or takes beyond :data:`MAX_TURNS` cam revolutions.
        """
        change = self.last_cam_speed - first_cam_speed
        if not (
            math.isfinite(self.cam_acceleration)
            and change * self.cam_acceleration > 0
            and self.last_cam_speed > 0
        ):
            raise InputError(
                "the cam acceleration of a run-up must lead from its first to its last speed; change its sign or the speeds"
            )
        if change / self.cam_acceleration * first_cam_speed > MAX_TURNS * 2 * math.pi:
            raise InputError(
                f"a run-up of more than {MAX_TURNS} cam revolutions is taken for a mistake; raise the acceleration"
            )
        return change / self.cam_acceleration


Until = Cycles | Periodic | RunUp
Keep = Literal["all", "contacts", "ends"]


@dataclass(frozen=True)
class RunOptions:
    """Numerical choices of a run.

    ``samples`` per cam revolution (None: the integrator's default). ``time_step`` (s; None: chosen
    by stability). ``keep``: channels stored, of ``all`` that the system shows, of the coil ``contacts`` and
    the ends, or of the ``ends`` alone. ``rest``: a train at rest where it is known already.
    ``integrator``: name in the registry (None: the first that serves). ``window``: begin and end
    (cam rad, may pass the end of the turn) in which the least force of every contact of a train is
    noted on every step (statistics ``least_..._force``, largest as ``open_..._force``). ``nose``:
    cam angle (rad) at which the force of the cam is taken to the angle itself. ``start``: motion at
    another speed that a train starts from instead of from rest. ``coil_contacts``: a train's coils are watched for
    clashes. ``watch``: called with the share of a long
    run that is done; False stops it.
    """

    samples: int | None = None
    time_step: float | None = None
    keep: Keep = "all"
    rest: TrainRest | None = None
    integrator: str | None = None
    window: tuple[float, float] | None = None
    nose: float | None = None
    start: Orbit | None = None
    coil_contacts: bool = True
    watch: Callable[[float], bool] | None = None


@runtime_checkable
class Integrator(Protocol):
    """One way of integrating a system in time; frozen. A run that fails is a status in its
    solution, never an exception.
    """

    @property
    def word(self) -> str: ...

    @property
    def order(self) -> int:
        """Declared order of convergence in the time step (0: exact at any step)."""
        ...

    def serves(self, system: System, until: Until) -> bool:
        """Whether this integrator runs such a system so long."""
        ...

    def run(
        self,
        system: System,
        cam_speed: float,
        until: Until,
        options: RunOptions,
        provenance: Provenance,
    ) -> Solution:
        """The run as a solution without events and quantities; see
        :func:`valvetrain.integrate.run.run`.
        """
        ...


@dataclass(frozen=True)
class OfOneSpring:
    """What serves a single spring of the class ``model`` under prescribed motion at a steady speed."""

    model: ClassVar[type[Any]]

    def serves(self, system: System, until: Until) -> bool:
        """Whether it runs such a system so long."""
        alone = isinstance(system, PrescribedSpring) and len(system.springs) == 1
        return alone and isinstance(system.springs[0], self.model) and not isinstance(until, RunUp)


@dataclass(frozen=True, eq=False)
class Orbit:
    """State at the start of a cam revolution, with the springs (as the run's step made them) and the cam
    speed (rad/s) that it belongs to.

    ``motion`` (2, S): displacement (m) of the retainer over that revolution and its derivative by the cam angle (m/rad),
    None where it does not repeat. ``contraction``: of the search that found it.
    """

    state: TrainState
    springs: tuple[SpringModel, ...]
    cam_speed: float
    motion: Array | None = None
    contraction: float = 0.1

    def at(self, ready: TrainRunner) -> TrainState:
        """The state for the same train at the speed of ``ready``: positions as they are, velocities
        in the ratio of the cam speeds (so that the rigid part of the motion fits), springs on the
        grid of the new step.
        """
        state, share = self.state.copy(), ready.cam_speed / self.cam_speed
        state.v[:] *= share
        retainer = ready.system.arrays.retainer
        place, rate = float(state.q[retainer]), float(state.v[retainer])
        springs = []
        for values, spring, other in zip(state.springs, self.springs, ready.springs, strict=True):
            values[spring.unknowns : 2 * spring.unknowns] *= share
            springs.append(carried_state(values, spring, other, place, rate))
        return TrainState(state.q, state.v, tuple(springs), state.law_state, state.held, 0.0)
