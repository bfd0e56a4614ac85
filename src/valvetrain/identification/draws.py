"""What a method hands on: weighted points that stand for the posterior, and how it was found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import MissingExtraError

Array = NDArray[np.float64]
#: Told the share done and what was done.
Report = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class Draws:
    """Points ``work`` (n, quantities) with ``weights`` (n) of sum one, and where known the
    logarithm of the evidence and its error.

    ``evidence_kind``: how the evidence was found. ``whole``: False where the search was cut short;
    ``notes``: what a reader should know.
    """

    work: Array
    weights: Array
    log_evidence: float = np.nan
    evidence_error: float = np.nan
    evidence_kind: str = ""
    whole: bool = True
    notes: tuple[str, ...] = ()

    @property
    def effective(self) -> float:
        """Number of equally weighted draws that tell as much (Kish)."""
        return float(1.0 / np.sum(self.weights**2))


def quietly(steps: Iterable[Any]) -> Iterator[Any]:
    """The steps of a library that prints where it is interrupted: standard output belongs to the
    answer.
    """
    ahead, end = iter(steps), object()
    while True:
        with redirect_stdout(StringIO()):
            step = next(ahead, end)
        if step is end:
            return
        yield step


def extra(package: str) -> MissingExtraError:
    """The error of a package of the extra ``studies`` that is not installed."""
    return MissingExtraError(
        f"{package} is not installed; install it with pip install 'valvetrain[studies]'"
    )


def silent(done: float, text: str) -> None:
    """A report that goes nowhere."""
