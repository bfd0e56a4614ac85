"""Quantities: keys of named numbers by run, and a mapping of them."""

from __future__ import annotations

from collections.abc import ItemsView, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError, UnknownNameError
from valvetrain.solution.definition import definition_of
from valvetrain.solution.display import frame, table, value_text
from valvetrain.units import Given, keep_si, si

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, slots=True)
class Quantity:
    """A named scalar: ``engine_speed`` of the crank (rad/s, "5600 rpm", pint; None where none
    applies) and ``label`` of the run.

    >>> Quantity("peak_seat_force", "2000 rpm", "massless").unit
    'N'
    """

    name: str
    engine_speed: float | None = None
    label: str = ""

    if TYPE_CHECKING:  # arguments may have other types than the fields

        def __init__(
            self, name: str, engine_speed: Given | None = None, label: str = ""
        ) -> None: ...

    def __post_init__(self) -> None:
        keep_si(self, f"quantity '{self.name}'", engine_speed="angular speed")

    @property
    def unit(self) -> str:
        """SI unit."""
        return unit_of(self.name)


def unit_of(name: str) -> str:
    """SI unit of a quantity as the table of quantities has it; ``1`` for plain numbers."""
    return definition_of(name).si_unit


class Quantities(Mapping[Quantity, float]):
    """Read-only mapping of :class:`Quantity` to SI values; a plain name is a key where it is
    unique: ``quantities["preload"]``.

    Raises :class:`KeyError` for what was not computed and :class:`InputError` for a name that
    several runs gave and for a slip of units.

    >>> quantities = Quantities({Quantity("preload"): 301.5, Quantity("peak_seat_force", 586.43, "massless"): 820.0})
    >>> quantities["preload"]
    301.5
    >>> quantities
    Quantities: 2 values of 2 names
      preload 301.5 N
      peak_seat_force 820 N (massless, 5600 rpm)
    """

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[Quantity, float] = {}) -> None:
        self._values = dict(values)

    def __getitem__(self, key: Quantity | str) -> float:
        if isinstance(key, Quantity):
            if key in self._values:
                return self._values[key]
            near = (one for one in self._values if (one.name, one.label) == (key.name, key.label))
            same = next(
                (one for one in near if same_speed(one.engine_speed, key.engine_speed)), key
            )
            # A speed that no run has may be a slip of units.
            if same not in self._values and key.engine_speed is not None:
                si(key.engine_speed, "engine_speed", f"quantity '{key.name}'")
            return self._values[same]
        found = [one for one in self._values if one.name == key]
        if len(found) == 1:
            return self._values[found[0]]
        if not found:
            raise UnknownNameError(key, (one.name for one in self._values))
        runs = ", ".join(
            f"{one.label} at {(one.engine_speed or 0.0) * 9.549296585513721:.6g} rpm"
            for one in found[:4]
        )
        raise InputError(
            f"'{key}' was computed {len(found)} times ({runs}); use Quantity(name, engine_speed, label), or use of_run()"
        )

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self._values)

    def items(self) -> ItemsView[Quantity, float]:
        """Keys with their values."""
        return self._values.items()

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        lines = [
            f"Quantities: {len(self._values)} values of {len({key.name for key in self._values})} names"
        ]
        for key in list(self._values)[:4]:
            run = _run_text(key)
            lines.append(
                f"{key.name} {value_text(self._values[key], key.unit)}{f' ({run})' if run else ''}"
            )
        return "\n  ".join(
            [*lines, f"and {len(self._values) - 4} more"] if len(self._values) > 4 else lines
        )

    def _repr_html_(self) -> str:
        rows = [
            (key.name, _run_text(key), value_text(value, key.unit))
            for key, value in self._values.items()
        ]
        return table(repr(self).partition("\n")[0], ("quantity", "run", "value"), rows)

    def to_pandas(self) -> pandas.DataFrame:
        """One row per value (SI): quantity, label, engine_speed (rpm of the crank, missing where
        none applies), value, unit.
        """
        keys = list(self._values)
        columns: dict[str, ArrayLike] = {
            "quantity": [key.name for key in keys], "label": [key.label for key in keys],
            "engine_speed": np.round([np.nan if key.engine_speed is None else key.engine_speed * 30 / np.pi for key in keys], 6),
            "value": np.array(list(self._values.values()), dtype=float), "unit": [key.unit for key in keys],
        }  # fmt: skip
        return frame(columns, units={"engine_speed": "rpm"})

    def __reduce__(self) -> tuple[object, ...]:
        return Quantities, (self._values,)

    def at_rest(self, label: str | None = None) -> dict[str, float]:
        """Name -> value of what has no engine speed, of one ``label`` where given."""
        return {
            key.name: value
            for key, value in self._values.items()
            if key.engine_speed is None and label in (None, key.label)
        }

    def of_run(self, label: str, engine_speed: Given) -> dict[str, float]:
        """Name -> value of the run of ``label`` at ``engine_speed`` (of the crank: rad/s, "5600
        rpm" or a pint quantity).
        """
        mine = {
            key: value
            for key, value in self._values.items()
            if key.label == label and key.engine_speed is not None
        }
        known = (key.engine_speed for key in self._values if key.engine_speed is not None)
        speed = known_speed(engine_speed, known)
        return {
            key.name: value for key, value in mine.items() if same_speed(key.engine_speed, speed)
        }


def _run_text(key: Quantity) -> str:
    return ", ".join(
        filter(None, (key.label, value_text(key.engine_speed, "rad/s") if key.engine_speed else ""))
    )


def known_speed(given: Given, known_speeds: Iterable[float]) -> float:
    """A crank speed (rad/s) by :func:`valvetrain.units.si`; an SI number that is one of those
    ``known_speeds`` is always valid.
    """
    if not isinstance(given, str) and not hasattr(given, "to_base_units"):
        own = next((speed for speed in known_speeds if same_speed(speed, float(given))), None)
        if own is not None:
            return own
    return si(given, "engine_speed", "engine_speed")


def same_speed(first: float | None, other: float | None) -> bool:
    """Whether two crank speeds (rad/s) are equal but for rounding; None equals None only."""
    if first is None or other is None:
        return first is other
    return abs(first - other) <= 1e-7 * max(abs(first), abs(other))
