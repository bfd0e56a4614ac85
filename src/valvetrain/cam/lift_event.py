"""The lifting part of a table of lifts, between its stations on the base circle."""

from __future__ import annotations

import math
from itertools import pairwise

from valvetrain.errors import InputError


def event_of_table(
    cam_angles: tuple[float, ...], lifts: tuple[float, ...], threshold: float = 0.0
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The lifting part of a table, from the last station of zero lift before it to the first after it.

    Lifts up to ``threshold`` (m) count as zero. A table over a whole revolution may start within the event. Raises
    :class:`InputError` when the table has no base circle on both sides, or no lift.
    """
    angles, lifted = cam_angles, [lift > threshold for lift in lifts]
    if not any(lifted):
        raise InputError("the table holds no lift above its base circle; check the unit and the smoothing")
    turn = 2 * math.pi
    gap, widest = angles[0] + turn - angles[-1], max(late - early for early, late in pairwise(angles))
    if (lifted[0] or lifted[-1]) and gap < 1.01 * widest:
        start = _middle_of_longest_rest(lifted)
        whole = angles[-1] - angles[0] > turn - 1e-6
        first, last = angles[start:], [angle + turn for angle in angles[int(whole) : start + 1]]
        angles, lifts = (*first, *last), (*lifts[start:], *lifts[int(whole) : start + 1])
        lifted = [lift > threshold for lift in lifts]
    if lifted[0] or lifted[-1]:
        raise InputError("a lift table must begin and end on the base circle; add stations of zero lift on both sides")
    begin, end = lifted.index(True) - 1, len(lifted) - lifted[::-1].index(True)
    return tuple(angles[begin : end + 1]), (0.0, *lifts[begin + 1 : end], 0.0)


def _middle_of_longest_rest(lifted: list[bool]) -> int:
    best, best_length, length = -1, 0, 0
    for index, up in enumerate([*lifted, True]):
        if up and length > best_length:
            best, best_length = index - 1 - length // 2, length
        length = 0 if up else length + 1
    if best < 0:
        raise InputError("the lift table never rests on the base circle; add stations of zero lift")
    return best
