"""Doubtful values of the points of a study or search."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.explore.case_paths import vary
from valvetrain.explore.space import Varied
from valvetrain.parameters.case import Case

#: Points whose cases are made again to be counted.
MAX_POINTS = 300


def doubts(
    case: Case | None,
    varied: Sequence[Varied],
    draws: NDArray[np.float64] | Sequence[Sequence[float]],
) -> dict[int, str]:
    """Those of the first :data:`MAX_POINTS` ``draws`` (n, d; SI) that have doubtful values which the case itself has not:
    place -> its first warning. A function has none.

    >>> import valvetrain as vt
    >>> case, height = vt.load_case("vaz-ohc"), Varied("train.springs.nested-cards.0.rate", "N/mm")
    >>> doubts(case, (height,), [[17e3]])
    {}
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
    return found
