"""Named numbers: the key under which a computed value meets a published one, and a mapping of them that is easy to ask."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from valvetrain.errors import InputError
from valvetrain.solution.definition import definition_of


@dataclass(frozen=True, slots=True)
class Quantity:
    """A named scalar: ``engine_speed`` in rad/s of the crank (None where none applies), ``label`` of the run (empty where none applies)."""

    name: str
    engine_speed: float | None = None
    label: str = ""

    @property
    def unit(self) -> str:
        """SI unit."""
        return unit_of(self.name)


def unit_of(name: str) -> str:
    """SI unit of a quantity as the table of quantities has it; ``1`` for plain numbers."""
    return definition_of(name).si_unit


def named(values: Mapping[str, float], engine_speed: float | None, label: str) -> dict[Quantity, float]:
    """Plain names made :class:`Quantity` of one run."""
    return {Quantity(name, engine_speed, label): value for name, value in values.items()}


class Quantities(Mapping[Quantity, float]):
    """Read-only mapping of :class:`Quantity` to SI values; a plain name serves where it is unique: ``quantities["preload"]``."""

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[Quantity, float] = {}) -> None:
        self._values = dict(values)

    def __getitem__(self, key: Quantity | str) -> float:
        if isinstance(key, Quantity):
            return self._values[key]
        found = [one for one in self._values if one.name == key]
        if len(found) == 1:
            return self._values[found[0]]
        if not found:
            raise KeyError(key)
        runs = ", ".join(f"{one.label} at {(one.engine_speed or 0.0) * 9.549296585513721:.6g} rpm" for one in found[:4])
        raise InputError(f"'{key}' was computed {len(found)} times ({runs}); ask with Quantity(name, engine_speed, label), or use of_run()")

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"Quantities({len(self._values)} of {len({key.name for key in self._values})} names)"

    def __reduce__(self):
        return Quantities, (self._values,)

    def at_rest(self, label: str | None = None) -> dict[str, float]:
        """Name -> value of what has no engine speed, of one ``label`` where given."""
        return {key.name: value for key, value in self._values.items() if key.engine_speed is None and label in (None, key.label)}

    def of_run(self, label: str, engine_speed: float) -> dict[str, float]:
        """Name -> value of the run of ``label`` at ``engine_speed`` (rad/s of the crank)."""
        mine = ((key, value) for key, value in self._values.items() if key.label == label)
        return {key.name: value for key, value in mine if key.engine_speed is not None and same_speed(key.engine_speed, engine_speed)}


def same_speed(one: float | None, other: float | None) -> bool:
    """Whether two crank speeds (rad/s) are the same but for rounding; None is the same as None only."""
    if one is None or other is None:
        return one is other
    return abs(one - other) <= 1e-7 * max(abs(one), abs(other))
