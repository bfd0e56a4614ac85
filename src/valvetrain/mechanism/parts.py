"""What a mechanism is made of: coordinates (masses) and interactions (gap geometry plus the name of
a law).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from valvetrain.contact import kernels
from valvetrain.contact.friction import CoulombFriction
from valvetrain.errors import InputError
from valvetrain.mechanism.gap_kinds import GEOMETRY_COLUMNS

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One generalised coordinate of a body.

    ``mass``: kg, or kg m2 for a turning body (``unit`` 'rad'). ``force``: constant generalised
    force (N, N m), gravity included. ``damping``: viscous guide damping (N s/m). ``friction``:
    Coulomb guide friction (N), regularised below ``friction_velocity`` (m/s). Raises
    :class:`InputError` for a mass that no body has.
    """

    name: str
    mass: float
    unit: str = "m"
    force: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    friction_velocity: float = 0.01

    def __post_init__(self) -> None:
        noun = "moment of inertia" if self.unit == "rad" else "mass"
        if not (np.isfinite(self.mass) and self.mass > 0):
            raise InputError(f"the {noun} of '{self.name}' must be positive; it is {self.mass:g}")
        if self.damping < 0 or self.friction < 0:
            raise InputError(f"guide damping and friction of '{self.name}' must not be negative")
        if not self.friction_velocity > 0:
            raise InputError(f"the friction velocity of '{self.name}' must be positive")


class Law(Protocol):
    """What acts in an interaction: a contact law (``contact.law.ContactLaw``) or a link of this
    module.
    """

    @property
    def code(self) -> int:
        """Code of ``contact.kernels``: negative for a link, which pulls as well as it pushes."""
        ...

    @property
    def states(self) -> int:
        """How many numbers it remembers from step to step, zero at rest."""
        ...

    def parameters(self) -> Array:
        """At most ``contact.kernels.WIDTH`` values (SI) for the compiled loop."""
        ...


@runtime_checkable
class WithDifferentialMemory(Protocol):
    """A law whose memory follows a differential equation: it belongs to the motion and must repeat
    in a periodic state.
    """

    @property
    def states(self) -> int:
        """How many numbers it remembers."""
        ...

    def memory_derivative(self, memory: Array, penetration_rate: float) -> Array:
        """Rates of the ``states`` numbers at a rate (m/s) of the penetration."""
        ...

    def memory_scale(self, displacement: float) -> Array:
        """Size of the numbers in a motion of ``displacement`` (m)."""
        ...


@dataclass(frozen=True, slots=True)
class Interaction:
    """A gap between bodies and the law that acts in it.

    ``kind``: one of :mod:`valvetrain.mechanism.gap_kinds`. ``coordinates``: up to four coordinate
    names, '' where a slot is empty. ``geometry``: the row of the kind. ``table``: name of the lift
    or contour table, '' when none. ``law``: a contact law, an :class:`ElasticLink` or a
    :class:`MaxwellLink`. ``friction``: along the contact, None for none.
    """

    name: str
    kind: int
    coordinates: tuple[str, ...]
    geometry: tuple[float, ...]
    law: Law
    table: str = ""
    friction: CoulombFriction | None = None

    def geometry_row(self) -> Array:
        """The geometry padded to its fixed number of columns."""
        row = np.zeros(GEOMETRY_COLUMNS)
        row[: len(self.geometry)] = self.geometry
        return row


@dataclass(frozen=True, slots=True)
class ElasticLink:
    """A massless element that pulls as well as it pushes: ``stiffness`` N/m and ``damping`` N s/m."""

    stiffness: float
    damping: float = 0.0
    code: ClassVar[int] = kernels.ELASTIC_LINK
    states: ClassVar[int] = 0

    def __post_init__(self) -> None:
        if not self.stiffness > 0:
            raise InputError(
                f"the stiffness of an elastic link must be positive; it is {self.stiffness:g}"
            )
        if self.damping < 0:
            raise InputError(
                f"the damping of an elastic link must not be negative; it is {self.damping:g}"
            )

    def parameters(self) -> Array:
        """Stiffness and damping."""
        return np.array([self.stiffness, self.damping])


@dataclass(frozen=True, slots=True)
class MaxwellLink:
    """A massless link of a spring parallel to a spring and a damper in series (the standard linear
    solid, or Zener element).

    ``stiffness`` N/m of the lone spring (zero for a bare Maxwell element), ``branch_stiffness`` N/m
    and ``branch_damping`` N s/m of the two in series. It remembers the force f (N) of the branch:
    f' = branch_stiffness (rate - f / branch_damping). At rest f is zero.
    """

    stiffness: float
    branch_stiffness: float
    branch_damping: float
    code: ClassVar[int] = kernels.MAXWELL_LINK
    states: ClassVar[int] = 1

    def __post_init__(self) -> None:
        if not (np.isfinite(self.stiffness) and self.stiffness >= 0):
            raise InputError(
                f"the stiffness of a Maxwell link must be zero or positive; it is {self.stiffness:g}"
            )
        for name, value in (("stiffness", self.branch_stiffness), ("damping", self.branch_damping)):
            if not (np.isfinite(value) and value > 0):
                raise InputError(
                    f"the branch {name} of a Maxwell link must be positive; it is {value:g}"
                )

    def parameters(self) -> Array:
        """Stiffness, branch stiffness and branch damping."""
        return np.array([self.stiffness, self.branch_stiffness, self.branch_damping])

    def memory_derivative(self, memory: Array, penetration_rate: float) -> Array:
        """Rate (N/s), shape (1,), of the branch force ``memory`` (1,) at a rate (m/s) of the
        penetration.
        """
        return self.branch_stiffness * (penetration_rate - memory / self.branch_damping)

    def memory_scale(self, displacement: float) -> Array:
        """Branch force (N), shape (1,), that the bare branch spring takes at ``displacement`` (m)."""
        return np.array([self.branch_stiffness * displacement])


class Mechanism(Protocol):
    """A train without its spring: what moves, what touches what, and its rigid kinematics."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]: ...

    @property
    def interactions(self) -> tuple[Interaction, ...]: ...

    @property
    def tables(self) -> Mapping[str, Array]: ...

    @property
    def valve(self) -> str:
        """Name of the coordinate that carries the retainer; its value is the valve lift (m)."""
        ...


@dataclass(frozen=True)
class AssembledMechanism:
    """The plain :class:`Mechanism` that every builder returns.

    ``tables``: name -> (nodes, 3) value and first two derivatives over the cam angle. ``retainer``:
    coordinate that carries the spring retainer, ``valve``: coordinate whose value is called valve
    lift. ``motion_ratio``: valve velocity over cam-side velocity near mid lift, for step and force
    estimates. ``rigid``: callable of the rigid kinematics. ``travel``: lowest and highest value of
    the coordinates (by name) whose geometry ends somewhere: a lever's dead points (rad).
    """

    name: str
    coordinates: tuple[Coordinate, ...]
    interactions: tuple[Interaction, ...]
    tables: Mapping[str, Array]
    valve: str
    retainer: str
    kinematics: Any = None
    notes: Mapping[str, str] = field(default_factory=dict)
    travel: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        names = [coordinate.name for coordinate in self.coordinates]
        if len(set(names)) != len(names):
            raise InputError(
                f"mechanism '{self.name}' names a coordinate twice; give each its own name"
            )
        known = {*names, ""}
        for interaction in self.interactions:
            unknown = set(interaction.coordinates) - known
            if unknown:
                raise InputError(
                    f"interaction '{interaction.name}' joins unknown coordinates {sorted(unknown)}; known: {names}"
                )
            if interaction.table and interaction.table not in self.tables:
                raise InputError(
                    f"interaction '{interaction.name}' reads table '{interaction.table}', which is missing"
                )

    def index(self, name: str) -> int:
        """Place of a coordinate."""
        return [coordinate.name for coordinate in self.coordinates].index(name)

    def interaction_index(self, name: str) -> int:
        """Place of an interaction."""
        return [interaction.name for interaction in self.interactions].index(name)
