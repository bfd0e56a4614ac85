"""Equations 2 and 5 of the beehive study's modal model, letter by letter, with its printed modes.

Equation 2 holds the ratio of natural to cam frequency, and the text takes the wave speed from the
stiffness k(x), so that the frequencies follow its root over the cycle. The spring model
``modal-varied`` includes them, as a linear system must; this module has both, for the page on the study.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

#: Printed modes (Hz) and damping ratio (table 1, section 3.3).
FREQUENCIES, DAMPING_RATIO = (630.0, 1120.0, 1639.0), 0.016
#: Cam orders of the lift that are included.
ORDERS = 60


def forces_of_equation_5(
    valve_lift: ArrayLike,
    cam_speed: float,
    compression: ArrayLike,
    force: ArrayLike,
    precompression: float,
    following: bool,
) -> Array:
    """Force (N) of the modal model at even cam angles of one turn.

    ``valve_lift`` (m) at these angles; ``cam_speed`` in rad/s; ``compression`` (m) and ``force`` (N): the
    static curve; ``following``: natural frequencies follow the root of k(x) at each instant.

    >>> flat = forces_of_equation_5(np.zeros(64), 400.0, [0.0, 0.02], [0.0, 800.0], 7e-3, True)
    >>> flat.round(1)[:2].tolist()
    [280.0, 280.0]
    """
    moved = np.asarray(valve_lift, dtype=float)
    count, top = len(moved), min(ORDERS, len(moved) // 2)
    order = np.arange(top + 1)
    spectrum = np.fft.rfft(moved)[: top + 1] / count * np.where(order == 0, 1.0, 2.0)
    angle = 2 * np.pi * np.arange(count) / count
    curve, values = np.asarray(compression, dtype=float), np.asarray(force, dtype=float)
    bent = np.exp(1j * np.outer(angle, order)) * spectrum * order**2
    at = precompression + moved
    stiffness = np.interp(at, curve, values) / at
    rest = float(np.interp(precompression, curve, values)) / precompression
    follow = np.sqrt(stiffness / rest) if following else np.ones(count)
    total: Array = stiffness * at
    for frequency in FREQUENCIES:
        ratio = (2 * np.pi * frequency / cam_speed * follow)[:, None]
        transfer = ratio**2 - order**2 + 2j * DAMPING_RATIO * ratio * order
        total = total + 2 * stiffness * np.sum((bent / transfer).real, axis=1)
    return total
