"""Critical engine speeds, at which a train loses control of its valve: value, range over model, damping,
step and mesh, and kind of onset, with the brackets between two runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from valvetrain.solution.saveable import Saveable

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
    """Two engine speeds (rad/s of the crank) between which something changes; no run was made
    between them.
    """

    lower_engine_speed: float
    upper_engine_speed: float

    def __str__(self) -> str:
        low, high = (
            f"{round(value / RPM, 6):.0f}"
            for value in (self.lower_engine_speed, self.upper_engine_speed)
        )
        return low if low == high else f"{low}–{high}"

    def apart(self, other: SpeedBracket) -> float:
        """Speed (rad/s) between this bracket and ``other``, 0 where they meet or overlap."""
        gap = max(
            self.lower_engine_speed - other.upper_engine_speed,
            other.lower_engine_speed - self.upper_engine_speed,
        )
        return max(0.0, gap)


@dataclass(frozen=True, slots=True)
class Crossing:
    """One loss or recovery of control, found in three ways.

    ``from_rest``: every speed started at rest. ``rising``, ``falling``: every speed started from
    the motion at its neighbour below, or above; None where that motion did not change within the
    speeds searched, does not repeat or could not be continued.
    """

    from_rest: SpeedBracket
    rising: SpeedBracket | None = None
    falling: SpeedBracket | None = None

    @property
    def hysteresis(self) -> float:
        """Speed (rad/s) between the brackets of rising and of falling speed; 0 where they meet, NaN
        where one of them is missing.
        """
        return (
            math.nan
            if self.rising is None or self.falling is None
            else self.rising.apart(self.falling)
        )


@dataclass(frozen=True, slots=True)
class RangeMember:
    """The critical speed of a train in which one thing is changed.

    ``cause``: what is changed (``model``, ``damping``, ``step``, ``mesh``), or what leaves the speed of the same train
    open: ``force`` (a tenth of it, of an onset that just touches zero), ``revolution`` (motion that does not repeat),
    ``ends`` (they would pull below the speed). ``change``: to what, such as ``multi-mass`` or ``×0.6``.
    ``engine_speed`` (rad/s): 0 where control is lost from the first speed searched on, infinite where it is maintained
    up to the last. ``pulled``: as in :class:`CriticalSpeed`. ``refusal``: why this train cannot run, whose speed is NaN
    then; empty where it can.
    """

    cause: str
    change: str
    engine_speed: float
    pulled: tuple[SpeedBracket, ...] = ()
    refusal: str = ""


@dataclass(frozen=True, slots=True, repr=False)
class CriticalSpeed:
    """Result of the search for one kind of loss of control; speeds in rad/s of the crank.

    ``kind``: ``contact-loss`` (a contact of the drive opens while the valve is open), ``float``
    (the valve is above its rigid lift by more than ``limit``, in m) or ``bounce`` (it leaves its
    seat again by more than ``limit``). ``places``: codes of the contacts that open first (``valve_tip``; ``run`` of
    one that failed), ``valve`` or ``seat``. ``begins``: the lowest onset, None where there is none or control is lost already at
    ``first_engine_speed``. ``ends``: end of that range of speeds, from rest, None where it lasts to
    ``last_engine_speed``. ``again``: further ranges above it, by their lowest and highest sampled
    speed. ``runs_count``: runs of the search in addition to those of the sweep.

    ``nominal_engine_speed``: the onset itself, inside the bracket; infinite for never. ``members``: the same search with
    one thing changed each; none where nothing was repeated. ``onset``: ``sharp``; ``graze`` where a tenth of the largest
    margin more or less moves it by more than 7.5 % of the speed, for a force that just reaches zero;
    ``non-repeating`` where the motion does not repeat from cycle to cycle.
    ``pulled``: ranges below the onset, by their lowest and highest sampled speed, in which the ends of the spring would
    pull in a model that cannot lift them: such a run gives no critical speed.
    ``cause``: why control is lost there, as the events of a run have it, with what surge takes off the
    ``spring_force_loss`` (N) and the cam order of surge (0: unknown of both); empty where it was not requested.
    ``cam_angle`` (rad), of a loss of contact: where the force of that contact first comes to zero; NaN where unknown.
    ``curve``, of a loss of contact: engine speed and least cam force (N) of the runs from rest, those of the sweep among them.
    ``passed``: ranges below the onset, by their lowest and highest sampled speed, that are short (:data:`NARROW`) and
    whose motion does not repeat: the last revolution of a run lost control there, the next may not.
    ``decisive_engine_speed``: from where control stays lost, above short ranges of lost contact; ``members`` and ``onset``
    are then of that speed. NaN where the onset itself decides.
    """

    label: str
    kind: str
    limit: float
    first_engine_speed: float
    last_engine_speed: float
    resolution: float
    found: bool = False
    places: tuple[str, ...] = ()
    begins: Crossing | None = None
    ends: Crossing | None = None
    again: tuple[SpeedBracket, ...] = ()
    runs_count: int = 0
    nominal_engine_speed: float = math.nan
    members: tuple[RangeMember, ...] = ()
    pulled: tuple[SpeedBracket, ...] = ()
    onset: str = ""
    cause: str = ""
    spring_force_loss: float = 0.0
    surge_order: int = 0
    cam_angle: float = math.nan
    curve: tuple[tuple[float, float], ...] = ()
    passed: tuple[SpeedBracket, ...] = ()
    decisive_engine_speed: float = math.nan

    @property
    def engine_speed(self) -> float:
        """Speed (rad/s) from which control is lost, started at rest: it moves smoothly with the
        inputs where the motion repeats. Without it the upper end of the bracket; NaN for never.
        """
        if not self.found:
            return math.nan
        if math.isfinite(self.nominal_engine_speed):
            return self.nominal_engine_speed
        return (
            self.first_engine_speed
            if self.begins is None
            else self.begins.from_rest.upper_engine_speed
        )

    @property
    def deciding_speed(self) -> float:
        """Speed (rad/s) that the range is of: the decisive one, or the onset; infinite for never."""
        if math.isfinite(self.decisive_engine_speed):
            return self.decisive_engine_speed
        return self.engine_speed if self.found else math.inf

    @property
    def ranges(self) -> tuple[SpeedBracket, ...]:
        """All ranges of lost control; the first from 0 where control is lost at the first speed searched."""
        if not self.found:
            return ()
        begin, end = self.engine_speed, self.last_engine_speed
        if self.begins is None and not math.isfinite(self.nominal_engine_speed):
            begin = 0.0
        if self.ends is not None:
            end = max(begin, self.ends.from_rest.lower_engine_speed)
        return SpeedBracket(begin, end), *self.again

    @property
    def both_motions(self) -> tuple[float, float] | None:
        """Engine speeds (rad/s) between which control is kept where the speed rises and is not regained where
        it falls; None of a range that is narrow or was not followed.
        """
        begins = self.begins
        if begins is None or begins.rising is None or begins.falling is None:
            return None
        low, high = begins.falling.lower_engine_speed, begins.rising.upper_engine_speed
        return (low, high) if high - low > NARROW * low else None

    def short_ranges(self, other: float) -> tuple[SpeedBracket, ...]:
        """The ranges of lost contact below the one that stays, each narrow and below every ``other`` loss
        (rad/s); none of more than :data:`MAX_SHORT`, for control then ends at the first.
        """
        found = list[SpeedBracket]()
        for one in self.ranges:
            low, high = one.lower_engine_speed, one.upper_engine_speed
            # of a range with both motions control is not regained for long
            if (
                high - low > NARROW * low
                or high >= min(other, self.last_engine_speed)
                or self.both_motions
            ):
                break
            found.append(one)
        return tuple(found) if len(found) <= MAX_SHORT else ()

    @property
    def later_text(self) -> str:
        """Until which speed (rpm) control stays lost, where it is lost again, and where single revolutions lost it
        before; empty for never.
        """
        short = ", ".join(map(str, self.passed[:MAX_AGAIN]))
        single = [f"single revolutions {short}"] if short else []
        if not self.found:
            return ", ".join(single)
        end = f"{self.last_engine_speed / RPM:.6g} or more"
        parts = [f"until {end if self.ends is None else self.ends.from_rest}"]
        if self.again:
            parts.append(f"again {', '.join(map(str, self.again[:MAX_AGAIN]))}")
        if len(self.again) > MAX_AGAIN:
            parts.append(f"and {len(self.again) - MAX_AGAIN} times more")
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
        if not self.found:
            speed = f"none up to {self.last_engine_speed / RPM:.6g}"
        elif self.begins is None:
            speed = f"below {self.first_engine_speed / RPM:.6g}"
        elif math.isfinite(self.nominal_engine_speed):
            speed = f"{self.nominal_engine_speed / RPM:.0f}"
        else:
            speed = str(self.begins.from_rest)
        if math.isfinite(self.decisive_engine_speed):
            speed += f", stays lost from {self.decisive_engine_speed / RPM:.0f}"
        if over := self.range_text:
            speed += f" ({over})"
        elif math.isfinite(self.nominal_engine_speed) and self.span is None:
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


def _range_text(one: SpeedBracket, first: float, last: float) -> str:
    """A range in rpm, rounded outwards."""
    low, high = one.lower_engine_speed, one.upper_engine_speed
    begin = f"below {first / RPM:.6g}" if low <= 0 else f"{math.floor(round(low / RPM, 3))}"
    end = f"{math.ceil(round(high / RPM, 3))}" if math.isfinite(high) else f"above {last / RPM:.6g}"
    return f"{begin} to {end}"


@dataclass(frozen=True, slots=True)
class CriticalSpeeds(Saveable):
    """Results of a search over engine speed, by label and kind.

    >>> never = CriticalSpeed("stock", "float", 5e-5, 700.0, 300 * math.pi, 1.0)
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
        """One row per label and kind; speeds in rad/s of the crank, the limit in SI, NaN for what
        was not found.
        """
        from valvetrain.solution.display import frame

        missing = SpeedBracket(math.nan, math.nan)
        brackets = {
            f"{name}_{end}": [
                math.nan
                if one.begins is None
                else float(getattr(getattr(one.begins, name) or missing, end))
                for one in self.rows
            ]
            for name in ("from_rest", "rising", "falling")
            for end in ("lower_engine_speed", "upper_engine_speed")
        }
        plain = (
            "label",
            "kind",
            "places",
            "limit",
            "engine_speed",
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
        return frame(own | ranges | brackets)
