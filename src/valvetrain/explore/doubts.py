"""Doubtful values of the points of a study or search, counted and reported once."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.explore.case_paths import vary
from valvetrain.explore.space import Varied
from valvetrain.parameters.case import Case

#: Points whose cases are made again to be counted.
MAX_POINTS = 300


@dataclass(frozen=True)
class Doubts:
    """Which of ``count`` points (from 0) have doubtful values that the case itself has not: point -> its
    first warning.
    """

    by_point: dict[int, str]
    count: int

    def sentence(self, noun: str, remark: str = "") -> str:
        """``16 of 80 designs are doubtful, such as at seat load = 444 N: ...``; empty where none is.
        ``remark``: behind that they are.
        """
        if not self.by_point:
            return ""
        many, first = len(self.by_point), next(iter(self.by_point.values()))
        return f"{many} of {self.count} {noun} {'are' if many > 1 else 'is'} doubtful{remark}, such as {first}"


def doubts(
    case: Case | None,
    varied: Sequence[Varied],
    draws: NDArray[np.float64] | Sequence[Sequence[float]],
) -> Doubts:
    """The doubtful ones of ``draws`` (n, d), SI, up to :data:`MAX_POINTS`; none of a function.

    >>> import valvetrain as vt
    >>> case, height = vt.load_case("vaz-ohc"), Varied("train.springs.nested-cards.0.rate", "N/mm")
    >>> doubts(case, (height,), [[17e3]]).sentence("points")
    ''
    """
    own = list(draws)[:MAX_POINTS]
    found: dict[int, str] = {}
    for point, draw in enumerate(own if case is not None else ()):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                assert case is not None
                vary(case, dict(zip(varied, map(float, draw), strict=True)))
            except InputError:
                continue  # a point that cannot be built is reported as that
        texts = [str(one.message) for one in caught if one.category is UnusualValueWarning]
        if new := [text for text in texts if text.startswith("at ")]:
            found[point] = new[0]
    return Doubts(found, len(own))
