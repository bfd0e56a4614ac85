"""The one contract of all spring models between seat and retainer.

Written for the finite-element rod (a large internal state); the massless spring is the case with no
unknown.
A model is a frozen object; its values travel in one flat ``state`` array. Objects build flat arrays
once, then the train's
compiled loop calls ``kernel`` at every step and never sees the object.

Stepping (explicit leapfrog shared by everything that moves in a train)::

    retainer_force, seat_force = kernel(parameters, integers, state, retainer_displacement,
    retainer_velocity, time_step)

* ``retainer_displacement`` (m) at t_n, measured from the INSTALLED position, compressive positive
  (= valve lift when the
  retainer moves with the valve); ``retainer_velocity`` (m/s) is the best value known at the call
  (the half-step velocity of the
  leapfrog is good enough; it enters damping and rubbing only).
* The kernel computes both end forces at t_n (N, compressive positive, preload included) from the
  internal positions at t_n,
  then kicks and drifts its unknowns in place to t_(n+1). ``time_step == 0``: forces only;
  positions, velocities and
  bookkeeping stay as they are (scratch behind them may be written).
* ``state[:unknowns]`` are positions at t_n, ``state[unknowns:2 * unknowns]`` velocities at
  t_(n-1/2); what follows
  (histories, the dissipated energy) is bookkeeping of the model and no part of a periodicity test.
* A train with step h first calls ``model.with_time_step(h)`` for the model adapted to that step (a
  wave rod chooses its grid; all
  others answer themselves), then uses THAT model's arrays.
* The spring's share of mass that moves with the retainer (``retainer_mass``) is carried by the
  train, never by the kernel:
  the force on a retainer with acceleration A is ``retainer_force + retainer_mass() * A``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from valvetrain.arrays import Array, Ints

#: Target spacing of a record of coil contacts over the spring's first natural period, of some 2 ms: their
#: impacts last about 10 us.
WATCH_SHARE = 1e-3
Kernel = Callable[[Array, Ints, Array, float, float, float], tuple[float, float]]


class EndForces(NamedTuple):
    """Forces (N, compressive positive, preload included) on the retainer and on the seat."""

    retainer: float
    seat: float


class SpringEnergy(NamedTuple):
    """Energies (J); ``elastic`` counts from the model's own zero, so only differences matter
    between models.
    """

    kinetic: float
    elastic: float
    contact: float
    dissipated: float = 0.0

    @property
    def potential(self) -> float:
        """Elastic plus contact energy (J); its derivative by the retainer displacement is the
        retainer force.
        """
        return self.elastic + self.contact

    @property
    def total(self) -> float:
        """Kinetic plus potential energy (J); dissipated energy not counted."""
        return self.kinetic + self.elastic + self.contact


def _empty() -> Array:
    return np.zeros(0)


@dataclass(frozen=True)
class SpringOutputs:
    """What a spring shows at one instant; SI units.

    ``coil_number`` (n,): turns from the lower wire tip of each section; ``axial_displacement``
    (n,): motion of the section from the
    installed state along z (seat to retainer, so compression is negative). ``upper_coil`` (p,),
    ``coil_gap`` (p,),
    ``coil_contact_force`` (p,): coil pairs by the coil number of the upper partner. Empty where the
    model has none. ``section_loads``: (n,) by the names of their channels, where the model knows them.
    """

    retainer_force: float
    seat_force: float
    coil_number: Array = field(default_factory=_empty)
    axial_displacement: Array = field(default_factory=_empty)
    axial_velocity: Array = field(default_factory=_empty)
    upper_coil: Array = field(default_factory=_empty)
    coil_gap: Array = field(default_factory=_empty)
    coil_contact_force: Array = field(default_factory=_empty)
    section_loads: Mapping[str, Array] = field(default_factory=dict)


class ShownSeries(NamedTuple):
    """What a spring shows at n instants: as :class:`SpringOutputs`, with arrays by instants (n, ...) but for
    the coil numbers, and ``energy`` (n, 4) in J (None: not requested).
    """

    coil_number: Array
    axial_displacement: Array
    axial_velocity: Array
    upper_coil: Array
    coil_gap: Array
    coil_contact_force: Array
    section_loads: Mapping[str, Array]
    energy: Array | None


@dataclass(frozen=True, eq=False)
class ContactWatch:
    """Where in a state the contacts of the coils are, so that a compiled loop can record them
    without knowing the model.

    ``stretches`` (r, 2): first entry and length of each stretch of the state that is written, one
    after the other.
    ``first_period`` (s): first natural period of the spring. ``interval``: target spacing (s) of the
    record. ``read(record, spacing, time_step)``: of the
    pairs that touch in a record (n, entries)
    at a spacing (s) of a run with that step (s), their places (p,) in the row of all pairs by coil
    number, the coil numbers (p,) of their
    upper partners, force (N) and stored energy (J), both (p, n).
    """

    stretches: Ints
    first_period: float
    interval: float
    read: Callable[[Array, float, float], tuple[Ints, Array, Array, Array]]

    @property
    def entries(self) -> int:
        """Values per row of the record."""
        return int(self.stretches[:, 1].sum())


@runtime_checkable
class WatchedSpring(Protocol):
    """A spring model whose coil contacts can be recorded inside the loop; None where this spring
    has none.
    """

    def contact_watch(self) -> ContactWatch | None: ...


@runtime_checkable
class SpringWithModes(Protocol):
    """A spring model with modes of its own, about rest at a retainer displacement (m): ``stiffness`` (N/m) of its
    coordinates, of unit mass each, and of the retainer, which is last; ``surge_frequency`` (Hz), both ends fixed.
    """

    def stiffness(self, retainer_displacement: float) -> Array: ...

    def surge_frequency(self, retainer_displacement: float) -> float: ...


@runtime_checkable
class LargeSpring(Protocol):
    """A spring model whose inner state is too large for many samples and for an accelerated search
    of the periodic state.
    """

    def prepare(self) -> None:
        """Find once what all runs of this model share, before threads do."""
        ...

    def place_retainer(
        self, state: Array, retainer_displacement: float, travel_since: float
    ) -> None:
        """Write into a recorded ``state`` where the retainer was when its positions were taken:
        ``travel_since`` (m) before
        ``retainer_displacement`` (m)."""
        ...


@runtime_checkable
class OutputsTogether(Protocol):
    """A spring model that gives its outputs at many instants at once, for loops over all samples."""

    def outputs_at(
        self, states: Array, displacements: Array, velocities: Array
    ) -> list[SpringOutputs]:
        """:meth:`SpringModel.outputs` of every row of ``states`` (n, s) at the ``displacements`` (n,) m
        and ``velocities`` (n,) m/s of the retainer.
        """
        ...


@runtime_checkable
class ShownTogether(Protocol):
    """A spring model that shows many instants at once, and reads for them the first ``sampled_entries`` of
    a state alone.
    """

    @property
    def sampled_entries(self) -> int: ...

    def shown_at(
        self, states: Array, displacements: Array, velocities: Array, time_step: float
    ) -> ShownSeries:
        """:meth:`SpringModel.outputs` and :meth:`SpringModel.energy` of every row of ``states`` (n, s) at
        the ``displacements`` (n,) m and ``velocities`` (n,) m/s of the retainer.
        """
        ...


@runtime_checkable
class TabulatedSpring(Protocol):
    """A spring model made of tables over lift, which needs the largest travel of the retainer."""

    def reaching(self, largest_lift: float) -> SpringModel:
        """The model with tables up to a lift (m) and a little more."""
        ...

    def make_tables(self) -> None:
        """Make or read the tables; raises where there are none."""
        ...

    def refuse_unreached(self) -> None:
        """Raise :class:`InputError` where the tables would not reach the lift; none are made."""
        ...


def outputs_at(
    spring: SpringModel, states: Array, displacements: Array, velocities: Array
) -> list[SpringOutputs]:
    """The outputs of a spring at many instants, at once where its model can."""
    if isinstance(spring, OutputsTogether):
        return spring.outputs_at(states, displacements, velocities)
    motion = zip(states, displacements.tolist(), velocities.tolist(), strict=True)
    return [spring.outputs(state, x, v) for state, x, v in motion]


def shown_at(
    spring: SpringModel,
    states: Array,
    displacements: Array,
    velocities: Array,
    time_step: float,
    energies: bool = True,
) -> ShownSeries:
    """Outputs of a spring at many instants and, if requested, ``energies``; at once where its model can."""
    if isinstance(spring, ShownTogether):
        return spring.shown_at(states, displacements, velocities, time_step)
    shown = outputs_at(spring, states, displacements, velocities)
    motion = zip(states, displacements.tolist(), velocities.tolist(), strict=True)
    rows = (
        [tuple(spring.energy(state, x, v, time_step)) for state, x, v in motion] if energies else []
    )
    first = shown[0]
    return ShownSeries(
        first.coil_number,
        np.array([one.axial_displacement for one in shown]),
        np.array([one.axial_velocity for one in shown]),
        first.upper_coil,
        np.array([one.coil_gap for one in shown]),
        np.array([one.coil_contact_force for one in shown]),
        {
            name: np.array([one.section_loads[name] for one in shown])
            for name in first.section_loads
        },
        np.array(rows) if energies else None,
    )


def sampled_entries(spring: SpringModel, state: Array) -> int:
    """How many entries of a ``state`` (s,) samples need."""
    return spring.sampled_entries if isinstance(spring, ShownTogether) else len(state)


def contact_watch_of(spring: object) -> ContactWatch | None:
    """The watch of a spring model, None where its kind or this spring has no coil contacts to
    record.
    """
    return spring.contact_watch() if isinstance(spring, WatchedSpring) else None


@runtime_checkable
class SpringModel(Protocol):
    """One fidelity of a spring. All quantities SI; see the module text for the stepping rules.

    >>> import valvetrain as vt
    >>> isinstance(vt.springs.MasslessSpring(30e3, 250.0), SpringModel)
    True
    """

    @property
    def name(self) -> str: ...

    @property
    def unknowns(self) -> int:
        """Internal degrees of freedom (0 for a massless spring)."""
        ...

    @property
    def kernel(self) -> Kernel:
        """Compiled function with the signature of :data:`Kernel`."""
        ...

    def parameters(self) -> Array:
        """Flat float64 array for the kernel."""
        ...

    def integers(self) -> Ints:
        """Flat int64 array for the kernel."""
        ...

    def with_time_step(self, time_step: float) -> SpringModel:
        """The model adapted to the train's step (s); most answer themselves."""
        ...

    def initial_state(self, retainer_displacement: float) -> Array:
        """State of static equilibrium (at rest) at ``retainer_displacement`` (m)."""
        ...

    def stable_time_step(self) -> float:
        """Largest stable leapfrog step (s) of the model between fixed ends, contacts closed;
        infinite where there is none.
        """
        ...

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Energies (J); ``time_step`` > 0 brings the half-step velocities to the time of the
        positions (second order).
        """
        ...

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        """Both end forces (N); at zero velocities the retainer force is the derivative of the
        potential energy.
        """
        ...

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        """Derivative (N/m) of the retainer force by the retainer displacement, internal positions
        fixed.
        """
        ...

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        """Section motion, coil gaps and forces of this instant."""
        ...

    def retainer_mass(self) -> float:
        """Mass (kg) of the spring that moves with the retainer; the train adds it to the valve."""
        ...
