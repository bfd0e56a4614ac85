"""Flat layout of a chain of masses along the wire: local stiffness, masses and real gaps from one
spring definition.

A section at coil number u moves by w(u) towards the seat, from the free state. Local rate of dn
turns:
1/dk = 64 R**3 dn / (G d**4) (torsion of the wire); masses from the wire's volume.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.coil_contact.law import LINEAR, CoilContactLaw
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition


def wire_lift_row(
    spring: SpringDefinition, coil: Array, place: float, *, from_below: bool
) -> Array:
    """Axial travel of the wire at coil number ``place`` towards its fixed end per node travel,
    shape (N + 1,), nodes at ``coil``.

    ``from_below``: relative to the lower fixed end (twist of the elements below counts), else of
    the upper end relative to the wire.
    """
    edges = np.minimum(coil, place) if from_below else np.maximum(coil, place)
    turned = 2 * np.pi * np.abs(place - edges)
    middle = (coil[:-1] + coil[1:]) / 2
    radius = spring.mean_diameter.value(np.array([place]))[0] / spring.mean_diameter.value(middle)
    share = (
        (np.diff(turned) - radius * np.diff(np.sin(turned)))
        / (2 * np.pi * np.diff(coil))
        * (-1.0 if from_below else 1.0)
    )
    row = np.zeros(len(coil))
    row[1:] += share
    row[:-1] -= share
    return row


@dataclass(frozen=True, eq=False)
class CoilContacts:
    """Unilateral contacts of a chain of N elements (nodes 0 = seat ... N = retainer), arrays of
    shape (p,).

    ``upper`` node meets the wire between nodes ``lower`` and ``lower + 1`` (share ``fraction``
    towards the latter) when the free
    ``gap`` (m) is used up; ``stiffness`` in N/m; ``upper_coil`` is the coil number of the upper
    partner (0 for
    contacts with the seat plane, the total turns for those with the retainer). The last contacts of
    the list, as many as ``end_rows``
    (e, N + 1) has rows, join the wire to a fixed end: there overlap is row . node positions less
    the gap. ``law``: the law of them all.
    """

    upper: Ints
    lower: Ints
    fraction: Array
    gap: Array
    stiffness: Array
    upper_coil: Array
    end_rows: Array = field(default_factory=lambda: np.zeros((0, 0)))
    law: CoilContactLaw = LINEAR

    @property
    def ends(self) -> int:
        """Number of contacts with a fixed end that have their own row."""
        return len(self.end_rows)

    def spans(self) -> tuple[Ints, Array]:
        """The end rows without their zeros: first node, length and place in the weights (3 e,),
        weights.
        """
        filled = [np.flatnonzero(row) for row in self.end_rows]
        first = np.array([nodes[0] for nodes in filled], dtype=np.int64)
        length = np.array([nodes[-1] + 1 for nodes in filled], dtype=np.int64) - first
        weights = [row[a : a + n] for row, a, n in zip(self.end_rows, first, length, strict=True)]
        return np.concatenate((first, length, np.cumsum(length) - length)), np.concatenate(
            (np.zeros(0), *weights)
        )

    @property
    def count(self) -> int:
        """Number of contacts."""
        return len(self.gap)

    def regular(self, inner: int) -> int:
        """Length of the leading run of contacts among nodes 1 .. ``inner``, both counting up by one
        at a constant fraction.
        """
        if not self.count or self.lower[0] < 1 or self.upper[0] > inner:
            return 0
        steady = (
            (np.diff(self.upper) == 1)
            & (np.diff(self.lower) == 1)
            & (np.abs(np.diff(self.fraction)) < 1e-9)
        )
        steady &= (self.upper[1:] <= inner) & (self.lower[1:] < inner)
        return self.count if np.all(steady) else int(np.argmin(steady)) + 1


NO_CONTACTS = CoilContacts(
    np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0)
)


@dataclass(frozen=True, eq=False)
class ChainLayout:
    """Chain of N elements: ``stiffness`` (N,) N/m, inner ``masses`` (N - 1,) kg, ``coil_number`` (N
    + 1,) of all nodes.

    ``seat_mass`` and ``retainer_mass`` (kg): half of the end elements plus the inactive wire there.
    """

    stiffness: Array
    masses: Array
    coil_number: Array
    seat_mass: float
    retainer_mass: float
    contacts: CoilContacts = NO_CONTACTS

    def __post_init__(self) -> None:
        if len(self.stiffness) < 2:
            raise InputError(
                "a chain needs at least two elements (one inner mass); raise the number of masses"
            )
        if not (np.all(self.stiffness > 0) and np.all(self.masses > 0)):
            raise InputError(
                "every element and mass of a chain must be positive; check wire, coil diameter and density"
            )

    @property
    def rate(self) -> float:
        """Rate (N/m) of the whole chain with every coil open."""
        return float(1 / np.sum(1 / self.stiffness))


def chain_from_definition(
    spring: SpringDefinition,
    elements: int,
    contact_stiffness: float,
    contact_law: CoilContactLaw = LINEAR,
) -> ChainLayout:
    """Chain of ``elements`` equal turns between the fixed ends; ``contact_stiffness`` in N/m per m
    of wire, 0 for no coil contact.
    """
    if elements < 2:
        raise InputError(f"a chain of {elements} elements has no inner mass; give at least 2")
    first, last = spring.free_coils
    coil = np.linspace(first, last, elements + 1)
    middle = np.concatenate(([first], (coil[:-1] + coil[1:]) / 2, [last]))
    lumps = _wire_mass(spring, middle)
    held = _wire_mass(spring, np.array([0.0, first, last, spring.total_coils]))
    contacts = (
        coil_contacts(spring, coil, contact_stiffness, contact_law)
        if contact_stiffness > 0
        else NO_CONTACTS
    )
    return ChainLayout(
        1 / local_compliance(spring, coil),
        lumps[1:-1],
        coil,
        float(lumps[0] + held[0]),
        float(lumps[-1] + held[2]),
        contacts,
    )


def uniform_chain(
    rate: float, mass: float, elements: int, inactive_mass: float = 0.0
) -> ChainLayout:
    """Uniform chain of a spring card: ``rate`` N/m, ``mass`` kg spread evenly, half an element's
    mass on either end.
    """
    if elements < 2:
        raise InputError(f"a chain of {elements} elements has no inner mass; give at least 2")
    if not (rate > 0 and mass > 0):
        raise InputError(
            f"a chain needs a positive rate and mass; the card gives {rate} N/m and {mass} kg"
        )
    lump = mass / elements
    return ChainLayout(
        np.full(elements, rate * elements),
        np.full(elements - 1, lump),
        np.linspace(0, 1, elements + 1),
        lump / 2,
        lump / 2 + inactive_mass,
    )


def local_compliance(spring: SpringDefinition, coil: Array) -> Array:
    """Compliance (m/N) of each interval of ``coil`` (n + 1,) -> (n,): integral of 64 R**3 / (G
    d**4) over the turns.
    """
    points, weights = _gauss(coil)
    radius, wire = spring.mean_diameter.value(points) / 2, spring.wire_diameter.value(points)
    found: Array = np.sum(
        weights * 64 * radius**3 / (spring.material.shear_modulus * wire**4), axis=1
    )
    return found


def _wire_mass(spring: SpringDefinition, coil: Array) -> Array:
    points, weights = _gauss(coil)
    area = np.pi / 4 * spring.wire_diameter.value(points) ** 2
    found: Array = np.sum(
        weights * spring.material.density * area * spring.line_speed(points), axis=1
    )
    return found


def _gauss(coil: Array) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(6)
    width = np.diff(coil)[:, None]
    return coil[:-1, None] + width * (nodes + 1) / 2, width * weights / 2


def axial_clearance(spring: SpringDefinition, coil: Array) -> Array:
    """Axial travel (m) until the wire at ``coil`` rests on the wire one turn below; infinite where
    they pass each other.
    """
    rise = spring.axial_position(coil) - spring.axial_position(coil - 1)
    shift = (spring.mean_diameter.value(coil) - spring.mean_diameter.value(coil - 1)) / 2
    wire = (spring.wire_diameter.value(coil) + spring.wire_diameter.value(coil - 1)) / 2
    nested = np.abs(shift) >= wire
    touching_rise = np.sqrt(np.where(nested, 0.0, wire**2 - shift**2))
    return np.where(nested, np.inf, np.maximum(rise - touching_rise, 0.0))


def coil_contacts(
    spring: SpringDefinition,
    coil: Array,
    contact_stiffness: float,
    contact_law: CoilContactLaw = LINEAR,
) -> CoilContacts:
    """All contacts of the chain with nodes at ``coil``: neighbouring coils, lower seat, retainer."""
    width, last_node = coil[1] - coil[0], len(coil) - 1
    held = coil[-1] + width * np.arange(
        1, int(np.floor((spring.total_coils - coil[-1]) / width + 1e-9)) + 1
    )
    places = np.concatenate((coil[1:], held))
    nodes = np.minimum(np.arange(1, len(places) + 1), last_node)
    line = contact_stiffness * width * spring.line_speed(places)
    # Neighbours: partners below the lower fixed end move with the seat (node 0).
    pairs = (
        (places >= 1.0)
        & (places - 1 < coil[-1] - 1e-9)
        & ((places < coil[-1] - 1e-9) | (places - 1 > coil[0] + 1e-9))
    )
    partner = np.clip((places - 1 - coil[0]) / width, 0.0, last_node)
    lower = np.minimum(np.floor(partner + 1e-9).astype(np.int64), last_node - 1)
    fraction = np.clip(partner - lower, 0.0, 1.0)
    fraction[fraction < 1e-9] = 0.0
    gap = np.where(places >= 1.0, axial_clearance(spring, np.maximum(places, 1.0)), np.inf)
    chosen = np.flatnonzero(pairs & np.isfinite(gap))
    # The run of free neighbours leads, so that the kernel can vectorise it.
    free = (lower[chosen] >= 1) & (nodes[chosen] < last_node)
    chosen = np.concatenate((chosen[free], chosen[~free]))
    rows = [(nodes[i], lower[i], fraction[i], gap[i], line[i], places[i]) for i in chosen]
    inner, stiffness = coil[1:-1], contact_stiffness * width * spring.line_speed(coil[1:-1])
    wire = spring.wire_diameter.value(inner)
    above = np.maximum(spring.axial_position(inner) - wire / 2 - spring.lower_seat_height, 0.0)
    below = np.maximum(spring.upper_seat_height - spring.axial_position(inner) - wire / 2, 0.0)
    rows += [
        (i + 1, 0, 0.0, above[i], stiffness[i], 0.0)
        for i in np.flatnonzero((inner < 1.0) | spring.telescopes(inner))
    ]
    # The retainer meets the section at inner node i + 1 from above.
    rows += [
        (last_node, i + 1, 0.0, below[i], stiffness[i], spring.total_coils)
        for i in np.flatnonzero((inner > spring.total_coils - 1) | spring.telescopes(inner + 1.0))
    ]
    return _with_ends(spring, coil, rows, contact_law)


def _with_ends(
    spring: SpringDefinition,
    coil: Array,
    rows: Sequence[tuple[float, ...]],
    contact_law: CoilContactLaw,
) -> CoilContacts:
    """The contacts in order, those of a free wire with a fixed end last and with their own rows."""
    if not rows:
        return NO_CONTACTS
    last = len(coil) - 1
    column = [np.array(values) for values in zip(*rows, strict=True)]
    upper, lower, fraction = (
        column[0].astype(np.int64),
        column[1].astype(np.int64),
        column[2].astype(float),
    )
    gap, stiffness, upper_coil = (values.astype(float) for values in column[3:])
    on_seat = (lower == 0) & (fraction == 0.0) & (upper < last)
    under_retainer = (upper == last) & ~((lower == 0) & (fraction == 0.0))
    free = np.where(on_seat, coil[upper], coil[lower] + fraction * (coil[lower + 1] - coil[lower]))
    # Coils that telescope meet the seat far from the end, whose stiffness they do not feel.
    on_seat &= free - coil[0] < 1.0
    under_retainer &= coil[-1] - free < 1.0
    order = np.argsort(on_seat | under_retainer, kind="stable")
    held = np.flatnonzero(on_seat | under_retainer)
    ends = [wire_lift_row(spring, coil, float(free[i]), from_below=bool(on_seat[i])) for i in held]
    # travel by bending alone: the moment R sin(psi - phi) about the wire's normal, off the clamp, under a force there
    place, wire = free[held], spring.wire_diameter.value(free[held])
    psi = 2 * np.pi * np.where(on_seat[held], place - coil[0], coil[-1] - place)
    radius = spring.mean_diameter.value(place) / 2
    bending_stiffness = spring.material.youngs_modulus * np.pi / 64 * wire**4
    bending = radius**3 * (psi / 2 - np.sin(2 * psi) / 4) / bending_stiffness
    stiffness[held] = 1 / (1 / stiffness[held] + bending)
    return CoilContacts(
        upper[order],
        lower[order],
        fraction[order],
        gap[order],
        stiffness[order],
        upper_coil[order],
        np.array(ends).reshape(-1, last + 1),
        contact_law,
    )


#: Share of the wire's mass that moves with the retainer in the static shape (Rayleigh).
RAYLEIGH_FRACTION = 1.0 / 3.0


def check_masses(
    name: str, preload: float, active_mass: float, fraction: float, inactive_mass: float
) -> None:
    """Raise :class:`InputError` for a preload or mass no spring has."""
    if preload < 0:
        raise InputError(
            f"preload of spring '{name}' is {preload} N; give zero or a positive force"
        )
    if active_mass < 0 or inactive_mass < 0:
        raise InputError(
            f"mass of spring '{name}' is {active_mass} kg (fixed ends {inactive_mass} kg); give zero or positive masses"
        )
    if not 0 <= fraction <= 1:
        raise InputError(
            f"effective_mass_fraction of spring '{name}' is {fraction}; it must be between 0 and 1 (one third is typical)"
        )
