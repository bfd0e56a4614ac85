"""Status and events of a run: how it ended (a value, never an exception) and what happened in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import StrEnum
from types import MappingProxyType

#: Every way a run can end (docs/architecture.md).
STATUS_CODES = (
    "completed",
    "not-converged",
    "diverged",
    "out-of-range",
    "coil-bind",
    "solid",
    "buckled",
    "refused",
    "interrupted",
    "worker-lost",
)


@dataclass(frozen=True, slots=True)
class Status:
    """The end of a run: ``code``, message, the time reached (s), the location and the remedy.

    Raises :class:`ValueError` for a code outside :data:`STATUS_CODES`.

    >>> Status("coil-bind", "the spring is solid at 11.2 mm of lift", remedy="take a longer spring").completed
    False
    """

    code: str = "completed"
    message: str = ""
    time: float = 0.0
    where: str = ""
    remedy: str = ""

    def __post_init__(self) -> None:
        if self.code not in STATUS_CODES:
            raise ValueError(
                f"status code '{self.code}' is unknown; use one of {', '.join(STATUS_CODES)}"
            )

    @property
    def completed(self) -> bool:
        """True when the run reached its end."""
        return self.code == "completed"

    def sentence(self) -> str:
        """One line of text: code, message, time, location and remedy, where known."""
        if self.completed and not self.message:
            return "completed"
        remedy = f"; {self.remedy}" if self.remedy else ""
        when = f", at time {self.time:.6g} s" + (f" at {self.where}" if self.where else "")
        if self.where and not self.time and self.code in ("not-converged", "diverged"):
            when = f", at {self.where}"  # of a spring at rest
        elif self.completed or self.code in ("refused", "buckled", "worker-lost"):
            when = ""
        elif self.code == "interrupted" and not self.time:
            when = ""
        return f"{self.code}: {self.message}{when}{remedy}"


COMPLETED = Status()


class Cause(StrEnum):
    """Why an event happened, as its detail ``cause``.

    Of a loss of contact or float: the inertia of rigid parts exceeds the spring force, surge lowers that
    force, or the parts vibrate. Of a clash: coils strike, or come to rest on each other as the spring closes. Of a
    seating: the closing flank or a bounce ends. Of a bounce: a rebound, or one with the spring force lowered by surge.
    """

    INERTIA = "inertia"
    SURGE = "surge"
    VIBRATION = "vibration"
    COILS_STRIKE = "coils-strike"
    COILS_REST = "coils-rest"
    FLANK_ENDS = "flank-ends"
    BOUNCE_ENDS = "bounce-ends"
    REBOUND = "rebound"
    REBOUND_IN_SURGE = "rebound-in-surge"


#: Types of the details of an event, all of which can be stored.
Detail = float | int | str | bool


@dataclass(frozen=True)
class Event:
    """One event: ``cam_angle`` (rad, unwrapped) and ``time`` (s) of its start, ``duration`` (s),
    ``size`` in ``unit``. ``where``: code of a contact (``valve_tip``), or the coils. ``counts``: False of
    a loss of contact near the seat, which loses no control of the valve.

    Kind ``clash``: size = peak contact force (N); details hold ``impulse`` (N s), ``energy`` (J),
    ``upper_coil``, ``lower_coil``.

    >>> event = Event("clash", cam_angle=4.2, time=0.012, duration=2e-4, size=310.0, unit="N", where="coils 1-2")
    >>> event.kind, event.size
    ('clash', 310.0)
    """

    kind: str
    cam_angle: float
    time: float
    duration: float
    size: float
    unit: str
    where: str = ""
    details: Mapping[str, Detail] = field(default_factory=dict)
    counts: bool = True

    def __post_init__(self) -> None:
        # a code is plain text, as it comes back from a file
        object.__setattr__(self, "details", MappingProxyType(
            {name: getattr(one, "value", one) for name, one in self.details.items()}
        ))  # fmt: skip

    def __reduce__(self) -> tuple[object, ...]:
        # A mappingproxy does not pickle, and sweeps send results between processes.
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Event, tuple((values | {"details": dict(self.details)}).values())
