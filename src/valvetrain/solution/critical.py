"""Critical engine speeds, at which a train loses control of its valve: value, range over model, damping,
step and mesh, and kind of onset.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from valvetrain.solution.display import Saveable

if TYPE_CHECKING:
    import pandas

#: Kind -> quantity of its engine speed, in the order of tables.
KINDS = {
    "contact-loss": "contact_loss_engine_speed",
    "float": "float_engine_speed",
    "bounce": "bounce_engine_speed",
}
RPM = math.pi / 30
#: Lift above the rigid lift from which a valve floats, and height from which a bounce counts (m):
#: of critical speeds unless others are requested, and of every verdict.
FLOAT_LIFT, BOUNCE_HEIGHT = 50e-6, 100e-6
#: Travel to coil bind at full lift (m) below which it is close.
NEAR_BIND = 1e-3
#: Factors on the damping of the springs at which critical speeds are repeated.
DAMPING_FACTORS = (0.6, 1.5)
#: Further ranges of lost control that are named one by one.
MAX_AGAIN = 3
#: Width of a range of lost control, over its speed, up to which it is a short one: an engine passes it at once.
NARROW = 0.02
#: Short ranges below the loss that stays; where control comes and goes more often it ends at the first.
MAX_SHORT = 2
#: Kind of onset -> what the text says of it; nothing of a sharp one.
ONSETS = {"graze": "just touching zero", "non-repeating": "motion does not repeat"}
#: Cause of a range -> what the text says of it, where that is another word.
CAUSES = {"force": "a tenth of the force", "ends": "ends that would pull"}
#: What is said of speeds at which a model of fixed ends has pulled, which says nothing of control there.
PULLED = "ends of the spring would pull"


@dataclass(frozen=True, slots=True)
class SpeedBracket:
    """Two engine speeds (rad/s of the crank) and what lies between them."""

    lower_engine_speed: float
    upper_engine_speed: float

    def __str__(self) -> str:
        low, high = (
            f"{round(value / RPM, 6):.0f}"
            for value in (self.lower_engine_speed, self.upper_engine_speed)
        )
        return low if low == high else f"{low}–{high}"


@dataclass(frozen=True, slots=True)
class RangeMember:
    """The critical speed of a train in which one thing is changed.

    ``cause``: what is changed (``model``, ``damping``, ``step``, ``mesh``), or what leaves the speed of the same train
    open: ``force`` (a tenth of it, of an onset that just touches zero), ``revolution`` (motion that does not repeat),
    ``ends`` (they would pull below the speed). ``change``: to what, such as ``multi-mass`` or ``×0.6``.
    ``engine_speed`` (rad/s): 0 where control is lost from the first speed searched on, infinite where it is maintained
    up to the last. ``pulled``, ``silent``: as in :class:`CriticalSpeed`. ``refusal``: why this train cannot run, whose speed is NaN
    then; empty where it can.
    """

    cause: str
    change: str
    engine_speed: float
    pulled: tuple[SpeedBracket, ...] = ()
    refusal: str = ""
    silent: tuple[SpeedBracket, ...] = ()


@dataclass(frozen=True, slots=True, repr=False)
class CriticalSpeed:
    """Result of the search for one kind of loss of control; speeds in rad/s of the crank.

    ``kind``: ``contact-loss`` (a contact of the drive opens while the valve is open), ``float``
    (the valve is above its rigid lift by more than ``limit``, in m) or ``bounce`` (it leaves its
    seat again by more than ``limit``). ``ranges`` of lost control as the speed rises, by the roots at their ends: the
    first from 0 where control is lost already at ``first_engine_speed``, the last to ``last_engine_speed`` where it
    stays lost; none where control is never lost. ``places``: codes of the contacts that open first (``valve_tip``;
    ``run`` of one that failed), ``valve`` or ``seat``. ``short_count``: how many of the first ranges are short ones of
    lost contact, which an engine passes at once, below the loss that stays. ``runs_count``: runs of the search in
    addition to those of the sweep.

    ``members``: roots of the same loss, the one that stays, with one thing changed each; none where nothing was
    repeated. ``onset`` of it: ``sharp``; ``graze`` where a tenth of the largest
    margin more or less moves it by more than 7.5 % of the speed, for a force that just reaches zero;
    ``non-repeating`` where the motion does not repeat from cycle to cycle.
    ``pulled``: ranges outside those of lost control, by their lowest and highest sampled speed, in which the ends of the spring
    would pull in a model that cannot lift them: such a run gives no critical speed. ``silent``: those of them in which such
    runs lose control, over more than a short range or up to the last speed, so that control is not known to be kept.
    ``cause``: why control is lost there, as the events of a run have it, with what surge takes off the
    ``spring_force_loss`` (N) and the cam order of surge (0: unknown of both); empty where it was not requested.
    ``cam_angle`` (rad), of a loss of contact: where the force of that contact first comes to zero; NaN where unknown.
    ``curve``, of a loss of contact: engine speed, least cam force (N) and amplitude of surge (N, NaN where there is none)
    of all runs, those of the sweep among them.
    ``passed``: ranges, by their lowest and highest sampled speed, that are short (:data:`NARROW`) and
    whose motion does not repeat: the last revolution of a run lost control there, the next may not.
    ``falling_engine_speed``: below which control returns as the speed falls, where that is more than a short range
    below the onset; NaN otherwise and where it was not followed.
    """

    label: str
    kind: str
    limit: float
    first_engine_speed: float
    last_engine_speed: float
    ranges: tuple[SpeedBracket, ...] = ()
    places: tuple[str, ...] = ()
    short_count: int = 0
    runs_count: int = 0
    members: tuple[RangeMember, ...] = ()
    pulled: tuple[SpeedBracket, ...] = ()
    onset: str = ""
    cause: str = ""
    spring_force_loss: float = 0.0
    surge_order: int = 0
    cam_angle: float = math.nan
    curve: tuple[tuple[float, float, float], ...] = ()
    passed: tuple[SpeedBracket, ...] = ()
    falling_engine_speed: float = math.nan
    silent: tuple[SpeedBracket, ...] = ()

    @property
    def found(self) -> bool:
        """Whether control is lost anywhere."""
        return bool(self.ranges)

    @property
    def engine_speed(self) -> float:
        """Speed (rad/s) from which control is lost, as it rises; the first one searched where it is lost there already,
        NaN for never.
        """
        if not self.ranges:
            return math.nan
        return self.ranges[0].lower_engine_speed or self.first_engine_speed

    @property
    def deciding_speed(self) -> float:
        """Speed (rad/s) that the range is of: from where control stays lost; infinite for never."""
        if not self.ranges:
            return math.inf
        return self.ranges[self.deciding_place].lower_engine_speed or self.first_engine_speed

    @property
    def deciding_place(self) -> int:
        """Place of the range of lost control that stays; 0 where none does."""
        return self.short_count if self.short_count < len(self.ranges) else 0

    @property
    def both_motions(self) -> tuple[float, float] | None:
        """Engine speeds (rad/s) between which control is kept where the speed rises and is not regained where
        it falls; None of a range that is narrow or was not followed.
        """
        if not math.isfinite(self.falling_engine_speed):
            return None
        return self.falling_engine_speed, self.engine_speed

    def decided(self, other: float) -> CriticalSpeed:
        """The result with the ranges of lost contact below the one that stays counted: each narrow and below every
        ``other`` loss (rad/s); none of more than :data:`MAX_SHORT`, for control then ends at the first, and none of
        two motions, for control is not regained for long.
        """
        count = 0
        for one in () if self.both_motions else self.ranges:
            low, high = one.lower_engine_speed, one.upper_engine_speed
            if high - low > NARROW * low or high >= min(other, self.last_engine_speed):
                break
            count += 1
        return replace(self, short_count=count if count <= MAX_SHORT else 0)

    @property
    def later_text(self) -> str:
        """Until which speed (rpm) control stays lost, where it is lost again, and where single revolutions lost it
        before; empty for never.
        """
        short = ", ".join(map(str, self.passed[:MAX_AGAIN]))
        single = [f"single revolutions {short}"] if short else []
        if not self.ranges:
            return ", ".join(single)
        first, *again = self.ranges
        stays = first.upper_engine_speed >= self.last_engine_speed
        parts = [
            f"until {self.last_engine_speed / RPM:.6g} or more"
            if stays
            else f"until {first.upper_engine_speed / RPM:.0f}"
        ]
        if again:
            parts.append(f"again {', '.join(map(str, again[:MAX_AGAIN]))}")
        if len(again) > MAX_AGAIN:
            parts.append(f"and {len(again) - MAX_AGAIN} times more")
        return ", ".join((*parts, *single))

    def __repr__(self) -> str:
        return f"{self.label}, {self.kind}: {'; '.join(filter(None, (self.text, self.later_text)))}"

    @property
    def span(self) -> SpeedBracket | None:
        """The one range of the onset: this search and its members that ran; None where nothing was repeated."""
        speeds = [one.engine_speed for one in self.members if not one.refusal]
        if not speeds:
            return None
        own = self.deciding_speed
        return SpeedBracket(min(own, *speeds), max(own, *speeds))

    @property
    def causes(self) -> tuple[str, ...]:
        """What the ends of the range come from, the lower one first."""
        span = self.span
        if span is None:
            return ()
        own = self.deciding_speed
        ends = (span.lower_engine_speed, span.upper_engine_speed)
        named = (
            next(one.cause for one in self.members if one.engine_speed == end)
            for end in ends
            if end != own
        )
        return tuple(dict.fromkeys(named))

    @property
    def range_text(self) -> str:
        """The range in rpm, rounded outwards, with its causes: ``6600 to 6810: model, damping``; empty for none."""
        span = self.span
        if span is None or not self.causes:
            return ""
        ends = _range_text(span, self.first_engine_speed, self.last_engine_speed)
        return f"{ends}: {', '.join(CAUSES.get(one, one) for one in self.causes)}"

    @property
    def pulled_text(self) -> str:
        """Where the ends of the spring would pull, by this search and by members, in rpm; empty for nowhere."""
        ranges = sorted(
            (*self.pulled, *(each for one in self.members for each in one.pulled)),
            key=lambda one: one.lower_engine_speed,
        )
        joined: list[SpeedBracket] = []
        for one in ranges:
            if joined and one.lower_engine_speed <= joined[-1].upper_engine_speed:
                top = max(joined[-1].upper_engine_speed, one.upper_engine_speed)
                one = SpeedBracket(joined.pop().lower_engine_speed, top)
            joined.append(one)
        return f"{PULLED} at {', '.join(map(str, joined))}" if joined else ""

    @property
    def refused_text(self) -> str:
        """The members of the range that cannot run; empty for none."""
        refused = [f"{one.cause} {one.change}" for one in self.members if one.refusal]
        return f"no run with {', '.join(refused)}" if refused else ""

    @property
    def text(self) -> str:
        """The result in rpm as terminal, page and Python print it: ``6729 (6600 to 6810: model, damping)``,
        ``below 7000, at the cam``, ``none up to 9000``; ``(nominal)`` where nothing was repeated.
        """
        if not self.ranges:
            speed = f"none up to {self.last_engine_speed / RPM:.6g}"
        elif not self.ranges[0].lower_engine_speed > 0:
            speed = f"below {self.first_engine_speed / RPM:.6g}"
        else:
            speed = f"{self.engine_speed / RPM:.0f}"
        if self.deciding_place:
            speed += f", stays lost from {self.deciding_speed / RPM:.0f}"
        if over := self.range_text:
            speed += f" ({over})"
        elif self.engine_speed > self.first_engine_speed and self.span is None:
            speed += " (nominal)"
        place = (
            f"at the {places_text(*self.places)}"
            if self.found and self.kind == "contact-loss"
            else ""
        )
        parts = (speed, ONSETS.get(self.onset), place, self.pulled_text, self.refused_text)
        return ", ".join(filter(None, parts))


def places_text(*places: str) -> str:
    """Codes of places as words: ``cam, valve tip``."""
    return ", ".join(places).replace("_", " ")


def _range_text(bracket: SpeedBracket, first: float, last: float) -> str:
    """A range in rpm, rounded outwards."""
    low, high = bracket.lower_engine_speed, bracket.upper_engine_speed
    begin = f"below {first / RPM:.6g}" if low <= 0 else f"{math.floor(round(low / RPM, 3))}"
    end = f"{math.ceil(round(high / RPM, 3))}" if math.isfinite(high) else f"above {last / RPM:.6g}"
    return f"{begin} to {end}"


@dataclass(frozen=True, slots=True)
class CriticalSpeeds(Saveable):
    """Results of a search over engine speed, by label and kind.

    >>> never = CriticalSpeed("stock", "float", 5e-5, 700.0, 300 * math.pi)
    >>> CriticalSpeeds((never,))
    critical engine speeds (rpm)
      stock, float: none up to 9000
    """

    rows: tuple[CriticalSpeed, ...] = ()

    def __iter__(self) -> Iterator[CriticalSpeed]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return "\n  ".join(
            (
                "critical engine speeds (rpm)",
                *map(repr, self.rows),
            )
        )

    def of(self, kind: str, label: str = "") -> CriticalSpeed | None:
        """The first result of ``kind`` and, where given, ``label``; None where there is none."""
        return next(
            (one for one in self.rows if one.kind == kind and label in ("", one.label)), None
        )

    def limiting(
        self, label: str = ""
    ) -> tuple[tuple[CriticalSpeed, tuple[SpeedBracket, ...]], ...]:
        """The results of a label, or of all, each with its ranges of lost control but for the short ones, which limit
        nothing; without a result that has only those.
        """
        return tuple(
            (one, one.ranges[one.short_count :])
            for one in self.rows
            if label in ("", one.label) and (not one.ranges or one.short_count < len(one.ranges))
        )

    def quantities(self, label: str) -> dict[str, float]:
        """The engine speeds (rad/s) of one label by the names of the quantities, of what was found."""
        return {
            KINDS[one.kind]: one.engine_speed
            for one in self.rows
            if one.label == label and one.found
        }

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels in order of first appearance."""
        return tuple(dict.fromkeys(one.label for one in self.rows))

    def to_pandas(self) -> pandas.DataFrame:
        """One row per label and kind; speeds in rpm of the crank, the limit in m, NaN for what
        was not found. ``attrs["units"]`` has the unit of each number.
        """
        from valvetrain.solution.display import frame

        missing = SpeedBracket(math.nan, math.nan)
        plain = (
            "label",
            "kind",
            "places",
            "limit",
            "engine_speed",
            "falling_engine_speed",
            "onset",
            "first_engine_speed",
            "last_engine_speed",
        )
        ranges: dict[str, list[Any]] = {
            f"range_{end}": [float(getattr(one.span or missing, end)) for one in self.rows]
            for end in ("lower_engine_speed", "upper_engine_speed")
        }
        ranges["range_causes"] = [", ".join(one.causes) for one in self.rows]
        own = {name: [getattr(one, name) for one in self.rows] for name in plain}
        speeds = [name for name in (*own, *ranges) if name.endswith("engine_speed")]
        turned = {
            name: [round(float(one) / RPM, 6) for one in (own | ranges)[name]] for name in speeds
        }
        return frame(own | ranges | turned, units={"limit": "m", **dict.fromkeys(speeds, "rpm")})
