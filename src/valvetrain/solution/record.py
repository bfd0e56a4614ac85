"""What may be shown of a case after its parts are built: words, sources, published values. Nothing
is computed from it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Literal

Role = Literal["calibration", "check", "prediction"]


@dataclass(frozen=True, slots=True)
class PublishedValue:
    """One published number to compare with.

    ``quantity``: name from docs/quantities.md. ``value``: SI. ``unit``: the unit to show it in.
    ``model``: what produced it
    in the source (such as ``solid finite elements``). ``origin``: the place in the source.
    ``role``: ``calibration`` for a value that
    unknown numbers of the case were found or chosen by, ``check`` for one that was known then and
    not used, ``prediction`` for one that
    must not be used; ``used_for``: what it was used for, in words; ``doubt``: why the number
    cannot be right, where its source contradicts it. ``engine_speed`` in rad/s of the crank, None
    for statics and modes.
    ``tolerance``: allowed absolute difference (SI), None where none is stated. ``relation``: how
    firmly the source states it.
    """

    quantity: str
    value: float
    unit: str
    origin: str = ""
    role: Role = "prediction"
    engine_speed: float | None = None
    model: str = ""
    source: str = ""
    tolerance: float | None = None
    relation: Literal["equal", "about", "at-most", "at-least"] = "equal"
    used_for: str = ""
    doubt: str = ""


@dataclass(frozen=True, slots=True)
class CaseValue:
    """One value of a case as a reader sees it: key path, value in words, status and source."""

    path: str
    words: str
    status: str = ""
    source: str = ""


@dataclass(frozen=True)
class CaseRecord:
    """The words of a case: what a result says of its origin.

    ``study``: word of the published study the case re-runs (empty for a case of one's own).
    ``changed``: key paths that were set from
    outside the file; a changed case no longer speaks of published numbers. ``text``: the resolved
    case file (TOML), from which the case
    is read again. ``citations``: whole references. ``points``: coil numbers of the study's points
    on the wire, where the case tells them.
    """

    name: str
    title: str = ""
    description: str = ""
    study: str = ""
    remarks: tuple[str, ...] = ()
    published: tuple[PublishedValue, ...] = ()
    values: tuple[CaseValue, ...] = ()
    citations: tuple[str, ...] = ()
    zero_of_angle: str = ""
    changed: tuple[str, ...] = ()
    text: str = ""
    points: tuple[tuple[str, float], ...] = ()

    @property
    def digest(self) -> str:
        """Short fingerprint of the resolved case file."""
        return hashlib.sha256(self.text.encode()).hexdigest()[:16]
