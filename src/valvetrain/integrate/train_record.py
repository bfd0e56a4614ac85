"""What a run of a train is given and what it leaves: its numerical choices, the state of one instant, and the record of one
cam cycle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from valvetrain.arrays import Array
from valvetrain.integrate.train_tuples import (
    HIGHEST,
    HIGHEST_ANGLE,
    LOADS,
)
from valvetrain.integrate.transitions import Transitions
from valvetrain.solution.force_peak import FORCE_BANDWIDTH, ForcePeak, force_peak
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.system.train_system import TrainSystem

TURN = 2 * np.pi
IMPACT_STEPS = 16
"""Parts of the rise of an impact; where the step is longer, it is divided for as long as the impact
lasts.
"""


@dataclass(frozen=True, slots=True)
class TrainOptions:
    """Numerical choices of a run.

    ``samples``: records per cam cycle. ``step_fraction``: step over the stable limit. ``time_step``
    (s) overrides it (rounded so that a cycle holds a whole number of steps). ``exchange``: steps
    per exchange of a partitioned coupling (0: all advance together). ``impact_steps``: parts in
    which the rise of an impact of a contact is taken (0: steps are never divided), more at a finer
    prescribed step. ``record_springs``: store the springs' inner states per sample;
    ``record_contacts``: write down the contacts of their coils. ``window``: begin and end (cam rad)
    of the part of the cycle in which minimum forces are searched; it may pass the end of the turn.
    ``nose`` (cam rad): where the forces of the contacts are taken to the angle itself.
    ``force_bandwidth`` (Hz): cut-off of the peaks of the springs' forces.
    """

    samples: int = 1440
    step_fraction: float = 0.35
    time_step: float | None = None
    exchange: int = 0
    impact_steps: int = IMPACT_STEPS
    record_springs: bool = False
    record_contacts: bool = False
    window: tuple[float, float] = (0.0, TURN)
    nose: float = 0.0
    force_bandwidth: float = FORCE_BANDWIDTH


@dataclass(frozen=True)
class TrainState:
    """Values of one instant: positions at t_n, velocities half of ``last_step`` (s; 0: of the run's
    own step) before, spring states, held spring forces.

    ``law_state``: memory of all laws in one flat array; ``TrainArrays.memory_of`` gives where an
    interaction's begins.
    """

    q: Array
    v: Array
    springs: tuple[Array, ...]
    law_state: Array
    held: Array
    cam_angle: float = 0.0
    last_step: float = 0.0

    def copy(self) -> TrainState:
        """An independent copy."""
        return TrainState(
            self.q.copy(),
            self.v.copy(),
            tuple(s.copy() for s in self.springs),
            self.law_state.copy(),
            self.held.copy(),
            self.cam_angle,
            self.last_step,
        )


@dataclass(frozen=True)
class CycleRecord:
    """One cam cycle, S samples: positions, velocities, accelerations (S, N); forces (N) and gaps
    (m) per interaction (S, n).

    ``spring_forces`` (S, springs, 2): retainer and seat force; ``spring_states``: per spring the
    head of its state (S, entries) or empty. ``cam_power`` (W). ``peak_forces``,
    ``peak_penetrations`` (n,): over every step; ``least_forces`` (n,): over every step inside the
    options' window; both with their cam angles (rad). ``largest_forces`` (n,): over every step
    inside the window; ``nose_forces`` (n,): at the nose. ``loads`` (7, 4), ``bodies`` (N, 5):
    extremes over every step by the rows and columns of ``train_tuples``. ``transitions``: openings
    and closings of every contact. ``work``: of cam, of constant and gas forces, dissipated, on
    springs (J). ``friction_loss`` (J): share of the contacts' friction in what was dissipated.
    ``pressed``: per spring the coil contacts at every ``pressed_interval`` (s), for its model's
    watch; without rows where not recorded. ``ends`` (bins, 4): end forces (N) by the first rows of
    ``train_tuples.LOADS``, means of ``averaged`` steps every ``end_interval`` (s); ``force_bandwidth`` (Hz):
    cut-off of their peaks.
    """

    cam_angle: Array
    q: Array
    v: Array
    a: Array
    forces: Array
    gaps: Array
    spring_forces: Array
    spring_states: tuple[Array, ...]
    cam_power: Array
    peak_forces: Array
    peak_penetrations: Array
    work: Array
    time_step: float
    cam_speed: float
    status: Status = COMPLETED
    friction_loss: float = 0.0
    peak_force_cam_angles: Array = field(default_factory=lambda: np.zeros(0))
    least_forces: Array = field(default_factory=lambda: np.zeros(0))
    least_force_cam_angles: Array = field(default_factory=lambda: np.zeros(0))
    transitions: Transitions = field(
        default_factory=lambda: Transitions.from_log(np.zeros((0, 7)), 0)
    )
    pressed: tuple[Array, ...] = ()
    pressed_interval: float = 0.0
    largest_forces: Array = field(default_factory=lambda: np.zeros(0))
    nose_forces: Array = field(default_factory=lambda: np.zeros(0))
    loads: Array = field(default_factory=lambda: np.zeros((0, 4)))
    bodies: Array = field(default_factory=lambda: np.zeros((0, 5)))
    ends: Array = field(default_factory=lambda: np.zeros((0, 4)))
    end_interval: float = 0.0
    averaged: int = 1
    force_bandwidth: float = FORCE_BANDWIDTH

    def force_peak(self, load: str) -> ForcePeak:
        """Peak of an end force, a row of ``train_tuples.LOADS`` but for the torque, below the cut-off."""
        row = LOADS.index(load)
        values = self.ends[:, row] if row < 4 else self.ends[:, row - 4] + self.ends[:, row - 2]
        turned = np.append(self.cam_angle, 2 * self.cam_angle[-1] - self.cam_angle[-2])
        raw, at = self.loads[row, HIGHEST], self.loads[row, HIGHEST_ANGLE]
        place = float(np.interp(at, turned, np.linspace(0.0, 1.0, len(turned))))
        cutoff, interval = self.force_bandwidth, self.end_interval
        return force_peak(values, interval, cutoff, float(raw), place, self.averaged)

    def touches_cam(self, system: TrainSystem) -> bool:
        """Whether the contact of the cam closed in this cycle; True for a train without one."""
        cam = system.mechanism.cam
        return cam is None or bool(self.peak_forces[cam] > 0)
