"""A table of a TOML file, read key by key with the location of every refusal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.units import dimension_of, parse_quantities, parse_quantity
from valvetrain.units.text import split_quantity

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
        """Path of a key."""
        return f"{self.where}.{key}" if self.where else key

    def take(self, key: str, fallback: Any = None) -> Any:
        """The value of a key."""
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
        """Refuse keys that were not read."""
        unknown = next((key for key in self.table if key not in self.taken), None)
        if unknown is not None:
            raise InputError(
                f"key '{unknown[:40]}' is unknown; {nearest(unknown, tuple(dict.fromkeys(self.taken)))}",
                self.where,
            )


def same_dimension(unit: str, other: str) -> bool:
    """Whether two units measure the same."""
    return dimension_of(unit) == dimension_of(other)
