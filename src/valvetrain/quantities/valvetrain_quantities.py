"""Named numbers of one steady cycle of a train, and the data its events are found in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.train_steady import SteadyTrain
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.quantities.valvetrain_events import CycleData, clash_events, find_events, of_kind
from valvetrain.solution.event import Event

Array = NDArray[np.float64]
TURN = 2 * np.pi
ORDERS = 20
"""Cam orders whose surge amplitude is told."""


def cycle_data(steady: SteadyTrain, table: RigidTable) -> CycleData:
    """What the events and numbers of a cycle are read from; the rigid table may have any number of samples."""
    record, system = steady.record, steady.runner.system
    valve, retainer = system.mechanism.index(system.mechanism.valve), system.arrays.retainer
    angle = np.arange(len(record.q)) * TURN / len(record.q)
    ring = np.append(table.cam_angle, TURN)
    rigid = {
        name: np.interp(angle, ring, np.append(table[name], table[name][0]))
        for name in ("valve_lift", "valve_acceleration", "contact_force")
    }
    lift = record.q[:, retainer]
    grid = np.linspace(min(float(lift.min()), 0.0), float(lift.max()) + 1e-6, 33)
    static = np.interp(lift, grid, system.spring_forces(grid))
    names = system.interaction_names
    return CycleData(
        cam_angle=angle, cam_speed=record.cam_speed, valve_lift=record.q[:, valve], valve_velocity=record.v[:, valve],
        rigid_lift=rigid["valve_lift"], rigid_acceleration=rigid["valve_acceleration"],
        gaps={name: record.gaps[:, k] for k, name in enumerate(names)}, forces={name: record.forces[:, k] for k, name in enumerate(names)},
        rigid_force=rigid["contact_force"], spring_force=record.spring_forces[:, :, 0].sum(axis=1), static_spring_force=static,
    )  # fmt: skip


def cycle_events(steady: SteadyTrain, data: CycleData) -> tuple[Event, ...]:
    """Events of the train and, where spring states were recorded, clashes of their coils."""
    found = list(find_events(data))
    for place, spring in enumerate(steady.runner.springs):
        states = steady.record.spring_states[place]
        if states.shape[1] == 0:
            continue
        upper, force = coil_contacts(steady, place)
        if len(upper):
            name = ("outer spring", "inner spring")[place] if len(steady.runner.springs) > 1 else "spring"
            found += clash_events(data.cam_angle, data.cam_speed, upper, force, name)
        del spring
    return tuple(sorted(found, key=lambda event: event.cam_angle))


def coil_contacts(steady: SteadyTrain, place: int) -> tuple[Array, Array]:
    """Upper coil numbers (pairs,) and contact forces (S, pairs) of one spring from its recorded states."""
    outputs = spring_outputs(steady, place)
    return outputs[0].upper_coil, np.array([output.coil_contact_force for output in outputs])


def spring_outputs(steady: SteadyTrain, place: int) -> list:
    """:class:`SpringOutputs` of one spring at every sample. Needs ``record_springs``."""
    if place not in steady.known:
        steady.known[place] = _spring_outputs(steady, place)
    return list(steady.known[place])


def _spring_outputs(steady: SteadyTrain, place: int) -> list:
    from valvetrain.springs.finite_element_kernel import TRAVEL

    record, spring = steady.record, steady.runner.springs[place]
    retainer = steady.runner.system.arrays.retainer
    states, found = record.spring_states[place], []
    whole = np.array(steady.start.springs[place], dtype=float)
    whole[: 2 * spring.unknowns] = 0.0  # velocities that a large model did not record count as zero
    for row in range(len(states)):
        whole[: states.shape[1]] = states[row]
        if spring.name == "finite-element":
            # the rod's state also holds the retainer's place of the step before, to which its held vertices belong
            step, a = record.time_step, float(record.a[row, retainer])
            before = float(record.q[row, retainer]) - step * (float(record.v[row, retainer]) - 0.5 * step * a)
            whole[TRAVEL] = spring.precompression + before
        found.append(spring.outputs(whole, float(record.q[row, retainer]), float(record.v[row, retainer])))
    return found


def cycle_quantities(steady: SteadyTrain, data: CycleData, table: RigidTable, events: Sequence[Event]) -> dict[str, float]:
    """Named numbers (SI) of one steady cycle; names follow docs/quantities.md."""
    record, system = steady.record, steady.runner.system
    values = _contact_numbers(steady, data)
    values |= {
        "peak_valve_lift": float(data.valve_lift.max()), "peak_rigid_valve_lift": float(data.rigid_lift.max()),
        "lift_loss_displacement": float(data.rigid_lift.max() - data.valve_lift.max()),
        "peak_valve_acceleration": float(np.max(np.abs(record.a[:, system.mechanism.index(system.mechanism.valve)]))),
        "peak_retainer_force": float(data.spring_force.max()), "minimum_retainer_force": float(data.spring_force.min()),
        "cycle_work_energy": float(record.work[0]), "cycle_dissipated_energy": float(record.work[2]),
        "spring_dissipated_energy": float(record.work[3]), "contact_friction_dissipated_energy": record.friction_loss,
        "steady_cycles_count": float(steady.search.cycles), "steady_residual_ratio": float(steady.search.residuals[-1]),
        "steady_tolerance_ratio": steady.tolerance, "motion_period_count": float(steady.search.period),
        "time_step_duration": record.time_step, "steps_per_cycle_count": float(steady.runner.steps),
    }  # fmt: skip
    values |= _event_numbers(events)
    values |= {f"surge_order_{order}_force": float(size) for order, size in enumerate(surge_orders(data)) if order > 0}
    turning = [k for k, part in enumerate(system.mechanism.coordinates) if part.unit == "rad"]
    if turning:
        rate = np.abs(record.v[:, turning[0]])
        values["peak_lever_speed"] = float(rate.max())
        values["peak_lever_speed_valve_lift"] = float(data.valve_lift[int(np.argmax(rate))])
    del table
    return values


def surge_orders(data: CycleData, orders: int = ORDERS) -> Array:
    """Amplitude (N, 0 to peak) per cam order 0 to ``orders`` of the spring force less its static value at the same lift."""
    spectrum = np.fft.rfft(data.spring_force - data.static_spring_force) / len(data.spring_force)
    return 2 * np.abs(spectrum[: orders + 1])


def _contact_numbers(steady: SteadyTrain, data: CycleData) -> dict[str, float]:
    """Peak force of every interaction over all steps; least force of the driving contacts while the valve is well open."""
    record, names = steady.record, steady.runner.system.interaction_names
    values = {f"peak_{_word(name)}_force": float(record.peak_forces[k]) for k, name in enumerate(names)}
    opened = data.rigid_lift > 0.1 * np.max(data.rigid_lift)
    for name in ("cam", "valve tip"):
        if name in data.forces:
            values[f"minimum_{_word(name)}_force"] = float(np.min(data.forces[name][opened]))
            values[f"peak_open_{_word(name)}_force"] = float(np.max(data.forces[name][opened]))
    values["nose_cam_contact_force"] = float(data.forces["cam"][int(np.argmax(data.rigid_lift))])
    return values


def _word(name: str) -> str:
    """``valve tip`` -> ``valve_tip_contact``; elastic links keep their own name."""
    plain = name.replace(" ", "_")
    return f"{plain}_contact" if name in ("cam", "tappet", "rocker", "valve tip", "seat") else plain


def _event_numbers(events: Sequence[Event]) -> dict[str, float]:
    seatings, bounces, floats = of_kind(events, "seating"), of_kind(events, "bounce"), of_kind(events, "float")
    lofts, clashes = of_kind(events, "loft"), of_kind(events, "clash")
    first = [event for event in seatings if event.details.get("touch") == 1]
    values = {
        "seating_velocity": first[0].size if first else 0.0, "bounce_count": float(len(bounces)),
        "bounce_height": max((event.size for event in bounces), default=0.0),
        "loft_gap": max((event.size for event in lofts), default=0.0), "loft_count": float(len(lofts)),
        "loft_duration": sum(event.duration for event in lofts),
        "float_excess_lift": max((event.size for event in floats), default=0.0), "float_duration": sum(event.duration for event in floats),
        "clash_count": float(len(clashes)), "peak_clash_force": max((event.size for event in clashes), default=0.0),
    }  # fmt: skip
    if first:
        values["seating_cam_angle"] = first[0].cam_angle
    return values
