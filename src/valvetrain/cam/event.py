"""The main lift event of a cam: where it begins and ends."""

from __future__ import annotations

import math

import numpy as np

from valvetrain.cam.contract import LiftLaw
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.solution.study import LiftEvent

#: Where a law does not say where its main event begins, it is where the lift passes this share of its largest value.
EVENT_SHARE = 0.04
_TURN = 2 * math.pi


def find_lift_event(law: LiftLaw | None, parameters: LiftLawParameters | None = None) -> LiftEvent | None:
    """Main lift event of a law; None without lift or where the event spans the zero of the cam angle.

    The event is the law's own (``event_start`` with ``event_end`` or mirrored about ``nose`` among the values of ``parameters``), else
    from where the lift first passes 4 % of its largest value to where it last does.
    """
    values = {} if parameters is None else parameters.values
    end = values.get("event_end")
    if "event_start" in values and (end is not None or "nose" in values):
        start = float(values["event_start"])
        found = start, 2 * float(values["nose"]) - start if end is None else float(end)
    elif law is None or (passed := _passed(law)) is None:
        return None
    else:
        found = passed
    first, length = found[0] % _TURN, found[1] - found[0]
    # Whole cam degrees stay whole through sums of radians.
    first, last = (math.radians(round(math.degrees(angle), 9)) for angle in (first, first + length))
    return LiftEvent(first, last) if last <= _TURN else None


def _passed(law: LiftLaw) -> tuple[float, float] | None:
    """Where the lift passes the share of its maximum, from the nose outward round the circle until it has gone under for good."""
    lift = law.lift(np.arange(7200) * _TURN / 7200)
    top, up = int(np.argmax(lift)), lift > EVENT_SHARE * float(np.max(lift))
    if not np.max(lift) > 0 or np.all(up):
        return None
    inside = np.flatnonzero(np.roll(up, len(up) // 2 - top)) - len(up) // 2 + top
    step = _TURN / len(up)
    return float(inside[0] * step), float((inside[-1] + 1) * step)
