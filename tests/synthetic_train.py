"""Closed cycles of a train with a known answer, made of plain formulas."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event

COUNT, CAM_SPEED = 1440, 200.0
ANGLE = np.arange(COUNT) * 2 * np.pi / COUNT
TIME = ANGLE / CAM_SPEED


def degrees(first: float, last: float) -> np.ndarray:
    """Mask of the samples from ``first`` to ``last`` cam degrees."""
    place = np.degrees(ANGLE)
    return (place >= first) & (place < last)


def lift_of(angle: np.ndarray) -> np.ndarray:
    """Open from 90 to 270 degrees, 8 mm at 180."""
    turned = np.mod(angle, 2 * np.pi)
    return np.where(
        (turned >= np.pi / 2) & (turned < 1.5 * np.pi), 8e-3 * np.sin(turned - np.pi / 2) ** 2, 0.0
    )


def rigid(**changes) -> RigidTable:
    """Rigid table of that lift: contact force 400 N, falling over the nose from 135 to 225 degrees."""
    columns = {
        "valve_lift": lift_of(ANGLE),
        "valve_acceleration": np.where(degrees(135, 225), -1000.0, 1000.0),
        "contact_force": 400.0 + 0 * ANGLE,
        "valve_tip_contact_force": 300.0 + 0 * ANGLE,
    }
    return RigidTable(ANGLE, CAM_SPEED, columns | changes)


def train(
    events: tuple[Event, ...] = (),
    springs=("spring",),
    statistics=None,
    label="",
    pairs=None,
    **changes,
) -> Solution:
    """A valve that follows its rigid lift, no gap anywhere; ``changes``: channels; ``pairs``:
    spring -> (upper_coil, force, gap).
    """
    import xarray

    lift = np.where(degrees(90, 270), lift_of(ANGLE), -1e-6)
    values = {
        "valve_lift": lift, "valve_velocity": np.gradient(lift, TIME), "valve_acceleration": np.gradient(np.gradient(lift, TIME), TIME),
        "cam_gap": np.full(COUNT, -1e-5), "valve_tip_gap": np.full(COUNT, -1e-5), "cam_contact_force": np.full(COUNT, 500.0),
        "valve_tip_contact_force": np.full(COUNT, 300.0), "retainer_force": np.full(COUNT, 500.0), "seat_force": np.full(COUNT, 500.0),
        "static_retainer_force": np.full(COUNT, 500.0),
    }  # fmt: skip
    words = {"units": "1", "long_name": "made up"}
    variables = {name: (("sample",), array, words) for name, array in (values | changes).items()}
    coords = {"time": (("sample",), TIME), "cam_angle": (("sample",), ANGLE)}
    for name, (upper, force, gap) in (pairs or {}).items():
        first = f"{name}_" if len(springs) > 1 else ""
        coords[f"{first}upper_coil"] = ((f"{first}coil_pair",), np.asarray(upper, dtype=float))
        variables[f"{first}coil_contact_force"] = (("sample", f"{first}coil_pair"), force, words)
        variables[f"{first}coil_gap"] = (("sample", f"{first}coil_pair"), gap, words)
    where = Provenance(
        "synthetic", "multi-mass", 2 * CAM_SPEED, label=label, system="train", springs=springs
    )
    return Solution(
        xarray.Dataset(variables, coords=coords),
        events,
        provenance=where,
        statistics=statistics or {},
    )


def found(solution: Solution | None = None, table: RigidTable | None = None, **changes) -> Solution:
    """The made-up train with its events and numbers."""
    return evaluate(solution or train(**changes), Frame(rigid=table or rigid()))
