"""Readings of a published study taken from a run, and those that need more than one channel.

A study that stored a value every so many degrees sees a spike by the luck of its samples. A reading
that is ``sampled`` is therefore taken at samples of that spacing at many phases: its number is the
median over them, and a comparison gives their range.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from pydantic.dataclasses import dataclass as table

from valvetrain.arrays import Array
from valvetrain.integrate.clash import runs
from valvetrain.parameters.schema_types import Angle
from valvetrain.quantities.cycle import Cycle
from valvetrain.quantities.signal import (
    filtered_force,
    fine_filtered,
    fine_series,
    window_bounds,
)
from valvetrain.solution.definition import pattern_of
from valvetrain.solution.study import LiftEvent
from valvetrain.sources.readings import (
    KINDS,
    KNOWN_KEYS,
    Numbers,
    Reading,
    View,
    numbered,
    spike_index,
)

#: Contacts closer than this share of the period of the first mode are one collision; the same as an
#: angle (rad) where no natural frequency is known.
SEPARATION_SHARE, SEPARATION = 0.35, float(np.radians(8.0))
#: Gap (m) below which coils touch: contact stiffness lets them overlap by less.
TOUCHING = 1e-6
TURN = 2 * np.pi


@table(frozen=True, config=KNOWN_KEYS)
class Sampling:
    """Cam angle (rad) between the values that a study stored, and the most phases at which they are laid."""

    spacing: Angle
    phases: int


@dataclass(frozen=True, eq=False)
class Reader:
    """Readings of one cycle: ``found``, and in ``phases`` those of samples, one value for each phase.

    ``event``: the main lift event; ``period``: cam angle (rad) of one period of the first mode, None where its
    frequency is not known; ``coils``: coil number by point.
    """

    cycle: Cycle
    event: LiftEvent | None = None
    period: float | None = None
    coils: Mapping[str, float] = field(default_factory=dict)
    sampling: Sampling | None = None
    found: Numbers = field(default_factory=dict)
    phases: dict[str, Array] = field(default_factory=dict)

    @property
    def separation(self) -> float:
        """Least distance (cam rad) of two collisions."""
        return SEPARATION if self.period is None else SEPARATION_SHARE * self.period

    def read(self, readings: Iterable[Reading]) -> Numbers:
        """Every quantity that the cycle covers, those of samples first."""
        covered = [one for one in readings if not one.runs and self._covers(one)]
        numbers: dict[str, list[float]] = {}
        for one in (each for each in covered if each.sampled):
            self.found.update(self._take(one))
            for angle, values in zip(*self.sampled(one.channel), strict=True):
                view = self.view(replace(self.cycle, cam_angle=angle), values, one)
                for name, number in KINDS[one.kind](view, one).items():
                    numbers.setdefault(name, []).append(number)
        count = max(map(len, numbers.values()), default=0)  # of those that every phase has
        whole = {name: np.array(some) for name, some in numbers.items() if len(some) == count}
        self.phases.update(whole)
        for name, values in self.phases.items():
            # an angle between two collisions would be that of neither
            angle = name.endswith("_angle")
            middle = np.quantile(values, 0.5, method="nearest" if angle else "linear")
            self.found[name] = float(middle)
        for one in covered:
            if not one.sampled:
                self.found.update(self._take(one))
        return self.found

    def _covers(self, reading: Reading) -> bool:
        """Whether the cycle has the window of a reading, with three samples or more."""
        if reading.window is None:
            return self.cycle.whole or reading.kind == "difference"
        if self.event is None:
            return False
        bounds = window_bounds(self.event, reading.window)
        return int(np.sum(self.cycle.window(*bounds))) > 2 and self.cycle.covers(*bounds)

    def _take(self, reading: Reading) -> Numbers:
        if reading.kind in MORE_KINDS:
            return MORE_KINDS[reading.kind](self, reading)
        values = self._values(reading)
        if values is None or not np.all(np.isfinite(values)):
            return {}
        return KINDS[reading.kind](self.view(self.cycle, values, reading), reading)

    def view(self, cycle: Cycle, values: Array, reading: Reading) -> View:
        """What a reading sees of values (sample,) over a cycle."""
        bounds = (0.0, TURN)
        if reading.window is not None and self.event is not None:
            bounds = window_bounds(self.event, reading.window)
        inside = np.flatnonzero(cycle.window(*bounds))
        return View(cycle, values, inside, bounds[1], self.separation)

    def first_of(self, channels: Sequence[str]) -> str:
        """The first of these channels that the run has; empty where it has none."""
        return next((one for one in channels if self.cycle.solution.has(one)), "")

    def _values(self, reading: Reading) -> Array | None:
        cycle, solution = self.cycle, self.cycle.solution
        name = self.first_of(reading.channel)
        if not name:
            return None
        if reading.point:
            return cycle.at_coil(name, self.coils[reading.point])
        if reading.highest:
            if solution.has(f"{name}_highest"):
                return cycle.channel(f"{name}_highest")
            fine = f"{name}_fine"
            return cycle.channel(fine).max(axis=1) if solution.has(fine) else None
        if (
            reading.above
        ):  # the largest size in each interval; the filters see one side only at the end
            time = solution.time
            quick = fine_filtered(solution, reading.below, name)
            slow = fine_filtered(solution, reading.above, name)
            if quick is None or slow is None:
                return None
            size = np.abs(quick - slow)
            if len(size) > len(time):
                size = np.append(size.reshape(len(time) - 1, -1).max(axis=1), 0.0)
            inside = cycle.time < cycle.time[-1] - 1 / reading.above
            return np.where(inside, size[cycle.samples], 0.0)
        if reading.below:
            force = filtered_force(solution, reading.below, name)
            return None if force is None else force[cycle.samples]
        return cycle.channel(name)

    def sampled(self, channels: Sequence[str]) -> tuple[Array, Array]:
        """Cam angle (rad) and value of a channel as the study would have stored it, both (phase, sample).

        Empty where the run's record is no finer than such samples.
        """
        cycle, name, none = self.cycle, self.first_of(channels), np.zeros((0, 0))
        if not name or self.sampling is None:
            return none, none
        spacing = self.sampling.spacing
        record = "finest" if cycle.solution.has(f"{name}_finest") else "fine"
        _, angle, values = fine_series(cycle.solution, name, record)
        angle = angle - (cycle.solution.cam_angle[cycle.samples][0] - cycle.cam_angle[0])
        inside = (angle >= cycle.cam_angle[0] - 1e-9) & (angle <= cycle.cam_angle[-1] + 1e-9)
        angle, values = angle[inside], values[inside]
        phases = int(min(round(spacing / float(np.median(np.diff(angle)))), self.sampling.phases))
        if phases < 2:
            return none, none
        count = int(np.floor((angle[-1] - angle[0]) / spacing + 1e-6))
        starts = angle[0] + spacing * np.arange(phases) / phases
        grid = starts[:, None] + spacing * np.arange(count)
        return grid, np.interp(grid.ravel(), angle, values).reshape(grid.shape)

    def between(self, reading: Reading, channel: str) -> Array | None:
        """A channel of coil pairs (sample, pair) over a stretch of the wire; None where it has none there."""
        if not self.cycle.solution.has(channel):
            return None
        places = self.cycle.solution.arrays.coords["upper_coil"].values
        first, last = reading.between
        mine = (places > first + 1e-9) & (places <= last + 1e-9)
        return self.cycle.channel(channel)[:, mine] if np.any(mine) else None


def difference(reader: Reader, reading: Reading) -> Numbers:
    """One quantity less another; of samples at each phase too."""
    first, second = reading.of
    if not {first, second} <= set(reader.found):
        return {}
    if {first, second} <= set(reader.phases):
        reader.phases[reading.names[0]] = reader.phases[first] - reader.phases[second]
    return {reading.names[0]: reader.found[first] - reader.found[second]}


def over_phases(reader: Reader, reading: Reading) -> Numbers:
    """The least and the largest value of a quantity over the phases of samples."""
    values = reader.phases.get(reading.of[0])
    if values is None:
        return {}
    return dict(zip(reading.names, (float(np.min(values)), float(np.max(values))), strict=True))


def spike_shape(reader: Reader, reading: Reading) -> Numbers:
    """How long (s) the spike of a window is above half its height, and its impulse (N s), by the samples of
    all phases.
    """
    grid, values = reader.sampled(reading.channel)
    if not len(grid):
        return {}
    view = reader.view(replace(reader.cycle, cam_angle=grid.T.ravel()), values.T.ravel(), reading)
    top = spike_index(view, reading)
    shape = half_height(view.cycle.cam_angle, view.values, top, reader.separation)
    turned, passed = np.ptp(reader.cycle.cam_angle), np.ptp(reader.cycle.time)
    return {
        name: float(one * passed / turned) for name, one in zip(reading.names, shape, strict=True)
    }


def half_height(cam_angle: Array, force: Array, peak: int, reach: float) -> tuple[float, float]:
    """Width (rad) of a spike at half its height, and the area (N rad) of its part above its foot.

    The foot is the median force within ``reach`` (rad) of the sample ``peak``; between samples the
    force is a straight line.

    >>> angle = np.linspace(0.0, 2.0, 2001)
    >>> triangle = np.maximum(0.0, 100.0 - 1000.0 * abs(angle - 1.0))
    >>> width, area = half_height(angle, triangle, 1000, 1.0)
    >>> round(width, 3), round(area, 2)
    (0.1, 10.0)
    """
    near = np.abs(cam_angle - cam_angle[peak]) <= reach
    angle, above = cam_angle[near], force[near] - float(np.median(force[near]))
    top = peak - int(np.flatnonzero(near)[0])
    if above[top] <= 0:
        return 0.0, 0.0
    half = above[top] / 2
    # the spike alone: down to where it first meets its foot on either side
    (left, right), (first, last) = (
        next(one for one in runs(above > level) if one[0] <= top <= one[1]) for level in (half, 0.0)
    )
    width = angle[right] - angle[left]
    for inner, outer in ((left, left - 1), (right, right + 1)):
        if 0 <= outer < len(above):
            share = (above[inner] - half) / (above[inner] - above[outer])
            width += share * abs(angle[outer] - angle[inner])
    part = slice(max(first - 1, 0), last + 2)
    area = np.trapezoid(np.maximum(above[part], 0.0), angle[part])
    return float(width), float(area)


def at_contact(reader: Reader, reading: Reading) -> Numbers:
    """The value at a point at the first sample of the window at which another channel exceeds zero there."""
    coil = reader.coils[reading.point]
    value, force = (reader.cycle.at_coil(name, coil) for name in (*reading.channel, *reading.of))
    if value is None or force is None or reader.event is None or reading.window is None:
        return {}
    inside = reader.cycle.window(*window_bounds(reader.event, reading.window))
    shut = np.flatnonzero(inside & (force > 0))
    return reading.number(0, value[shut[0]], reader.cycle.cam_angle[shut[0]]) if len(shut) else {}


def meetings(reader: Reader, reading: Reading) -> Numbers:
    """Cam angles at which two coils meet: touches of any point of a stretch, more than a separation
    after the touch before.
    """
    gaps = reader.between(reading, *reading.channel)
    if gaps is None:
        return {}
    closing = (gaps < TOUCHING) & (np.roll(gaps, 1, axis=0) >= TOUCHING)
    angles = reader.cycle.cam_angle[np.any(closing, axis=1)]
    first = np.r_[True, np.diff(angles) > reader.separation][: len(angles)]
    return numbered(reading.names[0], angles[first])


def interval(reader: Reader, reading: Reading) -> Numbers:
    """Mean distance (rad) of successive angles within the cycle's parts before and after the event, one
    that did not show left out; the same over the period of the first mode.
    """
    if reader.event is None:
        return {}
    counted, event = pattern_of(reading.of[0]), reader.event
    angles = np.array([one for name, one in reader.found.items() if counted.fullmatch(name)])
    parts = (angles[angles < event.start], angles[angles >= event.end])
    steps = np.concatenate([np.diff(one) for one in parts])
    if len(steps) == 0:
        return {}
    mean = float(np.mean(steps[steps <= 1.5 * np.median(steps)]))
    ratio = {} if reader.period is None else {reading.names[1]: mean / reader.period}
    return {reading.names[0]: mean, **ratio}


def bounce(reader: Reader, reading: Reading) -> Numbers:
    """Cam angles (rad) at which coils meet at a spike and meet again after a sample apart, and the time (s)
    between.

    Of the points of a stretch that touch within a sample of the study of that angle, that meet, leave
    and meet again within a separation each, it is the one that is pressed hardest there; where no force
    is known, the deepest.
    """
    cycle, spike = reader.cycle, reader.found.get(reading.of[0])
    gaps = reader.between(reading, "coil_gap")
    if gaps is None or spike is None or reader.sampling is None:
        return {}
    touched = gaps < TOUCHING
    touched[1:] |= touched[:-1]  # a contact may be shorter than a sample
    forces = reader.between(reading, "coil_contact_force")
    pressed = reader.between(reading, "coil_contact_peak_force")
    touched = touched if forces is None else touched | (forces > 0)
    near = np.abs(cycle.cam_angle - spike) <= reader.sampling.spacing * (1 + 1e-9)
    if not np.any(near):
        return {}
    hardest = (-gaps if pressed is None else pressed)[near].max(axis=0)
    found: list[tuple[float, int, int]] = []
    for pair in range(touched.shape[1]):
        for (first, last), (again, _) in pairwise(runs(touched[:, pair])):
            meets, leaves, comes = cycle.cam_angle[[first, last, again]] - spike
            late = max(-meets, leaves, comes - leaves)
            if np.any(near[first : last + 1]) and late <= reader.separation:
                found.append((float(hardest[pair]), first, again))
    if not found:
        return {}
    _, first, again = max(found)
    time = cycle.time[again] - cycle.time[first]
    numbers = (cycle.cam_angle[first], cycle.cam_angle[again], time)
    return dict(zip(reading.names, map(float, numbers), strict=True))


#: Kind -> function of a reader, of what was read before or of several channels.
MORE_KINDS: dict[str, Callable[[Reader, Reading], Numbers]] = {
    "difference": difference,
    "over phases": over_phases,
    "spike shape": spike_shape,
    "at contact": at_contact,
    "meetings": meetings,
    "interval": interval,
    "bounce": bounce,
}
