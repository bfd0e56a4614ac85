"""Many variants of one rod under one motion: side by side in the vector unit, groups of them over
the cores.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from valvetrain.arrays import Array
from valvetrain.cosserat.buffer import RodDynamics, fill_buffer, stable_time_step, stepping_numbers
from valvetrain.cosserat.lanes import LANES, integrate_lanes
from valvetrain.cosserat.layout import PAD, ROWS, STRIDE, empty_buffer
from valvetrain.cosserat.mesh import MAXIMUM_VERTICES, RodMesh
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.time_stepping import GUIDED, LOWER_END, STRETCHES, UPPER_START
from valvetrain.cosserat.transient import dense_records, simulate
from valvetrain.errors import InputError
from valvetrain.units import Given, si

_ROW_STARTS = np.array([PAD + number * STRIDE for number in range(ROWS)], dtype=np.uint64)


@dataclass(frozen=True)
class RodBatch:
    """End forces of n variants: ``time`` (ns,), forces (n, ns); the ``dense_*`` records as in
    ``RodTransient``; SI units.

    ``completed`` (n,): whether the variant reached the end; forces after a divergence are NaN.

    >>> import numpy as np
    >>> none = np.zeros((2, 3))
    >>> batch = RodBatch(np.zeros(3), np.zeros(3), none, none, np.zeros(3), none, none, np.array([True, False]), 1e-7)
    >>> batch.completed.tolist()
    [True, False]
    """

    time: Array
    displacement: Array
    retainer_force: Array
    seat_force: Array
    dense_time: Array
    dense_retainer_force: Array
    dense_seat_force: Array
    completed: NDArray[np.bool_]
    time_step: float


def simulate_batch(
    meshes: Sequence[RodMesh],
    starts: Sequence[RodState],
    motion: Callable[[Array], ArrayLike],
    sample_interval: Given,
    samples: int,
    dynamics: RodDynamics,
    time_step: Given | None = None,
    workers: int = 1,
) -> RodBatch:
    """Integrate many variants of one rod from their equilibria under one motion, side by side.

    The variants share step, motion and mesh numbers; sections, geometry and gaps may differ. A mesh
    too long for the lanes runs one by one, and so do
    rods whose ends lift or whose coils rub.

    Parameters
    ----------
    meshes : n rods, ``FiniteElementRod.mesh``
    starts : n equilibria, ``FiniteElementRod.installed.state``
    motion : compression (m from the free state) of times (s), arrays of one shape
    sample_interval : between the samples (s, "20 us" or a pint quantity)
    samples : intervals to integrate
    dynamics : damping and coil contact of all
    time_step : s, as ``sample_interval``; None for the smallest stable one of all
    workers : threads; they change no bit

    Returns
    -------
    RodBatch with ``time`` (samples + 1,) s and forces (n, samples + 1) N

    Raises
    ------
    InputError : meshes that are not of one size, as many starts as meshes missing, a slip of units

    Examples
    --------
    >>> import numpy as np
    >>> import valvetrain as vt
    >>> same = {"mean_diameter": "22 mm", "pitch": "7 mm", "total_coils": 4, "material": "OTEVA 90 SC"}
    >>> wires = [vt.parameters.SpringDefinition(wire, **same) for wire in ("3.8 mm", "3.9 mm")]
    >>> rods = [vt.springs.FiniteElementRod(wire, "2 mm", 12) for wire in wires]
    >>> meshes, starts = [rod.mesh for rod in rods], [rod.installed.state for rod in rods]
    >>> batch = vt.cosserat.simulate_batch(meshes, starts, lambda time: np.full_like(time, 2e-3), "20 us", 5, rods[0].dynamics)
    >>> batch.seat_force.shape, batch.completed.tolist()
    ((2, 6), [True, True])
    """
    _check(meshes, starts)
    sample_interval = si(sample_interval, "time", "sample_interval")
    limit = (
        min(stable_time_step(mesh, dynamics) for mesh in meshes)
        if time_step is None
        else si(time_step, "time", "time_step")
    )
    dense = dense_records(sample_interval, samples)
    sub = max(1, int(np.ceil(sample_interval / dense / limit * (1 - 1e-9))))
    step, steps = sample_interval / (dense * sub), samples * dense * sub
    displacement = np.ascontiguousarray(motion(step * np.arange(steps + 1.0)), dtype=float)
    wide = (meshes[0].vertices + 2) * LANES <= MAXIMUM_VERTICES and dynamics.ends is None
    wide = wide and not dynamics.coil_friction

    def lanes(first: int) -> tuple[Array, NDArray[np.bool_]]:
        group = range(first, min(first + LANES, len(meshes)))
        chosen = [min(first + lane, len(meshes) - 1) for lane in range(LANES)]
        forces, reached = _advance_group(
            [meshes[k] for k in chosen],
            [starts[k] for k in chosen],
            dynamics,
            displacement,
            step,
            sub,
        )
        return forces[: len(group)], reached[: len(group)]

    def single(index: int) -> tuple[Array, NDArray[np.bool_]]:
        run = simulate(
            meshes[index], starts[index], motion, sample_interval, samples, dynamics, step
        )
        forces = np.full((1, 2, samples * dense + 1), np.nan)
        forces[0, 0, : len(run.dense_time)], forces[0, 1, : len(run.dense_time)] = (
            run.dense_retainer_force,
            run.dense_seat_force,
        )
        return forces, np.array([run.completed])

    with ThreadPoolExecutor(max(1, workers)) as pool:
        parts = list(
            pool.map(lanes, range(0, len(meshes), LANES))
            if wide
            else pool.map(single, range(len(meshes)))
        )
    forces = np.concatenate([part[0] for part in parts])
    return RodBatch(
        time=sample_interval * np.arange(samples + 1.0),
        displacement=displacement[:: dense * sub],
        retainer_force=forces[:, 0, ::dense],
        seat_force=forces[:, 1, ::dense],
        dense_time=step * sub * np.arange(samples * dense + 1.0),
        dense_retainer_force=forces[:, 0],
        dense_seat_force=forces[:, 1],
        completed=np.concatenate([part[1] for part in parts]),
        time_step=step,
    )


def _advance_group(
    meshes: Sequence[RodMesh],
    starts: Sequence[RodState],
    dynamics: RodDynamics,
    displacement: Array,
    step: float,
    sub: int,
) -> tuple[Array, NDArray[np.bool_]]:
    """Forces (LANES, 2, records) of one group of rods and which of them reached the end."""
    buffer = empty_buffer()
    rows = buffer[PAD : PAD + (ROWS - 1) * STRIDE + MAXIMUM_VERTICES]
    width = meshes[0].vertices + 4
    for lane, (mesh, start) in enumerate(zip(meshes, starts, strict=True)):
        single = fill_buffer(mesh, start, dynamics, step)
        for row in _ROW_STARTS.astype(int) - PAD:
            rows[row + lane : row + width * LANES : LANES][:width] = single[
                PAD + row : PAD + row + width
            ]
    integers, numbers, places = stepping_numbers(meshes[0], dynamics, step)
    each = [stepping_numbers(mesh, dynamics, step)[0] for mesh in meshes]
    integers[LOWER_END], integers[UPPER_START] = (
        max(row[LOWER_END] for row in each),
        min(row[UPPER_START] for row in each),
    )
    integers[GUIDED] = max(row[GUIDED] for row in each)
    steps = len(displacement) - 1
    dense = np.full((steps // sub + 1, 2, LANES), np.nan)
    reached = np.full(LANES, steps + 1, dtype=np.int64)
    integrate_lanes(
        buffer,
        integers,
        numbers,
        places,
        displacement,
        sub,
        _ROW_STARTS,
        np.zeros((STRETCHES, 2)),
        np.zeros((2, LANES)),
        dense,
        reached,
    )
    for lost in np.flatnonzero(reached <= steps):
        dense[reached[lost] // sub :, :, lost] = np.nan
    return np.ascontiguousarray(dense.transpose(2, 1, 0)), reached > steps


def _check(meshes: Sequence[RodMesh], starts: Sequence[RodState]) -> None:
    if not meshes or len(meshes) != len(starts):
        raise InputError(
            f"a batch needs as many start states as meshes and at least one; it has {len(starts)} and {len(meshes)}"
        )
    shapes = {
        (mesh.vertices, mesh.first, mesh.last, mesh.contact.offset, mesh.contact.groups)
        for mesh in meshes
    }
    if len(shapes) > 1:
        raise InputError(
            "the meshes of a batch differ in size; use one total_coils, one length of inactive wire and one mesh density"
        )
