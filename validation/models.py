"""The cheaper spring models against bar theory, and the rod against solid finite elements."""

from __future__ import annotations

import numpy as np

from validation.row import Kind, Row, book_case
from validation.springs import STEEL, mesh
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END, EndCoil
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.wave_rod import WaveRod

RATE, PRELOAD, MASS = 30e3, 250.0, 0.05
ABOUT = "30 N/mm, 50 g"

#: Axial frequencies (Hz) of the free spring and force (N) at 7 mm: Richardson limits of three
#: meshes of quadratic hexahedra.
SOLID = {
    "D / d = 5.8": (22e-3, 274.5536, (549.4779, 1058.929, 1469.991)),
    "D / d = 6": (22.8e-3, 246.6152, (512.152, 986.5889, 1369.954)),
}


@book_case()
def chain_surge() -> list[Row]:
    """Lumped chain of 60 masses: surge frequencies n / 2 sqrt(k / m)."""
    found = MultiMassSpring.from_card(RATE, PRELOAD, MASS, elements=60).frequencies(0.0)
    bar = 0.5 * np.sqrt(RATE / MASS)
    return [
        Row(
            "models",
            f"chain of 60 masses, surge frequency {n}",
            "vasilyev2016",
            ABOUT,
            n * bar,
            float(found[n - 1]),
            "Hz",
            n * bar * 1.05 * (n * np.pi / 120) ** 2 / 6,
            "closed form of the lumped chain: (n pi / 2 N)^2 / 6 low",
        )
        for n in (1, 2, 3)
    ]


@book_case()
def wave_rod_impact() -> list[Row]:
    """Wave equation at Courant number one: v sqrt(k m) at the moving end, doubled at the fixed one."""
    rod = WaveRod(EquivalentSpring(RATE, PRELOAD, MASS), 200)
    state, step, velocity = rod.initial_state(0.0), rod.stable_time_step(), 1.0
    parameters, integers, ends = rod.parameters(), rod.integers(), []
    for n in range(360):
        ends.append(rod.kernel(parameters, integers, state, velocity * step * n, velocity, step))
    forces = (np.array(ends) - PRELOAD) / (velocity * np.sqrt(RATE * MASS))
    return [
        Row(
            "models",
            "wave rod, impact force at the moving end over v sqrt(k m)",
            "wahl1963",
            ABOUT,
            1.0,
            float(forces[20:180, 0].mean()),
            "-",
            1e-9,
            "exact at Courant number one",
        ),
        Row(
            "models",
            "wave rod, impact force at the fixed end over v sqrt(k m)",
            "wahl1963",
            ABOUT,
            2.0,
            float(forces[240:350, 1].mean()),
            "-",
            1e-9,
            "exact at Courant number one",
        ),
    ]


@book_case()
def wave_rod_friction() -> list[Row]:
    """The friction mu of the wave equation: what is left after each double travel of a struck rod
    is exp(-mu) of it, per second.
    """
    friction, velocity, struck = 25.0, 1.0, 40
    rod = WaveRod(EquivalentSpring(RATE, PRELOAD, MASS), 200, friction, pulls=False)
    state, step = rod.initial_state(0.0), rod.stable_time_step()
    parameters, integers, ends = rod.parameters(), rod.integers(), []
    for n in range(400 * 21):
        moving = n < struck
        ends.append(
            rod.kernel(
                parameters,
                integers,
                state,
                velocity * step * min(n, struck),
                velocity if moving else 0.0,
                step,
            )[1]
        )
    swings = np.array(ends[-400 * 20 :]).reshape(20, 400)
    found = float(np.polyfit(np.arange(20) * 400 * step, np.log(np.ptp(swings, axis=1)), 1)[0])
    why = "one cell of 200"
    return [
        Row(
            "models",
            "wave rod, decay of a pulse by friction",
            "vasilyev2016",
            ABOUT,
            -friction,
            found,
            "1/s",
            0.005 * friction,
            why,
        )
    ]


@book_case()
def rod_against_solid() -> list[Row]:
    """Force and axial frequencies of short clamped springs by CalculiX 2.20, against the rod with
    curvature correction.
    """
    rows = []
    for name, (diameter, force, frequencies) in SOLID.items():
        definition = SpringDefinition(
            Constant(3.8e-3),
            Constant(diameter),
            Constant(7e-3),
            total_coils=5.0,
            material=STEEL,
            lower_end=OPEN_END,
            upper_end=OPEN_END,
        )
        statics = RodStatics(mesh(definition, curvature=True))
        found = compress(statics, [7e-3])[-1].retainer_force
        rows.append(
            Row(
                "models",
                f"rod against solid, force at 7 mm, {name}",
                "",
                "wire 3.8, pitch 7 mm, 5 turns clamped",
                force,
                found,
                "N",
                0.001 * force,
                "curvature of the bar beyond Goehner's term",
                "independent computation",
            )
        )
        modes = natural_modes(statics, compress(statics, [1e-9])[-1].state, 14)
        for n, value in zip((1, 5, 9), frequencies, strict=True):
            rows.append(
                Row(
                    "models",
                    f"rod against solid, free frequency {n} (axial), {name}",
                    "",
                    "wire 3.8, pitch 7 mm, 5 turns clamped",
                    value,
                    float(modes.natural_frequency[n - 1]),
                    "Hz",
                    0.005 * value,
                    "sections stay plane in the rod: 0.06 to 0.25 % high, growing with the mode",
                    "independent computation",
                )
            )
    return rows


#: Beehive with coil 2 closing on coil 1: forces (N) at 5.6 and 7 mm by quadratic hexahedra with
#: self-contact (23 859 unknowns).
SOLID_BEEHIVE = {5.6e-3: 234.249, 7e-3: 298.2233}


def solid_beehive() -> SpringDefinition:
    """The beehive that the solid model was run on (frozen; not the shipped case)."""
    clearances = (0.0, 0.0, 1.017e-3, 2.032e-3, 5.488e-3, 5.488e-3, 1.351e-3)
    wire = 3.867e-3
    return SpringDefinition(
        Constant(wire),
        PiecewiseLinear((0.0, 4.0, 7.0), (22.47e-3, 22.47e-3, 17.31e-3)),
        PiecewiseLinear(
            (0.0, 0.875, 1.125, 2.0, 3.0, 6.0, 7.0), tuple(wire + c for c in clearances)
        ),
        total_coils=7.0,
        material=STEEL,
        lower_end=EndCoil("closed-ground", 0.78, 0.78),
        upper_end=EndCoil("closed-ground", 0.83, 0.83),
    )


@book_case()
def rod_against_solid_with_contact() -> list[Row]:
    """Force and stiffness of a beehive whose coil 2 comes to rest on coil 1, by CalculiX and by the
    rod with coil contact.
    """
    statics = RodStatics(mesh_spring(solid_beehive()))
    half, whole = (point.retainer_force for point in compress(statics, list(SOLID_BEEHIVE)))
    below, above = SOLID_BEEHIVE.values()
    what, travel = "wire 3.867, D 22.47 to 17.31 mm, 7 coils", 1.4
    rate, found = (above - below) / travel, (whole - half) / travel
    why = "contact of round wires along a line, and one mesh of the solid"
    kind: Kind = "independent computation"
    return [
        Row(
            "models",
            "beehive with coil contact, force at 7 mm",
            "",
            what,
            above,
            whole,
            "N",
            0.003 * above,
            why,
            kind,
        ),
        Row(
            "models",
            "beehive with coil contact, stiffness 5.6 to 7 mm",
            "",
            what,
            rate,
            found,
            "N/mm",
            0.005 * rate,
            why,
            kind,
        ),
    ]
