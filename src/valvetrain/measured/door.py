"""Doubts about what was read: whether the outcome of a reading is possible at all."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Doubt:
    """Why a file hardly says what was read from it: the ``code`` of the finding that shows it, ``what``
    is odd and ``where``, and the ``step`` that settles it.

    >>> str(Doubt("Z104", "the rate falls", "table.csv", "check the zero of the scale"))
    'table.csv: the rate falls; check the zero of the scale'
    """

    code: str
    what: str
    where: str
    step: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}; {self.step}"
