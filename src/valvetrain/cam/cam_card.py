"""A symmetric lobe from the values of a cam card: lift, durations at checking lifts, ramps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

from numpy.typing import ArrayLike

from valvetrain.cam.cam_card_table import ADVERTISED_LIFT, DURATION_LIFT, RAMP_VELOCITY, UPPER_LIFT, CamCardModel
from valvetrain.cam.contract import Array, LiftSpec
from valvetrain.cam.flank_pulse import SHARES, USUAL_SHARE, HalfLobe, joined
from valvetrain.cam.pieces import PeriodicPieces
from valvetrain.cam.roots import solve
from valvetrain.errors import InputError

#: Fullness of the nose: see :class:`HalfLobe`.
FULLNESS, USUAL_FULLNESS = (-1.0, 1.0), 0.0
#: Least and largest velocity of a ramp (m/rad): 0.0001 and 0.003 in per cam degree.
VELOCITIES = (RAMP_VELOCITY / 5, RAMP_VELOCITY * 6)
#: Shortest and longest flank (cam rad).
LENGTHS = (math.radians(1.0), math.radians(175.0))


@dataclass(frozen=True, kw_only=True)
class CamCard:
    """Lobe about ``nose`` (cam rad) that stands ``duration`` (cam rad) above ``duration_lift`` (m), 0.050 in on most cards.

    ``maximum_lift`` (m): of the lobe. ``advertised_duration`` above ``advertised_lift`` and ``upper_duration`` above ``upper_lift``: met
    where given, by the share of the flank with positive acceleration (by the velocity of the ramp, where they stand on it) and by the
    fullness of the nose. Ramps of ``ramp_velocity`` (m/rad; None: the usual one, or that of the advertised duration) end at
    ``ramp_lift`` (m); over their share ``ramp_blend`` it is built up. Raises :class:`InputError` with what is possible where the values
    contradict each other.
    """

    continuity: ClassVar[int] = 2

    maximum_lift: float
    nose: float
    duration: float
    duration_lift: float = DURATION_LIFT
    advertised_duration: float | None = None
    advertised_lift: float = ADVERTISED_LIFT
    upper_duration: float | None = None
    upper_lift: float = UPPER_LIFT
    ramp_lift: float = 1e-4
    ramp_velocity: float | None = None
    ramp_blend: float = 0.3

    def __post_init__(self) -> None:
        points = self.checking_points
        for (name, low, long), (other, high, short) in pairwise(points):
            if not (low < high and long > short):
                raise InputError(
                    f"{name} ({_deg(long)} at {_mm(low)}) must be longer and at a lower lift than {other} ({_deg(short)} at {_mm(high)}); "
                    "check both on the card"
                )
        if not (0 < points[0][1] and points[-1][1] < self.maximum_lift and 0 < points[-1][2] and points[0][2] < 2 * math.pi):
            raise InputError(
                f"the lifts at which durations are given ({_mm(points[0][1])} to {_mm(points[-1][1])}) must lie below the lobe lift "
                f"({_mm(self.maximum_lift)}), and the durations within a cam turn; check them and angle_of"
            )
        if not (0 < self.ramp_lift < self.maximum_lift and self.ramp_velocity != 0 and 0 < self.ramp_blend <= 1):
            raise InputError("ramp_lift must lie between zero and the lobe lift, and ramp_velocity be positive; correct them")
        straight = self.ramp_lift * self.ramp_blend / (2 - self.ramp_blend)
        if points[0][1] < straight:
            raise InputError(
                f"{points[0][0]} is told at {_mm(points[0][1])}, where the ramp still gathers velocity (to {_mm(straight)}); lower "
                "ramp_blend or ramp_lift"
            )
        if self.half_lobe.length + self.ramp_length > math.pi:
            raise InputError("flanks and ramps together are longer than a cam turn; raise ramp_velocity or lower ramp_lift")
        if not self.half_lobe.sizes[0] > 0:
            raise InputError("the ramps alone would lift more than the lobe; lower ramp_velocity")

    @property
    def checking_points(self) -> list[tuple[str, float, float]]:
        """Name, lift (m) and duration (cam rad) of every duration told, lowest lift first."""
        told = [
            ("advertised_duration", self.advertised_lift, self.advertised_duration), ("duration", self.duration_lift, self.duration),
            ("upper_duration", self.upper_lift, self.upper_duration),
        ]  # fmt: skip
        return [(name, lift, length) for name, lift, length in told if length is not None]

    @property
    def ramp_length(self) -> float:
        """Cam angle (rad) of one ramp: velocity times (length less half the blend) is its lift."""
        return self.ramp_lift / (self.half_lobe.start[1] * (1 - self.ramp_blend / 2))

    @cached_property
    def half_lobe(self) -> HalfLobe:
        """The flank that meets every duration told: one unknown for each, found inside each other, all monotone."""
        first = HalfLobe(self.maximum_lift, (self.ramp_lift, self.ramp_velocity or RAMP_VELOCITY), 1.0, USUAL_SHARE, USUAL_FULLNESS)
        return self._by_fullness(first)

    def _by_fullness(self, half: HalfLobe) -> HalfLobe:
        if self.upper_duration is None:
            return self._by_share(half)
        made = lambda value: self._by_share(replace(half, fullness=value))  # noqa: E731
        return self._met("upper_duration", self.upper_lift, self.upper_duration, made, FULLNESS)

    def _by_share(self, half: HalfLobe) -> HalfLobe:
        if self.advertised_duration is None:
            return self._by_length(half)
        on_ramp = self.ramp_velocity is None and self.advertised_lift <= self.ramp_lift

        def made(value: float) -> HalfLobe:
            return self._by_length(replace(half, start=(self.ramp_lift, value)) if on_ramp else replace(half, share=value))

        bounds = VELOCITIES if on_ramp else SHARES
        return self._met("advertised_duration", self.advertised_lift, self.advertised_duration, made, bounds)

    def _by_length(self, half: HalfLobe) -> HalfLobe:
        made = lambda value: replace(half, length=value)  # noqa: E731
        return self._met("duration", self.duration_lift, self.duration, made, LENGTHS)

    def _met(
        self, name: str, lift: float, duration: float, made: Callable[[float], HalfLobe], bounds: tuple[float, float]
    ) -> HalfLobe:  # fmt: skip
        """The flank of the one value between ``bounds`` that passes ``lift`` half a ``duration`` before the nose."""
        value = solve(lambda value: made(value).before_nose(duration / 2) - lift, bounds)
        if value is not None:
            return made(value)
        possible = sorted(2 * angle_before_nose(made(bound), lift) for bound in bounds)
        raise InputError(
            f"{name} {_deg(duration)} at {_mm(lift)} does not go with the other values of the cam card: they leave {_deg(possible[0])} to "
            f"{_deg(possible[1])}; check lifts, durations, ramps and whether angle_of is crank or cam"
        )

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        flank = self.half_lobe.after_ramp(self.ramp_length, self.ramp_blend)
        return joined(self.nose, flank, flank)

    @property
    def joints(self) -> tuple[float, ...]:
        return self._pieces.joints

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return self._pieces.lift(cam_angle, derivative)

    def polynomial_pieces(self) -> PeriodicPieces:
        """The exact flat form."""
        return self._pieces


def angle_before_nose(half: HalfLobe, passed_lift: float) -> float:
    """Angle (rad) before the nose at which a flank or its ramp passes ``passed_lift`` (m)."""
    if passed_lift <= half.start[0]:
        return half.length + (half.start[0] - passed_lift) / half.start[1]
    return solve(lambda angle: half.before_nose(angle) - passed_lift, (0.0, half.length)) or 0.0


def _deg(angle: float) -> str:
    return f"{2 * math.degrees(angle):.4g} crank deg"


def _mm(lift: float) -> str:
    return f"{lift * 1e3:.4g} mm"


SPEC = LiftSpec(CamCard, CamCardModel)
