"""Static equilibrium of the rod by Newton iteration under prescribed retainer displacement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.linalg import solve_banded
from scipy.sparse import coo_matrix, csc_matrix, dia_matrix
from scipy.sparse.linalg import splu

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import (
    LINEAR,
    CoilContactLaw,
    ContactResponse,
    contact_response,
    law_address,
    law_numbers,
)
from valvetrain.cosserat import energy_kernels as kern
from valvetrain.cosserat import quaternion as quat
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState, advance, free_state

#: Increments that must hold in a row before one is doubled after a failure, and failures after
#: which a target is given up.
HELD, FAILURES = 3, 40


@dataclass(frozen=True, slots=True)
class NewtonOptions:
    """``tolerance``: largest residual (N and N m over the coil radius) allowed;
    ``largest_increment`` of travel (m).
    """

    tolerance: float = 1e-5
    iterations: int = 25
    largest_increment: float = 4e-3
    smallest_increment: float = 1e-6


@dataclass(frozen=True, slots=True)
class TipLoads:
    """Dead loads in space on the wire's last end, which is free to move and turn: ``force`` (3,) N
    and ``torque`` (3,) N m.
    """

    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    torque: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """A static equilibrium: state, forces at both ends (N, compressive positive), energy (J),
    Newton record.
    """

    state: RodState
    retainer_force: float
    seat_force: float
    energy: float
    converged: bool
    residual: float
    iterations: int


class RodStatics:
    """Assembles residual and tangent of one mesh and solves for equilibrium; holds no state of its
    own.

    Both ends are fixed, unless ``loads`` are given: then the last end is free and carries them.
    """

    #: Whether the retainer may turn about the axis
    #: (:class:`~valvetrain.cosserat.turning.TurningStatics`).
    turns: ClassVar[bool] = False

    def __init__(
        self,
        mesh: RodMesh,
        contact_stiffness: float = 2e10,
        options: NewtonOptions | None = None,
        loads: TipLoads | None = None,
        contact_law: CoilContactLaw = LINEAR,
    ) -> None:
        self.mesh = mesh
        self.contact_stiffness = contact_stiffness
        self.contact_law = contact_law
        self.options = options or NewtonOptions()
        self.loads = loads
        slots = np.zeros((mesh.vertices, 6), dtype=bool)
        slots[mesh.first + 1 : mesh.last, :3] = True
        slots[mesh.first : mesh.last, 3:] = True
        if loads is not None:
            slots[mesh.last] = True
        #: Mask of the free unknowns; they are contiguous.
        self.free = slots.ravel()
        self._span = slice(
            int(np.argmax(self.free)), int(len(self.free) - np.argmax(self.free[::-1]))
        )
        count, width = self._span.stop - self._span.start, 2 * kern.HALF_BAND + 1
        #: Row of each entry of the band of free unknowns, by column, and whether it is one of theirs.
        self._rows = np.arange(count)[:, None] + (np.arange(width) - kern.HALF_BAND)[None]
        self._inside = (self._rows >= 0) & (self._rows < count)
        self._has_contact = bool(mesh.contact.points.any())
        self._radius = float(np.max(np.hypot(mesh.position[:, 0], mesh.position[:, 1])))

    def assemble(
        self, state: RodState, with_tangent: bool = True
    ) -> tuple[float, Array, Array, csc_matrix | None]:
        """Energy (J), residual (6 nv,), banded tangent and sparse contact tangent (None when no
        coils touch).
        """
        mesh, size = self.mesh, 6 * self.mesh.vertices
        residual = np.zeros(size)
        band = np.zeros((2 * kern.HALF_BAND + 1, size if with_tangent else 1))
        x, q = state.position, state.frame
        energy = kern.stretch_terms(
            mesh.first,
            mesh.last,
            x,
            q,
            mesh.edge_length,
            mesh.stretch_stiffness,
            mesh.rest_stretch,
            residual,
            band,
            with_tangent,
        )
        energy += kern.bend_terms(
            mesh.first,
            mesh.last,
            q,
            mesh.bend_stiffness,
            mesh.rest_bend,
            residual,
            band,
            with_tangent,
        )
        energy += kern.seat_terms(
            x,
            mesh.lower_seat_limit,
            mesh.upper_seat_limit - state.compression,
            mesh.node_length,
            self.contact_stiffness,
            law_address(self.contact_law),
            law_numbers(self.contact_law),
            residual,
            band,
            with_tangent,
        )
        if mesh.guide is not None:
            energy += kern.guide_terms(
                mesh.first,
                mesh.last,
                x,
                mesh.guide.bore,
                mesh.guide.rod,
                mesh.node_length,
                mesh.guide.stiffness,
                residual,
                band,
                with_tangent,
            )
        contact = None
        if self._has_contact:
            more, contact = self._contact(x, residual, with_tangent)
            energy += more
        if self.loads is not None:
            energy += self._load_tip(state, residual, self.loads)
        return energy, residual, band, contact

    def _load_tip(self, state: RodState, residual: Array, loads: TipLoads) -> float:
        """Take the tip's dead loads off the residual; returns the energy of the force (a torque in
        space has none).
        """
        last, force = self.mesh.last, np.array(loads.force)
        residual[6 * last : 6 * last + 3] -= force
        residual[6 * last + 3 : 6 * last + 6] -= quat.to_matrix(state.frame[last + 1 : last + 2])[
            0
        ].T @ np.array(loads.torque)
        return -float(force @ (state.position[last] - self.mesh.position[last]))

    def _contact(
        self, x: Array, residual: Array, with_tangent: bool
    ) -> tuple[float, csc_matrix | None]:
        line = self.mesh.contact
        active = int(np.count_nonzero(self.gaps(x) < 0.0)) if with_tangent else 0
        rows, columns = np.empty(324 * active, np.int64), np.empty(324 * active, np.int64)
        values = np.empty(324 * active)
        energy, used = kern.contact_terms(
            x,
            line.offset,
            line.upper_place,
            line.lower_place,
            line.distance,
            line.length,
            self.contact_stiffness,
            law_address(self.contact_law),
            law_numbers(self.contact_law),
            residual,
            rows,
            columns,
            values,
        )
        if not used:
            return energy, None
        size = 6 * self.mesh.vertices
        places = rows.astype(np.int32), columns.astype(np.int32)  # whose range scipy does not scan
        return energy, coo_matrix((values, places), shape=(size, size)).tocsc()

    def gaps(self, position: Array) -> Array:
        """Gap (groups, nv) in m between each contact point and its partner, infinite where there is
        none.
        """
        line, gaps = self.mesh.contact, np.empty_like(self.mesh.contact.length)
        kern.contact_state(
            position,
            line.offset,
            line.upper_place,
            line.lower_place,
            line.distance,
            line.length,
            gaps,
        )
        return gaps

    def tangent(self, state: RodState) -> csc_matrix:
        """Whole tangent stiffness (6 nv, 6 nv), fixed unknowns included."""
        _, _, band, contact = self.assemble(state)
        matrix = sparse_of(band)
        return matrix if contact is None else (matrix + contact).tocsc()

    def solve(self, state: RodState, compression: float) -> Equilibrium:
        """Equilibrium at a retainer displacement (m), from a nearby equilibrium ``state``; one
        increment.
        """
        state = self._predict(state, compression)
        energy, residual, band, contact = self.assemble(state)
        size = self._norm(residual)
        count = 0
        while size > self.options.tolerance and count < self.options.iterations:
            count += 1
            step = np.zeros_like(residual)
            step[self._span] = self._solve_linear(band, contact, -residual[self._span])
            scale, best = 1.0, None
            while True:
                trial = advance(state, scale * step, compression)
                trial_energy, trial_residual, trial_band, trial_contact = self.assemble(trial)
                trial_size = self._norm(trial_residual)
                best = (trial, trial_energy, trial_residual, trial_band, trial_contact, trial_size)
                # A torque in space has no energy to fall: wires under tip loads take whole steps
                # and small load increments.
                if (
                    trial_size < size
                    or trial_energy < energy - 1e-12 * abs(energy)
                    or scale < 0.02
                    or self.loads is not None
                ):
                    break
                scale *= 0.5
            state, energy, residual, band, contact, size = best
            if not np.isfinite(size):
                break
        retainer, seat = self.end_forces(state, residual)
        return Equilibrium(
            state, retainer, seat, energy, bool(size <= self.options.tolerance), size, count
        )

    def end_forces(self, state: RodState, residual: Array) -> tuple[float, float]:
        """Retainer and seat force (N, compressive positive) from the residual of the fixed vertices
        and the seats.
        """
        mesh, x = self.mesh, state.position
        axial = residual.reshape(-1, 6)[:, 2]
        lower = contact_response(self.contact_law, mesh.lower_seat_limit - x[:, 2]).elastic
        seats = self.contact_stiffness * mesh.node_length
        return float(
            -np.sum(axial[mesh.last :]) + self.retainer_contact(state).elastic @ seats
        ), float(np.sum(axial[: mesh.first + 1]) + lower @ seats)

    def retainer_contact(self, state: RodState) -> ContactResponse:
        """Contact of the wire at every vertex with the retainer's plane, per stiffness."""
        limit = self.mesh.upper_seat_limit - state.compression
        return contact_response(self.contact_law, state.position[:, 2] - limit)

    def _predict(self, state: RodState, compression: float) -> RodState:
        """Move the retainer and let the wire follow by the tangent: the increment spreads along the
        wire.
        """
        travel = compression - state.compression
        moved = np.zeros((self.mesh.vertices, 6))
        moved[self.mesh.last :, 2] = -travel
        if travel == 0.0:
            return state
        _, residual, band, contact = self.assemble(state)
        matrix = sparse_of(band) if contact is None else sparse_of(band) + contact
        load = (matrix @ moved.ravel())[self._span] + residual[self._span]
        change = moved.ravel()
        change[self._span] = self._solve_linear(band, contact, -load)
        return advance(state, change, compression)

    def follow(self, moved: Array, band: Array, contact: csc_matrix | None, load: Array) -> Array:
        """``moved`` (nv, 6) with the free unknowns in balance with ``load`` (nv, 6), by the tangent
        of :meth:`assemble`.
        """
        found = moved.ravel().copy()
        found[self._span] = self._solve_linear(band, contact, -load.ravel()[self._span])
        return found.reshape(moved.shape)

    def _solve_linear(self, band: Array, contact: csc_matrix | None, right: Array) -> Array:
        """The step by the tangent; not a number, which ends the search, where the tangent is
        singular.
        """
        half = kern.HALF_BAND
        try:
            if contact is None:
                found: Array = solve_banded(
                    (half, half), band[:, self._span], right, check_finite=False
                )
                return found
            matrix = (self._free_band(band) + contact[self._span, self._span]).tocsc()
            found = splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(
                right
            )
        except (np.linalg.LinAlgError, RuntimeError):  # of a band, of a sparse matrix
            found = np.full(len(right), np.nan)
        return found

    def _free_band(self, band: Array) -> csc_matrix:
        """The banded tangent of the free unknowns as a sparse matrix, without entries that are zero."""
        columns = band[:, self._span].T
        present = self._inside & (columns != 0.0)
        ends = np.append(0, np.cumsum(np.count_nonzero(present, axis=1)))
        size = (len(columns), len(columns))
        return csc_matrix((columns[present], self._rows[present], ends), shape=size)

    def _norm(self, residual: Array) -> float:
        steps = (residual * self.free).reshape(-1, 6)
        return float(max(np.abs(steps[:, :3]).max(), np.abs(steps[:, 3:]).max() / self._radius))


def sparse_of(band: Array) -> csc_matrix:
    """A banded tangent as a sparse matrix."""
    half, size = kern.HALF_BAND, band.shape[1]
    return dia_matrix((band, np.arange(half, -half - 1, -1)), shape=(size, size)).tocsc()


def compress(
    statics: RodStatics,
    targets: Sequence[float],
    start: RodState | None = None,
) -> list[Equilibrium]:
    """Equilibria at increasing retainer displacements (m); increments are halved where Newton fails
    and doubled after three that held.

    Returns the equilibria reached; the last one has ``converged`` False when the path ended early.
    """
    state = start or free_state(statics.mesh)
    found: list[Equilibrium] = []
    options = statics.options
    for target in targets:
        increment, holding, failures = options.largest_increment, HELD, 0
        while True:
            remaining = target - state.compression
            step = np.sign(remaining) * min(abs(remaining), increment)
            result = statics.solve(state, state.compression + step)
            if not result.converged:
                increment, holding, failures = (
                    abs(step) / 2,
                    0,
                    failures + 1,
                )  # of what was tried: the way left may be shorter
                if increment < options.smallest_increment or failures >= FAILURES:
                    return [*found, result]
                continue
            state, holding = result.state, holding + 1
            if (
                holding >= HELD
            ):  # a spring flat on its seat fails at the same increment again and again
                increment = min(2 * increment, options.largest_increment)
            if abs(target - state.compression) < 1e-12:
                break
        found.append(result)
    return found
