"""The solid route, mesh to CalculiX and back, against closed forms. Coarse meshes; seconds."""

from __future__ import annotations

import numpy as np
import pytest
from validation.calculix.deck import SolidContact, model_text
from validation.calculix.jobs import SolidSpring
from validation.calculix.results import read_printed
from validation.calculix.solver import run_deck
from validation.calculix.transient import TransientJob, run_transient

from valvetrain.continuum.mesh import FaceSet, MeshOptions, SolidMesh, connect_sections
from valvetrain.continuum.section import disc_section
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END, EndCoil

pytestmark = pytest.mark.calculix

RADIUS, LENGTH = 2e-3, 20e-3
STEEL = OTEVA_90_SC


def straight_bar(core: int = 2, rings: int = 1, spans: int = 10) -> SolidMesh:
    """Round bar along z, bonded at z = 0 (seat) and driven at z = LENGTH (retainer)."""
    section = disc_section(core, rings)
    stations = np.linspace(0, LENGTH, 2 * spans + 1)
    grid = np.concatenate(
        [
            np.column_stack([RADIUS * section.nodes, np.full(len(section.nodes), z)])
            for z in stations
        ]
    )
    elements = connect_sections(section, spans, reverse=False)
    used, numbered = np.unique(elements, return_inverse=True)
    coordinates = grid[used]
    ends = {
        "seat": np.flatnonzero(coordinates[:, 2] < 1e-12),
        "retainer": np.flatnonzero(coordinates[:, 2] > LENGTH - 1e-12),
    }
    nothing = FaceSet(np.zeros(0, dtype=np.int64), np.zeros(0))
    place = np.tile(section.nodes, (len(stations), 1))[used]
    return SolidMesh(
        coordinates,
        numbered.reshape(elements.shape),
        coordinates[:, 2],
        place,
        nothing,
        nothing,
        ends,
    )


def linear_reactions(
    mesh: SolidMesh, displacement: np.ndarray, components: str = "123"
) -> np.ndarray:
    """Reactions (node, 3) in N of the retainer nodes moved by ``displacement`` (m), in a
    small-displacement step.
    """
    seat = "SEAT, 3, 3\n1, 1, 2\n2, 1, 1\n" if components == "3" else "SEAT, 1, 3\n"
    lines = [
        f"{node + 1}, {k + 1}, {k + 1}, {1e3 * value:.12g}"
        for node, row in zip(mesh.node_sets["retainer"], displacement, strict=True)
        for k, value in enumerate(row)
        if str(k + 1) in components
    ]
    deck = (
        model_text(mesh, STEEL, MeshOptions())
        + f"*STEP\n*STATIC\n*BOUNDARY\n{seat}"
        + "\n".join(lines)
    )
    output = run_deck(deck + "\n*NODE PRINT, NSET=RETAINER\nRF\n*END STEP\n", time_limit=60)
    assert output.status.completed, output.status.sentence()
    return read_printed(output.printed).history("forces", "RETAINER")[1][0][:, 1:]


def test_stretched_bar_is_a_patch_test():
    mesh = straight_bar()
    stretch = np.zeros((len(mesh.node_sets["retainer"]), 3))
    stretch[:, 2] = 1e-3 * LENGTH
    force = linear_reactions(mesh, stretch, "3")[:, 2].sum()
    # Section area is exact by construction; seven printed digits.
    assert force == pytest.approx(STEEL.youngs_modulus * np.pi * RADIUS**2 * 1e-3, rel=2e-6)


def test_twisted_bar_has_the_torsional_stiffness_of_saint_venant():
    mesh = straight_bar()
    end = mesh.coordinates[mesh.node_sets["retainer"]]
    twist = 1e-3
    turned = np.column_stack([-twist * end[:, 1], twist * end[:, 0], np.zeros(len(end))])
    force = linear_reactions(mesh, turned)
    torque = np.sum(end[:, 0] * force[:, 1] - end[:, 1] * force[:, 0])
    # The section is round to second order of its arcs, its polar moment to better than 1e-4.
    assert torque == pytest.approx(
        STEEL.shear_modulus * np.pi / 2 * RADIUS**4 * twist / LENGTH, rel=2e-4
    )


def test_bent_bar_has_euler_stiffness():
    mesh = straight_bar()
    end = mesh.coordinates[mesh.node_sets["retainer"]]
    angle = 1e-3
    # Pure bending: the end section turns by the angle and moves to the side by half of angle x
    # length.
    moved = np.column_stack(
        [np.full(len(end), angle * LENGTH / 2), np.zeros(len(end)), -angle * end[:, 0]]
    )
    force = linear_reactions(mesh, moved)
    moment = -np.sum(end[:, 0] * force[:, 2])
    # Clamped faces suppress the lateral contraction near both ends, which stiffens the bar a
    # little.
    assert moment == pytest.approx(
        STEEL.youngs_modulus * np.pi / 4 * RADIUS**4 * angle / LENGTH, rel=0.015
    )


@pytest.fixture(scope="module")
def uniform() -> SpringDefinition:
    return SpringDefinition(
        wire_diameter=Constant(3.8e-3),
        mean_diameter=Constant(38e-3),
        pitch=Constant(6e-3),
        total_coils=4.0,
        material=STEEL,
        lower_end=OPEN_END,
        upper_end=OPEN_END,
    )


def test_slender_spring_has_the_elementary_rate(uniform):
    # At index 10 Goehner, pitch and clamped ends change the rate of elementary theory by less than
    # 1.5 %.
    curve = SolidSpring(uniform, MeshOptions(16, 1, 1)).static_curve(1e-3, points=2)
    assert curve.status.completed
    rate = STEEL.shear_modulus * 3.8e-3**4 / (8 * 38e-3**3 * 4)
    assert curve.stiffness[-1] == pytest.approx(rate, rel=0.015)


class SmoothRamp:
    """Lift whose velocity rises from 0 to 1 m per unit angle along a cosine over ``rise`` and then
    stays.
    """

    def __init__(self, rise: float) -> None:
        self.rise = rise

    def lift(self, cam_angle, derivative=0):
        share = np.clip(np.asarray(cam_angle, dtype=float) / self.rise, 0.0, 1.0)
        if derivative:
            return (1 - np.cos(np.pi * share)) / 2
        beyond = np.maximum(np.asarray(cam_angle, dtype=float) - self.rise, 0.0)
        return self.rise * (share / 2 - np.sin(np.pi * share) / (2 * np.pi)) + beyond


@pytest.mark.long
def test_end_impact_gives_speed_times_wave_resistance(uniform):
    """A retainer moving at speed v meets the force v sqrt(k m) until the reflection returns after
    two travel times.
    """
    model = SolidSpring(uniform, MeshOptions(8, 1, 1))
    rate = STEEL.shear_modulus * 3.8e-3**4 / (8 * 38e-3**3 * 4)
    travel = np.sqrt(uniform.mass / rate)
    # Cam speed 1 rad/s: angle is time, so the retainer reaches 1 m/s.
    job = TransientJob(
        SmoothRamp(0.4 * travel), 2.0, 1e-3, 0.0, 1.5 * travel, time_step=travel / 10
    )
    solution = run_transient(model, job)
    assert solution.status.completed and solution.model == "solid"
    force = solution.channel("retainer_force") - solution.channel("retainer_force")[0]
    steady = solution.time > 0.5 * travel
    # A short helix is dispersive; the mean over one travel time is within a few per cent of the
    # ideal rod.
    assert np.mean(force[steady]) == pytest.approx(np.sqrt(rate * uniform.mass), rel=0.05)
    seat = solution.channel("seat_force") - solution.channel("seat_force")[0]
    assert np.max(np.abs(seat[solution.time < 0.7 * travel])) < 0.15 * np.sqrt(rate * uniform.mass)
    assert np.allclose(
        solution.channel("axial_displacement")[:, -1], -solution.channel("valve_lift"), atol=1e-8
    )


def test_closing_coils_stiffen_the_spring_and_carry_its_force():
    """The first free turn lies 0.15 mm over the inactive one: once it rests there, only the wide
    turns are left.
    """
    spring = SpringDefinition(
        wire_diameter=Constant(3e-3),
        mean_diameter=Constant(30e-3),
        pitch=PiecewiseLinear((0.0, 1.25, 1.75, 4.0), (3.15e-3, 3.15e-3, 6e-3, 6e-3)),
        total_coils=4.0,
        material=STEEL,
        lower_end=EndCoil(inactive_coils=0.75),
        upper_end=EndCoil(inactive_coils=0.75),
    )
    model = SolidSpring(spring, MeshOptions(10, 1, 1, ends="bonded"), SolidContact())
    curve = model.static_curve(2e-3, points=5)
    assert curve.status.completed
    assert curve.stiffness[-1] > 1.15 * curve.stiffness[0]
    assert curve.coil_contact_force[0].max() == 0
    # The contact takes part of the force past the first piece of wire.
    assert 0.2 * curve.force[-1] < curve.coil_contact_force[-1].sum() < curve.force[-1]
    # Penalty contact gives way by micrometres; arcs of a quarter circle leave the circle by some
    # more.
    assert -0.03e-3 < curve.coil_gap[-1].min() < 0.03e-3
