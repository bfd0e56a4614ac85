"""What a point is asked for: numbers of a case under one condition, each with the key that data
know it by.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from valvetrain.solution.definition import definition_of
from valvetrain.units import format_quantity


@dataclass(frozen=True, slots=True)
class Station:
    """Where something was measured: ``engine_speed`` (rad/s of the crank; None at rest), word of
    the spring model and set (empty: the
    case's own)."""

    engine_speed: float | None = None
    spring_model: str = ""
    spring_set: str = ""

    @property
    def words(self) -> str:
        """How keys begin, empty at rest by the case's own model."""
        speed = (
            [] if self.engine_speed is None else [f"{format_quantity(self.engine_speed, 'rpm')}"]
        )
        return ", ".join([*speed, *filter(None, (self.spring_model, self.spring_set))])


@dataclass(frozen=True, slots=True)
class Sought:
    """One number: a named ``quantity``; the ``force`` of a spring at a compression ``at`` (m from
    the free state) or its ``load`` at a
    height ``at`` (m between its seats), ``name`` being the spring (empty: the only one); the cam
    angle of the event number ``at`` (from 1)
    of the kind ``name``; the channel ``name`` at the cam angle ``at`` (rad)."""

    station: Station
    kind: Literal["quantity", "force", "load", "event", "channel"]
    name: str = ""
    at: float = 0.0

    @property
    def key(self) -> str:
        """What data and outcomes know it by."""
        if self.kind == "quantity":
            own = self.name
        elif self.kind == "force":
            own = f"force{' of ' + self.name if self.name else ''} at {1e3 * self.at:.6g} mm"
        elif self.kind == "load":
            own = f"load{' of ' + self.name if self.name else ''} at a height of {1e3 * self.at:.6g} mm"
        elif self.kind == "event":
            own = f"{self.name} {self.at:.0f} cam angle"
        else:
            own = f"{self.name} at {format_quantity(self.at, 'deg')}"
        return f"{self.station.words}: {own}" if self.station.words else own

    @property
    def unit(self) -> str:
        """Unit it is shown in; None's stand-in, an empty one, where it is not known."""
        if self.kind in ("force", "load"):
            return "N"
        return "deg" if self.kind == "event" else definition_of(self.name).shown_unit
