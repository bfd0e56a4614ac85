"""What the stations of a lift can be: their last digit, the turn they lie in, the events they hold, and dust among them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from valvetrain.arrays import Array, Flags, Ints

TURN = 2 * np.pi
#: Share of the largest lift above which an event stands out, and angle (rad) above which it is no dust.
EVENT_SHARE, EVENT_ANGLE = 0.04, np.radians(8)
#: Angle (rad) between two events from which there is a base circle between them.
REST = np.radians(30)
#: Widest dust (rad), window (rad, stations) in which it is looked for, and standard deviations from which it is some.
DUST_ANGLE, WINDOW_ANGLE, MAX_WINDOW, DUST = np.radians(4), np.radians(24), 160, 6.0
#: Least dust, as a share of the lift: where the acceleration of a lobe of arcs jumps, its neighbours foretell it no closer.
DUST_SHARE = 1.5e-3
#: Jerk that lobes have, of peak lift over the cube of half their width, and the angle (rad) over which it changes.
JERK, JERK_ANGLE = 12.0, np.radians(4)


@dataclass(frozen=True, slots=True)
class Dust:
    """Stations that stand out of a smooth lift on one side: first and last cam angle (rad), height (m), number of stations."""

    first: float
    last: float
    height: float
    count: int


def last_digit(lifts: Array) -> float:
    """Step (m) to which lifts are rounded, of mm or inches: the largest of which nine in ten are multiples; 0 for none."""
    values = np.unique(lifts)
    for decade in range(1, 9):
        for unit in (0.0254, 1e-3):
            for part in (5.0, 2.0, 1.0):
                parts = values / (unit * part * 10.0**-decade)
                whole = np.abs(parts - np.round(parts)) < 1e-6 + 1e-13 * np.abs(parts)
                if np.mean(whole) > 0.9 and len(values) > 3:
                    return unit * part * 10.0**-decade
    return 0.0


def runs_of(flags: Flags) -> Ints:
    """First place of each run of true ``flags``, and the place behind its last, shape (runs, 2).

    >>> runs_of(np.array([True, False, True, True])).tolist()
    [[0, 1], [2, 4]]
    """
    edges: Ints = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return edges.reshape(-1, 2)


def base_of(lifts: Array) -> float:
    """Level (m) of the base circle: the median of what is within 4 % of the least lift."""
    return float(np.median(lifts[lifts <= lifts.min() + EVENT_SHARE * np.ptp(lifts)]))


def turned(cam_angles: Array, lifts: Array) -> tuple[Array, Array]:
    """A table of one whole turn, begun where its longest rest is; any other table as it is."""
    step = float(np.median(np.diff(cam_angles)))
    if cam_angles[-1] - cam_angles[0] < TURN - 1.5 * step:
        return cam_angles, lifts
    if cam_angles[-1] - cam_angles[0] > TURN - 0.5 * step:
        cam_angles, lifts = cam_angles[:-1], lifts[:-1]
    high = np.flatnonzero(lifts > lifts.min() + EVENT_SHARE * np.ptp(lifts))
    if not len(high):
        return cam_angles, lifts
    gaps = np.diff([*high, high[0] + len(lifts)])
    place = int(np.argmax(gaps))
    if gaps[place] <= gaps[-1] + 1:
        place = len(gaps) - 1
    if place < len(gaps) - 1 or min(high[0], len(lifts) - 1 - high[-1]) * step < REST:
        begin = int(high[place] + gaps[place] // 2) % len(lifts)
        late = 2 * begin > len(lifts)
        cam_angles = np.concatenate(
            [cam_angles[begin:] - late * TURN, cam_angles[:begin] + (not late) * TURN]
        )
        lifts = np.roll(lifts, -begin)
    if gaps[place] * step < REST:  # the last event ends where the first begins
        cam_angles, lifts = np.append(cam_angles, cam_angles[0] + TURN), np.append(lifts, lifts[0])
    return cam_angles, lifts


def events_of(cam_angles: Array, lifts: Array) -> list[slice]:
    """The stations of each event: of all rises above the base circle that are too wide for dust."""
    runs = [
        (int(begin), int(end))
        for begin, end in runs_of(lifts > base_of(lifts) + EVENT_SHARE * np.ptp(lifts))
        if cam_angles[end - 1] - cam_angles[begin] > EVENT_ANGLE
    ]
    cuts = [(before[1] + after[0]) // 2 for before, after in pairwise(runs)]
    begins, ends = [0, *cuts], [*(cut + 1 for cut in cuts), len(lifts)]
    return [slice(*one) for one in zip(begins, ends, strict=True)]


def dust_of(cam_angles: Array, lifts: Array) -> tuple[Dust, ...]:
    """Bumps of one to many stations, up to 4 deg wide, which a smooth lift does not have.

    Every block of stations is compared with what those around it foretell: a lift whose jerk is white noise of the size that
    lobes have, and the noise of a station (leave-out residuals of a Gaussian process: Rasmussen and Williams 2006, eq. 5.12).
    """
    step = float(np.median(np.diff(cam_angles)))
    count = min(round(WINDOW_ANGLE / step), MAX_WINDOW, len(lifts))
    if count < 12:
        return ()
    rounding = last_digit(lifts)
    rough, high = (
        np.abs(np.diff(lifts, 4)),
        lifts[2:-2] > base_of(lifts) + EVENT_SHARE * np.ptp(lifts),
    )
    # of a base circle that is exactly zero nothing is learned
    noise = (
        1.4826
        / np.sqrt(70)
        * max(float(np.median(part)) for part in (rough, rough[high]) if len(part))
    )
    noise = max(noise, rounding / np.sqrt(12), 1e-7)
    wide = float(np.count_nonzero(lifts > base_of(lifts) + np.ptp(lifts) / 2)) * step
    jerk = JERK * float(np.ptp(lifts)) / max(wide, step) ** 3
    widths = [
        one
        for one in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
        if (one - 1) * step <= DUST_ANGLE and 3 * one < count
    ]
    height, edge = np.zeros(len(lifts)), count // 6
    for begin in sorted({*range(0, len(lifts) - count, count // 2), len(lifts) - count}):
        window = slice(begin, begin + count)
        alike = _covariance(cam_angles[window] - cam_angles[begin], noise, jerk**2 * JERK_ANGLE)
        out = _standing_out(
            alike,
            lifts[window],
            widths,
            max(DUST * noise, 2 * rounding, DUST_SHARE * float(np.ptp(lifts))),
        )
        # at the edges the next window knows more
        inner = slice(edge * (begin > 0), count - edge * (begin + count < len(lifts)))
        height[window][inner] = np.maximum(height[window][inner], out[inner])
    return tuple(
        Dust(
            float(cam_angles[first]),
            float(cam_angles[last - 1]),
            float(height[first:last].max()),
            int(last - first),
        )
        for first, last in runs_of(height > 0)
    )


def _covariance(cam_angles: Array, noise: float, density: float) -> Array:
    """Covariance of stations (rad from the first): noise, a lift whose jerk has that density, and any parabola."""
    low = np.minimum(cam_angles[:, None], cam_angles)
    apart = np.abs(cam_angles[:, None] - cam_angles)
    # integral of (a - t)^2 (b - t)^2 / 4 from 0 to the lower of both
    jerk = low**5 / 20 + low**4 * apart / 8 + low**3 * apart**2 / 12
    parabola = np.vander(cam_angles / cam_angles[-1], 3)
    found: Array = (
        density * jerk + noise**2 * np.eye(len(cam_angles)) + 1e-4 * parabola @ parabola.T
    )
    return found


def _standing_out(alike: Array, lifts: Array, widths: list[int], least: float) -> Array:
    """Height (m) of each station above what the others foretell, zero where it does not stand out."""
    inverse, count = np.linalg.inv(alike), len(lifts)
    lifts = lifts - lifts[0]
    pulls, marked = inverse @ lifts, np.zeros(count, dtype=bool)
    for _ in range(count // 3):  # the clearest block first, the next without it
        best, clearest = slice(0), 0.0
        for width in widths:
            places = np.arange(width) + np.arange(count - width + 1)[:, None]
            places = places[~marked[places].any(axis=1)]
            blocks, pull = inverse[places[:, :, None], places[:, None, :]], pulls[places]
            apart = np.linalg.solve(blocks, pull[..., None])[..., 0]
            gain = np.einsum("ij,ij->i", apart, pull) - DUST**2 * (3 + width) / 4
            gain[(apart.min(axis=1) < least / 3) | (apart.max(axis=1) < least)] = 0.0
            if len(gain) and gain.max() > clearest:
                clearest, first = float(gain.max()), int(places[np.argmax(gain), 0])
                best = slice(first, first + width)
        if not clearest:
            break
        left = np.linalg.solve(inverse[best, best], inverse[best])
        pulls, inverse, marked[best] = (
            pulls - left.T @ pulls[best],
            inverse - inverse[:, best] @ left,
            True,
        )
    # a second look: a station next to dust may have been taken with it, or have been left
    marked[1:] |= marked[:-1].copy()
    marked[:-1] |= marked[1:].copy()
    clean = ~marked
    foretold = np.linalg.solve(
        alike[np.ix_(clean, clean)], np.column_stack([lifts[clean], alike[np.ix_(clean, marked)]])
    )
    across = alike[np.ix_(marked, clean)]
    apart = lifts[marked] - across @ foretold[:, 0]
    spread = np.sqrt(np.diagonal(alike)[marked] - np.einsum("ij,ji->i", across, foretold[:, 1:]))
    height = np.zeros(count)
    height[marked] = np.where(apart > np.maximum(least / 3, DUST / 2 * spread), apart, 0.0)
    return height
