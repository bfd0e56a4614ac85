"""Forces, stiffness and stable step of an assembled train: the plain NumPy side of the compiled
loop.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from valvetrain.arrays import Array
from valvetrain.mechanism.gaps import gap_rows, table_value
from valvetrain.system.train_system import TrainSystem


def gap_states(
    system: TrainSystem, positions: Array, cam_angles: Array
) -> tuple[Array, Array, Array]:
    """Penetrations (S, n) in m, their gradients (S, n, N) and derivatives by the cam angle (S, n)
    in m/rad at ``positions`` (S, N) and ``cam_angles`` (S,) in rad.
    """
    arrays, shape = system.arrays, (len(cam_angles), len(system.arrays.kinds))
    pens, slopes, gradients = (
        np.zeros(shape),
        np.zeros(shape),
        np.zeros((*shape, positions.shape[1])),
    )
    gap_rows(
        arrays.kinds,
        arrays.coordinate_of,
        arrays.geometry,
        arrays.tables,
        arrays.table_of,
        np.ascontiguousarray(positions, dtype=float),
        cam_angles,
        np.zeros((shape[1], 4)),
        pens,
        gradients,
        slopes,
    )
    return pens, gradients, slopes


def gap_state(system: TrainSystem, q: Array, cam_angle: float) -> tuple[Array, Array, Array]:
    """Penetrations (n,) in m, their gradients (n, N) and derivatives by the cam angle (n,) in
    m/rad.
    """
    pens, gradients, slopes = gap_states(
        system, np.asarray(q)[None], np.array([cam_angle], dtype=float)
    )
    return pens[0], gradients[0], slopes[0]


def law_force(system: TrainSystem, place: int, pen: float) -> float:
    """Rate-free force (N) of one interaction at rest at a penetration (m)."""
    from valvetrain.contact.kernels import OWN_LAW, contact_force

    law, parameters = system.arrays.laws[place], system.arrays.law_parameters[place]
    if law < 0:
        return float(parameters[0] * pen)
    if law >= OWN_LAW:
        memory = np.zeros(system.mechanism.interactions[place].law.states)
        return float(system.law_kernels[law - OWN_LAW](parameters, memory, pen, pen, 0.0, 0.0)[0])
    return float(contact_force(law, parameters, 0.0, pen, 0.0)) if pen > 0 else 0.0


def law_tangent(system: TrainSystem, place: int, pen: float) -> float:
    """Derivative (N/m) of the force by the penetration in a quick motion, in which no damper of a
    branch gives way.
    """
    from valvetrain.contact.kernels import MAXWELL_LINK

    if system.arrays.laws[place] == MAXWELL_LINK:
        return float(np.sum(system.arrays.law_parameters[place, :2]))
    small = max(abs(pen) * 1e-6, 1e-12)
    return (law_force(system, place, pen + small) - law_force(system, place, pen - small)) / (
        2 * small
    )


def penetration_at(system: TrainSystem, place: int, force: float) -> float:
    """Penetration (m) at which one interaction carries ``force`` (N > 0), by bisection."""
    high = 1e-9
    while law_force(system, place, high) < force and high < 1.0:
        high *= 2
    low = 0.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if law_force(system, place, middle) < force else (low, middle)
    return high


def generalised_forces(
    system: TrainSystem,
    q: Array,
    cam_angle: float,
    spring_force: Callable[[float], float] | None = None,
) -> Array:
    """Static generalised forces (N, N m), shape (N,): constant, gas, laws and springs in their own
    equilibrium.

    ``spring_force``: static force (N) of the springs at a retainer displacement (m); the system's
    own by default.
    """
    arrays = system.arrays
    pens, gradients, _ = gap_state(system, q, cam_angle)
    forces = np.array([law_force(system, k, pen) for k, pen in enumerate(pens)])
    total = arrays.body[:, 1] - forces @ gradients
    total[arrays.retainer] -= (spring_force or system.spring_force)(float(q[arrays.retainer]))
    if arrays.gas_coordinate >= 0:
        total[arrays.gas_coordinate] += table_value(arrays.gas, 0, cam_angle)[0]
    return total


def highest_frequency(
    system: TrainSystem, force: float, cam_angle: float = 0.0, q: Array | None = None
) -> float:
    """Largest circular frequency (rad/s) of the train with every contact closed under ``force``
    (N), springs' ends fixed.
    """
    position = np.zeros(len(system.masses)) if q is None else q
    _, gradients, _ = gap_state(system, position, cam_angle)
    tangents = np.array(
        [law_tangent(system, k, penetration_at(system, k, force)) for k in range(len(gradients))]
    )
    root = 1 / np.sqrt(system.masses)
    stiffness = (gradients.T * tangents) @ gradients
    stiffness[system.arrays.retainer, system.arrays.retainer] += sum(
        s.tangent(s.initial_state(0.0), 0.0) for s in system.springs
    )
    return float(np.sqrt(np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1]))


def own_time_step(system: TrainSystem, force: float) -> float:
    """Stable leapfrog limit (s) of the train's own masses: 2 / highest frequency with every contact
    closed under ``force`` (N).
    """
    return 2 / highest_frequency(system, force)


def springs_time_step(system: TrainSystem, time_step: float) -> float:
    """Largest step (s) up to ``time_step`` that all springs carry; those that choose their grid by
    the step (wave rods) carry any.
    """
    limit = time_step
    for spring in system.springs:
        if spring.with_time_step(time_step).stable_time_step() < time_step * (1 - 1e-9):
            limit = min(limit, spring.stable_time_step())
    return float(limit)


def stable_time_step(system: TrainSystem, force: float) -> float:
    """Largest stable leapfrog step (s) of train and springs together."""
    return springs_time_step(system, own_time_step(system, force))
