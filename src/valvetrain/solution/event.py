"""Something that happened at a known angle of a run: a clash, a loss of contact, a seating."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

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
