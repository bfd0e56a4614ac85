"""The frame shared by laws of the kind dwell, rise, dwell, return: a normalised flank stretched
over opening and closing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.cam.contract import TURN, after, check_derivative
from valvetrain.cam.pieces import PeriodicPieces, quintic_pieces, with_base_circle
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength

#: ``shape(x, derivative)``: rise from 0 to 1 for x in [0, 1], with zero velocity at both ends.
Shape = Callable[[Array, int], Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlankEvents:
    """Top lift (m) and the four events (cam rad, in rising order): base of the flank laws, of no
    use alone.
    """

    joint_continuity: ClassVar[int] = 2
    #: Joints inside each flank, as shares of it.
    inside: ClassVar[tuple[float, ...]] = ()

    maximum_lift: float
    opening_start: float
    opening_end: float
    closing_start: float
    closing_end: float

    def __post_init__(self) -> None:
        ordered = self.opening_start < self.opening_end <= self.closing_start < self.closing_end
        if not ordered or self.closing_end - self.opening_start > TURN * (1 + 1e-12):
            names = "opening_start, opening_end, closing_start and closing_end"
            raise InputError(
                f"{names} must follow each other within one cam revolution; reorder them"
            )

    @property
    def continuity(self) -> int:
        return self.joint_continuity

    @property
    def joints(self) -> tuple[float, ...]:
        flanks = (self.opening_start, self.opening_end), (self.closing_start, self.closing_end)
        inner = [start + (end - start) * share for start, end in flanks for share in self.inside]
        return tuple(sorted((*flanks[0], *flanks[1], *inner)))


class FlankModel(LiftModel):
    """Dwell, rise, dwell, return: cycloidal, modified sine, harmonic."""

    maximum_lift: PositiveLength
    opening_start: Angle
    opening_end: Angle
    closing_start: Angle
    closing_end: Angle


def flanked(law: FlankEvents, shape: Shape, cam_angle: ArrayLike, derivative: int) -> Array:
    """Lift of ``law`` whose two flanks have the normalised ``shape`` (the closing one mirrored)."""
    check_derivative(derivative)
    since = after(law.opening_start, cam_angle)
    rise, fall = law.opening_end - law.opening_start, law.closing_end - law.closing_start
    top, base = law.closing_start - law.opening_start, law.closing_end - law.opening_start
    opening, closing = since / rise, (base - since) / fall
    rising = shape(np.clip(opening, 0.0, 1.0), derivative) / rise**derivative
    falling = shape(np.clip(closing, 0.0, 1.0), derivative) / (-fall) ** derivative
    dwell = 1.0 if derivative == 0 else 0.0
    parts = [since < rise, since < top, since < base]
    return law.maximum_lift * np.select(parts, [rising, np.full_like(since, dwell), falling], 0.0)


def polynomial_value(
    powers: tuple[int, ...], factors: tuple[float, ...], x: Array, derivative: int
) -> Array:
    """Sum of ``factor * x**power``, differentiated ``derivative`` times."""
    total = np.zeros_like(x)
    for power, factor in zip(powers, factors, strict=True):
        for step in range(derivative):
            factor *= power - step
        if factor:
            total = total + factor * x ** (power - derivative)
    return total


def rise_factors(powers: tuple[int, ...]) -> tuple[float, ...]:
    """Factors of the polynomial with these ``powers`` that is 1 at x = 1 with as many vanishing
    derivatives as there are powers, less one.

    Closed form: the product over the other powers q of q / (q - p); 3-4-5 gives 10, -15, 6.
    """
    return tuple(float(np.prod([q / (q - p) for q in powers if q != p])) for p in powers)


Powers = tuple[float, ...]


def _twice(*pulse: float) -> tuple[Powers, float, float]:
    """The second integral of a pulse by ascending powers, and what the first and the second come to
    at 1.
    """
    second = tuple(map(float, polynomial.polyint(pulse, 2)))
    return second, float(polynomial.polyint(pulse).sum()), sum(second)


#: Share of a flank with positive acceleration: minimum, default and maximum.
SHARES, DEFAULT_SHARE = (0.08, 0.6), 0.27
#: 16 u^2 (1 - u)^2: largest value 1, no slope at either end.
RISEN, GAINED_AT_1, RISEN_AT_1 = _twice(0, 0, 16, -32, 16)
#: Negative pulse from its start (0) to the nose (1) at fullness 0, 1 (nearly even) and -1 (gathered
#: at the nose).
MIDDLE, EVEN, GATHERED = (
    _twice(0, 0, 3, -2, 0, 0),
    _twice(0, 0, 10, -20, 15, -4),
    _twice(0, 0, 0, 0, 5, -4),
)


@dataclass(frozen=True)
class HalfLobe:
    """One flank: ``length`` (rad) from the end of the ramp to the nose, ``start`` lift (m) and
    velocity (m/rad) it takes over.

    ``share`` of the length with positive acceleration, ``fullness`` (-1 to 1) of the nose,
    ``maximum_lift`` (m).
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
        return (
            mixed,
            (1 - part) * MIDDLE[1] + part * other[1],
            (1 - part) * MIDDLE[2] + part * other[2],
        )

    @cached_property
    def sizes(self) -> tuple[float, float, float]:
        """Largest acceleration and deceleration (m/rad2, both positive) and velocity (m/rad), from
        rest at ``maximum_lift``.
        """
        (lift, velocity), (_, lost, fallen) = self.start, self._negative
        first, second = self.share * self.length, (1 - self.share) * self.length
        left = second * (1 - fallen / lost)
        up = (self.maximum_lift - lift - velocity * (first + left)) / (
            first**2 * RISEN_AT_1 + first * GAINED_AT_1 * left
        )
        fastest = velocity + up * first * GAINED_AT_1
        return up, fastest / (second * lost), fastest

    @property
    def pieces(self) -> tuple[Array, Array]:
        """Ascending coefficients (2, 8) of the lift over the angle (rad) since the beginning of
        either pulse, and their lengths (2,).
        """
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
        since, (lift, velocity), (up, down, fastest) = (
            self.length - cam_angle,
            self.start,
            self.sizes,
        )
        first, second = self.share * self.length, (1 - self.share) * self.length
        if since < 0:
            return lift + velocity * since
        if since < first:
            return lift + velocity * since + up * first**2 * _value(RISEN, since / first)
        since -= first
        lift += velocity * first + up * first**2 * RISEN_AT_1
        return lift + fastest * since - down * second**2 * _value(self._negative[0], since / second)

    def after_ramp(self, ramp_length: float, blend: float) -> tuple[Array, Array]:
        """Ascending coefficients (pieces, 8) and lengths (pieces,) of a ramp that ends at
        ``start``, and of the flank.

        The ramp is ``ramp_length`` (rad) long; its velocity is built up over the share ``blend`` of
        it.
        """
        (lift, velocity), (flank, lengths) = self.start, self.pieces
        ends = np.array([0.0, blend * ramp_length, ramp_length])
        states = np.array(
            [[0.0, 0.0, 0.0], [velocity * ends[1] / 2, velocity, 0.0], [lift, velocity, 0.0]]
        )
        if blend == 1:
            ends, states = ends[[0, 2]], states[[0, 2]]
        ramp = np.zeros((len(ends) - 1, flank.shape[1]))
        ramp[:, :6] = quintic_pieces(ends, states[:-1], states[1:])
        return np.vstack([ramp, flank]), np.concatenate([np.diff(ends), lengths])


def joined(
    nose: float, opening: tuple[Array, Array], closing: tuple[Array, Array]
) -> PeriodicPieces:
    """A lobe about ``nose`` (cam rad) of two flanks by :meth:`HalfLobe.after_ramp`, the second run
    backwards.
    """
    (rows, widths), (others, backwards) = opening, closing
    turned = np.array(
        [_mirrored(row, width) for row, width in zip(others, backwards, strict=True)]
    )[::-1]
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
