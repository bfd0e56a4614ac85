"""Numbers of one cam turn of a run-up: the envelope of forces, lift and loss of contact over engine speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.train_channels import force_name
from valvetrain.integrate.train_run import CycleRecord
from valvetrain.mechanism.rigid import RigidKinematics
from valvetrain.quantities.train_events import PLACES, SMALLEST_GAP
from valvetrain.quantities.train_numbers import DRIVING
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]
#: Share of the largest rigid lift above which the valve counts as open, and above which a touch of the seat is one of closing.
OPEN_SHARE = 0.1
_TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class OpenWindow:
    """Cam angles (rad) from ``begin`` to ``end`` in which the rigid lift stands above :data:`OPEN_SHARE` of its largest, ``top`` (m)."""

    begin: float
    end: float
    top: float

    @classmethod
    def of(cls, kinematics: RigidKinematics) -> OpenWindow:
        """That of a train's rigid kinematics."""
        angle = np.arange(7200) * _TURN / 7200
        lift = kinematics.valve_lift(angle)
        top = int(np.argmax(lift))
        turned = np.roll(lift > OPEN_SHARE * lift[top], 3600 - top)
        inside = np.flatnonzero(turned) - 3600 + top
        return cls(float(inside[0] * _TURN / 7200) % _TURN, float(inside[0] * _TURN / 7200) % _TURN + len(inside) * _TURN / 7200, lift[top])

    def holds(self, cam_angle: Array) -> NDArray[np.bool_]:
        """Whether cam angles (rad, unwrapped or not) lie in it."""
        return np.asarray((cam_angle - self.begin) % _TURN <= self.end - self.begin)


def turn_quantities(system: TrainSystem, record: CycleRecord, window: OpenWindow) -> dict[str, float]:
    """Numbers (SI) of one turn, by the names and rules of a steady cycle (docs/quantities.md).

    Peak contact forces, least force at the cam and seating are those of every step; spring forces and lifts those of the samples.
    """
    mechanism, names = system.mechanism, system.interaction_names
    lift = record.q[:, mechanism.index(mechanism.valve)]
    rigid = mechanism.kinematics.valve_lift(record.cam_angle)
    spring = record.spring_forces[:, :, 1].sum(axis=1)
    retainer = record.spring_forces[:, :, 0].sum(axis=1)
    values = {f"peak_{force_name(name)}": float(record.peak_forces[k]) for k, name in enumerate(names)}
    for place in DRIVING:
        if (name := place.replace("_", " ")) in names:
            values[f"minimum_{place}_contact_force"] = float(record.least_forces[names.index(name)])
    values |= {
        "peak_spring_force": float(spring.max()), "minimum_spring_force": float(spring.min()),
        "peak_retainer_force": float(retainer.max()), "minimum_retainer_force": float(retainer.min()),
        "peak_valve_lift": float(lift.max()), "lift_loss_displacement": float(window.top - lift.max()),
    }  # fmt: skip
    apart = [record.gaps[:, names.index(one)] for place in PLACES if (one := place.replace("_", " ")) in names]
    cam = record.gaps[:, names.index("cam")]
    inside = window.holds(record.cam_angle)
    values["loft_gap"] = float(np.max(cam[inside], initial=0.0)) if np.any(cam[inside] > SMALLEST_GAP) else 0.0
    nose = (rigid > 0.3 * window.top) & (mechanism.kinematics.valve_lift(record.cam_angle, 2) < 0)
    excess = np.where(np.any(np.array(apart) > SMALLEST_GAP, axis=0) & nose, lift - rigid, 0.0)
    values["float_excess_lift"] = float(np.max(np.where(excess > 10 * SMALLEST_GAP, excess, 0.0), initial=0.0))
    return values | _seating(record, names, window)


def _seating(record: CycleRecord, names: tuple[str, ...], window: OpenWindow) -> dict[str, float]:
    """Velocity of the first touch of the seat after the valve was open; none in a turn that does not hold one."""
    if "seat" not in names:
        return {}
    found = record.transitions.of(names.index("seat"))
    closings = found.where(found.closes & (found.largest_gap > OPEN_SHARE * window.top))
    if not len(closings):
        return {}
    return {"seating_velocity": float(closings.gap_rate[0]), "seating_cam_angle": float(closings.cam_angle[0] % _TURN)}
