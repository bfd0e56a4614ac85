"""The main lift event of a cam: where it begins and ends."""

from __future__ import annotations

import math

import numpy as np

from valvetrain.cam.contract import TURN, LiftLaw
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.solution.study import LiftEvent

#: Where a law does not say where its main event begins, it is where the lift passes this share of its largest value.
EVENT_SHARE = 0.04


def lift_event(parameters: LiftLawParameters | None, law: LiftLaw) -> LiftEvent | None:
    """Main event of a law; None without lift or where the event spans the zero of the cam angle.

    It is the law's own (``event_start`` with ``event_end`` or mirrored about ``nose``), else from where the lift first passes 4 % of its
    largest value to where it last does.
    """
    values = parameters.values if parameters is not None else {}
    if "event_start" in values and ("event_end" in values or "nose" in values):
        start = float(values["event_start"])
        end = float(values["event_end"]) if "event_end" in values else 2 * float(values["nose"]) - start
    else:
        angle = np.arange(7200) * TURN / 7200
        lift = np.asarray(law.lift(angle))
        top, up = int(np.argmax(lift)), lift > EVENT_SHARE * float(np.max(lift))
        if not np.max(lift) > 0 or np.all(up):
            return None
        # From the nose outward, round the circle, until the lift has gone under the share for good.
        turned = np.roll(up, len(up) // 2 - top)
        inside = np.flatnonzero(turned) - len(up) // 2 + top
        start, end = float(inside[0] * TURN / len(up)), float((inside[-1] + 1) * TURN / len(up))
    first, length = start % TURN, end - start
    # Whole cam degrees stay whole through sums of radians.
    first, last = (math.radians(round(math.degrees(angle), 9)) for angle in (first, first + length))
    return LiftEvent(first, last) if last <= TURN else None
