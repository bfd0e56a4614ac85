"""Which losses of contact count: those while the valve is open, as over engine speed; a contact that
parts once the valve is on its seat loses no control of it.
"""

from __future__ import annotations

import math

import numpy as np

from valvetrain.quantities.train_events import LOSSES, TURN, covered, drive_forces, lost_spans
from valvetrain.quantities.valve_events import OPEN_SHARE
from valvetrain.report.clauses import Runs, Worst
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event

DURATION, GAP = "loss_of_contact_duration", "loft_gap"


def losses_while_open(run: Solution) -> list[Event]:
    """Losses of contact of a run while the valve is open by more than a tenth of its lift, the largest
    gap first.
    """
    events = [event for event in run.events if event.kind in LOSSES]
    return sorted(
        (event for event in events if _is_open(run, event)), key=lambda event: -event.size
    )


def worst_loss(runs: Runs, name: str) -> Worst | None:
    """The longest time without contact (:data:`DURATION`) or largest loft (:data:`GAP`) that counts, and
    its run.
    """
    known = [
        (value, run)
        for run in runs.solutions
        if math.isfinite(value := _counted(run, name, runs.value(run, name)))
    ]
    if not known:
        return None
    value, run = max(known, key=lambda pair: pair[0])
    alike = all(abs(one - value) <= 1e-9 * max(value, 1e-12) for one, _ in known)
    return Worst(name, value, None if alike else run)


def time_lost(run: Solution) -> float:
    """Time (s) without contact that counts in a run; of a turn without that number its loft (m), NaN
    where neither is known.
    """
    value = run.quantities.get(DURATION, math.nan)
    return (
        _counted(run, DURATION, value) if math.isfinite(value) else run.quantities.get(GAP, value)
    )


def loss_near_seat(runs: Runs) -> tuple[Event, Solution] | None:
    """The largest gap of a contact that opens on a ramp alone, the valve open by less than a tenth of its
    lift, and its run; None without one.
    """
    found = [
        (event, run)
        for run in runs.solutions
        if run.quantities.get(DURATION, 0.0) > 0
        for event in run.events
        if event.kind in LOSSES and not _is_open(run, event)
    ]
    return max(found, key=lambda pair: pair[0].size, default=None)


def _counted(run: Solution, name: str, value: float) -> float:
    """A number of all losses, of those while the valve is open alone where others are among them."""
    every = [event for event in run.events if event.kind in LOSSES]
    some = losses_while_open(run)
    if len(some) == len(every) or not math.isfinite(value):
        return value
    if name == GAP:
        return max((one.size for one in some if one.kind == "loft"), default=0.0)
    turn = 2 * TURN / run.engine_speed
    return turn / TURN * covered(lost_spans(some, turn))


def _is_open(run: Solution, event: Event) -> bool:
    """Whether the rigid valve, of a run without it the valve, is above a tenth of its lift anywhere in
    an event, as in the search over engine speed; True without any lift.
    """
    if (
        min(drive_forces(run).values(), default=0.0) > 0
    ):  # of every step with the rigid valve open so far
        return False
    name = next((one for one in ("rigid_valve_lift", "valve_lift") if run.has(one)), None)
    if name is None:
        return True
    lift = run.channel(name)
    turned = event.duration * run.engine_speed / 2
    angles = event.cam_angle + np.linspace(0.0, turned, 9)
    there = np.interp(angles, run.cam_angle, lift, period=TURN)
    return bool(np.max(there) > OPEN_SHARE * np.max(lift))
