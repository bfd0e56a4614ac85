"""How much engine speed each part of a train gains when it alone is changed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from valvetrain.solution.critical import NEAR_BIND, RPM
from valvetrain.solution.display import Saveable, frame

if TYPE_CHECKING:
    import pandas

#: Unit of each number of a change.
UNITS = {
    "engine_speed": "rad/s", "gain": "rad/s", "least_gain": "rad/s", "largest_gain": "rad/s", "seat_load_change": "N", "stress_change": "Pa",
    "lift_loss": "m", "time_lost": "rad", "bind_clearance": "m",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class PartChange:
    """A part that alone is changed.

    ``part``: what is changed and how; ``price``: what that costs; ``engine_speed`` (rad/s of the crank): up to which the
    changed train is controlled, 0 where it is not at the lowest speed searched, infinite where it is at the highest.
    ``gain`` (rad/s) of that speed, and the ``least_gain`` and ``largest_gain`` that finer numerics, another spring model and
    other damping of both trains give. ``seat_load_change`` (N), and ``stress_change`` (Pa) of the wire at full lift, NaN
    of a spring without a wire. ``lift_loss`` (m, at the lowest speed in use) and ``time_lost`` (rad of the crank, above 0.050 in of
    lift, at the lowest speed searched) are what flex takes. ``chosen``: whether a shop can choose it; else it is what nobody knows.
    ``bind_clearance`` (m): what it leaves to coil bind at full lift, where that is less than before; else NaN.
    ``loss``: kind of the critical speed that ends control, empty for none. ``setting``: what sets it on a command line, empty
    where a case file has to. ``refusal``: why the changed train cannot run,
    whose numbers are NaN then.
    """

    part: str
    price: str = ""
    engine_speed: float = math.nan
    gain: float = math.nan
    least_gain: float = math.nan
    largest_gain: float = math.nan
    seat_load_change: float = 0.0
    stress_change: float = math.nan
    lift_loss: float = math.nan
    time_lost: float = math.nan
    bind_clearance: float = math.nan
    chosen: bool = True
    loss: str = ""
    setting: str = ""
    refusal: str = ""

    @property
    def sign(self) -> int:
        """1 where the whole range is a gain, -1 where it is a loss, 0 for neither."""
        return 1 if self.least_gain > 0 else -1 if self.largest_gain < 0 else 0

    @property
    def near_bind(self) -> bool:
        """Whether it brings the coils closer than :data:`NEAR_BIND`."""
        return self.bind_clearance < NEAR_BIND


@dataclass(frozen=True, slots=True, repr=False)
class PartRanking(Saveable):
    """Parts of a train by the engine speed of control that each gains.

    ``case``: its name; ``label`` of the train as it is, controlled up to ``engine_speed`` (rad/s of the crank; as in :class:`PartChange`);
    changed trains were searched from ``first_engine_speed`` to ``last_engine_speed``. ``changes``: what nobody
    knows, then the parts, the largest gain first.
    ``seat_load`` (N), ``lift_loss``, ``time_lost`` and ``loss`` as in :class:`PartChange`; ``red_line`` (rad/s) and ``text`` of the case.

    >>> lighter = PartChange("valve 10 % lighter", engine_speed=800.0, gain=50.0, least_gain=40.0, largest_gain=60.0)
    >>> PartRanking("own", "stock", 750.0, 500.0, 900.0, (lighter,)).best.part
    'valve 10 % lighter'
    """

    case: str
    label: str
    engine_speed: float
    first_engine_speed: float
    last_engine_speed: float
    changes: tuple[PartChange, ...] = ()
    seat_load: float = math.nan
    red_line: float | None = None
    text: str = ""
    lift_loss: float = math.nan
    time_lost: float = math.nan
    loss: str = ""

    @property
    def choices(self) -> tuple[PartChange, ...]:
        """Parts that a shop can choose and that run, the largest gain first."""
        return tuple(one for one in self.changes if one.chosen and not one.refusal)

    @property
    def best(self) -> PartChange | None:
        """The part that gains most of those that surely gain, first of those that keep off coil bind, else of all; None where none was searched."""
        return min(self.choices, key=lambda one: (one.sign <= 0, one.near_bind), default=None)

    def __repr__(self) -> str:
        rows = [
            f"{one.part}: {one.refusal or f'{one.gain / RPM:+.0f} rpm'}" for one in self.changes
        ]
        return "\n  ".join((f"parts of {self.label}, by rpm of control gained", *rows))

    def to_pandas(self) -> pandas.DataFrame:
        """A row per change, SI; the units of its numbers are in ``attrs["units"]``."""
        names = ("part", *UNITS, "chosen", "price", "loss", "setting", "refusal")
        columns = {name: [getattr(one, name) for one in self.changes] for name in names}
        return frame(columns, units={name: UNITS.get(name, "") for name in names})
