"""Numbers of one cam revolution of a run-up: the envelope of forces, lift and loss of contact over engine
speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.train_channels import force_name
from valvetrain.integrate.train_run import CycleRecord
from valvetrain.integrate.train_tuples import HIGHEST, LOADS, LOWEST, PEAK_PLACE
from valvetrain.mechanism.rigid import RigidKinematics
from valvetrain.quantities.train_events import PLACES, SMALLEST_GAP
from valvetrain.quantities.train_numbers import DRIVING
from valvetrain.quantities.valve_events import OPEN_SHARE, open_window, top_of
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]
_TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class OpenWindow:
    """Cam angles (rad) from ``begin`` to ``end`` in which the rigid lift stands above
    :data:`OPEN_SHARE` of its largest, ``top`` (m).
    """

    begin: float
    end: float
    top: float

    @classmethod
    def of(cls, kinematics: RigidKinematics) -> OpenWindow:
        """That of a train's rigid kinematics."""
        return cls(*open_window(kinematics), top_of(kinematics))

    def holds(self, cam_angle: Array) -> NDArray[np.bool_]:
        """Whether cam angles (rad, unwrapped or not) lie in it."""
        return np.asarray((cam_angle - self.begin) % _TURN <= self.end - self.begin)


def turn_quantities(
    system: TrainSystem, record: CycleRecord, window: OpenWindow
) -> dict[str, float]:
    """Numbers (SI) of one turn, by the names and rules of a steady cycle (docs/quantities.md).

    All but gaps and the lift above the rigid one are those of every step.
    """
    mechanism, names = system.mechanism, system.interaction_names
    lift = record.q[:, mechanism.index(mechanism.valve)]
    rigid = mechanism.kinematics.valve_lift(record.cam_angle)
    retainer, spring = (record.loads[LOADS.index(side)].tolist() for side in ("retainer", "seat"))
    largest = float(record.bodies[mechanism.index(mechanism.valve), PEAK_PLACE])
    values = {
        f"peak_{force_name(name)}": float(record.peak_forces[k]) for k, name in enumerate(names)
    }
    for place in DRIVING:
        if (name := place.replace("_", " ")) in names:
            values[f"minimum_{place}_contact_force"] = float(record.least_forces[names.index(name)])
    values |= {
        "peak_spring_force": spring[HIGHEST],
        "minimum_spring_force": spring[LOWEST],
        "peak_retainer_force": retainer[HIGHEST],
        "minimum_retainer_force": retainer[LOWEST],
        "peak_valve_lift": largest,
        "lift_loss_displacement": window.top - largest,
    }
    apart = [
        record.gaps[:, names.index(one)]
        for place in PLACES
        if (one := place.replace("_", " ")) in names
    ]
    cam = record.gaps[:, names.index("cam")]
    inside = window.holds(record.cam_angle)
    values["loft_gap"] = (
        float(np.max(cam[inside], initial=0.0)) if np.any(cam[inside] > SMALLEST_GAP) else 0.0
    )
    nose = (rigid > 0.3 * window.top) & (mechanism.kinematics.valve_lift(record.cam_angle, 2) < 0)
    excess = np.where(np.any(np.array(apart) > SMALLEST_GAP, axis=0) & nose, lift - rigid, 0.0)
    values["float_excess_lift"] = float(
        np.max(np.where(excess > 10 * SMALLEST_GAP, excess, 0.0), initial=0.0)
    )
    return values | _seating(record, names, window)


def _seating(record: CycleRecord, names: tuple[str, ...], window: OpenWindow) -> dict[str, float]:
    """Velocity of the first touch of the seat after the valve was open; none in a turn that does
    not hold one.
    """
    if "seat" not in names:
        return {}
    found = record.transitions.of(names.index("seat"))
    closings = found.where(found.closes & (found.largest_gap > OPEN_SHARE * window.top))
    if not len(closings):
        return {}
    return {
        "seating_velocity": float(closings.gap_rate[0]),
        "seating_cam_angle": float(closings.cam_angle[0] % _TURN),
    }
