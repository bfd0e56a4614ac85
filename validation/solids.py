"""The solid in motion: its statics and modes against CalculiX, faces of bricks against Hertz and impact,
its clash spikes next to the rod's.
"""

from __future__ import annotations

import numpy as np

from validation.hertz import (
    bouncing_ring,
    colliding_bars,
    crossed_wires,
    pressed_blocks,
    pressed_section,
)
from validation.models import SOLID, SOLID_BEEHIVE, solid_beehive
from validation.row import Kind, Row, book_case
from validation.springs import STEEL
from valvetrain.coil_contact.line_contact import line_contact
from valvetrain.continuum.statics import SolidStatics
from valvetrain.continuum.wire import SolidContactLaw, SolidWire
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END
from valvetrain.runs.api import simulate
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.solid.model import SolidModel
from valvetrain.springs.spec import spring_model

KIND: Kind = "independent computation"


@book_case()
def bricks_against_calculix() -> list[Row]:
    """Clamped helices without contact: force at 7 mm and axial frequencies of the free spring."""
    what, rows = "wire 3.8, pitch 7 mm, 5 turns clamped, 24 slices per coil", []
    for name, (diameter, force, frequencies) in SOLID.items():
        spring = SpringDefinition(
            Constant(3.8e-3),
            Constant(diameter),
            Constant(7e-3),
            total_coils=5.0,
            material=STEEL,
            lower_end=OPEN_END,
            upper_end=OPEN_END,
        )
        statics = SolidStatics(SolidWire(spring, contact=SolidContactLaw(0.0)))
        found = statics.compress([7e-3])[0].retainer_force
        why = "straight slices: 0.1 % at 24 per coil"
        rows.append(
            Row("solids", f"bricks, force at 7 mm, {name}", "", what, force, found, "N", 1e-3 * force, why, KIND)
        )  # fmt: skip
        modes = statics.modes(statics.start(), 10).natural_frequency
        for n, value in zip((1, 5, 9), frequencies, strict=True):
            why = "eight-node bricks: 0.2 % at 24 per coil"
            rows.append(
                Row("solids", f"bricks, free frequency {n} (axial), {name}", "", what, value, float(modes[n - 1]), "Hz", 2e-3 * value, why, KIND)
            )  # fmt: skip
    return rows


@book_case()
def bricks_in_contact_against_calculix() -> list[Row]:
    """The beehive whose coil 2 comes to rest on coil 1: contact on section centres against contact
    of faces.
    """
    statics = SolidStatics(SolidWire(solid_beehive()))
    found = statics.compress(list(SOLID_BEEHIVE))
    what, why = "wire 3.867, D 22.47 to 17.31 mm, 7 coils", "the wire flattens where coils meet"
    return [
        Row("solids", f"bricks in contact, force at {1e3 * at:.1f} mm", "", what, due, one.retainer_force, "N", 0.003 * due, why, KIND)
        for (at, due), one in zip(SOLID_BEEHIVE.items(), found, strict=True)
    ]  # fmt: skip


def love_excess(
    wire_diameter: float = 3e-3, diameter: float = 30e-3, pitch: float = 34e-3
) -> tuple[float, float]:
    """By how much a clamped helix of bricks is stiffer than Love's, over its stiffness, for many turns;
    and what the curvature of its section adds by Goehner's series.

    Clamps that hold their sections add a part that falls with the square of the turns: it follows from
    6 and 10 turns.
    """
    angle = np.arctan(pitch / (np.pi * diameter))
    sine, cosine, radius = np.sin(angle), np.cos(angle), diameter / 2
    bending = STEEL.youngs_modulus * np.pi * wire_diameter**4 / 64
    torsion = STEEL.shear_modulus * np.pi * wire_diameter**4 / 32
    # travel and rotation of the end under force and torque about the axis, per length of wire
    travel = radius**2 * (cosine**2 / torsion + sine**2 / bending)
    mixed = radius * sine * cosine * (1 / torsion - 1 / bending)
    rotation = sine**2 / torsion + cosine**2 / bending
    turns, excess = np.array([6.0, 10.0]), list[float]()
    for count in turns:
        length = np.pi * diameter * count / cosine
        rate = rotation / (travel * rotation - mixed**2) / length
        spring = SpringDefinition(
            Constant(wire_diameter), Constant(diameter), Constant(pitch), total_coils=float(count),
            material=STEEL, lower_end=OPEN_END, upper_end=OPEN_END
        )  # fmt: skip
        statics = SolidStatics(SolidWire(spring, contact=SolidContactLaw(0.0)))
        excess.append(statics.compress([1e-5])[0].retainer_force / 1e-5 / rate - 1)
    square = turns**2
    many = (square[1] * excess[1] - square[0] * excess[0]) / (square[1] - square[0])
    index = diameter / cosine**2 / wire_diameter
    return float(many), 3 / (16 * (index**2 - 1))


@book_case()
def bricks_as_loves_helix() -> list[Row]:
    """Stiffness of a helix of 20 degrees, ends that do not turn, extrapolated to many turns."""
    found, curvature = love_excess()
    what = "wire 3, D 30, pitch 34 mm, 6 and 10 turns clamped, 24 slices per coil"
    name, why = "bricks, stiffness over Love's helix", "24 slices per coil; series of the section"
    return [
        Row("solids", name, "love1927", what, 1 + curvature, 1 + found, "1", 1e-3, why)
    ]  # fmt: skip


@book_case()
def curvature_in_job_c() -> list[Row]:
    """Static force of job C, which is posed without the correction of the section for curvature: the body
    has it.
    """
    spring = load_case("job-c").springs[0]
    corrected = spring.with_options("finite-element", curvature_correction=True)
    rod = spring_model("finite-element").build(corrected)
    body = spring_model("solid").build(spring)
    assert isinstance(rod, FiniteElementRod) and isinstance(body, SolidModel)
    at = spring.precompression
    due, found = rod.static_point(at).force, body.installed.retainer_force
    name, what = (
        "bricks against rod with curvature, force at 7 mm",
        "job-c, 24 slices and elements per coil",
    )
    why = "straight slices and contact points: 0.05 % at 24 per coil"
    return [Row("solids", name, "", what, due, found, "N", 5e-4 * due, why, KIND)]


@book_case()
def faces_as_hertz() -> list[Row]:
    """Bricks pressed together by their faces: a section between two planes, a ring on a plane, wires
    across each other.
    """
    wire, rows = 4e-3, []
    for line in (1e3, 1e4, 1e5):
        name = f"faces, section squeezed as far as {line / 1e3:g} N/mm needs"
        force, what = (
            pressed_section(wire, STEEL, line).force,
            "wire 4 mm, plane strain, two planes",
        )
        rows.append(_hertz(name, what, 1e-3 * line, 1e-3 * force, "N/mm", 0.01))
    for line in (1e3, 1e5):
        what = "wire 4 mm, ring of index 6 between two planes"
        ring = pressed_section(wire, STEEL, line, ring_radius=3 * wire)
        width = line_contact(wire, STEEL, line).half_width
        pressure = 2e-6 * line / (np.pi * width)
        rows += [
            _hertz(f"faces, ring on a plane, force at its approach, {line / 1e3:g} N/mm", what, 1e-3 * line, 1e-3 * ring.force, "N/mm", 0.02),
            _hertz(f"faces, ring on a plane, half width, {line / 1e3:g} N/mm", what, 1e6 * width, 1e6 * ring.half_width, "um", 0.02),
            _hertz(f"faces, ring on a plane, pressure, {line / 1e3:g} N/mm", what, pressure, 1e-6 * ring.pressure, "MPa", 0.02),
        ]  # fmt: skip
    half_width, what = 20e-6, "wires 4 mm at right angles, half width 20 um, 5 bricks in it"
    modulus = STEEL.shear_modulus / (1 - STEEL.poisson_ratio)
    crossed = crossed_wires(wire, STEEL, half_width)
    force = 8 / 3 * modulus * half_width**3 / wire
    pressure = 4e-6 * modulus * half_width / (np.pi * wire)
    return [
        *rows,
        _hertz("faces, crossed wires, force at their approach", what, force, crossed.force, "N", 0.02),
        _hertz("faces, crossed wires, pressure", what, pressure, 1e-6 * crossed.pressure, "MPa", 0.02),
    ]  # fmt: skip


def _hertz(name: str, what: str, due: float, found: float, unit: str, share: float) -> Row:
    """A row of Hertz's contact; ``share``: tolerance over the expected value."""
    return Row("solids", name, "johnson1985", what, due, found, unit, share * due, "mesh at the contact")  # fmt: skip


@book_case()
def faces_that_meet() -> list[Row]:
    """Patch test of the contact of faces, and bodies that strike: a wave runs to the far end and back."""
    patches, what = [], "cubes of 10 mm, bricks along their edges"
    for cells, order, within in (((4, 4), 2, 1e-6), ((4, 6), 4, 0.02)):
        name = "faces, patch test, largest pressure over mean, {} and {}".format(*cells)
        found, why = 1 + pressed_blocks(STEEL, cells, order), "Gauss points across other edges"
        patches.append(Row("solids", name, "", what, 1.0, found, "1", within, why))
    speed = float(np.sqrt(STEEL.youngs_modulus / STEEL.density))
    length, radius, wall, height = 40e-3, 2e-3, 0.5e-3, 60e-3
    bars = colliding_bars(STEEL, length, radius, 1.0)
    ring = bouncing_ring(STEEL, radius, wall, height, 1.0)
    strike = STEEL.density * speed * np.pi * radius**2 / 2
    fall = STEEL.density * speed * 24 * np.sin(2 * np.pi / 24) * radius * wall
    touch, rest = 2e6 * length / speed, 2e6 * height / speed
    bar, tube = "bars 4 x 40 mm, 1 m/s", "ring of 4 mm, wall 0.5, height 60 mm, 1 m/s"
    why = "waves of a thick bar spread"
    return [
        *patches,
        Row("solids", "faces, force of colliding bars", "", bar, strike, bars.force, "N", 0.02 * strike, why),
        Row("solids", "faces, time that colliding bars touch", "", bar, touch, 1e6 * bars.duration, "us", 0.02 * touch, why),
        Row("solids", "faces, velocity of the bar that was struck", "", bar, 1.0, bars.velocity, "m/s", 0.02, why),
        Row("solids", "faces, force of a ring that falls flat", "", tube, fall, ring.force, "N", 0.02 * fall, why),
        Row("solids", "faces, time that a ring that falls flat touches", "", tube, rest, 1e6 * ring.duration, "us", 0.02 * rest, why),
        Row("solids", "faces, velocity at which the ring bounces", "", tube, 1.0, ring.velocity, "m/s", 0.05, "it continues to breathe: " + why),
    ]  # fmt: skip


@book_case(slow=True)
def spikes_of_rod_and_solid() -> list[Row]:
    """The beehive of gu2021 at 8000 rpm by both: peak of the event and spike of the clash by band.

    Expected is the solid. Above 5 kHz neither is right: heights rest on mesh and contact constants.
    """
    study = simulate(
        load_case("gu2021-beehive-blind"),
        engine_speeds=[8000 * np.pi / 30],
        models=["finite-element", "solid"],
    )
    rod, solid = (run.quantities for run in study.solutions)
    what = "gu2021-beehive-blind, 8000 rpm, 24 slices and elements per coil"
    rows = []
    for name, label, within, why in (
        ("stage_2_peak_force", "peak of the event", 0.01, "rod and body move alike below clash"),
        ("main_clash_below_5_khz_peak_force", "spike below 5 kHz", 0.05, "instants of clashes"),
    ):
        rows.append(
            Row("solids", f"rod against solid, {label}", "", what, solid[name], rod[name], "N", within * solid[name], why, KIND)
        )  # fmt: skip
    return rows
