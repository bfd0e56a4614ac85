"""Stages of the beehive study (gu2021, section 3.3) and the forces it names by them: Stage I
before, II in, III after the lift event.

What the event is follows from the lift law of the case; the stages of the paper are 0 to 127, 127
to 233 and 233 to 360 cam degrees.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.quantities.clash import SPIKE_BANDWIDTH
from valvetrain.quantities.cycle import Array, Cycle, reported_cycle
from valvetrain.quantities.signal import (
    WINDOWS,
    filtered_force,
    is_covered,
    low_pass,
    prominences,
    prominent_peaks,
    window_bounds,
)
from valvetrain.solution.result import Solution
from valvetrain.solution.study import LiftEvent
from valvetrain.sources.gu2021_reading import Sampled, half_height, sampled

#: A peak of Stage I exceeds its surroundings by this share of the stage's force range.
STAGE_1_SHARE = 0.25
#: The two maxima of Stage II exceed their surroundings by this share of the stage's force range; ripples of coil
#: contact stay below a third of it.
STAGE_2_SHARE = 0.02
#: Both are above this share of the stage's force range: a ripple on its rising or falling flank is
#: no maximum of the lifted valve.
STAGE_2_HEIGHT = 0.5
#: Heights of the maxima and of the valley are the extreme samples within this angle (rad) of them.
MAXIMUM_REACH = np.radians(3.0)
#: The spike of Stage III exceeds its surroundings by this share of the cycle's force range, so a ripple on the
#: falling flank is none.
STAGE_3_SHARE = 0.01
#: A second spike exceeds its surroundings by this share of the main one's height over the median force after it.
SECOND_SPIKE_SHARE = 0.15
#: Above this frequency (Hz), four times the first mode's, nothing but contact of coils moves the
#: force.
RATTLE = 2500.0


def in_stage(cycle: Cycle, event: LiftEvent, stage: int) -> np.ndarray:
    """Mask of the samples of stage 1, 2 or 3."""
    return cycle.window(*window_bounds(event, WINDOWS[stage - 1]))


def covers_stage(cycle: Cycle, event: LiftEvent, stage: int) -> bool:
    """Whether the cycle covers stage 1, 2 or 3."""
    return is_covered(cycle, event, WINDOWS[stage - 1])


def stage_quantities(cycle: Cycle, separation: float, event: LiftEvent) -> dict[str, float]:
    """All force quantities of the stages that the run covers, by their names in docs/quantities.md;
    SI, angles rad.

    ``separation``: least distance (cam rad) of two collisions.
    """
    # the modal model of the source sums its modes as equation 5 prints it
    name = seat_force_name(cycle)
    force = cycle.channel(name)
    found: dict[str, float] = {}
    if covers_stage(cycle, event, 1):
        found |= stage_1(cycle, force, event)
    if covers_stage(cycle, event, 2):
        found |= stage_2(cycle, force, event)
    if covers_stage(cycle, event, 3):
        found |= stage_3(cycle, force, separation, event)
        found |= _stage_3_in_bandwidths(cycle, event) if cycle.whole else {}
    return found | _as_the_source_read(cycle, name, separation, event)


def _as_the_source_read(
    cycle: Cycle, channel: str, separation: float, event: LiftEvent
) -> dict[str, float]:
    """Forces and angles of the stages in the median over phases of the source's samples, and the
    range of the Stage III spike.
    """
    by_phase = over_phases(cycle, channel, separation, event)
    # an angle between two collisions would be that of neither
    found = {
        name: float(np.quantile(values, 0.5, method="nearest" if "angle" in name else "linear"))
        for name, values in by_phase.items()
    }
    if "stage_1_force_range" in found:
        ends = (found["stage_1_maximum_force"], found["stage_1_minimum_force"])
        found["stage_1_force_range"] = ends[0] - ends[1]
    if "stage_3_peak_force" in found:
        spikes = by_phase["stage_3_peak_force"]
        found["stage_3_least_sampled_peak_force"] = float(np.min(spikes))
        found["stage_3_largest_sampled_peak_force"] = float(np.max(spikes))
        found |= _spike_shape(cycle, sampled(cycle, channel), separation, event)
    return found


def over_phases(
    cycle: Cycle, channel: str, separation: float, event: LiftEvent
) -> dict[str, Array]:
    """Forces and angles of the stages once for each phase of the source's samples, of those that
    every phase has; empty where the run's record is no finer than the samples.
    """
    read = sampled(cycle, channel)
    if len(read.force) < 2:
        return {}
    numbers = []
    for angle, force in zip(read.cam_angle, read.force, strict=True):
        one: dict[str, float] = {}
        seen = replace(cycle, cam_angle=angle)
        # how many maxima Stage I has may differ from phase to phase, so only its range is read
        for stage, reading in ((1, range_of_stage_1), (2, stage_2)):
            if covers_stage(cycle, event, stage):
                one |= reading(seen, force, event)
        if covers_stage(cycle, event, 3):
            one |= stage_3(seen, force, separation, event)
        numbers.append(one)
    common = [name for name in numbers[0] if all(name in one for one in numbers)]
    return {name: np.array([one[name] for one in numbers]) for name in common}


def _spike_shape(
    cycle: Cycle, read: Sampled, separation: float, event: LiftEvent
) -> dict[str, float]:
    """How long the spike of Stage III is above half its height (s) and its impulse (N s)."""
    angle, force = read.cam_angle.T.ravel(), read.force.T.ravel()
    top = spike_index(replace(cycle, cam_angle=angle), force, event)
    width, area = half_height(angle, force, top, separation)
    turning = (cycle.cam_angle[-1] - cycle.cam_angle[0]) / (cycle.time[-1] - cycle.time[0])
    return {"stage_3_peak_duration": width / turning, "stage_3_peak_impulse": area / turning}


def range_of_stage_1(cycle: Cycle, force: Array, event: LiftEvent) -> dict[str, float]:
    """Least and largest force of Stage I and their difference."""
    inside = in_stage(cycle, event, 1)
    low, high = float(np.min(force[inside])), float(np.max(force[inside]))
    return {
        "stage_1_minimum_force": low,
        "stage_1_maximum_force": high,
        "stage_1_force_range": high - low,
    }


def stage_1(cycle: Cycle, force: Array, event: LiftEvent) -> dict[str, float]:
    """Range of the force in Stage I and the angles of the peaks that exceed its surroundings."""
    found = range_of_stage_1(cycle, force, event)
    low, high = found["stage_1_minimum_force"], found["stage_1_maximum_force"]
    # The cycle is periodic: seen twice, a peak next to 0 degrees has a left side as well.
    count = len(force)
    twice = np.concatenate((force, force)) if cycle.whole else force
    peaks = prominent_peaks(twice, max(STAGE_1_SHARE * (high - low), 1e-12))
    angles = np.unique(cycle.cam_angle[peaks % count])
    for number, angle in enumerate(angles[angles < event.start], start=1):
        found[f"stage_1_peak_{number}_cam_angle"] = float(angle)
    return found


def stage_2(cycle: Cycle, force: Array, event: LiftEvent) -> dict[str, float]:
    """Largest force of Stage II; where it has two maxima, both and the valley between; the force at
    its end.

    The two maxima are those of the force below :data:`RATTLE`, since a clash of coils next to one
    would be taken for the other; their heights are the extreme samples around them.
    """
    inside = np.flatnonzero(in_stage(cycle, event, 2))
    part, angle = force[inside], cycle.cam_angle[inside]
    top = int(np.argmax(part))
    found = {"stage_2_peak_force": float(part[top]), "stage_2_peak_cam_angle": float(angle[top])}
    found["stage_2_end_force"] = float(np.interp(event.end, cycle.cam_angle, force))
    whole = _slow(cycle, force)
    slow = np.zeros(0) if whole is None else whole[inside]
    if len(slow) and (pair := _two_peaks(slow)) is not None:
        first, second = pair
        valley = first + int(np.argmin(slow[first : second + 1]))
        for word, index in (("first_peak", first), ("valley", valley), ("second_peak", second)):
            near = part[np.abs(angle - angle[index]) <= MAXIMUM_REACH + 1e-9]
            height = np.min(near) if word == "valley" else np.max(near)
            found[f"stage_2_{word}_force"] = float(height)
            found[f"stage_2_{word}_cam_angle"] = float(angle[index])
    return found


def _slow(cycle: Cycle, force: Array) -> Array | None:
    """The force below :data:`RATTLE`; None where its samples do not allow that."""
    if not cycle.solution.engine_speed:
        return None
    try:
        time = cycle.cam_angle / (cycle.solution.engine_speed / 2)
        return low_pass(time, force, RATTLE, closed=cycle.whole)
    except InputError:
        return None


def _two_peaks(part: Array) -> tuple[int, int] | None:
    """The two most prominent maxima in order of angle, or None where only one is prominent in the
    upper half of the forces.
    """
    spread = float(np.ptp(part))
    peaks = prominent_peaks(part, max(STAGE_2_SHARE * spread, 1e-12))
    peaks = peaks[part[peaks] > float(part.min()) + STAGE_2_HEIGHT * spread]
    if len(peaks) < 2:
        return None
    strongest = peaks[np.argsort(-prominences(part, peaks))[:2]]
    first, second = sorted(int(index) for index in strongest)
    return first, second


def seat_force_name(cycle: Cycle) -> str:
    """Channel of the seat force that the study speaks of: of its modal model the form as printed."""
    return "seat_force_as_printed" if cycle.solution.has("seat_force_as_printed") else "seat_force"


def spike_index(cycle: Cycle, force: Array, event: LiftEvent) -> int:
    """Sample of the largest force maximum of Stage III; without one, of its largest force.

    A maximum, not the largest value: at low speed the falling flank of the lift event reaches into
    Stage III.
    """
    inside = np.flatnonzero(in_stage(cycle, event, 3))
    part = force[inside]
    peaks = prominent_peaks(part, max(STAGE_3_SHARE * float(np.ptp(force)), 1e-12))
    best = peaks[np.argmax(part[peaks])] if len(peaks) else int(np.argmax(part))
    return int(inside[best])


def stage_3(cycle: Cycle, force: Array, separation: float, event: LiftEvent) -> dict[str, float]:
    """The spike after the event, force and angle, and the next collision's spike at least
    ``separation`` (rad) later.
    """
    top = spike_index(cycle, force, event)
    found = {
        "stage_3_peak_force": float(force[top]),
        "stage_3_peak_cam_angle": float(cycle.cam_angle[top]),
    }
    later = np.flatnonzero(cycle.window(float(cycle.cam_angle[top]) + separation, 2 * np.pi))
    if len(later) > 2:
        part = force[later]
        peaks = prominent_peaks(
            part, max(SECOND_SPIKE_SHARE * float(force[top] - np.median(part)), 1e-12)
        )
        if len(peaks):
            found["stage_3_second_peak_cam_angle"] = float(
                cycle.cam_angle[later[peaks[np.argmax(part[peaks])]]]
            )
    return found


def rattle(solution: Solution, event: LiftEvent) -> tuple[float, float] | None:
    """Largest size (N) in Stage III of the seat force above :data:`RATTLE`, and its cam angle
    (rad); None for too few or uneven samples.
    """
    if len(solution.time) < 3 or not solution.has("seat_force"):
        return None
    cycle, force = reported_cycle(solution), solution.channel("seat_force")
    if not covers_stage(cycle, event, 3):
        return None
    try:
        slow = low_pass(solution.time, force, RATTLE)
    except InputError:
        return None
    # at the end of the record the filter sees one side only
    inside = in_stage(cycle, event, 3) & (cycle.time < cycle.time[-1] - 1 / RATTLE)
    sharp = np.where(inside, np.abs(force - slow)[cycle.samples], 0.0)
    top = int(np.argmax(sharp))
    return float(sharp[top]), float(cycle.cam_angle[top])


def _stage_3_in_bandwidths(cycle: Cycle, event: LiftEvent) -> dict[str, float]:
    """Height (N) of the Stage III spike at the highest instant known and below 5 kHz, where
    the run's samples allow it.
    """
    found: dict[str, float] = {}
    if cycle.solution.has("seat_force_fine"):
        exact = cycle.solution.has("seat_force_highest")
        name = "seat_force_highest" if exact else "seat_force_fine"
        highest = cycle.channel(name) if exact else cycle.channel(name).max(axis=1)
        found["stage_3_every_instant_peak_force"] = float(
            highest[spike_index(cycle, highest, event)]
        )
    force = filtered_force(cycle.solution, SPIKE_BANDWIDTH, seat_force_name(cycle))
    if force is not None:
        part = force[cycle.samples]
        found["stage_3_below_5_khz_peak_force"] = float(part[spike_index(cycle, part, event)])
    return found
