"""Named numbers of one closed cycle of a train from its channels and events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.integrate.train_channels import load_name, peak_forces
from valvetrain.integrate.train_record import CycleRecord
from valvetrain.integrate.train_tuples import PEAK_PLACE
from valvetrain.mechanism.rigid import OPEN_SHARE, RigidKinematics
from valvetrain.quantities.forces import counted_quantities
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.quantities.signal import ring_peak, ring_value
from valvetrain.quantities.train_events import (
    LOFT,
    SMALLEST_GAP,
    TURN,
    RigidCycle,
    Span,
    counted_losses,
    covered,
    lost_spans,
    span_of,
    spans_above,
)
from valvetrain.quantities.valve_events import open_window, top_of
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event
from valvetrain.system.train_system import TrainSystem

#: Share of the inertia force that a spring shall have to spare, for surge and for parts that flex.
RESERVE = 0.2


def train_quantities(
    solution: Solution, rigid: RigidCycle, events: Sequence[Event]
) -> dict[str, float]:
    """Numbers (SI) of one cycle; names follow docs/quantities.md."""
    lift, clearance = solution.channel("valve_lift"), "piston_clearance"
    counted = counted_quantities(solution)
    turn = 2 * np.pi / (solution.engine_speed / 2)
    values = {
        "peak_rigid_valve_lift": rigid.top, "lift_loss_displacement": rigid.top - counted.get("peak_valve_lift", ring_peak(lift)),
        "valve_open_duration": turn / TURN * covered(_open_spans(solution, events)),
        "loss_of_contact_duration": turn / TURN * covered(lost_spans(counted_losses(events), turn)),
    }  # fmt: skip
    if "peak_valve_acceleration" not in counted:
        values["peak_valve_acceleration"] = float(
            np.max(np.abs(solution.channel("valve_acceleration")))
        )
    # ``counted`` knows every step, samples only some: a number made of such a peak looks there first.
    if solution.has("cam_torque") and "peak_cam_torque" not in counted:
        torque = solution.channel("cam_torque")
        values |= {"peak_cam_torque": ring_peak(torque), "minimum_cam_torque": -ring_peak(-torque)}
    if "cycle_work_energy" in solution.statistics:
        values["mean_cam_torque"] = float(solution.statistics["cycle_work_energy"]) / (2 * np.pi)
        values["mean_cam_power"] = values["mean_cam_torque"] * solution.engine_speed / 2
    opened = rigid.valve_lift > 0.1 * np.max(rigid.valve_lift)
    for place in rigid.drive:
        name = f"{place}_contact_force"
        if solution.has(name):
            force = solution.channel(name)[opened]
            values[f"minimum_{name}"] = _number(solution, f"least_{name}", float(np.min(force)))
            values[f"peak_open_{name}"] = _number(solution, f"open_{name}", float(np.max(force)))
    if solution.has("cam_contact_force"):
        angle, force = solution.cam_angle, solution.channel("cam_contact_force")
        nose = ring_value(angle, force, rigid.nose)
        values["nose_cam_contact_force"] = _number(solution, "nose_cam_contact_force", nose)
        most = "peak_cam_contact_force_cam_angle"
        values[most] = _number(solution, most, float(angle[int(np.argmax(force))])) % TURN
    if solution.has("lever_speed"):
        rate = np.abs(solution.channel("lever_speed"))
        fastest = _number(
            solution, "peak_lever_speed_cam_angle", float(solution.cam_angle[int(np.argmax(rate))])
        )
        values |= {"peak_lever_speed": _number(solution, "peak_lever_speed", float(rate.max()))}
        values["peak_lever_speed_valve_lift"] = float(
            np.interp(fastest, solution.cam_angle, lift, period=TURN)
        )
    if solution.has(clearance):
        values["minimum_piston_clearance_gap"] = -ring_peak(-solution.channel(clearance))
    for spring in solution.springs:
        moved = solution.channel_of(spring, "axial_displacement")
        if solution.has(moved) and solution.channel(moved).size:
            values[f"{spring}_mean_peak_section_displacement"] = float(
                np.mean(np.max(-solution.channel(moved), axis=0))
            )
    return values | _event_numbers(events)


def _number(solution: Solution, name: str, sampled: float) -> float:
    """What the integrator saw of a number on every step; where it did not look, what the samples
    give.
    """
    logged = solution.statistics.get(name)
    return float(logged) if isinstance(logged, (int, float)) else sampled


def _open_spans(solution: Solution, events: Sequence[Event]) -> list[Span]:
    """Cam angles in which the valve is off its seat, of releases and touches where they are known."""
    touches = [
        event for event in of_kind(events, "seating") if "release_cam_angle" in event.details
    ]
    if not touches:
        return spans_above(solution.cam_angle, solution.channel("valve_lift"), SMALLEST_GAP)
    opened = [float(event.details["release_cam_angle"]) for event in touches]
    return [
        span_of(begin, begin + (event.cam_angle - begin) % TURN)
        for begin, event in zip(opened, touches, strict=True)
    ]


def margin_quantities(rigid: RigidTable) -> dict[str, float]:
    """Minimum surplus of the spring over inertia, weight and gas at the valve with rigid parts (N) and its ratio; the loads
    at which it is a fifth of the inertia force wherever the valve is slowed, at the same rate (none closed: at the least
    rate), and the rate that does so at the same preload; empty for a table without these columns.
    """
    if not {"spring_margin", "inertia_force"} <= set(rigid.columns):
        return {}
    margin, inertia, spring = (
        rigid[name] for name in ("spring_margin", "inertia_force", "spring_force")
    )
    slowing = (rigid["valve_lift"] > 0) & (inertia < 0)
    if not np.any(slowing):
        return {}
    surplus = margin[slowing]
    ratio = np.min(surplus / -inertia[slowing]) + 1
    lift = rigid["valve_lift"]
    closed, opened = float(spring[np.argmin(lift)]), float(spring[np.argmax(lift)])
    needed = needed_force(rigid)[slowing]
    more = float(np.max(needed - spring[slowing]))
    steeper = np.max((needed - closed) / lift[slowing])
    full = opened + more
    if closed + more < 0:  # no load closed is too much: the least rate from none
        full = float(np.max(needed / lift[slowing]) * np.max(lift))
    return {
        "minimum_spring_margin_force": float(np.min(surplus)), "minimum_spring_margin_ratio": float(ratio),
        "open_spring_force": opened, "needed_closed_spring_force": max(closed + more, 0.0),
        "needed_open_spring_force": full, "needed_spring_rate": max(float(steeper), 0.0),
    }  # fmt: skip


def needed_force(rigid: RigidTable) -> Array:
    """Spring force (N) that balances weight, gas and, where the valve is slowed, the inertia force plus :data:`RESERVE`."""
    reserve = RESERVE * np.maximum(-rigid["inertia_force"], 0.0)
    return rigid["spring_force"] - rigid["spring_margin"] + reserve


def _event_numbers(events: Sequence[Event]) -> dict[str, float]:
    seatings, bounces, lofts, floats = (
        of_kind(events, kind) for kind in ("seating", "bounce", LOFT, "float")
    )
    lofts = tuple(event for event in lofts if event.counts)
    first = next((event for event in seatings if event.details.get("touch") == 1), None)
    values = {
        "bounce_count": float(len(bounces)), "bounce_height": max((event.size for event in bounces), default=0.0),
        "loft_gap": max((event.size for event in lofts), default=0.0), "loft_count": float(len(lofts)),
        "loft_duration": sum(event.duration for event in lofts),
        "float_excess_lift": max((event.size for event in floats), default=0.0), "float_duration": sum(event.duration for event in floats),
    }  # fmt: skip
    return values | (
        {"seating_velocity": first.size, "seating_cam_angle": first.cam_angle}
        if first is not None
        else {}
    )


def of_kind(events: Sequence[Event], kind: str) -> tuple[Event, ...]:
    """The events of one kind."""
    return tuple(event for event in events if event.kind == kind)


_TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class OpenWindow:
    """Cam angles (rad) from ``begin`` to ``end`` in which the rigid lift is above
    :data:`OPEN_SHARE` of its largest, ``top`` (m).
    """

    begin: float
    end: float
    top: float

    @classmethod
    def of(cls, kinematics: RigidKinematics) -> OpenWindow:
        """That of a train's rigid kinematics."""
        return cls(*open_window(kinematics), top_of(kinematics))

    def holds(self, cam_angle: Array) -> Flags:
        """Whether cam angles (rad, unwrapped or not) are in it."""
        return np.asarray((cam_angle - self.begin) % _TURN <= self.end - self.begin)


def turn_quantities(
    system: TrainSystem, record: CycleRecord, window: OpenWindow
) -> dict[str, float]:
    """Numbers (SI) of one turn, by the names and rules of a steady cycle (docs/quantities.md).

    All but gaps and the lift above the rigid one are those of every step.
    """
    mechanism = system.mechanism
    lift = record.q[:, mechanism.index(mechanism.valve)]
    rigid = mechanism.kinematics.valve_lift(record.cam_angle)
    largest = float(record.bodies[mechanism.index(mechanism.valve), PEAK_PLACE])
    values = {
        f"peak_{load_name(one)}": float(record.peak_forces[k])
        for k, one in enumerate(mechanism.interactions)
    }
    values |= {
        f"minimum_{load_name(mechanism.interactions[k])}": float(record.least_forces[k])
        for k in mechanism.drive
    }
    values |= peak_forces(record) | {
        "peak_valve_lift": largest,
        "lift_loss_displacement": window.top - largest,
    }
    apart = record.gaps[:, list(mechanism.drive)]
    cam = record.gaps[:, mechanism.cam]
    inside = window.holds(record.cam_angle)
    values["loft_gap"] = float(np.max(cam[inside], initial=0.0))  # wide open any gap is a loft
    nose = (rigid > 0.3 * window.top) & (mechanism.kinematics.valve_lift(record.cam_angle, 2) < 0)
    excess = np.where(np.any(apart > SMALLEST_GAP, axis=1) & nose, lift - rigid, 0.0)
    values["float_excess_lift"] = float(
        np.max(np.where(excess > 10 * SMALLEST_GAP, excess, 0.0), initial=0.0)
    )
    return values | _seating(record, mechanism.seat, window)


def _seating(record: CycleRecord, seat: int | None, window: OpenWindow) -> dict[str, float]:
    """Velocity of the first touch of the seat after the valve was open; none in a turn that does
    not hold one.
    """
    if seat is None:
        return {}
    found = record.transitions.of(seat)
    closings = found.where(found.closes & (found.largest_gap > OPEN_SHARE * window.top))
    if not len(closings):
        return {}
    return {
        "seating_velocity": float(closings.gap_rate[0]),
        "seating_cam_angle": float(closings.cam_angle[0] % _TURN),
    }
