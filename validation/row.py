"""Rows of the validation book: a published or closed-form value and the computed one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Kind = Literal["closed form", "published", "recalled", "independent computation", "consistency"]


@dataclass(frozen=True, slots=True)
class Row:
    """``expected`` and ``computed`` in ``unit``; ``tolerance`` in the same unit, with its reason.

    ``kind``: how the expected value is known (``recalled``: confirmed by an independent
    computation, printed source not at hand; ``consistency``: a form of this package's own, so that
    the row shows that two parts agree, not that both are right). ``band``: the values that are
    accepted where a published number is not met for a known reason; ``explanation``: that reason. A
    value outside both fails, and so does a row that states neither.
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
    band: tuple[float, float] | None = None
    explanation: str = ""

    @property
    def difference(self) -> float:
        """Computed less expected value."""
        return self.computed - self.expected

    @property
    def within(self) -> bool:
        """Whether the computed value is within a tolerance that was stated."""
        return math.isfinite(self.tolerance) and abs(self.difference) <= self.tolerance

    @property
    def status(self) -> str:
        """``met``, ``miss (explained)`` or ``FAILS``."""
        if self.within:
            return "met"
        if self.band is None or not self.explanation:
            return "FAILS"
        low, high = self.band
        return "miss (explained)" if low <= self.computed <= high else "FAILS"


@dataclass(frozen=True, slots=True)
class BookCase:
    """A function of the book that returns one or several rows; ``slow`` where it takes more than
    seconds.
    """

    name: str
    rows: Callable[[], list[Row]]
    slow: bool = False


CASES: list[BookCase] = []
#: Text above the table of a topic, requested when its page is written.
NOTES: dict[str, Callable[[], str]] = {}
#: A file next to the page of a topic: its path from the page, and its content, requested likewise.
FILES: dict[str, tuple[str, Callable[[], str]]] = {}


def book_case(
    *, slow: bool = False
) -> Callable[[Callable[[], list[Row]]], Callable[[], list[Row]]]:
    """Decorator: enter a function into the book's one list."""

    def enter(function: Callable[[], list[Row]]) -> Callable[[], list[Row]]:
        CASES.append(BookCase(function.__name__, function, slow))
        return function

    return enter
