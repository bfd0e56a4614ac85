"""Plain NumPy twin of the compiled train loop: the same step written with matrices and a linear solve."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from valvetrain.contact.kernels import contact_force
from valvetrain.mechanism.sliding import SLIDING_KINDS, sliding_gradient
from valvetrain.system.train_forces import gap_state


def integrate_in_time(runner, state, steps):
    """Positions and velocities after ``steps`` steps, and the forces of the last one. Massless springs and no restitution laws."""
    system, arrays = runner.system, runner.system.arrays
    q, v, h = state.q.copy(), state.v.copy(), runner.time_step
    mass, angle, omega = system.masses, state.cam_angle, runner.cam_speed
    forces = np.zeros(len(arrays.kinds))
    for _ in range(steps):
        old = v.copy()
        pens, gradients, slopes = gap_state(system, q, angle)
        driven = slopes * omega
        forces, damping = np.zeros(len(pens)), np.zeros(len(pens))
        for k, pen in enumerate(pens):
            row, rate = arrays.law_parameters[k], driven[k] + gradients[k] @ v
            if arrays.laws[k] < 0:
                forces[k], damping[k] = row[0] * pen, row[1]
            elif pen > 0:
                forces[k] = contact_force(arrays.laws[k], row, 0.0, pen, 0.0)
                closing = max(abs(rate), 1e-9)
                damping[k] = (contact_force(arrays.laws[k], row, 0.0, pen, closing) - forces[k]) / closing
        total = arrays.body[:, 1] - forces @ gradients
        total[arrays.retainer] -= system.spring_force(float(q[arrays.retainer]))
        v = v + h * total / mass
        v, forces = _damp(arrays, gradients, driven, damping, forces, mass, h, v, old)
        v = _rub(system, q, angle, omega, forces, mass, h, v)
        for i in range(len(q)):
            coefficient = arrays.body[i, 2] + arrays.body[i, 3] / max(abs(v[i]), arrays.body[i, 4])
            z = h * coefficient / mass[i]
            v[i] /= 1 + z + z * z / 2
        q = q + h * v
        angle += h * omega
    return q, v, forces


def sliding_state(system, q, cam_angle):
    """Sliding velocity of every contact per coordinate velocity (n, N) and per cam speed (n,) in m/rad; zero where nothing slides."""
    arrays, count = system.arrays, len(system.arrays.kinds)
    rows, slopes, gradients = np.zeros((count, 4)), np.zeros(count), np.zeros((count, len(q)))
    for k in np.flatnonzero(np.isin(arrays.kinds, SLIDING_KINDS)):
        slopes[k] = sliding_gradient(
            k, arrays.kinds, arrays.coordinate_of, arrays.geometry, arrays.tables, arrays.table_of, q, cam_angle, rows
        )
        for slot in range(4):
            if arrays.coordinate_of[k, slot] >= 0:
                gradients[k, arrays.coordinate_of[k, slot]] += rows[k, slot]
    return gradients, slopes


def _rub(system, q, angle, omega, forces, mass, h, v):
    """Friction impulse of one contact after the other, the sliding velocity after it found by bisection."""
    rows, slopes = sliding_state(system, q, angle)
    for k, (coefficient, width) in enumerate(system.arrays.friction):
        if coefficient == 0 or forces[k] <= 0:
            continue
        free, mobility = rows[k] @ v + slopes[k] * omega, rows[k] ** 2 @ (1 / mass)
        most = h * coefficient * forces[k]
        after = brentq(lambda s, f=free, m=mobility * most, w=width: s + m * np.tanh(s / w) - f, -abs(free), abs(free), xtol=1e-16)
        v = v - most * np.tanh(after / width) * rows[k] / mass
    return v


def _damp(arrays, gradients, driven, damping, forces, mass, h, v, old):
    active = np.flatnonzero(damping > 0)
    if not len(active):
        return v, forces
    rows = gradients[active]
    mobility = rows / mass @ rows.T
    z = h * damping[active] * np.diag(mobility)
    theta = (3 + z) / (6 + z)
    right = driven[active] + rows @ v + (1 - theta) / theta * (driven[active] + rows @ old)
    held = np.zeros(len(active), dtype=bool)
    floor = np.where(arrays.laws[active] >= 0, -forces[active] * h, -np.inf)
    impulse = np.zeros(len(active))
    for _ in range(len(active)):
        impulse[held] = floor[held]
        free = ~held
        matrix = mobility[np.ix_(free, free)] + np.diag(1 / (h * damping[active] * theta))[np.ix_(free, free)]
        impulse[free] = np.linalg.solve(matrix, right[free] - mobility[np.ix_(free, held)] @ impulse[held])
        pulling = free & (impulse < floor)
        if not pulling.any():
            break
        held |= pulling
        impulse[pulling] = floor[pulling]
    forces = forces.copy()
    forces[active] += impulse / h
    return v - impulse @ rows / mass, forces
