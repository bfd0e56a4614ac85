"""A spring reduced to rate, preload and mass: what the uniform models (massless, rod, modal) need."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.chain_layout import ChainLayout, check_masses
from valvetrain.springs.chain_statics import (
    contact_depths,
    frequencies,
    reduction_chain,
    solve_static,
    static_curve,
)
from valvetrain.units import Given, believed, keep_si, si


class Card(Protocol):
    """Required values of a spring card: rate (N/m), preload at the seat (N), mass (kg) or None."""

    @property
    def rate(self) -> float: ...

    @property
    def preload(self) -> float: ...

    @property
    def mass(self) -> float | None: ...


@dataclass(frozen=True)
class EquivalentSpring:
    """Uniform spring of ``rate`` (N/m), ``preload`` (N), vibrating ``active_mass`` (kg) and
    ``inactive_mass`` (kg) on the retainer.

    >>> spring = EquivalentSpring(rate=30e3, preload=250.0, active_mass=0.04)
    >>> round(spring.surge_frequency)  # half the root of rate over mass, in Hz
    433
    """

    rate: float
    preload: float
    active_mass: float
    inactive_mass: float = 0.0
    name: str = "spring"

    def __post_init__(self) -> None:
        keep_si(
            self,
            f"spring '{self.name}'",
            rate="spring_rate",
            preload="force",
            active_mass="mass",
            inactive_mass="mass",
        )
        if not self.rate > 0:
            raise InputError(
                f"rate of spring '{self.name}' is {self.rate} N/m; give a positive rate"
            )
        if not self.active_mass > 0:
            raise InputError(
                f"mass of spring '{self.name}' is {self.active_mass} kg; a vibrating spring needs a positive mass"
            )
        check_masses(self.name, self.preload, self.active_mass, 0.0, self.inactive_mass)

    @classmethod
    def from_card(cls, card: Card, name: str = "spring") -> EquivalentSpring:
        """All of the card's mass vibrates. Raises :class:`InputError` when the card gives no mass."""
        if card.mass is None:
            raise InputError(
                f"spring card '{name}' gives no mass; add it, or use the massless spring"
            )
        return cls(card.rate, card.preload, card.mass, name=name)

    @classmethod
    def from_definition(cls, spring: SpringDefinition, precompression: Given) -> EquivalentSpring:
        """Same tangent rate, preload and first surge frequency as the wire at its installed state,
        coils that touch stay closed.

        Equal first frequency fixes the mass (rate / (4 f1**2)): for a cylindrical spring the wire's
        own, for a beehive the mass that
        vibrates. Turns resting on the retainer count as inactive.
        """
        precompression = si(
            precompression, "compression", f"precompression of spring '{spring.name}'"
        )
        layout = reduction_chain(spring)
        force, rate = static_curve(layout, np.array([precompression]))
        first = float(frequencies(layout, precompression, 1)[0])
        nodes = solve_static(layout, precompression)
        riding = (
            layout.masses[nodes[1:-1] > 0.999 * precompression]
            if precompression > 0
            else np.zeros(0)
        )
        mass, held = float(rate[0]) / (4 * first**2), float(layout.retainer_mass + riding.sum())
        with believed():  # nobody wrote these numbers
            return cls(float(rate[0]), float(force[0]), mass, held, spring.name)

    @classmethod
    def from_installed(cls, spring: InstalledSpring) -> EquivalentSpring:
        """From the wire where it is known, else from the card."""
        if spring.wire is not None:
            return cls.from_definition(spring.wire, spring.precompression)
        assert spring.card is not None
        return cls.from_card(spring.card, spring.name)

    @property
    def wave_speed(self) -> float:
        """a = sqrt(rate / mass), spring lengths per second (1/s): twice the first surge frequency."""
        return float(np.sqrt(self.rate / self.active_mass))

    @property
    def surge_frequency(self) -> float:
        """First natural frequency (Hz), both ends fixed: a / 2."""
        return self.wave_speed / 2


def free_range(layout: ChainLayout, precompression: float) -> tuple[int, int]:
    """First and last node of the wire that rests on nothing at the installed state."""
    nodes, contacts = solve_static(layout, precompression), layout.contacts
    closed = contact_depths(layout, nodes) > -1e-9
    last = len(nodes) - 1
    middle = last // 2
    bound = np.zeros(last + 1, dtype=bool)
    bound[0] = bound[last] = True
    # A node whose own underside rests bounds from below, one carried from above bounds from above.
    resting = contacts.upper[closed & (contacts.upper < middle)]
    carried = contacts.lower[closed & (contacts.upper > middle) & (contacts.lower > middle)]
    low = int(resting.max()) if len(resting) else 0
    high = int(carried.min()) if len(carried) else last
    return low, max(high, low + 2)


@dataclass(frozen=True, eq=False)
class InstalledGaps:
    """Gaps of the free wire at the installed state, arrays over its places.

    ``turns`` (n,) coil numbers and ``flow`` (n,) the share 0..1 of compliance passed there (in
    which a wave runs uniformly).
    ``upper_coil`` (p,) coil number of the upper partner of each gap ``gap`` (p,) in m; it meets the
    wire one turn below. Places beyond
    ``turns`` rest on the seat or on the retainer and move with them.
    """

    turns: Array
    flow: Array
    upper_coil: Array
    gap: Array

    def position(self, coil: Array) -> Array:
        """Flow coordinate of coil numbers, 0 on the seat and 1 on the retainer."""
        return np.interp(coil, self.turns, self.flow)


def installed_gaps(spring: SpringDefinition, precompression: float) -> InstalledGaps:
    """Gaps of ``spring`` at ``precompression`` (m) by the static chain, coils closed where they
    touch.
    """
    layout = reduction_chain(spring)
    low, high = free_range(layout, precompression)
    nodes, contacts = solve_static(layout, precompression), layout.contacts
    turns = layout.coil_number[low : high + 1]
    flow = np.concatenate(([0.0], np.cumsum(1 / layout.stiffness[low:high])))
    # A turn resting on the seat or carried by the retainer can only meet one that is free.
    real = (
        (contacts.upper_coil > turns[0])
        & (contacts.upper_coil - 1 < turns[-1])
        & (contacts.upper_coil < spring.total_coils)
    )
    coil, gap = contacts.upper_coil[real], np.maximum(-contact_depths(layout, nodes)[real], 0.0)
    order = np.argsort(coil)
    return InstalledGaps(turns, flow / flow[-1], coil[order], gap[order])
