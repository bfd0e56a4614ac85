"""Moments to jump to: peaks of the force, the hardest clashes, and what else happened in the cycle."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import Cycle
from valvetrain.report.motion.parts import Mark, Variant
from valvetrain.report.words import number
from valvetrain.solution.definition import angle_name, label_of, shown
from valvetrain.solution.display import words as shown_words
from valvetrain.solution.result import Solution

_TURN = 2 * np.pi
#: Clashes and other events in the list.
MOST_CLASHES, MOST_OTHERS = 12, 12
#: Peaks on every step of the integration, whose angles are quantities too.
_PEAKS = ("peak_spring_force", "minimum_spring_force")


def marks_of(run: Solution, cycle: Cycle) -> tuple[Mark, ...]:
    """Marks of a run by cam angle: largest and least spring force (on every step where the run tells it), the hardest clashes at their
    peaks, the first of its other events."""
    found = _peaks(run, cycle)
    clashes = sorted((event for event in run.events if event.kind == "clash"), key=lambda event: -event.size)[:MOST_CLASHES]
    for event in clashes:
        at = float(event.details.get("peak_cam_angle", event.cam_angle))
        words = f"clash {shown_words(event.size, event.unit, 3)}" + (f", {event.where}" if event.where else "")
        found.append(Mark(at % _TURN, "clash", words))
    for event in [event for event in run.events if event.kind != "clash"][:MOST_OTHERS]:
        size = f" {shown_words(event.size, event.unit, 3)}" if event.unit else ""
        where = f", {event.where}" if event.where else ""
        found.append(Mark(event.cam_angle % _TURN, "other", f"{event.kind.replace('_', ' ').replace('-', ' ')}{where}:{size}"))
    return tuple(sorted(found, key=lambda mark: mark.cam_angle))


def still_frame(variant: Variant) -> int:
    """Frame at which a picture begins and is printed: next to the mark of the largest spring force, else that of the largest lift."""
    peak = next((mark for mark in variant.marks if mark.kind == "peak" and not mark.words.startswith(("least", "minimum"))), None)
    if peak is None:
        return int(np.argmax(variant.valve_lift))
    return int(np.argmin(np.abs(variant.cam_angle - peak.cam_angle)))


def _peaks(run: Solution, cycle: Cycle) -> list[Mark]:
    found = []
    for name in _PEAKS:
        angle = run.quantities.get(angle_name(name))
        if name in run.quantities and angle is not None and np.isfinite(angle):
            value, unit = shown(name, run.quantities[name])
            found.append(Mark(float(angle) % _TURN, "peak", f"{label_of(name)} {number(float(value))} {unit}"))
    if not found and run.has("seat_force"):
        force = cycle.channel("seat_force")
        for place, words in ((int(np.argmax(force)), "largest"), (int(np.argmin(force)), "least")):
            found.append(Mark(float(cycle.cam_angle[place]), "peak", f"{words} force on the seat {number(float(force[place]))} N"))
    return found
