"""A lift as it was measured: stations, what they mean and who said so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Who answered a question: the file itself, the user, or nobody (then it is said to be assumed).
Teller = Literal["file", "asked", "assumed"]


@dataclass(frozen=True, slots=True)
class Answer:
    """One question that every table of lifts raises, its answer and who gave it."""

    question: str
    answer: str
    by: Teller


@dataclass(frozen=True, eq=False)
class MeasuredLift:
    """Lifts (m) of one lobe at cam angles (rad), both (stations,), rising in angle, before any smoothing.

    ``name``: lift, intake or exhaust. ``lift_of``: valve or tappet. ``form``: word of the format the file had. ``answers``: what the
    stations mean and who said so. ``notes``: sentences on what was found in the file, such as a velocity column that agrees.

    >>> lift = MeasuredLift("lift", np.radians([100.0, 101.0]), np.array([0.0, 1e-4]), "valve", "columns")
    >>> lift
    MeasuredLift 'lift' of the valve: 2 stations, 100 to 101 cam deg, peak 0.1000 mm
    """

    name: str
    cam_angles: Array
    lifts: Array
    lift_of: str
    form: str
    zero: str = ""
    answers: tuple[Answer, ...] = ()
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        first, last = np.degrees(self.cam_angles[[0, -1]])
        return (
            f"MeasuredLift '{self.name}' of the {self.lift_of}: {len(self.lifts)} stations, {first:g} to {last:g} cam deg, "
            f"peak {1e3 * self.lifts.max():.4f} mm"
        )
