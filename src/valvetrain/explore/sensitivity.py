"""Sobol indices: which share of an output's variance each varied quantity brings, alone and with
all it acts together with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.outputs import Run

Array = NDArray[np.float64]
#: Resamples behind an interval, and its ends in per cent.
RESAMPLES, ENDS = 1000, (2.5, 97.5)
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

    @property
    def leaders(self) -> tuple[str, ...]:
        """The quantity with the largest total share, behind it those whose intervals reach its own; none where nothing
        moves the output.
        """
        order = np.argsort(-self.total)
        if not self.total[order[0]] > 0:
            return ()
        least = self.total_interval[order[0], 0]
        near = [k for k in order[1:] if self.total_interval[k, 1] >= least]
        return tuple(self.names[k] for k in (order[0], *near))


def sensitivity_of(
    output: str, run: Run, names: Sequence[str], values: Array, seed: int = 1
) -> Sensitivity | None:
    """Indices from ``values`` of the rows of Saltelli's design (A, B, then A with each column of
    B); nan where a point failed.

    First order by Saltelli et al. (2010), total by Jansen (1999), intervals by bootstrap over the
    base rows. None with fewer than
    :data:`MIN_ROWS` whole base rows.
    """
    size = len(names)
    parts = values.reshape(size + 2, -1)
    whole = np.all(np.isfinite(parts), axis=0)
    retained = parts[:, whole]
    if retained.shape[1] < MIN_ROWS:
        return None
    first, total = indices(retained)
    generator, drawn = np.random.default_rng(seed), np.empty((RESAMPLES, 2, size))
    for index in range(RESAMPLES):
        drawn[index] = indices(
            retained[:, generator.integers(0, retained.shape[1], retained.shape[1])]
        )
    low, high = (np.nanpercentile(drawn, end, axis=0) for end in ENDS)
    intervals = [np.stack([low[kind], high[kind]], axis=1) for kind in (0, 1)]
    return Sensitivity(
        output,
        run,
        tuple(names),
        first,
        total,
        intervals[0],
        intervals[1],
        retained.shape[1],
        int(np.count_nonzero(~whole)),
    )


def indices(parts: Array) -> tuple[Array, Array]:
    """First-order and total indices (d) of outputs ``parts`` (d + 2, n)."""
    centred = parts - np.mean(parts[:2])
    a, b, mixed = centred[0], centred[1], centred[2:]
    variance = np.var(centred[:2])
    if not np.sqrt(variance) > NO_SPREAD * max(abs(float(np.mean(parts[:2]))), 1e-300):
        return np.zeros(len(mixed)), np.zeros(len(mixed))
    return np.mean(b * (mixed - a), axis=1) / variance, 0.5 * np.mean(
        (a - mixed) ** 2, axis=1
    ) / variance
