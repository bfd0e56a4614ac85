"""Modified trapezoid flanks: acceleration that rises and falls as a quarter sine between stretches
of constant acceleration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftSpec
from valvetrain.cam.flanks import FlankEvents, FlankModel, flanked

#: Ends of the pieces of the first half of a flank.
EIGHTH, SHARES = 0.125, (0.0, 0.125, 0.375, 0.5)
#: Peak acceleration 8 pi / (2 + pi) per unit rise and flank; peak velocity 2, jerk 4 pi times the
#: acceleration.
PEAK = 8 * np.pi / (2 + np.pi)
_WAVE = 4 * np.pi


@dataclass(frozen=True, slots=True, kw_only=True)
class ModifiedTrapezoid(FlankEvents):
    """Modified trapezoid: peak velocity 2, acceleration 4.8881, jerk 61.43 (per unit rise and
    flank).

    Acceleration: a quarter sine over the first eighth of the flank, constant to three eighths, a
    quarter sine to zero at the middle; the second half is the first turned about its middle
    (Neklutin; Norton, Cam Design and Manufacturing Handbook).
    """

    inside: ClassVar[tuple[float, ...]] = (0.125, 0.375, 0.625, 0.875)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return flanked(self, shape, cam_angle, derivative)


def shape(x: Array, derivative: int) -> Array:
    """Normalised flank: the first half, and one less the first half from the other end."""
    first = x < 0.5
    half = _first_half(np.where(first, x, 1 - x), derivative)
    if derivative == 0:
        return np.where(first, half, 1 - half)
    return np.where(first | (derivative % 2 == 1), half, -half)


def _first_half(x: Array, derivative: int) -> Array:
    pieces = [x < SHARES[1], x < SHARES[2]]
    return PEAK * np.select(
        pieces, [_rising(x, derivative), _even(x, derivative)], _falling(x, derivative)
    )


def _rising(x: Array, derivative: int) -> Array:
    sine, cosine = np.sin(_WAVE * x), np.cos(_WAVE * x)
    return np.asarray(
        (x / _WAVE - sine / _WAVE**2, (1 - cosine) / _WAVE, sine, _WAVE * cosine)[derivative]
    )


def _even(x: Array, derivative: int) -> Array:
    since = x - EIGHTH
    lift, velocity = EIGHTH / _WAVE - 1 / _WAVE**2, 1 / _WAVE
    return np.asarray(
        (
            lift + velocity * since + since**2 / 2,
            velocity + since,
            np.ones_like(x),
            np.zeros_like(x),
        )[derivative]
    )


def _falling(x: Array, derivative: int) -> Array:
    since = x - SHARES[2]
    lift, velocity = (float(_even(np.array(SHARES[2]), order)) for order in (0, 1))
    sine, cosine = np.sin(_WAVE * since), np.cos(_WAVE * since)
    parts = (
        lift + velocity * since + (1 - cosine) / _WAVE**2,
        velocity + sine / _WAVE,
        cosine,
        -_WAVE * sine,
    )
    return np.asarray(parts[derivative])


SPEC = LiftSpec(ModifiedTrapezoid, FlankModel)
