"""The compiled part of the search for clashes: a resting contact is thousands of samples long, and
each is evaluated 17 times.
"""

from __future__ import annotations

import numpy as np

from valvetrain.compiled import njit


@njit(cache=True, nogil=True)
def hardest_impact(area, pad, count, reach, lengths):
    """Largest impulse (N s) beyond the holding force, over ``count`` begins and ``lengths`` (shares
    of ``reach`` steps).

    ``area`` (pad + count + 2 pad,): integral of the force (N s) at every step, level before and
    after. See :func:`clash.impact_impulse`.
    """
    back = int(np.floor(-reach))
    back_share = -reach - back
    before, best = np.empty(count), np.zeros(count)
    closed, far = area[pad : pad + count], area[pad + back : pad + back + count + 1]
    for place in range(count):
        before[place] = closed[place] - (
            far[place] * (1 - back_share) + far[place + 1] * back_share
        )
    for share in lengths:
        on, over = share * reach, (1 + share) * reach
        whole, after = int(np.floor(on)), int(np.floor(over))
        on, over = on - whole, over - after
        near, beyond = (
            area[pad + whole : pad + whole + count + 1],
            area[pad + after : pad + after + count + 1],
        )
        for place in range(count):  # without a branch, so that several places are done at a time
            ended = near[place] * (1 - on) + near[place + 1] * on
            held = beyond[place] * (1 - over) + beyond[place + 1] * over - ended
            given = (
                ended - closed[place] - (held if held > before[place] else before[place]) * share
            )
            best[place] = given if given > best[place] else best[place]
    return best.max()
