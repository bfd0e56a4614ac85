"""Numbers, units and labels as text."""

from __future__ import annotations

import math

from valvetrain.parameters.summary import in_unit as in_unit
from valvetrain.parameters.summary import number as number
from valvetrain.parameters.summary import unit_text as unit_text
from valvetrain.solution.status import Cause
from valvetrain.units.reader import reader_factor, reader_unit

#: Cause of an event -> its words.
CAUSES: dict[str, str] = {
    Cause.INERTIA: "inertia exceeds the spring force",
    Cause.SURGE: "surge lowers the spring force",
    Cause.VIBRATION: "the train vibrates",
    Cause.COILS_STRIKE: "coils meet under surge",
    Cause.COILS_REST: "coils come to rest on each other as the spring closes",
    Cause.FLANK_ENDS: "the lift ends",
    Cause.BOUNCE_ENDS: "end of a bounce",
    Cause.REBOUND: "rebound from the seat",
    Cause.REBOUND_IN_SURGE: "rebound with the spring force lowered by surge",
}


def amount(value: float, unit: str, digits: int = 4) -> str:
    """A number in a metric ``unit`` as text in the unit of the reader: ``112.4 N``.

    >>> amount(0.5, "mm")
    '0.5 mm'
    """
    return f"{number(value * reader_factor(unit), digits)} {unit_text(reader_unit(unit))}".strip()


def rpm(engine_speed: float) -> float:
    """rad/s as revolutions per minute, rounded to 1e-6."""
    return round(engine_speed * 30 / math.pi, 6)
