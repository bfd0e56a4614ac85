"""Which samples of a cycle are drawn: even steps of the cam, closer around clashes, and every peak."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.report.motion.parts import Array, Places

#: Even steps (cam degrees) tried in turn until they take no more than :data:`EVEN_SHARE` of the frames;
#: beyond the last, as many as that share allows.
STEPS = (0.25, 0.5, 1.0, 2.0)
EVEN_SHARE = 0.8


def choose_frames(cam_angle: Array, most: int, keep: Sequence[int] = (), spans: Sequence[tuple[float, float]] = ()) -> Places:
    """Samples that are drawn, ascending: all where ``most`` allows.

    Parameters
    ----------
    cam_angle : (sample,) rad, ascending from 0 to less than one turn
    most : largest number of frames; what must be kept may exceed it
    keep : samples that stay whatever happens, such as those of peaks
    spans : first and last cam angle (rad) of clashes, most wanted first; every sample inside one is drawn until ``most`` is reached

    Returns
    -------
    Places (frame,) of the samples

    Examples
    --------
    >>> import numpy as np
    >>> turn = np.radians(np.arange(0, 360, 0.5))
    >>> chosen = choose_frames(turn, 300, keep=[347], spans=[(np.radians(100), np.radians(101))])
    >>> 347 in chosen, {200, 201, 202} <= set(chosen.tolist()), len(chosen) <= 300
    (True, True, True)
    """
    count = len(cam_angle)
    if count <= most:
        return np.arange(count)
    chosen = {0, count - 1, *(int(place) for place in keep)}
    chosen |= set(_even(cam_angle, max(1, int(EVEN_SHARE * most))).tolist())
    for first, last in spans:
        inside = np.flatnonzero((cam_angle >= first - 1e-9) & (cam_angle <= last + 1e-9)).tolist()
        room = most - len(chosen)
        if room <= 0:
            break
        new = [place for place in inside if place not in chosen]
        chosen |= set(new if len(new) <= room else new[:: -(-len(new) // room)])
    return np.array(sorted(chosen), dtype=np.int64)


def _even(cam_angle: Array, most: int) -> Places:
    """Samples next to even steps of the cam, no more than ``most``."""
    degrees = np.degrees(cam_angle)
    for step in STEPS:
        wanted = np.arange(0.0, 360.0, step)
        if len(wanted) <= most:
            break
    else:
        wanted = np.linspace(0.0, 360.0, most, endpoint=False)
    right = np.clip(np.searchsorted(degrees, wanted), 1, len(degrees) - 1)
    nearer = np.where(wanted - degrees[right - 1] <= degrees[right] - wanted, right - 1, right)
    return np.unique(nearer)
