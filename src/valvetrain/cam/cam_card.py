"""A symmetric lobe from the values of a cam card: lift, durations at checking lifts, ramps."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from valvetrain.cam.contract import LiftSpec
from valvetrain.cam.flanks import DEFAULT_SHARE, SHARES, HalfLobe, joined
from valvetrain.cam.pieces import OfPieces, PeriodicPieces, solve
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.measured.cam_events import KEYS, CamEvents
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.schema_types import (
    Angle,
    Lash,
    Line,
    PositiveLength,
    guarded,
    problem,
    quantity,
)

#: Lifts (m) of the lobe at which cards give durations unless they state them: 0.050, 0.006 and 0.200
#: in.
DURATION_LIFT, ADVERTISED_LIFT, UPPER_LIFT = (
    round(inches * 25.4e-3, 9) for inches in (0.050, 0.006, 0.200)
)
#: A ramp without a lift of its own ends this far (m) above the lash, and at most this share of the
#: way from the lash to the lift of the advertised duration: the lobe has to gain speed before it.
RAMP_ABOVE_LASH, RAMP_SHARE = 1e-4, 2 / 3
#: 0.0005 in per cam degree.
RAMP_VELOCITY = 0.0005 * 25.4e-3 / math.radians(1.0)
#: Half of the last digit (m) that a card prints: 0.0005 in.
ROUNDED_LIFT = 0.0005 * 25.4e-3

#: Crank angle (rad) beyond which no engine holds a valve open by half a millimetre of lobe lift.
MAX_DURATION = math.radians(360.0)

RockerRatio = Annotated[float, quantity("ratio", low=0.2, high=5.0)]
PositiveAngle = Annotated[float, quantity("angle", low=0.0, open_low=True)]
CamVelocity = Annotated[float, quantity("cam velocity", low=0.0, open_low=True)]
Blend = Annotated[float, quantity("ratio", low=0.01, high=1.0)]


class CamCardModel(LiftModel):
    """A symmetric lobe by the values of its cam card; every specified duration is met."""

    lift_of: Literal["valve", "tappet"] = Field(
        default="tappet", description="lift measured at: a cam card gives the lift of the lobe"
    )
    angle_of: Literal["crank", "cam"]
    lobe_lift: PositiveLength | None = Field(
        default=None, description="without it valve_lift over rocker_ratio"
    )
    valve_lift: PositiveLength | None = Field(
        default=None,
        description="gross, at zero lash: the valve lifts less by the lash; without it from lobe_lift; with lift_of = 'valve' enough alone",
    )
    rocker_ratio: RockerRatio | None = Field(
        default=None,
        description="also sets the rocker's arm ratio where [train.lever] gives none; 1 for a bucket tappet",
    )
    lash: Lash | None = Field(
        default=None, description="at the valve; also sets the lash of [train] where it gives none"
    )
    duration: PositiveAngle | None = Field(
        default=None, description="in angle_of; or where the valve opens and closes"
    )
    intake_opens: Line | None = Field(
        default=None, description="crank angle at duration_lift, such as '5 deg before top'"
    )
    intake_closes: Line | None = Field(default=None, description="such as '32.5 deg after bottom'")
    exhaust_opens: Line | None = Field(default=None, description="such as '40 deg before bottom'")
    exhaust_closes: Line | None = Field(default=None, description="such as '10 deg after top'")
    duration_lift: PositiveLength = Field(
        default=DURATION_LIFT, description="lobe lift at which duration is given"
    )
    advertised_duration: PositiveAngle | None = Field(
        default=None, description="without it the flank has its default shape"
    )
    advertised_lift: PositiveLength = Field(
        default=ADVERTISED_LIFT, description="lobe lift at which advertised_duration is given"
    )
    upper_duration: PositiveAngle | None = Field(
        default=None, description="without it the nose has its default shape"
    )
    upper_lift: PositiveLength = Field(
        default=UPPER_LIFT, description="lobe lift at which upper_duration is given"
    )
    valve: Literal["intake", "exhaust"] = Field(
        default="intake", description="which valve: lobe_centre after or before top dead centre"
    )
    lobe_centre: PositiveAngle | None = Field(
        default=None, description="of the nose from top dead centre; without it nose at 180 deg"
    )
    top_dead_centre: Angle = Field(
        default=math.pi, description="cam angle of top dead centre of gas exchange"
    )
    ramp_lift: PositiveLength | None = Field(
        default=None,
        description="of the lobe where ramps end; without it 0.1 mm above lash over ratio, less where advertised_lift is near",
    )
    ramp_velocity: CamVelocity | None = Field(
        default=None,
        description="per cam angle; without it 0.0005 in/deg, or that of an advertised_duration given on the ramp",
    )
    ramp_blend: Blend = Field(
        default=0.3, description="share of the ramp over which its velocity is built up"
    )

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class, in cam rad; refuses a lift given twice that
        disagrees, or none.
        """
        turn, events = 0.5 if self.angle_of == "crank" else 1.0, self.events()
        duration = (self.duration or 0.0) * turn if events is None else events.duration / 2
        if 2 * duration > MAX_DURATION and self.duration_lift >= 5e-4:
            warnings.warn(
                f"a duration of {math.degrees(2 * duration):.4g} crank deg at {_mm(self.duration_lift)} is longer than that of any "
                "engine; are these crank degrees (angle_of)?",
                UnusualValueWarning,
                stacklevel=2,
            )
        away = None if self.lobe_centre is None else self.lobe_centre * turn
        valve, away = (self.valve, away) if events is None else (events.valve, events.centre / 2)
        away = -away if away is not None and valve == "exhaust" else away
        own: dict[str, Any] = {
            "maximum_lift": self._law_lift(), "nose": math.pi if away is None else self.top_dead_centre + away,
            "duration": duration, "duration_lift": self.duration_lift,
            "ramp_lift": self._ramp_lift(), "ramp_velocity": self.ramp_velocity, "ramp_blend": self.ramp_blend,
        }  # fmt: skip
        for name in ("advertised", "upper"):
            if (given_durations := getattr(self, f"{name}_duration")) is not None:
                own |= {
                    f"{name}_duration": given_durations * turn,
                    f"{name}_lift": getattr(self, f"{name}_lift"),
                }
        return own

    @property
    def dead_centre(self) -> float | None:
        """Cam angle (rad) of top dead centre of gas exchange; None of a card without a place of its lobe."""
        timed = self.lobe_centre is not None or self.events() is not None
        return self.top_dead_centre if timed else None

    def events(self) -> CamEvents | None:
        """Where the valve opens and closes by the card; None of a card with a duration."""
        texts = {event: text for key, event in KEYS.items() if (text := getattr(self, key))}
        if (self.duration is None) == (not texts) or (texts and self.lobe_centre is not None):
            raise problem(
                "a cam card needs either duration, with or without lobe_centre, or where its valve opens and closes, such as intake_opens = "
                "'5 deg before top' and intake_closes = '40 deg after bottom'; give one of both"
            )
        named = {"intake" if event[0] == "I" else "exhaust" for event in texts}
        valve = self.valve if self.valve in named or not named else named.pop()
        return guarded(CamEvents.of, texts, valve) if texts else None

    def _law_lift(self) -> float:
        """Lift (m) where the law gives it: of the lobe, or of the valve."""
        lobe, valve, ratio = self.lobe_lift, self.valve_lift, self.rocker_ratio
        if (
            lobe is not None
            and valve is not None
            and ratio is not None
            and abs(lobe * ratio / valve - 1) > 0.01
        ):
            raise problem(
                f"lobe_lift times rocker_ratio is {lobe * ratio * 1e3:.4g} mm, but valve_lift {valve * 1e3:.4g} mm; correct one",
                ("valve_lift",),
            )
        if self.lift_of == "valve":
            lift = valve if valve is not None else lobe
        else:
            lift = lobe if lobe is not None else valve and ratio and valve / ratio
        if lift is None:
            raise problem(
                "a cam card needs lobe_lift, or valve_lift and rocker_ratio; add it (of a finger or rocker: valve_lift with lift_of = 'valve')"
            )
        return lift

    def _ramp_lift(self) -> float:
        if self.ramp_lift is not None:
            return self.ramp_lift
        if self.lash and self.rocker_ratio is None and self.lift_of == "tappet":
            raise problem(
                "the ramp over the lash needs rocker_ratio: lash is given at the valve; add it, 1 where the cam moves the valve itself, "
                "or give ramp_lift",
                ("lash",),
            )
        ratio = self.rocker_ratio if self.lift_of == "tappet" and self.rocker_ratio else 1.0
        lash = (self.lash or 0.0) / ratio
        above = RAMP_ABOVE_LASH
        # a card rounds: an advertised lift at the lash ends the ramp there
        if self.advertised_duration is not None and self.advertised_lift > lash - ROUNDED_LIFT:
            above = min(above, RAMP_SHARE * max(0.0, self.advertised_lift - lash))
        return lash + above


#: Fullness of the nose: see :class:`HalfLobe`.
FULLNESS, DEFAULT_FULLNESS = (-1.0, 1.0), 0.0
#: Least and largest velocity of a ramp (m/rad): 0.0001 and 0.001 in per cam degree.
VELOCITIES = (RAMP_VELOCITY / 5, RAMP_VELOCITY * 2)
#: Of ramps that are doubted, where the flank cannot do the rest either: to 0.003 in per cam degree.
STEEP = (VELOCITIES[1], RAMP_VELOCITY * 6)
#: Shortest and longest flank (cam rad).
LENGTHS = (math.radians(1.0), math.radians(175.0))


@dataclass(frozen=True, kw_only=True)
class CamCard(OfPieces):
    """Lobe about ``nose`` (cam rad) that is for ``duration`` (cam rad) above ``duration_lift`` (m),
    0.050 in on most cards.

    ``maximum_lift`` (m): of the lobe. ``advertised_duration`` above ``advertised_lift`` and
    ``upper_duration`` above ``upper_lift``: met where given, by the share of the flank with
    positive acceleration (on the ramp by its velocity first) and by the fullness of the nose.
    Ramps of ``ramp_velocity`` (m/rad; None: the default one, or that of the advertised duration)
    end at ``ramp_lift`` (m); over their share ``ramp_blend`` it is built up. Raises
    :class:`InputError` with what is possible where the values contradict each other.
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
        if not (
            0 < points[0][1]
            and points[-1][1] < self.maximum_lift
            and 0 < points[-1][2]
            and points[0][2] < 2 * math.pi
        ):
            raise InputError(
                f"the lifts at which durations are given ({_mm(points[0][1])} to {_mm(points[-1][1])}) must be below the lobe lift "
                f"({_mm(self.maximum_lift)}), and the durations within a cam revolution; check them and angle_of"
            )
        if not (
            0 < self.ramp_lift < self.maximum_lift
            and self.ramp_velocity != 0
            and 0 < self.ramp_blend <= 1
        ):
            raise InputError(
                "ramp_lift must be between zero and the lobe lift, and ramp_velocity be positive; correct them"
            )
        straight = self.ramp_lift * self.ramp_blend / (2 - self.ramp_blend)
        if points[0][1] < straight:
            raise InputError(
                f"{points[0][0]} is given at {_mm(points[0][1])}, where the ramp still gathers velocity (to {_mm(straight)}); lower "
                "ramp_blend or ramp_lift"
            )
        if self.half_lobe.length + self.ramp_length > math.pi:
            raise InputError(
                "flanks and ramps together are longer than a cam revolution; raise ramp_velocity or lower ramp_lift"
            )
        if not self.half_lobe.sizes[0] > 0:
            raise InputError("the ramps alone would lift more than the lobe; lower ramp_velocity")

    @property
    def _shapes_ramp(self) -> bool:
        """Whether the advertised duration is counted on the ramp and meets its velocity first."""
        return (
            self.advertised_duration is not None
            and self.ramp_velocity is None
            and self.advertised_lift < self.ramp_lift
        )

    @property
    def assumed_ramp(self) -> float | None:
        """Velocity (m/rad) of a ramp that no value of the card decides; None of one that the card does."""
        given = self.ramp_velocity is not None or self._shapes_ramp
        return None if given else RAMP_VELOCITY

    @property
    def checking_points(self) -> list[tuple[str, float, float]]:
        """Name, lift (m) and duration (cam rad) of every specified duration, lowest lift first."""
        given_durations = [
            ("advertised_duration", self.advertised_lift, self.advertised_duration), ("duration", self.duration_lift, self.duration),
            ("upper_duration", self.upper_lift, self.upper_duration),
        ]  # fmt: skip
        return [
            (name, lift, length) for name, lift, length in given_durations if length is not None
        ]

    @property
    def ramp_length(self) -> float:
        """Cam angle (rad) of one ramp: velocity times (length less half the blend) is its lift."""
        return self.ramp_lift / (self.half_lobe.start[1] * (1 - self.ramp_blend / 2))

    @cached_property
    def half_lobe(self) -> HalfLobe:
        """The flank that meets every specified duration: one unknown for each, found inside each other,
        all monotone.
        """
        first = HalfLobe(
            self.maximum_lift,
            (self.ramp_lift, self.ramp_velocity or RAMP_VELOCITY),
            1.0,
            DEFAULT_SHARE,
            DEFAULT_FULLNESS,
        )
        return self._by_fullness(first)

    def _by_fullness(self, half: HalfLobe) -> HalfLobe:
        if self.upper_duration is None:
            return self._by_share(half)
        made = lambda value: self._by_share(replace(half, fullness=value))  # noqa: E731
        return self._met("upper_duration", self.upper_lift, self.upper_duration, made, FULLNESS)

    def _by_share(self, half: HalfLobe) -> HalfLobe:
        if self.advertised_duration is None:
            return self._by_length(half)
        name, lift, duration = "advertised_duration", self.advertised_lift, self.advertised_duration

        def shaped(share: float, start: HalfLobe = half) -> HalfLobe:
            return self._by_length(replace(start, share=share))

        if not self._shapes_ramp:
            return self._met(name, lift, duration, shaped, SHARES)

        def ramped(velocity: float) -> HalfLobe:
            return self._by_length(replace(half, start=(self.ramp_lift, velocity)))

        def above(velocity: float) -> float:
            return ramped(velocity).before_nose(duration / 2) - lift

        if (velocity := solve(above, VELOCITIES)) is not None:
            return ramped(velocity)
        # a ramp of the least or the largest velocity, and the flank for the rest
        ends = [replace(half, start=(self.ramp_lift, bound)) for bound in VELOCITIES]
        start = ends[above(VELOCITIES[1]) > 0]
        if (
            solve(lambda share: shaped(share, start).before_nose(duration / 2) - lift, SHARES)
            is None
            and (velocity := solve(above, STEEP)) is not None
        ):
            warnings.warn(
                f"advertised_duration {_deg(duration)} at {_mm(lift)} makes a ramp {velocity / RAMP_VELOCITY:.2g} times as fast as a typical one "
                f"(0.0005 in/deg), on which the valve strikes its seat; the ramp ends at {_mm(self.ramp_lift)}: lower ramp_lift",
                UnusualValueWarning,
                stacklevel=2,
            )
            return ramped(velocity)
        reach = tuple(shaped(share, end) for share, end in zip(SHARES[::-1], ends, strict=True))
        return self._met(name, lift, duration, lambda share: shaped(share, start), SHARES, reach)

    def _by_length(self, half: HalfLobe) -> HalfLobe:
        made = lambda value: replace(half, length=value)  # noqa: E731
        return self._met("duration", self.duration_lift, self.duration, made, LENGTHS)

    def _met(
        self,
        name: str,
        lift: float,
        duration: float,
        made: Callable[[float], HalfLobe],
        bounds: tuple[float, float],
        reach: tuple[HalfLobe, ...] = (),
    ) -> HalfLobe:
        """The flank of the one value between ``bounds`` that passes ``lift`` half a ``duration``
        before the nose; ``reach``: flanks of the shortest and longest duration, where others.
        """
        value = solve(lambda value: made(value).before_nose(duration / 2) - lift, bounds)
        if value is not None:
            return made(value)
        extremes = reach or tuple(made(bound) for bound in bounds)
        possible = sorted(2 * angle_before_nose(end, lift) for end in extremes)
        whole = possible[1] > math.pi  # more than half a revolution of the cam is no bound
        left = f"{_deg(possible[0])} or more" if whole else f"{_deg(possible[0])} to {_deg(possible[1])}"  # fmt: skip
        default = name == "advertised_duration" and lift == ADVERTISED_LIFT
        where = " (cards of solid tappets often count at 0.015 or 0.020 in: advertised_lift)" if default else ""  # fmt: skip
        if name == "advertised_duration" and lift < self.ramp_lift:
            where = f" (the ramp ends at {_mm(self.ramp_lift)}, above this lift; a lower ramp_lift above the lash leaves more)"
        raise InputError(
            f"{name} {_deg(duration)} at {_mm(lift)} does not go with the other values of the cam card: they leave {left}; check lifts"
            f"{where}, durations, ramps and whether angle_of is crank or cam"
        )

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        flank = self.half_lobe.after_ramp(self.ramp_length, self.ramp_blend)
        return joined(self.nose, flank, flank)


def angle_before_nose(half: HalfLobe, passed_lift: float) -> float:
    """Angle (rad) before the nose at which a flank or its ramp passes ``passed_lift`` (m)."""
    if passed_lift <= half.start[0]:
        return half.length + (half.start[0] - passed_lift) / half.start[1]
    return solve(lambda angle: half.before_nose(angle) - passed_lift, (0.0, half.length)) or 0.0


def _deg(angle: float) -> str:
    return f"{2 * math.degrees(angle):.4g} crank deg"


def _mm(lift: float) -> str:
    return f"{lift * 1e3:.4g} mm ({lift / 0.0254:.3g} in)"


SPEC = LiftSpec(CamCard, CamCardModel)
