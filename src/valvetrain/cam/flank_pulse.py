"""Half a lobe from its acceleration: a positive pulse after the ramp, then a negative one that is greatest at the nose.

Both pulses are polynomials that begin without slope, so that the jerk is continuous from the end of the ramp to the nose.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import polynomial

from valvetrain.cam.contract import Array
from valvetrain.cam.pieces import PeriodicPieces, quintic_pieces, with_base_circle

Powers = tuple[float, ...]


def _twice(*pulse: float) -> tuple[Powers, float, float]:
    """The second integral of a pulse by ascending powers, and what the first and the second come to at 1."""
    second = tuple(map(float, polynomial.polyint(pulse, 2)))
    return second, float(polynomial.polyint(pulse).sum()), sum(second)


#: Share of a flank with positive acceleration: least, usual and most.
SHARES, USUAL_SHARE = (0.08, 0.6), 0.27
#: 16 u^2 (1 - u)^2: largest value 1, no slope at either end.
RISEN, GAINED_AT_1, RISEN_AT_1 = _twice(0, 0, 16, -32, 16)
#: Negative pulse from its start (0) to the nose (1) at fullness 0, 1 (nearly even) and -1 (gathered at the nose).
MIDDLE, EVEN, GATHERED = _twice(0, 0, 3, -2, 0, 0), _twice(0, 0, 10, -20, 15, -4), _twice(0, 0, 0, 0, 5, -4)


@dataclass(frozen=True)
class HalfLobe:
    """One flank: ``length`` (rad) from the end of the ramp to the nose, ``start`` lift (m) and velocity (m/rad) it takes over.

    ``share`` of the length with positive acceleration, ``fullness`` (-1 to 1) of the nose, ``maximum_lift`` (m).
    """

    maximum_lift: float
    start: tuple[float, float]
    length: float
    share: float
    fullness: float = 0.0

    @cached_property
    def _negative(self) -> tuple[Powers, float, float]:
        other, part = EVEN if self.fullness >= 0 else GATHERED, abs(self.fullness)
        mixed = tuple((1 - part) * a + part * b for a, b in zip(MIDDLE[0], other[0], strict=True))
        return mixed, (1 - part) * MIDDLE[1] + part * other[1], (1 - part) * MIDDLE[2] + part * other[2]

    @cached_property
    def sizes(self) -> tuple[float, float, float]:
        """Largest acceleration and deceleration (m/rad2, both positive) and velocity (m/rad), from rest at ``maximum_lift``."""
        (lift, velocity), (_, lost, fallen) = self.start, self._negative
        first, second = self.share * self.length, (1 - self.share) * self.length
        left = second * (1 - fallen / lost)
        up = (self.maximum_lift - lift - velocity * (first + left)) / (first**2 * RISEN_AT_1 + first * GAINED_AT_1 * left)
        fastest = velocity + up * first * GAINED_AT_1
        return up, fastest / (second * lost), fastest

    @property
    def pieces(self) -> tuple[Array, Array]:
        """Ascending coefficients (2, 8) of the lift over the angle (rad) since the beginning of either pulse, and their lengths (2,)."""
        (lift, velocity), (up, down, fastest), fallen = self.start, self.sizes, self._negative[0]
        lengths = self.length * np.array([self.share, 1 - self.share])
        first, second = lengths
        rows = np.zeros((2, len(fallen)))
        rows[0, : len(RISEN)] = up * first**2 * np.array(RISEN)
        rows[1] = -down * second**2 * np.array(fallen)
        rows /= lengths[:, None] ** np.arange(len(fallen))
        rows[:, 0] += lift, lift + velocity * first + up * first**2 * RISEN_AT_1
        rows[:, 1] += velocity, fastest
        return rows, lengths

    def before_nose(self, cam_angle: float) -> float:
        """Lift (m) at ``cam_angle`` (rad) before the nose; on the straight ramp beyond the flank."""
        since, (lift, velocity), (up, down, fastest) = self.length - cam_angle, self.start, self.sizes
        first, second = self.share * self.length, (1 - self.share) * self.length
        if since < 0:
            return lift + velocity * since
        if since < first:
            return lift + velocity * since + up * first**2 * _value(RISEN, since / first)
        since -= first
        lift += velocity * first + up * first**2 * RISEN_AT_1
        return lift + fastest * since - down * second**2 * _value(self._negative[0], since / second)

    def after_ramp(self, ramp_length: float, blend: float) -> tuple[Array, Array]:
        """Ascending coefficients (pieces, 8) and lengths (pieces,) of a ramp that ends at ``start``, and of the flank.

        The ramp is ``ramp_length`` (rad) long; its velocity is built up over the share ``blend`` of it.
        """
        (lift, velocity), (flank, lengths) = self.start, self.pieces
        ends = np.array([0.0, blend * ramp_length, ramp_length])
        states = np.array([[0.0, 0.0, 0.0], [velocity * ends[1] / 2, velocity, 0.0], [lift, velocity, 0.0]])
        if blend == 1:
            ends, states = ends[[0, 2]], states[[0, 2]]
        ramp = np.zeros((len(ends) - 1, flank.shape[1]))
        ramp[:, :6] = quintic_pieces(ends, states[:-1], states[1:])
        return np.vstack([ramp, flank]), np.concatenate([np.diff(ends), lengths])


def joined(nose: float, opening: tuple[Array, Array], closing: tuple[Array, Array]) -> PeriodicPieces:
    """A lobe about ``nose`` (cam rad) of two flanks by :meth:`HalfLobe.after_ramp`, the second run backwards."""
    (rows, widths), (others, backwards) = opening, closing
    turned = np.array([_mirrored(row, width) for row, width in zip(others, backwards, strict=True)])[::-1]
    lengths = np.concatenate([widths, backwards[::-1]])
    breaks = nose - widths.sum() + np.concatenate([[0.0], np.cumsum(lengths)])
    return with_base_circle(breaks, np.vstack([rows, turned]), 2)


def _mirrored(row: Array, width: float) -> Array:
    """Ascending coefficients of a piece run backwards: p(width - x)."""
    whole = np.poly1d(row[::-1])(np.poly1d([-1.0, width]))
    coefficients = np.atleast_1d(whole.coeffs)[::-1]
    return np.pad(coefficients, (0, len(row) - len(coefficients)))


def _value(powers: Powers, x: float) -> float:
    total = 0.0
    for factor in reversed(powers):
        total = total * x + factor
    return total
