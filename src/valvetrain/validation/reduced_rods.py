"""Springs reduced from their rods: at rest, in small swings and in motion with clash, beside the
finite-element rod at 24 elements per coil.
"""

from __future__ import annotations

import numpy as np

from valvetrain.cosserat.modes import natural_modes
from valvetrain.integrate.contract import Cycles
from valvetrain.integrate.run import run as integrate
from valvetrain.runs.against_rod import difference_from_rods
from valvetrain.springs.finite_element_channels import wire_points
from valvetrain.springs.finite_element_statics import equilibrium_at
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.springs.stress import LOADS, wire_stress
from valvetrain.system.build import build
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.validation.row import Row, book_case

TOPIC, CASE = "reduced rods", "gu2021-beehive-blind"


def _beehive() -> tuple[PrescribedSpring, ReducedRod]:
    system = build(CASE, spring_models=("reduced-rod",)).members[0].system()
    assert isinstance(system, PrescribedSpring)
    (spring,) = system.springs
    assert isinstance(spring, ReducedRod)
    return system, spring


@book_case()
def reduced_rod_at_rest() -> list[Row]:
    """Force and six frequencies of the beehive over lift, between the tables as well."""
    _, spring = _beehive()
    rows = []
    for lift in (0.0, 2.1e-3, 5.3e-3, 9.0e-3):
        at = equilibrium_at(spring.rod, spring.rod.precompression + lift)
        modes = natural_modes(spring.statics, at.state, 6).natural_frequency
        force = spring.force(spring.initial_state(lift), lift).retainer
        furthest = float(np.max(np.abs(spring.frequencies(lift) / modes - 1)))
        where = f"{CASE}, retainer at {lift * 1e3:g} mm"
        rows.append(
            Row(
                TOPIC,
                f"force at rest at {lift * 1e3:g} mm",
                "",
                where,
                at.retainer_force,
                force,
                "N",
                1e-3 * at.retainer_force,
                "0.1 %, tables are straight between their lifts",
                "consistency",
            )
        )
        rows.append(
            Row(
                TOPIC,
                f"largest difference of six frequencies at {lift * 1e3:g} mm",
                "",
                where,
                0.0,
                100 * furthest,
                "%",
                0.5,
                "0.5 %, of any of them",
                "consistency",
            )
        )
    return rows


@book_case()
def reduced_rod_in_motion() -> list[Row]:
    """The beehive over two revolutions at three speeds, the fastest with clash."""
    system, spring = _beehive()
    rows = []
    for engine_speed, share in ((4200.0, 0.01), (5600.0, 0.01), (8000.0, 0.03)):
        found = difference_from_rods([spring], system.valve_lift, engine_speed * np.pi / 60)
        assert found is not None
        where = f"{CASE}, {engine_speed:g} rpm, 24 elements per coil"
        rows.append(
            Row(
                TOPIC,
                f"seat force at {engine_speed:g} rpm, rms of the difference below 20 kHz",
                "",
                where,
                0.0,
                100 * found.rms,
                "%",
                100 * share,
                "of the rms: 1 % without, 3 % with clash",
                "consistency",
            )
        )
        names = "below_20_khz_peak_spring_force", "minimum_spring_force"
        rows.append(
            Row(
                TOPIC,
                f"peak below 20 kHz and minimum of the spring force at {engine_speed:g} rpm, larger difference",
                "",
                where,
                0.0,
                max(abs(found.differences[name]) for name in names),
                "N",
                1.0,
                "some times the 0.1 N without clash and the 0.7 N with",
                "consistency",
            )
        )
    return rows


@book_case()
def reduced_rod_stress() -> list[Row]:
    """Largest shear stress at the inner fibre of the beehive over the second of two revolutions."""
    system, spring = _beehive()
    rows = []
    for engine_speed in (4200.0, 5600.0):
        peaks = []
        for model in (spring, spring.rod):
            run = integrate(
                PrescribedSpring((model,), system.valve_lift),
                engine_speed * np.pi / 60,
                Cycles(2),
            )
            loads = {name: np.asarray(run.cycle[name]) for name in LOADS}
            coil = wire_points(spring.rod.definition.total_coils)
            stress = wire_stress(loads, spring.rod.definition, coil)
            peaks.append(float(np.max(stress["inner_fibre_shear_stress"])) / 1e6)
        rows.append(
            Row(
                TOPIC,
                f"largest shear stress at the inner fibre at {engine_speed:g} rpm",
                "",
                f"{CASE}, {engine_speed:g} rpm, 24 elements per coil",
                peaks[1],
                peaks[0],
                "MPa",
                3e-3 * peaks[1],
                "0.3 %, loads are those of the rod to first order about rest",
                "consistency",
            )
        )
    return rows
