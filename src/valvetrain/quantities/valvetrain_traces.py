"""The curves of one steady cycle, light enough to send between processes and to store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.train_steady import SteadyTrain
from valvetrain.mechanism.crank import piston_clearance
from valvetrain.parameters.train import TrainParameters
from valvetrain.quantities.valvetrain_events import CycleData
from valvetrain.quantities.valvetrain_quantities import spring_outputs

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpringTraces:
    """One spring over the cycle: end forces (S,), section motion (S, n) from installed (m, seat to retainer positive), pair forces (S,
    p)."""

    name: str
    retainer_force: Array
    seat_force: Array
    coil_number: Array
    axial_displacement: Array
    upper_coil: Array
    coil_contact_force: Array

    @property
    def peak_section_displacement(self) -> Array:
        """Largest displacement (m, compression positive) of every section over the cycle (n,)."""
        return np.max(-self.axial_displacement, axis=0) if self.axial_displacement.size else np.zeros(0)


@dataclass(frozen=True, eq=False)
class CycleTraces:
    """Curves over ``cam_angle`` (S,) in rad; forces and gaps by place; ``springs`` outer first; SI units."""

    cam_angle: Array
    cam_speed: float
    valve_lift: Array
    valve_velocity: Array
    valve_acceleration: Array
    rigid_lift: Array
    forces: Mapping[str, Array]
    gaps: Mapping[str, Array]
    spring_force: Array
    static_spring_force: Array
    cam_torque: Array
    springs: tuple[SpringTraces, ...] = ()
    piston_clearance: Array | None = None
    lever_speed: Array | None = None


def cycle_traces(steady: SteadyTrain, data: CycleData, train: TrainParameters) -> CycleTraces:
    """Curves of a steady cycle; section motion of the springs where their states were recorded."""
    record, system = steady.record, steady.runner.system
    valve = system.mechanism.index(system.mechanism.valve)
    turning = [k for k, part in enumerate(system.mechanism.coordinates) if part.unit == "rad"]
    clearance = None if train.crank is None else piston_clearance(train.crank, data.cam_angle, data.valve_lift)
    return CycleTraces(
        cam_angle=data.cam_angle, cam_speed=data.cam_speed, valve_lift=data.valve_lift, valve_velocity=data.valve_velocity,
        valve_acceleration=record.a[:, valve], rigid_lift=data.rigid_lift, forces=data.forces, gaps=data.gaps,
        spring_force=data.spring_force, static_spring_force=data.static_spring_force, cam_torque=record.cam_power / record.cam_speed,
        springs=tuple(_spring_traces(steady, place) for place in range(len(steady.runner.springs))), piston_clearance=clearance,
        lever_speed=record.v[:, turning[0]] if turning else None,
    )  # fmt: skip


def _spring_traces(steady: SteadyTrain, place: int) -> SpringTraces:
    ends = steady.record.spring_forces[:, place]
    names = ("outer", "inner") if len(steady.runner.springs) > 1 else ("spring",)
    empty = np.zeros(0)
    if steady.record.spring_states[place].shape[1] == 0:
        return SpringTraces(names[place], ends[:, 0], ends[:, 1], empty, np.zeros((len(ends), 0)), empty, np.zeros((len(ends), 0)))
    found = spring_outputs(steady, place)
    return SpringTraces(
        names[place], ends[:, 0], ends[:, 1], found[0].coil_number, np.array([item.axial_displacement for item in found]),
        found[0].upper_coil, np.array([item.coil_contact_force for item in found]),
    )  # fmt: skip


def channels(traces: CycleTraces) -> xarray.Dataset:
    """The curves as a dataset with units and words, first dimension ``sample``."""
    import xarray

    words: dict[str, tuple[tuple[str, ...], Array, str, str]] = {
        "valve_lift": (("sample",), traces.valve_lift, "m", "valve lift"),
        "valve_velocity": (("sample",), traces.valve_velocity, "m/s", "valve velocity, opening positive"),
        "valve_acceleration": (("sample",), traces.valve_acceleration, "m/s2", "valve acceleration, opening positive"),
        "rigid_valve_lift": (("sample",), traces.rigid_lift, "m", "valve lift of rigid parts"),
        "retainer_force": (("sample",), traces.spring_force, "N", "force of all springs on the retainer"),
        "static_retainer_force": (("sample",), traces.static_spring_force, "N", "static spring force at the same lift"),
        "cam_torque": (("sample",), traces.cam_torque, "N m", "torque that drives the cam"),
    }
    for kind, unit, sentence in (("forces", "N", "force at"), ("gaps", "m", "gap at")):
        for name, values in getattr(traces, kind).items():
            words[f"{name.replace(' ', '_')}_{kind[:-1]}"] = (("sample",), values, unit, f"{sentence} {name}")
    for spring in traces.springs:
        words[f"{spring.name}_retainer_force"] = (("sample",), spring.retainer_force, "N", f"{spring.name}: force on the retainer")
        words[f"{spring.name}_seat_force"] = (("sample",), spring.seat_force, "N", f"{spring.name}: force on the seat")
        if spring.coil_number.size:
            dims = ("sample", f"{spring.name}_wire_point")
            words[f"{spring.name}_axial_displacement"] = (
                dims,
                spring.axial_displacement,
                "m",
                f"{spring.name}: section motion from installed",
            )
    if traces.piston_clearance is not None:
        words["piston_clearance"] = (("sample",), traces.piston_clearance, "m", "clearance between piston and valve")
    coords = {
        "time": (("sample",), traces.cam_angle / traces.cam_speed, {"units": "s", "long_name": "time"}),
        "cam_angle": (("sample",), traces.cam_angle, {"units": "rad", "long_name": "cam angle, unwrapped"}),
    }
    for spring in traces.springs:
        if spring.coil_number.size:
            label = {"units": "1", "long_name": f"{spring.name}: turns (or share) along the spring"}
            coords[f"{spring.name}_coil_number"] = ((f"{spring.name}_wire_point",), spring.coil_number, label)
    return xarray.Dataset(
        {name: (dims, values, {"units": unit, "long_name": text}) for name, (dims, values, unit, text) in words.items()}, coords
    )
