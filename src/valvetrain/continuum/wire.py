"""A spring's wire as bricks: mesh, section centres, contact points and seat planes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array, Flags, Ints
from valvetrain.coil_contact.law import LINEAR, CoilContactLaw
from valvetrain.continuum import contact_kernels
from valvetrain.continuum.bricks import Bricks, sweep_bricks
from valvetrain.continuum.mesh import MeshOptions, layer_coils, section_frames
from valvetrain.continuum.section import disc_section
from valvetrain.cosserat.contact_line import span_weights, true_distance
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition

Integers = Ints

#: Places of the contact points in the span of a station, and pairs of coils per turn of contact that
#: are reported.
CONTACT_PLACES, PAIRS_PER_COIL = (-0.25, 0.25), 8
#: Turns next to an end over which its plane may press on free wire.
PLANE_TURNS = 1.5
#: Stations that the scratch of a time step holds.
MAX_STATIONS = 4096


class ContactPoints(NamedTuple):
    """Contact points of the wire with the turn below: ``station`` and ``place`` in its span,
    ``distance`` (m) at which contact begins, ``stiffness`` (N/m), ``pair`` of coils; what kernels
    carry: ``foot`` (in stations), distance ``apart`` (m), ``near``, ``drag`` (2, points): damping
    force (N) and closing speed (m/s) of the step before, ``pressed`` (2, pairs): force and energy,
    ``peak`` (points,): largest force (N) since it was reset, ``held`` (4, points): normal force and
    friction on the upper wire along x, y, z (N).
    """

    station: Integers
    place: Array
    distance: Array
    stiffness: Array
    pair: Integers
    foot: Array
    apart: Array
    near: Flags
    drag: Array
    pressed: Array
    peak: Array
    held: Array

    def copy(self) -> ContactPoints:
        """With arrays of its own for what kernels carry."""
        return self._replace(
            foot=self.foot.copy(),
            apart=self.apart.copy(),
            near=self.near.copy(),
            drag=self.drag.copy(),
            pressed=self.pressed.copy(),
            peak=self.peak.copy(),
            held=self.held.copy(),
        )


class SeatPlanes(NamedTuple):
    """Stations that a plane may press on: ``side`` +1 at the seat, -1 at the retainer, the centre's
    ``height`` (m) at which it touches with the retainer at its free height, ``stiffness`` (N/m);
    ``radius`` (m) of the wire, ``peak`` and ``held`` (3, stations: normal, x, y; N) as of
    :class:`ContactPoints`.
    """

    station: Integers
    side: Array
    height: Array
    stiffness: Array
    radius: Array
    peak: Array
    held: Array


@dataclass(frozen=True)
class SolidMeshSize:
    """``per_coil`` slices along a turn, ``core`` x ``core`` cells inside ``rings`` rings of the
    section.
    """

    per_coil: int = 24
    core: int = 2
    rings: int = 1

    def __post_init__(self) -> None:
        if self.per_coil < 8:
            raise InputError(
                f"{self.per_coil} bricks per coil cannot follow a helix; give at least 8"
            )

    @property
    def cells(self) -> int:
        """Bricks per slice."""
        return self.core**2 + 4 * self.core * self.rings


@dataclass(frozen=True)
class SolidContactLaw:
    """Contact between coils and with seats, as the rod has it: ``stiffness`` (N/m per m of wire; 0:
    coils pass through one another), ``damping_time`` (s), ``law``. Coulomb coefficients of friction in
    motion between coils and of free wire on its seats; none at rest.
    """

    stiffness: float = 2e10
    damping_time: float = 1e-6
    law: CoilContactLaw = field(default=LINEAR)
    coil_friction: float = 0.0
    seat_friction: float = 0.0


@dataclass(frozen=True, eq=False)
class SolidWire:
    """Bricks of the wire of ``spring`` whose inactive turns are bonded to seat and retainer.

    Bricks fill the free wire; stations of the bonded turns stay as partners of contact. ``planes``:
    whether seat and retainer press on the free wire next to the bonded turns.
    """

    spring: SpringDefinition
    size: SolidMeshSize = SolidMeshSize()
    contact: SolidContactLaw = SolidContactLaw()
    planes: bool = True

    @cached_property
    def coil(self) -> Array:
        """Coil numbers of the stations."""
        options = MeshOptions(self.size.per_coil, element_type="C3D8I", ends="bonded")
        found = layer_coils(self.spring, options)
        if len(found) > MAX_STATIONS:
            raise InputError(
                f"{len(found)} stations are more than the solid takes ({MAX_STATIONS}); use fewer elements per coil"
            )
        return found

    @property
    def stations(self) -> int:
        """Sections of the wire."""
        return len(self.coil)

    @cached_property
    def ends(self) -> tuple[int, int]:
        """Stations at which the free wire leaves the seat and reaches the retainer."""
        first, last = self.spring.free_coils
        return (
            int(np.flatnonzero(self.coil <= first + 1e-9)[-1]),
            int(np.flatnonzero(self.coil >= last - 1e-9)[0]),
        )

    @cached_property
    def _section(self) -> tuple[Array, Integers, Array]:
        """Nodes (n, 2) of the section in the unit disc, its quadrilaterals (q, 4), and each node's
        share of the area.
        """
        disc = disc_section(self.size.core, self.size.rings, quadratic=False)
        used, quads = np.unique(disc.quads[:, :4], return_inverse=True)
        nodes, quads = disc.nodes[used], quads.reshape(-1, 4)
        x, y = nodes[quads].transpose(2, 0, 1)
        turned = x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y
        share = np.zeros(len(nodes))
        np.add.at(share, quads, 0.125 * turned.sum(axis=1)[:, None])
        return nodes, quads.astype(np.int64), share / share.sum()

    @property
    def section_nodes(self) -> Array:
        """Nodes (n, 2) in the unit disc: x outward from the spring's axis, y up."""
        return self._section[0]

    @property
    def weights(self) -> Array:
        """Share of the section's area of each node."""
        return self._section[2]

    @cached_property
    def grid(self) -> Array:
        """Free positions (stations, nodes, 3) in m.

        Straight slices cut the circle: the integral of R^2 ds, which makes the compliance, falls short
        by 5/24 theta^2 of it, so the radius is made larger by 5/72 theta^2.
        """
        outward, upward = section_frames(self.spring, self.coil)
        centre = self.spring.centreline(self.coil)
        centre[:, :2] *= 1 + 5 * (2 * np.pi / self.size.per_coil) ** 2 / 72
        radius = np.asarray(self.spring.wire_diameter.value(self.coil))[:, None, None] / 2
        place = radius * self.section_nodes[None]
        found: Array = centre[:, None] + place[..., :1] * outward[:, None]
        return found + place[..., 1:] * upward[:, None]

    @cached_property
    def bricks(self) -> Bricks:
        """The bricks of the free wire, with its mass: chords and tapered slices miss 0.7 % of it at 24
        slices per coil, and its frequencies half of that.
        """
        first, last = self.ends
        spring = self.spring
        found = sweep_bricks(
            self.grid,
            self._section[1],
            spring.material,
            reverse=spring.hand == "right",
            first=first,
            last=last,
        )
        squares = spring.integrate_along_wire(spring.wire_diameter, 2, spring.free_coils)
        own = spring.material.density * np.pi / 4 * squares
        return replace(found, mass=found.mass * (own / found.mass.sum()))

    @cached_property
    def free_position(self) -> Array:
        """Free positions (nodes, 3, stations) in m, as the kernels have them."""
        return np.ascontiguousarray(self.grid.transpose(1, 2, 0))

    def centres(self, position: Array) -> Array:
        """Section centres (3, stations) of positions (nodes, 3, stations)."""
        found: Array = np.einsum("n,nks->ks", self.weights, position)
        return found

    @cached_property
    def _station_length(self) -> Array:
        """Wire (m) that each station represents."""
        return np.asarray(self.spring.line_speed(self.coil)) * np.gradient(self.coil)

    @cached_property
    def contact_points(self) -> ContactPoints:
        """Contact points in the free shape; their feet are found."""
        coil, spring = self.coil, self.spring
        number = np.arange(self.stations, dtype=float)
        station = np.repeat(np.arange(1, self.stations - 1), len(CONTACT_PLACES))
        place = np.tile(CONTACT_PLACES, self.stations - 2)
        here = np.interp(station + place, number, coil)
        half = np.gradient(coil)[station] / (2 * len(CONTACT_PLACES))
        cell = np.minimum(here + half, spring.total_coils) - np.maximum(here - half, 1.0)
        foot = np.interp(here - 1, coil, number)
        used = (cell > 0) & (here >= coil[0] + 1)
        if not (self.contact.stiffness > 0):
            used &= False
        station, place, here, cell, foot = (
            part[used] for part in (station, place, here, cell, foot)
        )
        mean_speed = (spring.line_speed(here) + spring.line_speed(here - 1)) / 2
        bins = np.round(here * PAIRS_PER_COIL).astype(np.int64)
        pairs = np.unique(bins)
        points = ContactPoints(
            station,
            place,
            np.ones(len(station)),
            self.contact.stiffness * np.asarray(mean_speed) * cell,
            np.searchsorted(pairs, bins),
            np.clip(foot, 0.0, self.stations - 1.0),
            np.zeros(len(station)),
            np.zeros(len(station), dtype=bool),
            np.zeros((2, len(station))),
            np.zeros((2, len(pairs))),
            np.zeros(len(station)),
            np.zeros((4, len(station))),
        )
        free = self.centres(self.free_position).ravel()
        contact_kernels.follow_feet(free, self.stations, points, 0.0, 20)
        if not len(station):
            return points
        touch = (spring.wire_diameter.value(here) + spring.wire_diameter.value(here - 1)) / 2
        # contact begins at the wire diameter, or at the free distance of coils that are closer
        distance = points.apart + np.minimum(touch - true_distance(spring.centreline, here), 0.0)
        return points._replace(distance=distance)

    @cached_property
    def pair_coils(self) -> Array:
        """Upper coil numbers of the pairs of coils, at every eighth of a turn."""
        points = self.contact_points
        here = np.interp(
            points.station + points.place, np.arange(self.stations, dtype=float), self.coil
        )
        return np.unique(np.round(here * PAIRS_PER_COIL)) / PAIRS_PER_COIL

    @cached_property
    def seat_planes(self) -> SeatPlanes:
        """Free stations that seat and retainer may press on, as the rod has them: next to a closed
        end, and where coils telescope.
        """
        spring, coil, (first, last) = self.spring, self.coil, self.ends
        number = np.arange(self.stations)
        free = (number > first) & (number < last)
        below = (coil < coil[first] + PLANE_TURNS) & (spring.lower_end.kind != "open")
        above = (coil > coil[last] - PLANE_TURNS) & (spring.upper_end.kind != "open")
        pressing = self.planes and self.contact.stiffness > 0
        low = np.flatnonzero(pressing & free & (below | spring.telescopes(coil)))
        high = np.flatnonzero(pressing & free & (above | spring.telescopes(coil + 1.0)))
        level = self.centres(self.free_position)[2]
        radius = np.asarray(spring.wire_diameter.value(coil)) / 2
        height = np.concatenate(
            [
                np.minimum(spring.lower_seat_height + radius[low], level[low]),
                np.maximum(spring.upper_seat_height - radius[high], level[high]),
            ]
        )
        station = np.concatenate([low, high])
        side = np.concatenate([np.ones(len(low)), -np.ones(len(high))])
        stiffness = self.contact.stiffness * self._station_length[station]
        state = np.zeros(len(station)), np.zeros((3, len(station)))
        return SeatPlanes(station, side, height, stiffness, radius[station], *state)

    def contact_line(self, points: ContactPoints) -> tuple[Integers, Array]:
        """Control stations (points, 6) and their weights for the point and its foot, negative there."""
        upper = np.stack(span_weights(points.place), axis=1)
        span = np.clip(np.floor(points.foot + 0.5).astype(np.int64), 1, self.stations - 2)
        lower = np.stack(span_weights(points.foot - span), axis=1)
        around = np.arange(-1, 2)
        return (
            np.concatenate([points.station[:, None] + around, span[:, None] + around], axis=1),
            np.concatenate([upper, -lower], axis=1),
        )
