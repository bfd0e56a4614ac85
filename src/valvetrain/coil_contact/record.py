"""How finely the contacts of the coils are recorded over time: one rule for every integrator."""

from __future__ import annotations

import math

#: Largest record of one cam revolution (bytes).
MAX_BYTES = 128e6


def contact_spacing(interval: float, time_step: float, steps: int, entries: int) -> int:
    """Steps between two rows of a record of contacts.

    Parameters
    ----------
    interval : float
        Target spacing (s).
    time_step : float
        Step of the integrator (s).
    steps : int
        Steps that are recorded.
    entries : int
        Numbers per row.

    Returns
    -------
    int
        As many as make ``interval``; more where the record would pass :data:`MAX_BYTES`.

    Examples
    --------
    >>> contact_spacing(2e-6, 0.5e-6, 60_000, 90), contact_spacing(2e-6, 0.5e-6, 24_000_000, 90)
    (4, 135)
    """
    return max(1, round(interval / time_step), math.ceil(8.0 * steps * entries / MAX_BYTES))
