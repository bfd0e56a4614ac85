"""The frame shared by laws of the kind dwell, rise, dwell, return: a normalised flank stretched over opening and closing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.cam.contract import TURN, Array, after, check_derivative
from valvetrain.errors import InputError
from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength

#: ``shape(x, derivative)``: rise from 0 to 1 for x in [0, 1], with zero velocity at both ends.
Shape = Callable[[Array, int], Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlankEvents:
    """Top lift (m) and the four events (cam rad, in rising order): base of the flank laws, of no use alone."""

    joint_continuity: ClassVar[int] = 2

    maximum_lift: float
    opening_start: float
    opening_end: float
    closing_start: float
    closing_end: float

    def __post_init__(self) -> None:
        ordered = self.opening_start < self.opening_end <= self.closing_start < self.closing_end
        if not ordered or self.closing_end - self.opening_start > TURN * (1 + 1e-12):
            names = "opening_start, opening_end, closing_start and closing_end"
            raise InputError(f"{names} must follow each other within one cam revolution; reorder them")

    @property
    def continuity(self) -> int:
        return self.joint_continuity

    @property
    def joints(self) -> tuple[float, ...]:
        return (self.opening_start, self.opening_end, self.closing_start, self.closing_end)


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


def polynomial_value(powers: tuple[int, ...], factors: tuple[float, ...], x: Array, derivative: int) -> Array:
    """Sum of ``factor * x**power``, differentiated ``derivative`` times."""
    total = np.zeros_like(x)
    for power, factor in zip(powers, factors, strict=True):
        for step in range(derivative):
            factor *= power - step
        if factor:
            total = total + factor * x ** (power - derivative)
    return total


def rise_factors(powers: tuple[int, ...]) -> tuple[float, ...]:
    """Factors of the polynomial with these ``powers`` that is 1 at x = 1 with as many vanishing derivatives as there are powers, less one.

    Closed form: the product over the other powers q of q / (q - p); 3-4-5 gives 10, -15, 6.
    """
    return tuple(float(np.prod([q / (q - p) for q in powers if q != p])) for p in powers)
