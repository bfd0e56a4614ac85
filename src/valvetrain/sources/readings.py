"""How a published study reads numbers from results: a reading is data, and each kind is a function.

Here are the kinds that read one channel over a cycle; :mod:`valvetrain.sources.reader` has those that
need more, and takes the readings of a run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass as table

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.schema_types import Angle, Frequency
from valvetrain.quantities.cycle import Cycle
from valvetrain.quantities.signal import (
    Index,
    Window,
    low_pass,
    prominences,
    prominent_peaks,
    separate_spikes,
)
from valvetrain.sources.rows import angle_of

Numbers = dict[str, float]
Kind = Literal[
    "extreme", "end", "numbered peaks", "two maxima", "spike", "separate peaks", "rebound", "difference", "over phases", "spike shape",
    "at contact", "meetings", "interval", "bounce", "run", "rise",
]  # fmt: skip
#: A table of a study's file has no other keys.
KNOWN_KEYS = ConfigDict(extra="forbid")


@table(frozen=True, config=KNOWN_KEYS)
class Reading:
    """How the quantities ``names`` are read, in SI units; ``kind`` names a function.

    ``channel``: the first of these that the run has, over the cycle or within ``window``; with a ``point``
    at its place on the wire. ``below``, ``above``: the band (Hz) it is read in; ``smooth``: the band (Hz)
    in which maxima are sought; ``highest``: the highest instant of each interval; ``sampled``: at the
    samples of the study; ``with_angle``: its cam angle too; ``factor``: what the value is multiplied by.
    ``pick``: which extreme. ``share`` and ``height``: least prominence and height of a peak as shares of the
    range, ``later_share``: prominence of the next one; ``reach`` (rad) about a peak. ``between``: two coil
    numbers. ``of``: quantities or channels it is made of; ``runs``: labels of the runs that it belongs to.
    """

    kind: Kind
    names: tuple[str, ...]
    channel: tuple[str, ...] = ("seat_force",)
    window: Window | None = None
    point: str = ""
    below: Frequency = 0.0
    above: Frequency = 0.0
    smooth: Frequency = 0.0
    highest: bool = False
    sampled: bool = False
    with_angle: bool = False
    factor: float = 1.0
    pick: Literal["largest", "smallest", "size", "range"] = "largest"
    share: float = 0.0
    height: float = 0.0
    later_share: float = 0.0
    reach: Angle = 0.0
    between: tuple[float, ...] = ()
    of: tuple[str, ...] = ()
    runs: tuple[str, ...] = ()

    def number(self, place: int, value: float, cam_angle: float) -> Numbers:
        """The value of the name at ``place``, with its cam angle (rad) where that is read."""
        name = self.names[place]
        angle = {angle_of(name): float(cam_angle)} if self.with_angle else {}
        return {name: self.factor * float(value), **angle}


@dataclass(frozen=True, eq=False)
class View:
    """What a reading sees: ``values`` (sample,) of a channel over a cycle, the samples ``inside`` its window,
    the window's ``end`` and the least distance of two collisions, ``separation`` (rad).
    """

    cycle: Cycle
    values: Array
    inside: Index
    end: float
    separation: float

    @property
    def part(self) -> Array:
        """Values within the window."""
        return self.values[self.inside]


def extreme(view: View, reading: Reading) -> Numbers:
    """The largest or smallest value of the window, the largest size, or the range of all."""
    part = np.abs(view.part) if reading.pick == "size" else view.part
    if reading.pick == "range":
        return {reading.names[0]: float(np.ptp(part))}
    place = int(np.argmin(part) if reading.pick == "smallest" else np.argmax(part))
    return reading.number(0, part[place], view.cycle.cam_angle[view.inside[place]])


def end_value(view: View, reading: Reading) -> Numbers:
    """The value at the end of the window."""
    return reading.number(0, np.interp(view.end, view.cycle.cam_angle, view.values), view.end)


def numbered_peaks(view: View, reading: Reading) -> Numbers:
    """Cam angles of the peaks of the window that rise by a share of its range, in order."""
    # A cycle seen twice gives a peak next to 0 degrees a left side as well.
    whole, count = view.cycle.whole, len(view.values)
    twice = np.concatenate((view.values, view.values)) if whole else view.values
    peaks = prominent_peaks(twice, max(reading.share * float(np.ptp(view.part)), 1e-12))
    angles = view.cycle.cam_angle[np.intersect1d(peaks % count, view.inside)]
    return numbered(reading.names[0], angles)


def numbered(template: str, values: Array) -> Numbers:
    """Values by the names of a template, counted from 1.

    >>> numbered("clash_{n}_cam_angle", np.array([0.5, 2.0]))
    {'clash_1_cam_angle': 0.5, 'clash_2_cam_angle': 2.0}
    """
    return {template.format(n=n): float(value) for n, value in enumerate(values, start=1)}


def two_maxima(view: View, reading: Reading) -> Numbers:
    """The two most prominent maxima of the window and the valley between; nothing for one maximum.

    They are sought below a frequency, for a clash next to one would be taken for the other; each
    height is the extreme sample within reach.
    """
    try:
        time = view.cycle.cam_angle / (view.cycle.solution.engine_speed / 2)
        slow = low_pass(time, view.values, reading.smooth, closed=view.cycle.whole)[view.inside]
    except (InputError, ZeroDivisionError):
        return {}
    spread = float(np.ptp(slow))
    peaks = prominent_peaks(slow, max(reading.share * spread, 1e-12))
    peaks = peaks[slow[peaks] > float(slow.min()) + reading.height * spread]
    if len(peaks) < 2:
        return {}
    first, second = sorted(peaks[np.argsort(-prominences(slow, peaks))[:2]].tolist())
    valley = first + int(np.argmin(slow[first : second + 1]))
    found, angle = Numbers(), view.cycle.cam_angle[view.inside]
    for place, index in enumerate((first, valley, second)):
        near = view.part[np.abs(angle - angle[index]) <= reading.reach + 1e-9]
        height = np.min(near) if index == valley else np.max(near)
        found |= reading.number(place, height, angle[index])
    return found


def spike_index(view: View, reading: Reading) -> int:
    """Sample of the largest maximum of the window; without one, of its largest value.

    A maximum, not the largest value, for a flank may reach into the window.
    """
    peaks = prominent_peaks(view.part, max(reading.share * float(np.ptp(view.values)), 1e-12))
    best = peaks[np.argmax(view.part[peaks])] if len(peaks) else int(np.argmax(view.part))
    return int(view.inside[best])


def spike(view: View, reading: Reading) -> Numbers:
    """The spike of the window, and the cam angle of the highest spike of a later collision."""
    top = spike_index(view, reading)
    found = reading.number(0, view.values[top], view.cycle.cam_angle[top])
    first = float(view.cycle.cam_angle[top]) + view.separation
    later = view.inside[view.cycle.cam_angle[view.inside] >= first - 1e-9]
    if len(reading.names) < 2 or len(later) < 3:
        return found
    part = view.values[later]
    rise = reading.later_share * float(view.values[top] - np.median(part))
    peaks = prominent_peaks(part, max(rise, 1e-12))
    if len(peaks):
        found[reading.names[1]] = float(view.cycle.cam_angle[later[peaks[np.argmax(part[peaks])]]])
    return found


def separate_peaks(view: View, reading: Reading) -> Numbers:
    """The values of largest size, signed, each of another collision; as many as there are names."""
    spikes = separate_spikes(view.cycle.cam_angle, np.abs(view.values), view.separation, 0.0)
    found = Numbers()
    for place, index in zip(range(len(reading.names)), spikes, strict=False):
        found |= reading.number(place, view.values[index], view.cycle.cam_angle[index])
    return found


def rebound(view: View, reading: Reading) -> Numbers:
    """The first maximum after the smallest value of the window, the time (s) between, and the extremes after it."""
    lowest = int(view.inside[int(np.argmin(view.part))])
    falling = np.flatnonzero(np.diff(view.values[lowest:]) < 0)
    if len(falling) == 0:
        return {}
    highest = lowest + int(falling[0])
    late, time = view.values[highest:], view.cycle.time
    found = reading.number(0, view.values[highest], view.cycle.cam_angle[highest])
    rest = (time[highest] - time[lowest], np.min(late), np.max(late))
    return found | dict(zip(reading.names[1:], map(float, rest), strict=True))


#: Kind -> function of what a reading sees.
KINDS: dict[str, Callable[[View, Reading], Numbers]] = {
    "extreme": extreme,
    "end": end_value,
    "numbered peaks": numbered_peaks,
    "two maxima": two_maxima,
    "spike": spike,
    "separate peaks": separate_peaks,
    "rebound": rebound,
}
