"""Sobol indices: which share of an output's variance each varied quantity brings, alone and with
all it acts together with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import MissingExtraError
from valvetrain.explore.outputs import Run

Array = NDArray[np.float64]
#: Resamples behind an interval, and its ends in per cent.
RESAMPLES, ENDS = 1000, (2.5, 97.5)
#: Rows of all resamples together, which bound the memory.
MOST_DRAWN = 10**7
HINT = "Sobol indices need SALib, which is not installed; install the extra: pip install 'valvetrain[studies]'"
#: Base rows below which there is no index; a spread (over the size of the mean) below which there is
#: nothing to explain.
MIN_ROWS, NO_SPREAD = 8, 1e-9
#: Base rows that are recommended where fewer cannot separate quantities.
ENOUGH_ROWS = 64


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Indices of one ``output`` at one ``run`` by varied quantity (d): ``first`` order and
    ``total``, with 95 % intervals (d, 2).

    ``rows``: base rows used; ``dropped``: those left out because a point of them failed.
    """

    output: str
    run: Run
    names: tuple[str, ...]
    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    rows: int
    dropped: int


def sensitivity_of(
    output: str, run: Run, names: Sequence[str], values: Array
) -> Sensitivity | None:
    """Indices from ``values`` of the rows of Saltelli's design (A, B, then A with each column of
    B); nan where a point failed.

    First order by Saltelli et al. (2010), total by Jansen (1999), intervals by bootstrap over the
    base rows, by SALib. None with fewer than :data:`MIN_ROWS` whole base rows. Raises
    :class:`MissingExtraError` without SALib.
    """
    size = len(names)
    parts = values.reshape(size + 2, -1)
    whole = np.all(np.isfinite(parts), axis=0)
    rows = int(np.count_nonzero(whole))
    if rows < MIN_ROWS:
        return None
    indices = {order: np.zeros((size, 3)) for order in ("S1", "ST")}
    by_row = parts[[0, *range(2, size + 2), 1]][:, whole].T  # SALib's order: A, its mixtures, B
    if np.std(by_row) > NO_SPREAD * abs(np.mean(by_row)):
        try:
            from SALib.analyze import sobol
        except ImportError as error:
            raise MissingExtraError(HINT) from error
        problem = {"num_vars": size, "names": list(names), "bounds": [[0.0, 1.0]] * size}
        made = sobol.analyze(
            problem,
            by_row.ravel(),
            calc_second_order=False,
            num_resamples=min(RESAMPLES, max(100, MOST_DRAWN // rows)),
            keep_resamples=True,
            seed=1,
        )
        for order, columns in indices.items():
            ends = np.nanpercentile(made[f"{order}_conf_all"], ENDS, axis=0)
            columns[:] = np.column_stack([made[order], *ends])
    first, total = indices.values()
    return Sensitivity(
        output, run, tuple(names), first[:, 0], total[:, 0], first[:, 1:], total[:, 1:], rows, len(whole) - rows,
    )  # fmt: skip
