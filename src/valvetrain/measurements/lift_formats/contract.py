"""What a form of lift files answers: whether a content is its own, what it holds, how it is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Words that a column may carry.
COLUMN_WORDS = ("angle", "lift", "intake", "exhaust", "velocity", "acceleration", "ignore")


@dataclass(frozen=True, eq=False)
class LiftColumns:
    """What a file holds, before any question is answered.

    ``form``: word of the format. ``rows`` (stations, columns) in the file's own units. ``columns``: a word of :data:`COLUMN_WORDS` per
    column, empty where the file does not tell. ``units``: one per column, likewise. ``said``: questions that the file itself answers,
    such as ``{"angle_of": "crank"}``. ``headings``: its lines of words.
    """

    form: str
    rows: Array
    columns: tuple[str, ...]
    units: tuple[str, ...]
    said: Mapping[str, str] = field(default_factory=dict)
    headings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LiftTable:
    """Lifts (m) at cam angles (rad) as a writer takes them; ``names`` of the lobes, one column of ``lifts`` (stations, lobes) each."""

    cam_angles: Array
    lifts: Array
    names: tuple[str, ...]
    lift_of: str
    zero: str


@dataclass(frozen=True, slots=True)
class LiftFormat:
    """A form of lift files. ``recognise(content, name)`` looks at the content alone (the name is for messages);
    ``write`` may be missing."""

    words: str
    recognise: Callable[[bytes, str], bool]
    read: Callable[[bytes, str], LiftColumns]
    write: Callable[[LiftTable], bytes] | None = None
