"""One row of the validation book: a published or closed-form value beside the computed one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Kind = Literal["closed form", "published", "recalled", "independent computation"]


@dataclass(frozen=True, slots=True)
class Row:
    """``expected`` and ``computed`` in ``unit``; ``tolerance`` in the same unit, with the reason for it.

    ``kind``: how the expected value is known (``recalled``: confirmed by an independent computation, printed source not at hand).
    ``expected_miss``: why a published number is not met; such a row is shown and does not fail. ``at_most``: only more is a miss.
    """

    topic: str
    name: str
    source: str
    inputs: str
    expected: float
    computed: float
    unit: str
    tolerance: float
    reason: str
    kind: Kind = "closed form"
    expected_miss: str = ""

    @property
    def difference(self) -> float:
        """Computed less expected value."""
        return self.computed - self.expected

    @property
    def within(self) -> bool:
        """Whether the computed value lies within the tolerance."""
        return abs(self.difference) <= self.tolerance

    @property
    def status(self) -> str:
        """``met``, ``miss (explained)`` or ``FAILS``."""
        if self.within:
            return "met"
        return "miss (explained)" if self.expected_miss else "FAILS"


@dataclass(frozen=True, slots=True)
class BookCase:
    """A function of the book that answers one or several rows, and whether it takes more than seconds."""

    name: str
    rows: Callable[[], list[Row]]
    slow: bool = False


CASES: list[BookCase] = []


def book_case(*, slow: bool = False) -> Callable[[Callable[[], list[Row]]], Callable[[], list[Row]]]:
    """Decorator: enter a function into the book's one list."""

    def enter(function: Callable[[], list[Row]]) -> Callable[[], list[Row]]:
        CASES.append(BookCase(function.__name__, function, slow))
        return function

    return enter
