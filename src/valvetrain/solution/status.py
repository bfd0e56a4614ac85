"""How a run ended: a value, never an exception."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

#: Every way a run can end (docs/architecture.md).
STATUS_CODES = (
    "completed",
    "not-converged",
    "diverged",
    "coil-bind",
    "solid",
    "buckled",
    "refused",
    "interrupted",
    "worker-lost",
)


@dataclass(frozen=True, slots=True)
class Status:
    """The end of a run: ``code``, what happened, the time reached (s), the place and the remedy.

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
        """One line for people: code, message, time, place and remedy, those that are known."""
        if self.completed and not self.message:
            return "completed"
        place = f" at {self.where}" if self.where else ""
        if (
            self.where and not self.time and self.code in ("not-converged", "diverged")
        ):  # of a spring at rest
            return f"{self.code}: {self.message}, at {self.where}{f'; {self.remedy}' if self.remedy else ''}"
        timeless = (
            self.completed
            or self.code in ("refused", "buckled", "worker-lost")
            or (self.code == "interrupted" and not self.time)
        )
        when = "" if timeless else f", at time {self.time:.6g} s{place}"
        remedy = f"; {self.remedy}" if self.remedy else ""
        return f"{self.code}: {self.message}{when}{remedy}"


COMPLETED = Status()


#: Values that an event's details may hold; all of them survive storage.
Detail = float | int | str | bool


@dataclass(frozen=True)
class Event:
    """One event: ``cam_angle`` (rad, unwrapped) and ``time`` (s) of its start, ``duration`` (s),
    ``size`` in ``unit``.

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

    def __post_init__(self) -> None:
        object.__setattr__(self, "details", MappingProxyType(dict(self.details)))

    def __reduce__(
        self,
    ) -> tuple[
        object, ...
    ]:  # a mappingproxy does not pickle, and sweeps send results between processes
        values = (
            self.kind,
            self.cam_angle,
            self.time,
            self.duration,
            self.size,
            self.unit,
            self.where,
            dict(self.details),
        )
        return Event, values
