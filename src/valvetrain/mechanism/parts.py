"""What a mechanism is made of: coordinates (masses) and interactions (gap geometry plus the name of
a law).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from valvetrain.arrays import Array
from valvetrain.contact import kernels
from valvetrain.contact.friction import CoulombFriction
from valvetrain.errors import InputError
from valvetrain.mechanism.gap_kinds import CAM_KINDS, GEOMETRY_COLUMNS, LINEAR

CONTACT, LINK, SPRING = "contact", "link", "spring"
"""Roles of an interaction: a contact pushes only, a link is a stiff part that rigid theory takes for
rigid, a spring is a soft part that acts on rigid bodies by its force.
"""


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
    :class:`MaxwellLink`. ``friction``: along the contact, None for none. ``role``: :data:`CONTACT`,
    :data:`LINK` or :data:`SPRING`; by default a contact by its law, a spring where a link holds one
    body to the ground, else a link. ``unit`` of the gap: 'm', or 'rad' where the law gives N m.
    """

    name: str
    kind: int
    coordinates: tuple[str, ...]
    geometry: tuple[float, ...]
    law: Law
    table: str = ""
    friction: CoulombFriction | None = None
    role: str = ""
    unit: str = ""

    def __post_init__(self) -> None:
        pulls = self.law.code < 0
        alone = SPRING if len(self.bodies) == 1 else LINK
        role = self.role or (alone if pulls else CONTACT)
        if role not in (CONTACT, LINK, SPRING) or role == (CONTACT if pulls else LINK):
            raise InputError(
                f"interaction '{self.name}' cannot be a '{role}' by its law; a contact law makes a contact or a spring, a link law a link or a spring"
            )
        object.__setattr__(self, "role", role)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the coordinates that it joins."""
        return tuple(name for name in self.coordinates if name)

    @property
    def load(self) -> tuple[str, str]:
        """What its law gives, force or moment, and the unit of that."""
        return ("moment", "N m") if self.unit == "rad" else ("force", "N")

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


@dataclass(frozen=True)
class AssembledMechanism:
    """A train without its spring, as every builder returns it: what moves and what touches what.

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
            turning = {one.unit for one in self.coordinates if one.name in interaction.bodies}
            if interaction.kind == LINEAR and turning == {"rad"} and not interaction.unit:
                raise InputError(
                    f"interaction '{interaction.name}' joins turning bodies only; give it unit = 'rad' where its law gives N m, 'm' where N"
                )
        for place, name in ((self.cam, "cam"), (self.seat, "seat")):
            if place is not None and self.interactions[place].name != name:
                raise InputError(
                    f"contact '{self.interactions[place].name}' of mechanism '{self.name}' is its {name}; call it '{name}'"
                )

    def index(self, name: str) -> int:
        """Place of a coordinate."""
        return [coordinate.name for coordinate in self.coordinates].index(name)

    def interaction_index(self, name: str) -> int:
        """Place of an interaction."""
        return [interaction.name for interaction in self.interactions].index(name)

    def _of_role(self, role: str) -> list[int]:
        """Places of the interactions of a role but what follows the cam."""
        numbered = enumerate(self.interactions)
        return [k for k, one in numbered if one.role == role and one.kind not in CAM_KINDS]

    @cached_property
    def cam(self) -> int | None:
        """Place of what follows the cam, None without it."""
        kinds = (interaction.kind in CAM_KINDS for interaction in self.interactions)
        return next((k for k, is_cam in enumerate(kinds) if is_cam), None)

    @cached_property
    def seat(self) -> int | None:
        """Place of the contact of the valve alone, its seat; None without one."""
        contacts = self._of_role(CONTACT)
        return next((k for k in contacts if self.interactions[k].bodies == (self.valve,)), None)

    @cached_property
    def held(self) -> list[int]:
        """Places of what keeps its length in rigid theory: links, and contacts between two bodies that
        move; a contact with the ground opens.
        """
        joining = (k for k in self._of_role(CONTACT) if len(self._moving(k)) > 1)
        return sorted([*self._of_role(LINK), *joining])

    @cached_property
    def soft(self) -> list[int]:
        """Places of what acts on rigid bodies by its own force: all but cam, seat and what is held."""
        others = {self.cam, self.seat, *self.held}
        return [k for k in range(len(self.interactions)) if k not in others]

    @cached_property
    def drive(self) -> tuple[int, ...]:
        """Places of the contacts on a way from the cam to the valve, in their order."""
        if self.cam is None:
            return ()

        cam, contacts = self.cam, set(self._of_role(CONTACT))

        def is_between(k: int) -> bool:
            others = [j for j in self.held if j != k]
            from_cam = self._moving(k) & self._reached(self._moving(cam), others)
            from_valve = self._moving(k) & self._reached({self.valve}, others)
            return bool(from_cam and from_valve) and len(from_cam | from_valve) > 1

        return tuple(sorted((cam, *(k for k in self.held if k in contacts and is_between(k)))))

    @cached_property
    def valve_side(self) -> list[int]:
        """Places of the coordinates that links alone join to the valve."""
        return sorted(map(self.index, self._reached({self.valve}, self._of_role(LINK))))

    def _moving(self, k: int) -> set[str]:
        """Bodies of an interaction but those that a link holds to the ground."""
        links = (self.interactions[j].bodies for j in self._of_role(LINK))
        held = {name for bodies in links if len(bodies) == 1 for name in bodies}
        return {*self.interactions[k].bodies} - held

    def _reached(self, start: set[str], over: list[int]) -> set[str]:
        """Moving bodies that interactions at the places ``over`` join to those of ``start``."""
        joined = [self._moving(k) for k in over]
        found = set(start)
        for _ in joined:  # as often as the longest way
            found |= {name for bodies in joined if bodies & found for name in bodies}
        return found
