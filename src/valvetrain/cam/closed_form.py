"""Simple harmonic flanks: the acceleration jumps where they meet a dwell."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.cam.contract import HIGHEST_DERIVATIVE, TURN, LiftSpec, after, check_derivative
from valvetrain.cam.flanks import FlankEvents, FlankModel, flanked, polynomial_value, rise_factors
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import Exponents, LiftModel
from valvetrain.parameters.schema_types import Angle, PositiveLength, problem


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic(FlankEvents):
    """``s = (1 - cos(pi x)) / 2``: peak velocity pi / 2, acceleration pi^2 / 2. Only the velocity
    is continuous at a dwell.
    """

    joint_continuity: ClassVar[int] = 1

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return flanked(self, _shape, cam_angle, derivative)


def _shape(x: Array, derivative: int) -> Array:
    if derivative == 0:
        return (1 - np.cos(np.pi * x)) / 2
    if derivative == 1:
        return np.pi / 2 * np.sin(np.pi * x)
    return (
        np.pi**2 / 2 * np.cos(np.pi * x) if derivative == 2 else -(np.pi**3) / 2 * np.sin(np.pi * x)
    )


HARMONIC_SPEC = LiftSpec(Harmonic, FlankModel)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycloidal(FlankEvents):
    """``s = x - sin(2 pi x) / (2 pi)``: peak velocity 2, acceleration 2 pi, jerk 4 pi^2 (per unit
    rise and flank).
    """

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return flanked(self, _shape_cycloidal, cam_angle, derivative)


def _shape_cycloidal(x: Array, derivative: int) -> Array:
    if derivative == 0:
        return x - np.sin(TURN * x) / TURN
    if derivative == 1:
        return 1 - np.cos(TURN * x)
    return TURN * np.sin(TURN * x) if derivative == 2 else TURN**2 * np.cos(TURN * x)


CYCLOIDAL_SPEC = LiftSpec(Cycloidal, FlankModel)


@dataclass(frozen=True, slots=True, kw_only=True)
class ModifiedSine(FlankEvents):
    """Modified sine: peak velocity 1.7596, acceleration 5.5280, jerk 69.47 (per unit rise and
    flank).
    """

    inside: ClassVar[tuple[float, ...]] = (0.125, 0.875)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return flanked(self, _shape_modified_sine, cam_angle, derivative)


def _shape_modified_sine(x: Array, derivative: int) -> Array:
    quick, slow, phase = 4 * np.pi, 4 * np.pi / 3, np.pi / 3
    # sin(a x + b) differentiated n times is a^n sin(a x + b + n pi / 2).
    turn = derivative * np.pi / 2
    ends = quick**derivative * np.sin(quick * x + turn) / 4
    middle = slow**derivative * np.sin(slow * x + phase + turn) * 9 / 4
    line = np.pi * x if derivative == 0 else np.full_like(x, np.pi if derivative == 1 else 0.0)
    steps = (0.0, 2.0, 4.0) if derivative == 0 else (0.0, 0.0, 0.0)
    return np.select(
        [x < 0.125, x < 0.875],
        [steps[0] + line - ends, steps[1] + line - middle],
        steps[2] + line - ends,
    ) / (4 + np.pi)


MODIFIED_SINE_SPEC = LiftSpec(ModifiedSine, FlankModel)


@dataclass(frozen=True, slots=True, kw_only=True)
class SinePower:
    """``maximum_lift * sin(pi (angle - opening_start) / duration) ** power`` between
    ``opening_start`` and ``closing_end`` (cam rad).
    """

    maximum_lift: float
    opening_start: float
    closing_end: float
    power: int = 4

    def __post_init__(self) -> None:
        if not 0 < self.closing_end - self.opening_start <= TURN * (1 + 1e-12) or self.power < 2:
            raise InputError(
                "closing_end must follow opening_start within one cam revolution and power be 2 or more; correct them"
            )

    @property
    def continuity(self) -> int:
        return self.power - 1

    @property
    def joints(self) -> tuple[float, ...]:
        return (self.opening_start, self.closing_end)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        since, n = after(self.opening_start, cam_angle), self.power
        rate = np.pi / (self.closing_end - self.opening_start)
        inside = since < self.closing_end - self.opening_start
        angle = np.where(inside, rate * since, 0.0)
        sine, cosine = np.sin(angle), np.cos(angle)
        if derivative == 0:
            value = sine**n
        elif derivative == 1:
            value = n * sine ** (n - 1) * cosine
        elif derivative == 2:
            value = n * (n - 1) * sine ** (n - 2) * cosine**2 - n * sine**n
        else:
            steep = n * (n - 1) * (n - 2) * sine ** (n - 3) * cosine**2 if n > 2 else 0.0
            value = cosine * (steep - n * (3 * n - 2) * sine ** (n - 1))
        return np.where(inside, self.maximum_lift * rate**derivative * value, 0.0)


class SinePowerModel(LiftModel):
    """``maximum_lift * sin(pi (angle - opening_start) / duration) ** power``."""

    maximum_lift: PositiveLength
    opening_start: Angle
    closing_end: Angle
    power: int = Field(default=4, description="of the half sine")

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses a power out of range."""
        if not 2 <= self.power <= 40:
            raise problem("power must be a whole number from 2 to 40", ("power",))
        return super().values(folder)


SINE_POWER_SPEC = LiftSpec(SinePower, SinePowerModel)


@dataclass(frozen=True, slots=True, kw_only=True)
class Polynomial(FlankEvents):
    """Dwell, rise, dwell, return with a polynomial flank of the given ``exponents``.

    As many derivatives vanish at the top as there are exponents less one, and at the foot as many
    as the lowest exponent less one.
    """

    exponents: tuple[int, ...] = (3, 4, 5)

    @property
    def continuity(self) -> int:
        return min(min(self.exponents), len(self.exponents)) - 1

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        factors = rise_factors(self.exponents)
        return flanked(
            self,
            lambda x, order: polynomial_value(self.exponents, factors, x, order),
            cam_angle,
            derivative,
        )


class PolynomialModel(FlankModel):
    """The same with a polynomial flank such as 3-4-5."""

    exponents: Exponents = Field(default=(3, 4, 5), description="powers of the flank")


POLYNOMIAL_SPEC = LiftSpec(Polynomial, PolynomialModel)


@dataclass(frozen=True, slots=True)
class Zero:
    """Zero lift at every angle."""

    @property
    def continuity(self) -> int:
        return HIGHEST_DERIVATIVE

    @property
    def joints(self) -> tuple[float, ...]:
        return ()

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        return np.zeros_like(np.asarray(cam_angle, dtype=float))


class ZeroModel(LiftModel):
    """No lift at all."""


ZERO_SPEC = LiftSpec(Zero, ZeroModel)
