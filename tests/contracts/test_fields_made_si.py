"""Every field and argument that the package makes SI takes text with a unit; those of the source
are found, so none is forgotten.
"""

from __future__ import annotations

import ast
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import valvetrain as vt
from spring_shapes import cylindrical
from valvetrain.cosserat.batch import simulate_batch
from valvetrain.parameters.case import Operation
from valvetrain.parameters.installed_spring import CoilContact, InstalledSpring
from valvetrain.parameters.schema_types import Table
from valvetrain.parameters.train_parts import (
    CamParameters,
    CrankParameters,
    FollowerParameters,
    LeverParameters,
    PushrodParameters,
    SupportParameters,
    ValveParameters,
)
from valvetrain.quantities.statics import buckling_compression
from valvetrain.runs.request_fields import Answers
from valvetrain.runs.requests import Sweep
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.status import Status
from valvetrain.spring_card.card import CatalogueCard, SpringLoad

SOURCE = Path(vt.__file__).parent
SPRING = cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
UNIFORM = vt.springs.EquivalentSpring(40e3, 300.0, 0.05)
RATE, MASS, FORCE, LENGTH, SECOND, PER_SECOND = "40 N/mm", "50 g", "300 N", "5 mm", "2 us", "25 1/s"
IN_SI = {
    RATE: 40e3,
    MASS: 0.05,
    FORCE: 300.0,
    LENGTH: 0.005,
    SECOND: 2e-6,
    PER_SECOND: 25.0,
    "30 N/mm^2": 30e6,
    "2 deg": np.pi / 90,
    "5 kHz": 5000.0,
    "2000 rpm": 2000 * np.pi / 30,
    "8 mm": 0.008,
    "12 mm": 0.012,
    "600 mm/s": 0.6,
    "7.8 g/cm^3": 7800.0,
}
LOADS = SpringLoad("46 mm", "350 N"), SpringLoad("34 mm", "830 N")
CATALOGUE = CatalogueCard(
    wire_diameter=4.2e-3, outer_diameter=0.032, installed_load=LOADS[0], open_load=LOADS[1]
)
IN_SI |= {
    "2000 1/s": 2000.0,
    "4.2 mm": 4.2e-3,
    "32 mm": 0.032,
    "30 mm": 0.030,
    "29 mm": 0.029,
    "54.75 mm": 0.05475,
    "46 mm": 0.046,
    "150 mm": 0.15,
    "25 N s/m": 25.0,
    "2 N m": 2.0,
    "2e-5 kg m^2": 2e-5,
    "40 %": 0.4,
}
DAMPING = "25 N s/m"
#: Class -> one of it, and the fields that are given in text.
PARTS: dict[str, tuple[Callable[[], Any], dict[str, str]]] = {
    "CoilContact": (CoilContact, {"stiffness": "30 N/mm^2", "damping_time": SECOND}),
    "InstalledSpring": (lambda: InstalledSpring(wire=SPRING), {"precompression": LENGTH}),
    "Operation": (Operation, {"output_step": "2 deg", "red_line": "2000 rpm", "force_bandwidth": "5 kHz"}),
    "Guide": (lambda: vt.parameters.Guide(bore=0.03, rod=0.012), {"bore": LENGTH, "rod": "8 mm", "stiffness": "30 N/mm^2"}),
    "Quantity": (lambda: vt.solution.Quantity("peak_seat_force"), {"engine_speed": "2000 rpm"}),
    "EquivalentSpring": (lambda: UNIFORM, {"rate": RATE, "preload": FORCE, "active_mass": MASS, "inactive_mass": MASS}),
    "MasslessSpring": (lambda: vt.springs.MasslessSpring(1e4, 10.0),
                       {"rate": RATE, "preload": FORCE, "active_mass": MASS, "inactive_mass": MASS}),
    "MasslessTable": (lambda: vt.springs.MasslessTable((0.0, 0.01), (0.0, 300.0)), {"active_mass": MASS, "inactive_mass": MASS}),
    "ModalUniform": (lambda: vt.springs.ModalUniform(UNIFORM, 2), {"mass_damping": PER_SECOND, "stiffness_damping": SECOND}),
    "ModalVaried": (lambda: vt.springs.ModalVaried((450.0,), 0.01, (0.0, 0.02), (0.0, 800.0), 6e-3),
                    {"precompression": LENGTH, "residual_mass": MASS}),
    "MultiMassSpring": (lambda: vt.springs.MultiMassSpring.from_definition(SPRING, 6e-3),
                        {"precompression": LENGTH, "mass_damping": PER_SECOND, "stiffness_damping": SECOND,
                         "contact_damping_time": SECOND}),
    "WaveRod": (lambda: vt.springs.WaveRod(UNIFORM), {"friction": PER_SECOND}),
    "WaveRodWithClash": (lambda: vt.springs.WaveRodWithClash.from_definition(SPRING, 5e-3), {"friction": PER_SECOND}),
    "SpringLoad": (lambda: LOADS[0], {"height": "46 mm", "force": FORCE}),
    "CatalogueCard": (lambda: CATALOGUE, {"wire_diameter": "4.2 mm", "outer_diameter": "32 mm", "top_outer_diameter": "30 mm",
                                          "solid_height": "29 mm", "mass": MASS, "free_length": "54.75 mm"}),
    "Sensor": (lambda: vt.measured.Sensor(damping_ratio=0.02), {"bandwidth": "5 kHz", "natural_frequency": "5 kHz"}),
    "FilmSetup": (lambda: vt.film.FilmSetup(),
                  {"frame_rate": "2000 1/s", "marker_angle": "2 deg", "first_angle": "2 deg",
                   "cam_speed": "2000 rpm"}),
    "CamParameters": (lambda: CamParameters(0.018), {"base_radius": "12 mm", "width": "12 mm", "youngs_modulus": "30 N/mm^2"}),
    "FollowerParameters": (lambda: FollowerParameters(shape="roller", radius=0.01, mass=0.05),
                           {"radius": "8 mm", "mass": MASS, "offset": LENGTH, "tilt": "2 deg", "damping": DAMPING, "friction": FORCE,
                            "face_diameter": LENGTH}),
    "LeverParameters": (lambda: LeverParameters((0.0, 0.0), 0.03, 0.04, inertia=4e-5),
                        {"drive_arm": "29 mm", "valve_arm": "30 mm", "inertia": "2e-5 kg m^2", "valve_angle": "2 deg", "drive_angle": "2 deg",
                         "mass": MASS, "stiffness": RATE, "damping": DAMPING, "holding_torque": "2 N m", "tip_radius": "8 mm"}),
    "PushrodParameters": (lambda: PushrodParameters(0.06, lower_end=(0.0, 0.0)),
                          {"mass": MASS, "stiffness": RATE, "damping": DAMPING, "length": "150 mm",
                           "youngs_modulus": "30 N/mm^2", "density": "7.8 g/cm^3"}),
    "SupportParameters": (lambda: SupportParameters(2e7, 0.1),
                          {"stiffness": RATE, "mass": MASS, "damping": DAMPING, "direction": "2 deg"}),
    "ValveParameters": (lambda: ValveParameters(0.06, stem_stiffness=4e7),
                        {"mass": MASS, "opening_direction": "2 deg", "head_fraction": "40 %", "stem_stiffness": RATE,
                         "stem_damping": DAMPING, "damping": DAMPING, "friction": FORCE, "permitted_seating_velocity": "600 mm/s"}),
    "CrankParameters": (lambda: CrankParameters(0.04, 0.14, 0.002, 0.1),
                        {"radius": "46 mm", "rod_length": "150 mm", "clearance": LENGTH, "top_dead_centre": "2 deg",
                         "valve_inclination": "2 deg", "offset": LENGTH, "lobe_centre": "2 deg"}),
    "RodModel": (lambda: vt.springs.FiniteElementRod(SPRING, 6e-3, 6), {"precompression": LENGTH, "time_step": SECOND}),
}  # fmt: skip


def calls(name: str) -> list[tuple[str, str, ast.Call]]:
    """Class or function around, and the call, of every call of ``name`` in the package."""
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for owner in ast.walk(tree):
            if isinstance(owner, ast.ClassDef if name == "keep_si" else ast.FunctionDef):
                inside = [
                    one
                    for one in ast.walk(owner)
                    if isinstance(one, ast.Call) and getattr(one.func, "id", "") == name
                ]
                found += [(str(path.relative_to(SOURCE)), owner.name, one) for one in inside]
    return found


def test_every_field_that_is_made_si_stands_in_the_table():
    found = {owner: {word.arg for word in call.keywords} for _, owner, call in calls("keep_si")}
    made_here = {
        name: set(fields)
        for name, (make, fields) in PARTS.items()
        if not isinstance(make(), Table | Answers)
    }  # the fields of a table and of answers have their unit in the type
    assert made_here == found


@pytest.mark.parametrize(
    ("name", "field"), [(name, field) for name, (_, fields) in PARTS.items() for field in fields]
)
def test_a_field_takes_text_and_keeps_si(name, field):
    make, fields = PARTS[name]
    found = getattr(dataclasses.replace(make(), **{field: fields[field]}), field)
    assert isinstance(found, float) and found == pytest.approx(IN_SI[fields[field]], rel=1e-12)
    with pytest.raises(vt.InputError, match="apples"):
        dataclasses.replace(make(), **{field: "3 apples"})


CURVE = StaticCurve(
    np.array([0.0, 0.008, 0.016]),
    np.array([0.0, 320.0, 640.0]),
    np.full(3, 4e4),
    np.zeros((3, 0)),
    np.zeros((3, 0)),
    np.zeros(0),
    np.zeros((3, 2)),
    np.array([0.0, 7.0]),
    Status("completed", ""),
)


def rod() -> vt.springs.FiniteElementRod:
    return vt.springs.FiniteElementRod(SPRING, 5e-3, 6)


def batch(interval: Any = 2e-6, step: Any = 2e-7) -> Any:
    one = rod()
    return simulate_batch(
        [one.mesh],
        [one.installed.state],
        lambda t: 5e-3 + 0.1 * np.asarray(t),
        interval,
        2,
        one.dynamics,
        step,
    )


#: A number given in SI and as text: what is read of both is the same, and of twice the number
#: something else.
ARGUMENTS: dict[str, tuple[Callable[[Any], Any], float, str]] = {
    "force_at": (CURVE.force_at, 0.008, "8 mm"),
    "static_curve of a rod": (lambda x: rod().static_curve(x, 2).compression[-1], 0.005, LENGTH),
    "static_point of a rod": (lambda x: rod().static_point(x).force, 0.005, LENGTH),
    "modes of a rod": (lambda x: rod().modes(1, attached_mass=x).natural_frequency[0], 0.05, MASS),
    "static_curve": (lambda x: vt.static_curve(SPRING, models="massless", largest_compression=x, steps=2).compression[-1],
                     0.005, LENGTH),
    "buckling, length": (lambda x: buckling_compression(x, 0.01), 0.08, "80 mm"),
    "buckling, diameter": (lambda x: buckling_compression(0.08, x), 0.005, LENGTH),
    "resolution": (lambda x: Sweep.read({"case": "job-t", "resolution": x}).resolution, 20 * np.pi / 30, "20 rpm"),
    "float lift": (lambda x: Sweep.read({"case": "job-t", "float_lift": x}).float_lift, 0.005, LENGTH),
    "shear modulus": (lambda x: vt.parameters.Material("steel", 206e9, x, 7850.0).shear_modulus, 80e9, "80 GPa"),
    "density": (lambda x: vt.parameters.Material("steel", 206e9, 80e9, x).density, 7800.0, "7.8 g/cm^3"),
    "sample interval": (lambda x: batch(interval=x).time[-1], 2e-6, SECOND),
    "time step": (lambda x: batch(step=x).time_step, 1e-7, "0.1 us"),
    "pitch": (lambda x: cylindrical(3.8e-3, 22e-3, x, 7, ends="open").pitch.value(3.0), 0.008, "8 mm"),
    "free length": (lambda x: cylindrical(3.8e-3, 22e-3, total_coils=7, free_length=x).free_length, 0.045, "45 mm"),
    "clash rod from a wire": (lambda x: vt.springs.WaveRodWithClash.from_definition(SPRING, x).spring.preload, 0.005, LENGTH),
    "multi-mass mass": (lambda x: vt.springs.MultiMassSpring.from_card(RATE, FORCE, x).layout.masses.sum(), 0.05, MASS),
    "multi-mass preload": (lambda x: vt.springs.MultiMassSpring.from_card(RATE, x, MASS).precompression, 300.0, FORCE),
}  # fmt: skip


@pytest.mark.parametrize("name", ARGUMENTS)
def test_an_argument_is_the_same_as_a_number_and_as_text(name):
    read, number, text = ARGUMENTS[name]
    assert np.asarray(read(text)) == pytest.approx(np.asarray(read(number)), rel=1e-9)
    assert np.asarray(read(2 * number)) != pytest.approx(np.asarray(read(number)), rel=1e-3)
    with pytest.raises(vt.InputError):
        read("3 apples")
