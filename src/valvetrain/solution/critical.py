"""Critical engine speeds, at which a train loses control of its valve, as brackets between two
runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

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
    speeds searched, or could not be continued.
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
class CriticalSpeed:
    """Result of the search for one kind of loss of control; speeds in rad/s of the crank.

    ``kind``: ``contact-loss`` (a contact of the drive opens while the valve is open), ``float``
    (the valve is above its rigid lift by more than ``limit``, in m) or ``bounce`` (it leaves its
    seat again by more than ``limit``). ``place``: the contact that opens first, ``valve`` or
    ``seat``. ``begins``: the lowest onset, None where there is none or control is lost already at
    ``first_engine_speed``. ``ends``: end of that range of speeds, from rest, None where it lasts to
    ``last_engine_speed``. ``again``: further ranges above it, by their lowest and highest sampled
    speed. ``runs_count``: runs of the search besides those of the sweep.
    """

    label: str
    kind: str
    limit: float
    first_engine_speed: float
    last_engine_speed: float
    resolution: float
    found: bool = False
    place: str = ""
    begins: Crossing | None = None
    ends: Crossing | None = None
    again: tuple[SpeedBracket, ...] = ()
    runs_count: int = 0

    @property
    def engine_speed(self) -> float:
        """Lowest speed (rad/s) seen to lose control, started at rest: the upper end of the bracket;
        NaN where none does.
        """
        if not self.found:
            return math.nan
        return (
            self.first_engine_speed
            if self.begins is None
            else self.begins.from_rest.upper_engine_speed
        )

    @property
    def text(self) -> str:
        """The result in rpm as tables print it: ``7806–7813 (cam)``, ``below 7000 (cam)``, ``never
        up to 9000``.
        """
        if not self.found:
            return f"never up to {self.last_engine_speed / RPM:.6g}"
        speeds = (
            f"below {self.first_engine_speed / RPM:.6g}"
            if self.begins is None
            else str(self.begins.from_rest)
        )
        return f"{speeds} ({self.place})" if self.kind == "contact-loss" else speeds


setattr(CriticalSpeed, "words", CriticalSpeed.text)  # noqa: B010  the former name


@dataclass(frozen=True, slots=True)
class CriticalSpeeds(Saveable):
    """Results of a search over engine speed, by label and kind.

    >>> never = CriticalSpeed("stock", "float", 5e-5, 700.0, 300 * math.pi, 1.0)
    >>> CriticalSpeeds((never,))
    critical engine speeds (rpm)
      stock, float: never up to 9000
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
                *(f"{one.label}, {one.kind}: {one.text}" for one in self.rows),
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
            "place",
            "limit",
            "engine_speed",
            "first_engine_speed",
            "last_engine_speed",
        )
        return frame({name: [getattr(one, name) for one in self.rows] for name in plain} | brackets)
