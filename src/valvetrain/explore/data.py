"""One measured number and how far it may lie from the true one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln, ndtr, stdtr

from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.solution.definition import definition_of
from valvetrain.units import dimension_of, format_quantity, parse_quantities, parse_quantity
from valvetrain.units.text import split_quantity

Array = NDArray[np.float64]
Law = Literal["normal", "student"]


@dataclass(frozen=True, slots=True)
class Datum:
    """A measured ``value`` (SI) of what the computation calls ``key``, with the standard deviation
    ``scatter`` (SI) of its errors.

    ``measurement``: the entry of the file that it belongs to, such as a curve of many data. ``law``
    of the errors: ``normal``, or
    ``student`` with ``freedom`` degrees, of which outliers are part. ``used``: whether it is
    fitted, else it is only compared. ``unit`` it
    is shown in. Raises :class:`InputError` for a scatter that is not positive.

    >>> Datum("preload", 289.0, 1.5).deviation(292.0)
    np.float64(2.0)
    """

    key: str
    value: float
    scatter: float
    measurement: str = ""
    law: Law = "normal"
    freedom: float = 4.0
    used: bool = True
    source: str = ""
    unit: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.value) and math.isfinite(self.scatter) and self.scatter > 0):
            raise InputError(
                f"measurement '{self.name[:60]}' needs a finite value and a positive scatter"
            )
        if self.law not in ("normal", "student") or not self.freedom > 0:
            raise InputError(
                f"the errors of '{self.name[:60]}' are normal, or student with positive freedom; it says '{str(self.law)[:40]}'"
            )

    @property
    def name(self) -> str:
        """The measurement, or the key where it has no name."""
        return self.measurement or self.key

    def deviation(self, computed: Array | float) -> Array:
        """Computed less measured in units of the scatter."""
        return (np.asarray(computed, dtype=float) - self.value) / self.scatter

    def residual(self, computed: Array | float) -> Array:
        """Signed number whose square is minus twice the log likelihood above its peak: the
        deviation where errors are normal.
        """
        off = self.deviation(computed)
        if self.law == "normal":
            return off
        return np.sign(off) * np.sqrt((self.freedom + 1) * np.log1p(off**2 / self.freedom))

    @property
    def log_peak(self) -> float:
        """Logarithm of the likelihood where computed and measured agree."""
        if self.law == "normal":
            return -math.log(self.scatter * math.sqrt(2 * math.pi))
        half = 0.5 * self.freedom
        return float(
            gammaln(half + 0.5)
            - gammaln(half)
            - 0.5 * math.log(self.freedom * math.pi)
            - math.log(self.scatter)
        )

    def percentile(self, computed: Array, weights: Array) -> float:
        """Where the measured value lies in its own prediction, 0 to 100: over the draws
        ``computed`` with ``weights`` and its errors.
        """
        known = np.isfinite(computed)
        if not known.any() or weights[known].sum() <= 0:
            return math.nan
        below = -self.deviation(computed[known])
        share = ndtr(below) if self.law == "normal" else stdtr(self.freedom, below)
        return float(100.0 * np.average(share, weights=weights[known]))


#: Longest name of a quantity or measurement.
MAX_LENGTH = 80


class Part:
    """The ``table`` at ``where``; every method raises :class:`InputError` with that place."""

    def __init__(self, table: Any, where: str) -> None:
        if not isinstance(table, dict):
            raise InputError(f"is {str(table)[:40]!r}; write a table", where)
        self.table, self.where = table, where
        self.taken: list[str] = []

    def has(self, key: str) -> bool:
        """Whether the key is there."""
        return key in self.table

    def place(self, key: str) -> str:
        """Where a key stands."""
        return f"{self.where}.{key}" if self.where else key

    def take(self, key: str, fallback: Any = None) -> Any:
        """What stands at a key."""
        self.taken.append(key)
        return self.table.get(key, fallback)

    def text(self, key: str, fallback: str | None = None, choices: Sequence[str] = ()) -> str:
        """A text; without a ``fallback`` it must be there."""
        value = self.take(key, fallback)
        if value is None:
            raise InputError(f"is missing; give {key}", self.place(key))
        if not isinstance(value, str):
            raise InputError(f"is {str(value)[:40]!r}; write a text", self.place(key))
        if choices and value not in choices:
            raise InputError(
                f"'{value[:40]}' is unknown; {nearest(value, tuple(choices))}", self.place(key)
            )
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """One text or several."""
        value = self.take(key, [])
        found = [value] if isinstance(value, str) else value
        if not isinstance(found, list) or not all(isinstance(one, str) for one in found):
            raise InputError(
                "holds something else than texts; write one text or a list", self.place(key)
            )
        return tuple(found)

    def truth(self, key: str, fallback: bool) -> bool:
        """True or false."""
        value = self.take(key, fallback)
        if not isinstance(value, bool):
            raise InputError(f"is {str(value)[:40]!r}; write true or false", self.place(key))
        return value

    def plain(self, key: str, fallback: float | None = None) -> float:
        """A plain number."""
        value = self.take(key, fallback)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(
                f"is {'missing' if value is None else str(value)[:40]!r}; write a number",
                self.place(key),
            )
        return float(value)

    def amount(
        self, key: str, unit: str | None = None, fallback: float | None = None
    ) -> tuple[float, str]:
        """A value (SI) and the unit it was written in; ``unit``: one of the dimension that is due,
        None for any.
        """
        value = self.take(key)
        if value is None:
            if fallback is None:
                raise InputError(f"is missing; give {key}", self.place(key))
            return fallback, unit or ""
        text = (
            str(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else value
        )
        return parse_quantity(text, unit, self.place(key)), split_quantity(
            text, unit, self.place(key)
        )[1]

    def amounts(self, key: str, unit: str | None = None) -> tuple[float, ...]:
        """Values (SI) of a row such as ``"0, 5, 10 mm"``."""
        value = self.take(key)
        if value is None:
            raise InputError(f"is missing; give {key}", self.place(key))
        if isinstance(value, list):
            value = [
                str(one) if isinstance(one, (int, float)) and not isinstance(one, bool) else one
                for one in value
            ]
        return parse_quantities(
            str(value) if isinstance(value, (int, float)) else value, unit, self.place(key)
        )

    def parts(self, key: str) -> tuple[tuple[str, Part], ...]:
        """The tables below a key by their names; there must be one or more."""
        found = Part(self.take(key, {}), self.place(key))
        if not found.table:
            raise InputError(f"there is none; write a table [{key}.NAME]", self.place(key))
        for name in found.table:
            if not name.strip() or len(name) > MAX_LENGTH or not name.isprintable():
                raise InputError(f"'{name[:40]}' is no name; write a short word", found.where)
        return tuple(
            (name, Part(table, f"{found.where}.{name[:40]}")) for name, table in found.table.items()
        )

    def finish(self) -> None:
        """Refuse what nobody took."""
        unknown = next((key for key in self.table if key not in self.taken), None)
        if unknown is not None:
            raise InputError(
                f"key '{unknown[:40]}' is unknown; {nearest(unknown, tuple(dict.fromkeys(self.taken)))}",
                self.where,
            )


def same_dimension(unit: str, other: str) -> bool:
    """Whether two units measure the same."""
    return dimension_of(unit) == dimension_of(other)


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
class Target:
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
