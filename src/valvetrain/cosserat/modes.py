"""Natural modes of the rod about a static state, contact included, and their share in force
transmission.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csc_matrix, diags
from scipy.sparse.linalg import eigsh

from valvetrain.arrays import Array
from valvetrain.cosserat.buffer import inertia_of
from valvetrain.cosserat.rates import axial_rate, end_coupling
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics
from valvetrain.errors import InputError

#: Axial share of the kinetic energy of a motion that is the same in all three directions.
EVEN_SHARE = 1 / 3


@dataclass(frozen=True)
class RodModes:
    """Modes about one static state: ``natural_frequency`` (nm,) in Hz, mass-normalised ``shape``
    (nm, nv, 3) in 1/sqrt(kg).

    ``axial_transmission`` (nm,): residue of seat reaction x retainer reaction over 2 k omega^2, so
    that each surge mode
    of an ideal uniform spring has +1 or -1; ``axial_mass_share`` (nm,): effective axial mass over
    the mass that moves, 1 of all
    modes together;
    ``axial_energy_share`` (nm,): share of the wire's kinetic energy that goes along the spring's
    axis.
    """

    natural_frequency: Array
    shape: Array
    axial_transmission: Array
    axial_mass_share: Array
    axial_energy_share: Array
    axial_stiffness: float

    def axial_modes(self, count: int = 3) -> NDArray[np.int64]:
        """Indices of the first ``count`` axial (surge) modes.

        Surge spreads over clusters of modes; each cluster is named by its strongest transmitter.
        Successive surge
        modes transmit with alternating sign, so neighbours of one sign are one cluster. A buckled
        spring transmits by its sway as well:
        a mode that moves less along the axis than evenly in all directions is none of surge.
        """
        size = np.abs(self.axial_transmission)
        found: list[int] = []
        for index in np.flatnonzero(
            (size > 0.12) & (self.natural_frequency > 0) & (self.axial_energy_share > EVEN_SHARE)
        ):
            if not found or np.sign(self.axial_transmission[found[-1]]) != np.sign(
                self.axial_transmission[index]
            ):
                found.append(int(index))
            elif size[index] > size[found[-1]]:
                found[-1] = int(index)
        return np.array(found[:count], dtype=np.int64)


def natural_modes(
    statics: RodStatics, state: RodState, count: int = 24, end_mass: float | None = None
) -> RodModes:
    """Lowest ``count`` modes about ``state`` with both ends fixed: K phi = omega^2 M phi on the
    tangent with contact.

    With ``end_mass`` (kg, the inactive wire's share in it) the retainer moves along the axis with
    that mass, under the dead load that
    holds the state; ``axial_transmission`` then is the share of each mode in carrying a push on the
    retainer to the seat, as if held too.

    A negative eigenvalue (unstable state) appears as a negative frequency. With ``statics.loads``
    the last end is free (the loads are
    dead): its cross-section, which has no inertia of its own, follows at rest; nothing is
    transmitted, so those shares are zero.
    """
    inertia = inertia_of(statics.mesh)
    free, massless = statics.free & (inertia > 0), np.flatnonzero(statics.free & (inertia <= 0))
    tangent = statics.tangent(state)
    stiffness = tangent[free][:, free]
    if len(massless):
        coupled = tangent[massless][:, free].toarray()
        stiffness = stiffness - csc_matrix(
            coupled.T @ np.linalg.solve(tangent[massless][:, massless].toarray(), coupled)
        )
    masses = inertia[free]
    if end_mass is not None:
        stiffness, masses = (
            _with_end(statics, state, tangent, stiffness, free, massless),
            np.append(masses, end_mass),
        )
    scale = 1.0 / np.sqrt(masses)
    scaled = (diags(scale) @ stiffness @ diags(scale)).tocsc()
    size = scaled.shape[0]
    count = min(count, size - 2)
    start = np.sin(1.0 + np.arange(size))
    values, vectors = eigsh(scaled, k=count, sigma=-1e3, which="LM", v0=start, tol=1e-10)
    order = np.argsort(values)
    values, vectors = values[order], scale[:, None] * vectors[:, order]
    travel = np.zeros(count) if end_mass is None else vectors[-1]
    vectors = vectors if end_mass is None else vectors[:-1]
    transmission, axial_stiffness = np.zeros(count), 0.0
    if statics.loads is None:
        # axial reactions (modes,) of seat and retainer to each shape
        rows = tangent[2::6][:, free] @ vectors
        on_seat = rows[: statics.mesh.first + 1].sum(axis=0)
        on_retainer = rows[statics.mesh.last :].sum(axis=0)
        axial_stiffness = axial_rate(statics, state)
        transmission = on_seat * on_retainer / (2 * axial_stiffness * values)
        if end_mass is not None:
            transmission = on_seat * travel * (1 / values + end_mass / (2 * axial_stiffness))
    full = np.zeros((len(free), count))
    full[free] = vectors
    full[6 * statics.mesh.last + 2 :: 6] = -travel
    mass = inertia[2::6]
    moves = statics.free[2::6]
    end = 0.0 if end_mass is None else end_mass
    axial = mass[moves] @ full[2::6][moves] - end * travel
    return RodModes(
        natural_frequency=np.sign(values) * np.sqrt(np.abs(values)) / (2 * np.pi),
        shape=np.moveaxis(full.reshape(-1, 6, count)[:, :3], 2, 0),
        axial_transmission=transmission,
        axial_mass_share=axial**2 / (np.sum(mass[moves]) + end),
        axial_energy_share=(mass @ full[2::6] ** 2)
        / sum(inertia[place::6] @ full[place::6] ** 2 for place in range(3)),
        axial_stiffness=axial_stiffness,
    )


def _with_end(
    statics: RodStatics,
    state: RodState,
    tangent: csc_matrix,
    stiffness: csc_matrix,
    free: NDArray[np.bool_],
    massless: NDArray[np.int64],
) -> csc_matrix:
    """The stiffness of the ``free`` unknowns with the retainer's travel as one more."""
    if len(massless):
        raise InputError("a wire under tip loads has no retainer that could move with a mass")
    pull, own = end_coupling(statics, state, tangent)
    column = csc_matrix(pull[free][:, None])
    return bmat([[stiffness, column], [column.T, csc_matrix([[own]])]]).tocsc()
