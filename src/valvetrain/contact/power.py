"""Shared arithmetic of the laws F = K d**n (1 + factor * d') that never pull."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.contact.law import Array, overlap


def damped_power_force(stiffness: float, exponent: float, factor: float, penetration: ArrayLike, penetration_rate: ArrayLike) -> Array:
    """Force (N); ``factor`` in s/m."""
    growth = np.maximum(1.0 + factor * np.asarray(penetration_rate, dtype=float), 0.0)
    return stiffness * overlap(penetration) ** exponent * growth


def damped_power_tangent(stiffness: float, exponent: float, factor: float, penetration: ArrayLike, penetration_rate: ArrayLike) -> Array:
    """Derivative (N/m) of :func:`damped_power_force` by the penetration."""
    growth = np.maximum(1.0 + factor * np.asarray(penetration_rate, dtype=float), 0.0)
    depth = overlap(penetration)
    return np.where(depth > 0, stiffness * exponent * depth ** (exponent - 1.0) * growth, 0.0)


def damped_power_loss(stiffness: float, exponent: float, factor: float, penetration: ArrayLike, penetration_rate: ArrayLike) -> Array:
    """Dissipated power (W) of :func:`damped_power_force`."""
    elastic = stiffness * overlap(penetration) ** exponent
    force = damped_power_force(stiffness, exponent, factor, penetration, penetration_rate)
    return (force - elastic) * np.asarray(penetration_rate, dtype=float)
