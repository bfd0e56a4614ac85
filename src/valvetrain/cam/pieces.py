"""Periodic piecewise polynomials: the flat form of every lift law, which compiled kernels evaluate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.cam.contract import TURN, after, check_derivative
from valvetrain.errors import InputError


@dataclass(frozen=True, eq=False)
class PeriodicPieces:
    """Polynomials in the angle since each break.

    ``breaks`` (pieces + 1,) in cam rad, rising, over exactly one revolution; ``coefficients``
    (pieces, order), ascending powers, m per rad**power. Itself a lift law; ``continuity`` is what
    its maker guarantees.
    """

    breaks: Array
    coefficients: Array
    continuity: int = 2

    def __post_init__(self) -> None:
        breaks, coefficients = (
            np.ascontiguousarray(self.breaks, dtype=float),
            np.ascontiguousarray(self.coefficients, dtype=float),
        )
        if (
            coefficients.ndim != 2
            or len(breaks) != len(coefficients) + 1
            or not np.all(np.diff(breaks) > 0)
        ):
            raise InputError(
                "a piecewise law needs rising breaks, one more than it has pieces; correct them"
            )
        if abs(breaks[-1] - breaks[0] - TURN) > 1e-9:
            raise InputError(
                "a piecewise law must cover exactly one cam revolution; add the base circle as a piece"
            )
        for name, array in (("breaks", breaks), ("coefficients", coefficients)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(float(angle) for angle in self.breaks[:-1])

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        check_derivative(derivative)
        angle = self.breaks[0] + after(float(self.breaks[0]), cam_angle)
        piece = np.clip(
            np.searchsorted(self.breaks, angle, side="right") - 1, 0, len(self.coefficients) - 1
        )
        step, chosen = angle - self.breaks[piece], self.coefficients[piece]
        total: Array = np.zeros_like(step)
        for power in range(self.coefficients.shape[1] - 1, derivative - 1, -1):
            factor = float(np.prod(np.arange(power, power - derivative, -1)))
            total = total * step + factor * chosen[..., power]
        return total


class OfPieces:
    """A lift law made of ``_pieces``, whose joints it has."""

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        raise NotImplementedError

    @property
    def joints(self) -> tuple[float, ...]:
        return self._pieces.joints

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return self._pieces.lift(cam_angle, derivative)


def ramp_states(ramp_lift: float, length: float, blend: float) -> tuple[float, float]:
    """Velocity of the ramp (m/rad) and the lift (m) at which it is reached: half the velocity times
    the blend.
    """
    velocity = ramp_lift / (length * (1 - blend / 2))
    return velocity, velocity * blend * length / 2


def quintic_pieces(breaks: Array, start: Array, end: Array) -> Array:
    """Ascending coefficients (pieces, 6) of the quintics with lift, first and second derivative
    ``start`` and ``end``, each (pieces, 3).
    """
    width = np.diff(breaks)[:, None] ** np.arange(3)
    (p0, v0, a0), (p1, v1, a1) = (start * width).T, (end * width).T
    rise = p1 - p0
    unit = np.stack(
        [
            p0,
            v0,
            a0 / 2,
            10 * rise - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
            -15 * rise + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
            6 * rise - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1,
        ],
        axis=1,
    )
    scaled: Array = unit / np.diff(breaks)[:, None] ** np.arange(6)
    return scaled


def pieces_of_spline(spline: Any, continuity: int) -> PeriodicPieces:
    """A spline of scipy over an event as polynomials, completed by the base circle."""
    from scipy.interpolate import PPoly

    whole = PPoly.from_spline(spline)
    real = np.diff(whole.x) > 0
    breaks = np.append(whole.x[:-1][real], whole.x[-1])
    return with_base_circle(breaks, whole.c[::-1, real].T.copy(), continuity)


def with_base_circle(breaks: Array, coefficients: Array, continuity: int) -> PeriodicPieces:
    """An event given over part of the revolution, completed by a piece of exactly zero lift."""
    rest = breaks[0] + TURN - breaks[-1]
    if rest < 1e-9:
        return PeriodicPieces(np.append(breaks[:-1], breaks[0] + TURN), coefficients, continuity)
    return PeriodicPieces(
        np.append(breaks, breaks[0] + TURN),
        np.vstack([coefficients, np.zeros(coefficients.shape[1])]),
        continuity,
    )


def solve(
    error: Callable[[float], float], bounds: tuple[float, float], within: float = 0.0
) -> float | None:
    """Where ``error`` crosses zero between ``bounds``, by regula falsi (Illinois) until a step is
    no more than ``within`` (0: to rounding); None where it has one sign at both.
    """
    (before, now), (at_before, at_now) = bounds, (error(bounds[0]), error(bounds[1]))
    if at_before * at_now > 0:
        return None
    for _ in range(200):
        if (
            at_now == 0
            or at_before == at_now
            or abs(now - before) < 1e-15 * (abs(now) + abs(before))
        ):
            break
        found = (before * at_now - now * at_before) / (at_now - at_before)
        at_found = error(found)
        if at_found * at_now < 0:
            before, at_before = now, at_now
        else:
            at_before /= 2
        close = abs(found - now) <= within
        now, at_now = found, at_found
        if close:
            break
    return now
