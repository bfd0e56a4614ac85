"""Channels of a train from the records of its compiled loop, by the names of docs/architecture.md."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.integrate.contract import RunOptions
from valvetrain.integrate.train_record import CycleRecord, TrainState
from valvetrain.integrate.train_run import TrainRunner
from valvetrain.integrate.train_tuples import (
    HIGHEST,
    HIGHEST_ANGLE,
    LOADS,
    LOWEST,
    LOWEST_ANGLE,
    PEAK_ACCELERATION,
    PEAK_PLACE,
    PEAK_SPEED,
    PEAK_SPEED_ANGLE,
)
from valvetrain.integrate.transitions import CONTACTS_LOGGED, openings_by_law
from valvetrain.mechanism.parts import CONTACT, Coordinate, Interaction
from valvetrain.mechanism.planar import crank_angle, piston_clearance
from valvetrain.mechanism.rigid import OPEN_SHARE
from valvetrain.solution.channels import SPRING_CHANNELS, ChannelArrays, Variable
from valvetrain.springs.contract import LargeSpring, SpringModel, SpringOutputs, outputs_at
from valvetrain.system.train_rest import TrainRest
from valvetrain.system.train_system import TrainSystem


def load_name(interaction: Interaction) -> str:
    """Channel of an interaction's load: ``valve tip`` -> ``valve_tip_contact_force``, ``pushrod bar``
    -> ``pushrod_bar_force``, ``lever bending`` -> ``lever_bending_moment``.
    """
    contact = "_contact" if interaction.role == CONTACT else ""
    return f"{interaction.name.replace(' ', '_')}{contact}_{interaction.load[0]}"


def position_name(part: Coordinate, valve: str) -> str:
    """Channel of a body's coordinate: ``valve_lift`` of the valve, ``tappet_displacement``,
    ``lever_angle`` and so on of the others.
    """
    if part.name == valve:
        return "valve_lift"
    return f"{part.name.replace(' ', '_')}_{'angle' if part.unit == 'rad' else 'displacement'}"


def train_channels(
    system: TrainSystem,
    rest: TrainRest,
    records: Sequence[CycleRecord],
    start: TrainState | None = None,
) -> ChannelArrays:
    """Records as channels: of one closed turn with the state ``start`` that it began from, for the
    springs' inner motion, or of a run-up without one.
    """
    mechanism, arrays = system.mechanism, system.arrays
    valve, retainer = mechanism.index(mechanism.valve), arrays.retainer

    def all_of(name: str) -> Array:
        parts = [getattr(record, name) for record in records]
        return np.asarray(parts[0]) if len(parts) == 1 else np.concatenate(parts)

    q, v, a, forces, gaps, ends = (
        all_of(name) for name in ("q", "v", "a", "forces", "gaps", "spring_forces")
    )
    first = records[0]
    if (
        start is None
    ):  # a run-up: the true angle, unwrapped; every stretch takes the time of the first
        angle = all_of("cam_angle")
        time = np.arange(len(angle)) * (2 * np.pi / first.cam_speed / len(first.q))
        speed = np.gradient(angle, time) if len(angle) > 2 else np.full(len(angle), first.cam_speed)
    else:
        angle = np.arange(len(q)) * 2 * np.pi / len(q)
        time, speed = angle / first.cam_speed, np.full(len(q), first.cam_speed)
    table: dict[str, tuple[Array, str, str]] = {
        "valve_lift": (q[:, valve], "m", "valve lift"), "valve_velocity": (v[:, valve], "m/s", "valve velocity, opening positive"),
        "valve_acceleration": (a[:, valve], "m/s2", "valve acceleration, opening positive"),
        "retainer_velocity": (v[:, retainer], "m/s", "retainer velocity, opening positive"),
        "retainer_acceleration": (a[:, retainer], "m/s2", "retainer acceleration, opening positive"),
        "retainer_force": (ends[:, :, 0].sum(axis=1), "N", "force of all springs on the retainer"),
        "seat_force": (ends[:, :, 1].sum(axis=1), "N", "force of all springs on the cylinder head"),
        "static_retainer_force": (rest.static_spring_force(q[:, retainer]), "N", "spring force at rest at the same lift"),
        "cam_torque": (all_of("cam_power") / speed, "N m", "torque that drives the cam"),
    }  # fmt: skip
    for k, part in enumerate(mechanism.coordinates):
        if k != valve:
            label = f"{part.name}: {'turned' if part.unit == 'rad' else 'moved'} from the closed valve's rigid pose, opening positive"
            table[position_name(part, mechanism.valve)] = (q[:, k], part.unit, label)
    turning = [k for k, part in enumerate(mechanism.coordinates) if part.unit == "rad"]
    if turning:
        table["lever_speed"] = (v[:, turning[0]], "rad/s", "turning speed of the lever")
    if system.crank is not None:
        clearance = piston_clearance(system.crank, angle, q[:, valve])
        table["piston_clearance"] = (clearance, "m", "clearance between piston and valve")
        turned = crank_angle(system.crank, angle)
        table["crank_angle"] = (turned, "rad", "crank angle from top dead centre of gas exchange")
    for k, one in enumerate(mechanism.interactions):
        load, unit = one.load
        table[load_name(one)] = (forces[:, k], unit, f"{load} at {one.name}")
        if one.role == CONTACT:
            label = f"gap at {one.name}, open positive"
            table[f"{one.name.replace(' ', '_')}_gap"] = gaps[:, k], one.unit or "m", label
    variables = {
        name: Variable(("sample",), values, {"units": unit, "long_name": label})
        for name, (values, unit, label) in table.items()
    }
    coords = {
        "time": Variable(("sample",), time, {"units": "s", "long_name": "time"}),
        "cam_angle": Variable(
            ("sample",), angle, {"units": "rad", "long_name": "cam angle, unwrapped"}
        ),
    }
    single = len(system.springs) == 1
    for place, (spring, word) in enumerate(zip(system.springs, system.spring_names, strict=True)):
        prefix = "" if single else f"{word}_"
        if not single:
            for side, name, label in (
                (0, "retainer_force", "on the retainer"),
                (1, "seat_force", "on the cylinder head"),
            ):
                variables[f"{prefix}{name}"] = Variable(
                    ("sample",),
                    ends[:, place, side],
                    {"units": "N", "long_name": f"{word} spring: force {label}"},
                )
        if start is not None and first.spring_states[place].shape[1]:
            _add_sections(
                variables,
                coords,
                prefix,
                spring_outputs(spring, first, start.springs[place], place, retainer),
            )
    return ChannelArrays(variables, coords)


def _add_sections(
    variables: dict[str, Variable],
    coords: dict[str, Variable],
    prefix: str,
    outputs: list[SpringOutputs],
) -> None:
    heading = prefix.replace("_", " spring: ")
    if outputs[0].coil_number.size:
        dims = ("sample", f"{prefix}wire_point")
        label = {
            "units": "1",
            "long_name": f"{heading}turns from the lower wire tip, or share of the active length",
        }
        coords[f"{prefix}coil_number"] = Variable(dims[1:], outputs[0].coil_number, label)
        for name, unit, text in (
            (
                "axial_displacement",
                "m",
                "axial displacement from the installed state, seat to retainer positive",
            ),
            ("axial_velocity", "m/s", "axial velocity, seat to retainer positive"),
        ):
            values = np.array([getattr(one, name) for one in outputs])
            variables[f"{prefix}{name}"] = Variable(
                dims, values, {"units": unit, "long_name": f"{heading}{text}"}
            )
        for name in outputs[0].section_loads:
            _, unit, text = SPRING_CHANNELS[name]
            values = np.array([one.section_loads[name] for one in outputs])
            variables[f"{prefix}{name}"] = Variable(
                dims, values, {"units": unit, "long_name": f"{heading}{text}"}
            )
    if outputs[0].upper_coil.size:
        dims = ("sample", f"{prefix}coil_pair")
        coords[f"{prefix}upper_coil"] = Variable(
            dims[1:],
            outputs[0].upper_coil,
            {"units": "1", "long_name": f"{heading}coil number of the upper partner"},
        )
        for name, unit, text in (
            ("coil_gap", "m", "gap between a coil and the one below"),
            ("coil_contact_force", "N", "contact force on the coil below"),
        ):
            values = np.array([getattr(one, name) for one in outputs])
            variables[f"{prefix}{name}"] = Variable(
                dims, values, {"units": unit, "long_name": f"{heading}{text}"}
            )


def spring_outputs(
    spring: SpringModel, record: CycleRecord, start: Array, place: int, retainer: int
) -> list[SpringOutputs]:
    """What one spring shows at every sample of a record, from its recorded states."""
    states, q, v = record.spring_states[place], record.q[:, retainer], record.v[:, retainer]
    whole = np.array(start, dtype=float)
    whole[: 2 * spring.unknowns] = 0.0  # velocities that a large model did not record count as zero
    if not isinstance(spring, LargeSpring):
        every = np.tile(whole, (len(states), 1))
        every[:, : states.shape[1]] = states
        return outputs_at(spring, every, q, v)
    # its positions belong to the retainer's place of the step before
    step, found = record.time_step, list[SpringOutputs]()
    travels = step * (v - 0.5 * step * record.a[:, retainer])
    for row, x, speed, travel in zip(states, q.tolist(), v.tolist(), travels.tolist(), strict=True):
        whole[: states.shape[1]] = row
        spring.place_retainer(whole, x, travel)
        found.append(spring.outputs(whole, x, speed))
    return found


def train_statistics(
    system: TrainSystem, record: CycleRecord
) -> dict[str, float | int | str | bool]:
    """What the loop found on every step: peak forces, works; by the names of docs/quantities.md."""
    found: dict[str, float | int | str | bool] = {
        f"peak_{load_name(one)}": float(record.peak_forces[k])
        for k, one in enumerate(system.mechanism.interactions)
    }
    found |= _every_step(system, record)
    return found | {
        "cycle_work_energy": float(record.work[0]),
        "cycle_dissipated_energy": float(record.work[2]),
        "spring_dissipated_energy": float(record.work[3]),
        "contact_friction_dissipated_energy": record.friction_loss,
    }


def peak_forces(record: CycleRecord) -> dict[str, float]:
    """Peak forces (N) of all springs below the cut-off and raw, the duration of the raw ones, and the
    least forces of every step.
    """
    found: dict[str, float] = {}
    for load, word in (("seat", "spring_force"), ("retainer", "retainer_force")):
        row = record.loads[LOADS.index(load)]
        found |= {f"raw_peak_{word}": float(row[HIGHEST]), f"minimum_{word}": float(row[LOWEST])}
        found |= record.force_peak(load).quantities(word)
    return found


def _every_step(system: TrainSystem, record: CycleRecord) -> dict[str, float]:
    """Extremes of loads and bodies over all steps, and whether the log of contacts holds all
    openings and closings.
    """
    mechanism, turn = system.mechanism, 2 * np.pi
    loads = dict(zip(LOADS, record.loads.tolist(), strict=True))
    found: dict[str, float] = {}
    found |= peak_forces(record)
    found |= {
        "peak_spring_force_cam_angle": turn * record.force_peak("seat").place,
        "raw_peak_spring_force_cam_angle": loads["seat"][HIGHEST_ANGLE] % turn,
        "minimum_spring_force_cam_angle": loads["seat"][LOWEST_ANGLE] % turn,
    }
    if len(system.springs) > 1:
        for name, side in zip(system.spring_names, ("first", "second"), strict=True):
            found |= {
                f"{name}_peak_spring_force": record.force_peak(f"{side}_seat").below,
                f"{name}_minimum_spring_force": loads[f"{side}_seat"][2],
            }
    if mechanism.cam is not None:
        at = float(record.peak_force_cam_angles[mechanism.cam])
        found["peak_cam_contact_force_cam_angle"] = at % turn
    found |= {"peak_cam_torque": loads["torque"][0], "minimum_cam_torque": loads["torque"][2]}
    valve = record.bodies[mechanism.index(mechanism.valve)]
    found |= {
        "peak_valve_lift": float(valve[PEAK_PLACE]),
        "peak_valve_acceleration": float(valve[PEAK_ACCELERATION]),
    }
    turning = [k for k, part in enumerate(mechanism.coordinates) if part.unit == "rad"]
    if turning:
        lever = record.bodies[turning[0]]
        found |= {
            "peak_lever_speed": float(lever[PEAK_SPEED]),
            "peak_lever_speed_cam_angle": float(lever[PEAK_SPEED_ANGLE]) % turn,
        }
    return found | {CONTACTS_LOGGED: float(record.transitions.overflow == 0)}


def least_forces(system: TrainSystem, record: CycleRecord, options: RunOptions) -> dict[str, float]:
    """Least and largest force (N) of every contact of the drive over all steps in the window of
    ``options``, and that of the cam at the nose; nothing where none was requested.
    """
    if options.window is None or not len(record.least_forces):
        return {}
    found: dict[str, float] = {}
    for place in system.mechanism.drive:
        name = load_name(system.mechanism.interactions[place])
        found |= {
            f"least_{name}": float(record.least_forces[place]),
            f"open_{name}": float(record.largest_forces[place]),
        }
    if options.nose is not None and (cam := system.mechanism.cam) is not None:
        found["nose_cam_contact_force"] = float(record.nose_forces[cam])
    return found


COMPARED = 8
"""Cycles that are compared."""
EQUAL, NO_LENGTH = 1e-3, 1e-7
"""Share, and length (m), by which the numbers of two cycles that are taken for the same may differ."""
STEADY_VALVE = 1e-2
"""Share of the largest lift up to which the valve is taken to repeat."""
LONG_SEARCH = 30
"""Cycles after which what still changes is taken for rattle, not for a motion that has yet to
settle.
"""
SMALLEST_HEIGHT = 2e-6
"""Openings of the seat below this (m) are vibration, no bounce."""
PREFIX = "cycle_scatter_"
LANDING_ENDS = "least_landing_cam_angle", "largest_landing_cam_angle"
"""Cam angles (rad) between which the largest flight of each compared cycle lands on the cam."""


@dataclass(frozen=True)
class Scatter:
    """Over :data:`COMPARED` cycles: ``valve`` (m), largest spread of the valve lift at one cam
    angle; ``peak_valve_lift`` (m), the largest; ``numbers``: largest less least value of each
    number (SI) by the name of its quantity; ``on_cam``: whether the cam touches in one of them;
    ``landings``: cam angles (rad) at which the largest flight off the cam of each ends.
    """

    valve: float
    peak_valve_lift: float
    numbers: dict[str, float]
    on_cam: bool = True
    landings: tuple[float, ...] = ()

    @property
    def repeats(self) -> bool:
        """Whether the valve does the same in every cycle, whatever loose parts do."""
        return self.valve <= STEADY_VALVE * self.peak_valve_lift

    @property
    def statistics(self) -> dict[str, float]:
        """The scatter by the names of docs/quantities.md."""
        found = {PREFIX + "valve_lift": self.valve} | {
            PREFIX + name: value for name, value in self.numbers.items()
        }
        if not self.landings:
            return found
        last, turn = self.landings[-1], 2 * np.pi
        apart = [(one - last + np.pi) % turn - np.pi for one in self.landings]
        ends = ((last + one) % turn for one in (min(apart), max(apart)))
        return found | dict(zip(LANDING_ENDS, ends, strict=True))


def cycle_numbers(system: TrainSystem, record: CycleRecord) -> dict[str, float]:
    """Headline numbers (SI) of one cycle alone, as docs/quantities.md names them."""
    mechanism = system.mechanism
    peaks = peak_forces(record).items()
    found = {name: value for name, value in peaks if not name.endswith("_duration")}
    valve = record.bodies[mechanism.index(mechanism.valve)]
    found |= {
        "cycle_work_energy": float(record.work[0]),
        "peak_valve_lift": float(valve[PEAK_PLACE]),
        "peak_valve_acceleration": float(valve[PEAK_ACCELERATION]),
    }
    cam, seat_place = mechanism.cam, mechanism.seat
    for place, one in enumerate(mechanism.interactions):
        if one.role == CONTACT:
            found[f"peak_{load_name(one)}"] = float(record.peak_forces[place])
        if place in mechanism.drive:
            found[f"minimum_{load_name(one)}"] = float(record.least_forces[place])
    kinematics, lift = mechanism.kinematics, np.zeros_like(record.cam_angle)
    if cam is not None and kinematics is not None:
        lift = kinematics.valve_lift(record.cam_angle)
        opened = record.gaps[lift > OPEN_SHARE * lift.max(), cam]
        found["loft_gap"] = float(np.max(opened, initial=0.0))
        found["nose_cam_contact_force"] = float(record.nose_forces[cam])
    if seat_place is None:
        return found
    openings, own = (
        record.transitions.open_stretches(seat_place),
        record.transitions.of(seat_place),
    )
    spans = np.column_stack([own.cam_angle[np.flatnonzero(own.closes) - 1], openings.cam_angle])
    high = openings.largest_gap > SMALLEST_HEIGHT
    heights = openings.largest_gap[high]
    heights = np.delete(heights, openings_by_law(spans[high], heights, record.cam_angle, lift))
    found |= {
        "bounce_count": float(len(heights)), "bounce_height": float(np.max(heights, initial=0.0))
    }  # fmt: skip
    velocity = record.transitions.seating_velocity(seat_place)
    return found if velocity is None else found | {"seating_velocity": velocity}


def landing_angle(system: TrainSystem, record: CycleRecord) -> float | None:
    """Cam angle (rad) at which the largest flight off the cam ends, the rigid valve being off its seat at
    its largest gap; None without a flight.
    """
    kinematics, cam = system.mechanism.kinematics, system.mechanism.cam
    if cam is None or kinematics is None:
        return None
    found = record.transitions.open_stretches(cam)
    found = found.where(kinematics.valve_lift(found.largest_gap_cam_angle) > 0)
    return float(found.cam_angle[np.argmax(found.largest_gap)]) if len(found) else None


def scatter_of(
    runner: TrainRunner, start: TrainState, unless_equal: bool = False
) -> tuple[Scatter | None, TrainState]:
    """The spread over :data:`COMPARED` plain cycles from ``start``, and the state at the beginning
    of the last of them; None after two that are equal to :data:`EQUAL`, where requested.
    """
    bare = replace(
        runner, options=replace(runner.options, record_springs=False, record_contacts=False)
    )
    valve = runner.system.mechanism.index(runner.system.mechanism.valve)
    lifts, numbers, state, first, on_cam = [], [], start, start, False
    landings: list[float | None] = []
    for _ in range(COMPARED):
        first = state
        end, record = bare.cycle(state, judged=False)
        state = replace(end, cam_angle=0.0)
        lifts.append(record.q[:, valve])
        numbers.append(cycle_numbers(runner.system, record))
        landings.append(landing_angle(runner.system, record))
        on_cam = on_cam or record.touches_cam(runner.system)
        if unless_equal and len(numbers) == 2 and numbers[0].keys() == numbers[1].keys():
            before, after = (np.array(list(one.values())) for one in numbers)
            if np.allclose(before, after, rtol=EQUAL, atol=NO_LENGTH):
                return None, first
    spread = float(np.max(np.ptp(np.array(lifts), axis=0)))
    names = [name for name in numbers[0] if all(name in one for one in numbers)]
    return Scatter(
        spread,
        float(np.max(lifts)),
        {name: _range(one[name] for one in numbers) for name in names},
        on_cam,
        tuple(one for one in landings if one is not None),
    ), first


def _range(values: Iterable[float]) -> float:
    return float(np.ptp(list(values)))
