"""Forces of a cam cycle by its stages: range before the event, peaks and valley in it, spike after it.

The stages of a case follow from its lift law: see :func:`stages_of`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from valvetrain.cam.build import build_lift_law
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.quantities.cycle import Array, Cycle
from valvetrain.quantities.peaks import prominences, prominent_peaks

#: A peak of Stage I stands out by this share of the stage's force range.
STAGE_1_SHARE = 0.25
#: The two maxima of Stage II stand out by this share of the stage's force range; ripples of coil contact stay below a third of it.
STAGE_2_SHARE = 0.02
#: The spike of Stage III stands out by this share of the cycle's force range, so a ripple on the falling flank is none.
STAGE_3_SHARE = 0.01
#: A second spike stands out by this share of the main one's height over the median force after it.
SECOND_SPIKE_SHARE = 0.15
#: Where a law does not say where its main event begins, it is where the lift passes this share of its largest value.
EVENT_SHARE = 0.04
_TURN = 2 * math.pi


@dataclass(frozen=True, slots=True)
class Stages:
    """Cam angles (rad) at which Stage I ends and Stage II ends; Stage I starts at 0, Stage III ends at a whole turn.

    The defaults are those of the beehive's source (gu2021, section 3.3); :func:`stages_of` gives those of a case.
    """

    first_end: float = math.radians(127.0)
    second_end: float = math.radians(233.0)

    def bounds(self, stage: int) -> tuple[float, float]:
        """First and last cam angle (rad) of stage 1, 2 or 3."""
        return ((0.0, self.first_end), (self.first_end, self.second_end), (self.second_end, _TURN))[stage - 1]

    def covered(self, cycle: Cycle, stage: int) -> bool:
        """True when the run's cycle covers the stage with three samples or more."""
        return int(np.sum(cycle.window(*self.bounds(stage)))) > 2 and cycle.covers(*self.bounds(stage))


def stages_of(parameters: LiftLawParameters | None) -> Stages | None:
    """Stages of a lift law: Stage II is its main event; None without lift or where the event spans the zero of the cam angle.

    The event is the law's own (``event_start`` with ``event_end`` or mirrored about ``nose``), else from where the lift first passes
    4 % of its largest value to where it last does. Raises :class:`InputError` for parameters that make no law.
    """
    event = _main_event(parameters)
    if event is None:
        return None
    first, length = event[0] % _TURN, event[1] - event[0]
    # Whole cam degrees stay whole through sums of radians.
    first, last = (math.radians(round(math.degrees(angle), 9)) for angle in (first, first + length))
    return Stages(first, last) if last <= _TURN else None


def _main_event(parameters: LiftLawParameters | None) -> tuple[float, float] | None:
    """Begin and end (rad, end after begin) of the main event of a law."""
    if parameters is None:
        return None
    law = build_lift_law(parameters)
    values = parameters.values
    if "event_start" in values and ("event_end" in values or "nose" in values):
        start = float(values["event_start"])
        return start, float(values["event_end"]) if "event_end" in values else 2 * float(values["nose"]) - start
    angle = np.arange(7200) * _TURN / 7200
    lift = law.lift(angle)
    top, up = int(np.argmax(lift)), lift > EVENT_SHARE * float(np.max(lift))
    if not np.max(lift) > 0 or np.all(up):
        return None
    # From the nose outward, round the circle, until the lift has gone under the share for good.
    turned = np.roll(up, len(up) // 2 - top)
    inside = np.flatnonzero(turned) - len(up) // 2 + top
    step = _TURN / len(up)
    return float(inside[0] * step), float((inside[-1] + 1) * step)


def stage_quantities(cycle: Cycle, separation: float, stages: Stages | None = Stages()) -> dict[str, float]:
    """All force quantities of the stages that the run covers, by their names in docs/quantities.md; SI, angles rad; none without stages."""
    if stages is None:
        return {}
    force = cycle.channel("seat_force")
    found: dict[str, float] = {}
    if stages.covered(cycle, 1):
        found |= stage_1(cycle, force, stages)
    if stages.covered(cycle, 2):
        found |= stage_2(cycle, force, stages)
    if stages.covered(cycle, 3):
        found |= stage_3(cycle, force, separation, stages)
    return found


def stage_1(cycle: Cycle, force: Array, stages: Stages = Stages()) -> dict[str, float]:
    """Range of the force in Stage I and the angles of the peaks that stand out of it."""
    inside = cycle.window(*stages.bounds(1))
    low, high = float(np.min(force[inside])), float(np.max(force[inside]))
    found = {"stage_1_minimum_force": low, "stage_1_maximum_force": high}
    # The cycle is periodic: seen twice, a peak next to 0 degrees has a left side as well.
    count = len(force)
    twice = np.concatenate((force, force)) if cycle.whole else force
    peaks = prominent_peaks(twice, max(STAGE_1_SHARE * (high - low), 1e-12))
    angles = np.unique(cycle.cam_angle[peaks % count])
    for number, angle in enumerate(angles[angles < stages.first_end], start=1):
        found[f"stage_1_peak_{number}_cam_angle"] = float(angle)
    return found


def stage_2(cycle: Cycle, force: Array, stages: Stages = Stages()) -> dict[str, float]:
    """Largest force of Stage II; where it has two maxima, both and the valley between; the force at its end."""
    inside = np.flatnonzero(cycle.window(*stages.bounds(2)))
    part, angle = force[inside], cycle.cam_angle[inside]
    top = int(np.argmax(part))
    found = {"stage_2_peak_force": float(part[top]), "stage_2_peak_cam_angle": float(angle[top])}
    found["stage_2_end_force"] = float(np.interp(stages.second_end, cycle.cam_angle, force))
    pair = _two_peaks(part)
    if pair is not None:
        first, second = pair
        valley = first + int(np.argmin(part[first : second + 1]))
        for word, index in (("first_peak", first), ("valley", valley), ("second_peak", second)):
            found[f"stage_2_{word}_force"] = float(part[index])
            found[f"stage_2_{word}_cam_angle"] = float(angle[index])
    return found


def _two_peaks(part: Array) -> tuple[int, int] | None:
    """The two most prominent maxima in order of angle, or None where only one stands out."""
    peaks = prominent_peaks(part, max(STAGE_2_SHARE * float(np.ptp(part)), 1e-12))
    if len(peaks) < 2:
        return None
    strongest = peaks[np.argsort(-prominences(part, peaks))[:2]]
    first, second = sorted(int(index) for index in strongest)
    return first, second


def spike_index(cycle: Cycle, force: Array, stages: Stages = Stages()) -> int:
    """Sample of the largest force maximum of Stage III; without one, of its largest force.

    A maximum, not the largest value: at low speed the falling flank of the lift event reaches into Stage III.
    """
    inside = np.flatnonzero(cycle.window(*stages.bounds(3)))
    part = force[inside]
    peaks = prominent_peaks(part, max(STAGE_3_SHARE * float(np.ptp(force)), 1e-12))
    best = peaks[np.argmax(part[peaks])] if len(peaks) else int(np.argmax(part))
    return int(inside[best])


def stage_3(cycle: Cycle, force: Array, separation: float, stages: Stages = Stages()) -> dict[str, float]:
    """The spike after the event, force and angle, and the next collision's spike at least ``separation`` (rad) later."""
    top = spike_index(cycle, force, stages)
    found = {"stage_3_peak_force": float(force[top]), "stage_3_peak_cam_angle": float(cycle.cam_angle[top])}
    later = np.flatnonzero(cycle.window(float(cycle.cam_angle[top]) + separation, stages.bounds(3)[1]))
    if len(later) > 2:
        part = force[later]
        peaks = prominent_peaks(part, max(SECOND_SPIKE_SHARE * float(force[top] - np.median(part)), 1e-12))
        if len(peaks):
            found["stage_3_second_peak_cam_angle"] = float(cycle.cam_angle[later[peaks[np.argmax(part[peaks])]]])
    return found
