"""Sobol indices: which share of an output's variance each varied quantity brings, alone and with
all it acts together with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.outputs import Run
from valvetrain.solution.definition import label_of

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

    ``rows``: base rows used; ``dropped``: those left out because a point of them failed;
    ``sentence``: which quantity makes the spread.
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
    sentence: str


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
    sentence = verdict(output, names, total, intervals[1], retained[:2])
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
        sentence,
    )


def indices(parts: Array) -> tuple[Array, Array]:
    """First-order and total indices (d) of outputs ``parts`` (d + 2, n)."""
    centred = parts - np.mean(parts[:2])
    a, b, mixed = centred[0], centred[1], centred[2:]
    variance = np.var(centred[:2])
    if not variance > 0:
        return np.zeros(len(mixed)), np.zeros(len(mixed))
    return np.mean(b * (mixed - a), axis=1) / variance, 0.5 * np.mean(
        (a - mixed) ** 2, axis=1
    ) / variance


def verdict(output: str, names: Sequence[str], total: Array, interval: Array, base: Array) -> str:
    """One sentence: the quantity that makes the spread of an output, those that cannot be
    separated, or that there is none.
    """
    label = label_of(output)
    if not np.std(base) > NO_SPREAD * max(abs(float(np.mean(base))), 1e-300):
        return f"None of the varied quantities moves the {label}."
    order = np.argsort(-total)
    leader = int(order[0])
    rivals = [int(index) for index in order[1:] if interval[index, 1] >= interval[leader, 0]]

    def share(index: int) -> str:
        return f"{names[index]} ({100 * total[index]:.0f} %, {100 * interval[index, 0]:.0f} to {100 * interval[index, 1]:.0f})"

    if rivals:
        reported = ", ".join(share(index) for index in (leader, *rivals[:3]))
        rows = base.shape[1]
        more = (
            f" by {rows} base rows; count = {ENOUGH_ROWS * (len(names) + 2)} gives {ENOUGH_ROWS}"
            if rows < ENOUGH_ROWS
            else ""
        )
        return f"No single quantity makes the spread of the {label}: the shares of {reported} cannot be separated{more}."
    second = f"; next is {share(int(order[1]))}" if len(order) > 1 else ""
    return f"What makes the spread of the {label} is {share(leader)} of its variance{second}."
