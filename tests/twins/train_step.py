"""Plain NumPy twin of the compiled train loop: the same step written with matrices and a linear
solve.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.optimize import brentq

from valvetrain.contact.kernels import LINEAR, contact_force
from valvetrain.mechanism.sliding import SLIDING_KINDS, sliding_gradient
from valvetrain.system.train_forces import gap_state


def integrate_in_time(runner, state, steps):
    """Positions and velocities after ``steps`` steps, and the forces of the last one. Massless
    springs and no restitution laws.
    """
    system, arrays = runner.system, runner.system.arrays
    q, v, h = state.q.copy(), state.v.copy(), runner.time_step
    mass, angle, omega = system.masses, state.cam_angle, runner.cam_speed
    forces, previous = np.zeros(len(arrays.kinds)), None
    for _ in range(steps):
        old = v.copy()
        pens, gradients, slopes = gap_state(system, q, angle)
        driven = slopes * omega
        bend = (
            np.zeros(len(pens))
            if previous is None
            else driven + gradients @ old - (pens - previous) / h
        )
        before = pens if previous is None else previous
        previous = pens
        forces, damping = np.zeros(len(pens)), np.zeros(len(pens))
        for k, pen in enumerate(pens):
            row, rate = arrays.law_parameters[k], driven[k] + gradients[k] @ v
            if arrays.laws[k] < 0:
                forces[k], damping[k] = row[0] * pen, row[1]
            elif pen > 0:
                forces[k] = contact_force(arrays.laws[k], row, 0.0, pen, 0.0)
                closing = max(abs(rate), 1e-9)
                damping[k] = (
                    contact_force(arrays.laws[k], row, 0.0, pen, closing) - forces[k]
                ) / closing
                if (
                    arrays.laws[k] == LINEAR and before[k] <= 0 < rate
                ):  # met within the step: the kick began half a step ago
                    damping[k] *= pen / (pen - before[k]) + 0.5
        total = arrays.body[:, 1] - forces @ gradients
        total[arrays.retainer] -= system.spring_force(float(q[arrays.retainer]))
        v = v + h * total / mass
        drag = h * (
            arrays.body[:, 2]
            + arrays.body[:, 3] / np.maximum(np.abs((old + v) / 2), arrays.body[:, 4])
        )
        theta = (3 + drag / mass) / (6 + drag / mass)
        heavy = mass + theta * drag
        v = (mass * v - (1 - theta) * drag * old) / heavy
        v, forces = _damp(arrays, gradients, driven, damping, forces, heavy, h, v, old, bend)
        v = _rub(system, q, angle, omega, forces, heavy, h, v)
        q = q + h * v
        angle += h * omega
    return q, v, forces


def sliding_state(system, q, cam_angle):
    """Sliding velocity of every contact per coordinate velocity (n, N) and per cam speed (n,) in
    m/rad; zero where nothing slides.
    """
    arrays, count = system.arrays, len(system.arrays.kinds)
    rows, slopes, gradients = np.zeros((count, 2)), np.zeros(count), np.zeros((count, len(q)))
    for k in np.flatnonzero(np.isin(arrays.kinds, SLIDING_KINDS)):
        slopes[k] = sliding_gradient(
            k,
            arrays.kinds,
            arrays.coordinate_of,
            arrays.geometry,
            arrays.tables,
            arrays.table_of,
            q,
            cam_angle,
            rows,
        )
        for slot in range(2):
            if arrays.coordinate_of[k, slot] >= 0:
                gradients[k, arrays.coordinate_of[k, slot]] += rows[k, slot]
    return gradients, slopes


def _rub(system, q, angle, omega, forces, mass, h, v):
    """Friction impulse of one contact after the other, the sliding velocity after it found by
    bisection.
    """
    rows, slopes = sliding_state(system, q, angle)
    for k, (coefficient, width) in enumerate(system.arrays.friction):
        if coefficient == 0 or forces[k] <= 0:
            continue
        free, mobility = rows[k] @ v + slopes[k] * omega, rows[k] ** 2 @ (1 / mass)
        most = h * coefficient * forces[k]
        after = brentq(
            lambda s, f=free, m=mobility * most, w=width: s + m * np.tanh(s / w) - f,
            -abs(free),
            abs(free),
            xtol=1e-16,
        )
        v = v - most * np.tanh(after / width) * rows[k] / mass
    return v


def _damp(arrays, gradients, driven, damping, forces, mass, h, v, old, bend):
    """Every choice of held contacts is tried: the one whose free contacts press and whose held
    dampers do not is the step's.
    """
    active = np.flatnonzero(damping > 0)
    if not len(active):
        return v, forces
    rows = gradients[active]
    mobility = rows / mass @ rows.T
    z = h * damping[active] * np.diag(mobility)
    theta = (3 + z) / (6 + z)
    before, after = (
        driven[active] + rows @ old - bend[active],
        driven[active] + rows @ v + bend[active],
    )
    right = after + (1 - theta) / theta * before
    matrix = mobility + np.diag(1 / (h * damping[active] * theta))
    floor = np.where(arrays.laws[active] >= 0, -forces[active] * h, -np.inf)
    for choice in itertools.product(
        *((False, True) if np.isfinite(least) else (False,) for least in floor)
    ):
        held = np.array(choice)
        impulse = np.where(held, floor, 0.0)
        free = ~held
        impulse[free] = np.linalg.solve(
            matrix[np.ix_(free, free)], right[free] - mobility[np.ix_(free, held)] @ impulse[held]
        )
        slack = 1e-12 * np.max(np.abs(right))
        if np.all(impulse[free] >= floor[free]) and np.all(
            (right - matrix @ impulse)[held] <= slack
        ):
            break
    else:
        raise AssertionError("no choice of held contacts fits")
    forces = forces.copy()
    forces[active] += impulse / h
    return v - impulse @ rows / mass, forces
