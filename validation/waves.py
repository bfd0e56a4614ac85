"""Waves in long springs and the energy balance of runs: impact force, dynamic stiffness, energy
with clash.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import diags
from scipy.sparse.linalg import spsolve

from validation.row import Row, book_case
from validation.springs import mesh, rate, spring
from valvetrain.cam.contract import build_lift_law
from valvetrain.cosserat.buffer import RodDynamics, inertia_of
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import RodStatics
from valvetrain.cosserat.transient import simulate
from valvetrain.parameters.loading import load_case
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import rod_channels
from valvetrain.springs.spec import spring_model
from valvetrain.system.prescribed import PrescribedSpring

Array = NDArray[np.float64]
#: Imbalance of the energy books over all work that the runs of these cases come out with.
TYPICAL_IMBALANCE = {"job-c": 5e-5, "gu2021-beehive-blind": 8.5e-6}
ABOUT = "d 1, D 12, pitch 1.6 mm, 30 turns clamped, 16 elements per coil"


def _long_spring() -> tuple[RodMesh, float, float]:
    """A slender spring of many coils, its rate (N/m) and the mass between its ends (kg)."""
    definition = spring(1e-3, 12e-3, 1.6e-3, 30.0)
    rod = mesh(definition, 16)
    return rod, rate(rod, 1e-4), definition.mass


@book_case()
def drive_point_stiffness() -> list[Row]:
    """k b cot b at the driven end and k b / sin b at the fixed one, b = omega sqrt(m / k)."""
    rod, stiffness, mass = _long_spring()
    statics = RodStatics(rod)
    tangent, free = statics.tangent(free_state(rod)), statics.free
    unit = np.zeros(len(free))
    unit[6 * rod.last + 2] = 1.0
    rows = []
    for b in (0.5, 1.0, 2.0, 2.8):
        omega = b * np.sqrt(stiffness / mass)
        inner = (tangent - diags(omega**2 * inertia_of(rod))).tocsc()
        follow = unit.copy()
        follow[free] = spsolve(inner[free][:, free], -(inner @ unit)[free])
        reaction = inner @ follow
        # The driven vertex carries half an element of wire, counted in the formula.
        for name, expected, found, slope in (
            (
                "drive-point",
                stiffness * b / np.tan(b),
                float(reaction[6 * rod.last + 2]),
                1 / np.tan(b) - b / np.sin(b) ** 2,
            ),
            (
                "transfer",
                stiffness * b / np.sin(b),
                -float(reaction[6 * rod.first + 2]),
                (1 - b / np.tan(b)) / np.sin(b),
            ),
        ):
            rows.append(
                Row(
                    "waves",
                    f"{name} dynamic stiffness at b = {b:g}",
                    "wahl1963",
                    ABOUT,
                    expected,
                    found,
                    "N/m",
                    0.002 * b * stiffness * abs(slope),
                    "surge 0.2 % below bar theory, amplified towards the resonance at b = pi",
                )
            )
    return rows


@book_case()
def end_impact() -> list[Row]:
    """One end set in motion at v: force v sqrt(k m) there, twice that where the wave meets the
    fixed end.
    """
    rod, stiffness, mass = _long_spring()
    velocity, travel = 1.0, np.sqrt(mass / stiffness)
    rise = 0.15 * travel

    def motion(time: Array) -> Array:
        phase = np.clip(time / rise, 0, 1)
        return np.asarray(
            velocity * np.where(time < rise, rise * (phase**3 - phase**4 / 2), time - rise / 2)
        )

    run = simulate(rod, free_state(rod), motion, travel / 200, 400, RodDynamics(mass_damping=1e-9))
    force = velocity * np.sqrt(stiffness * mass)
    time = run.time / travel
    driven = float(run.retainer_force[(time > 0.4) & (time < 1.6)].mean())
    fixed = float(run.seat_force[(time > 1.4) & (time < 1.95)].mean())
    return [
        Row(
            "waves",
            "end impact, force at the moving end over v sqrt(k m)",
            "wahl1963",
            ABOUT,
            1.0,
            driven / force,
            "-",
            0.005,
            "mean over the plateau; ripple of the wave front",
        ),
        Row(
            "waves",
            "end impact, force at the fixed end over v sqrt(k m)",
            "wahl1963",
            ABOUT,
            2.0,
            fixed / force,
            "-",
            0.015,
            "mean over the plateau; ripple of the wave front",
        ),
    ]


@book_case()
def energy_balance() -> list[Row]:
    """Work done on the spring less what is stored and lost, over runs with clash, relative to all
    work that crossed the retainer.
    """
    rows = []
    for name in ("job-c", "gu2021-beehive-blind"):
        case = load_case(name)
        model = spring_model("finite-element").build(case.springs[0])
        assert isinstance(model, FiniteElementRod)
        cam_speed = case.operation.engine_speeds[-1] / 2
        run = simulate(
            model.mesh,
            model.installed.state,
            _motion(
                PrescribedSpring((model,), build_lift_law(case.lift_law)),
                model.precompression,
                cam_speed,
            ),
            np.radians(0.5) / cam_speed,
            1440,
            model.dynamics,
        )
        data = rod_channels(model, run, cam_speed)
        stored = np.sum(
            [data[part].values for part in ("kinetic_energy", "elastic_energy", "contact_energy")],
            axis=0,
        )
        balance = data["work_done"].values - (stored - stored[0]) - data["energy_dissipated"].values
        turned = float(np.abs(np.diff(data["work_done"].values)).sum())
        rows.append(
            Row(
                "waves",
                f"energy balance over two cycles with clash, {name}",
                "",
                "largest gap over all work that crossed the retainer",
                0.0,
                float(np.abs(balance).max()) / turned,
                "-",
                TYPICAL_IMBALANCE[name] * 3,
                "three times the typical imbalance of this run",
            )
        )
    return rows


def _motion(
    system: PrescribedSpring, precompression: float, cam_speed: float
) -> Callable[[Array], Array]:
    """Compression (m) of the spring over time (s)."""
    return lambda time: precompression + system.displacement(time, cam_speed)
