"""The wire of bricks: statics and modes against CalculiX and the rod, masses, and motion in balance."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from solid_parts import helix
from valvetrain.continuum import time_kernels as columns
from valvetrain.continuum.section_loads import SurfaceStress, section_loads
from valvetrain.continuum.statics import SolidStatics
from valvetrain.continuum.transient import SolidDynamics, simulate_solid, stable_time_step
from valvetrain.continuum.wire import SolidContactLaw, SolidMeshSize, SolidWire
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.stress import wire_stress

REFERENCE = tomllib.loads(
    (Path(__file__).parents[1] / "published" / "solid_reference.toml").read_text(encoding="utf-8")
)
NO_CONTACT = SolidContactLaw(stiffness=0.0)


@pytest.fixture(scope="module")
def clamped() -> SolidStatics:
    """The uniform helix of the solid reference, ends clamped, no contact."""
    return SolidStatics(SolidWire(helix(), contact=NO_CONTACT))


def test_helix_against_calculix(clamped):
    """Other solver: forces within 0.1 % and nine modes within 1.5 % of the converged quadratic bricks
    of docs/solid-reference.md; axial ones within 0.2 %."""
    entry = next(one for one in REFERENCE["uniform"] if one["name"] == "uniform-22")
    found = clamped.compress(entry["compressions"])
    assert [one.retainer_force for one in found] == pytest.approx(entry["forces"], rel=1e-3)
    assert [one.seat_force for one in found] == pytest.approx(entry["forces"], rel=1e-3)
    modes = clamped.modes(clamped.start(), 9)
    assert modes.natural_frequency == pytest.approx(entry["frequencies_free"][:9], rel=0.015)
    axial = np.array(entry["axial_modes_free"]) - 1
    assert modes.natural_frequency[axial] == pytest.approx(
        np.array(entry["frequencies_free"])[axial], rel=2e-3
    )


def test_mass_and_section_of_the_wire(clamped):
    """Closed form: the bricks weigh what the wire does, section centres lie on its axis but for the
    larger radius that makes up for chords."""
    wire, theta = clamped.wire, 2 * np.pi / 24
    assert wire.bricks.mass.sum() == pytest.approx(wire.spring.mass, rel=1e-6)
    assert wire.weights.sum() == pytest.approx(1.0)
    axis = wire.spring.centreline(wire.coil)
    assert wire.centres(wire.free_position).T == pytest.approx(axis, abs=theta**2 * 22e-3 / 2 / 12)


def test_stress_on_the_surface_is_that_of_the_section_loads(clamped):
    """Closed form: away from the ends of a compressed helix, shear and axial stress at the inner and the
    outer fibre are those of its section loads by the factors of curved bars, within 2.5 % of the larger shear;
    unstrained wire bears none, however it is turned."""
    surface, state = SurfaceStress(clamped.wire), clamped.compress([7e-3])[0]
    fibres = len(surface.angle)
    assert np.degrees(surface.angle) == pytest.approx(np.arange(0, 360, 360 / fibres))
    axial, shear = (part.reshape(-1, fibres) for part in surface.parts(state.position))
    found = section_loads(clamped.wire, state.position)
    loads = {
        "torsional_moment": found.moment[::2, 2], "binormal_moment": found.moment[::2, 1],
        "normal_force": found.force[::2, 2], "shear_force": np.hypot(*found.force[::2, :2].T),
    }  # fmt: skip
    due = wire_stress(loads, clamped.wire.spring, found.coil[::2])
    middle, size = slice(18, -18), np.abs(due["inner_fibre_shear_stress"]).max()
    for fibre, place in (("outer", 0), ("inner", fibres // 2)):
        off = -shear[middle, place] - due[f"{fibre}_fibre_shear_stress"][middle]
        assert np.abs(off).max() < 0.025 * size, fibre
        off = axial[middle, place] - due[f"{fibre}_fibre_axial_stress"][middle]
        assert np.abs(off).max() < 0.025 * size, fibre
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = np.einsum("ij,njs->nis", turn, clamped.wire.free_position)
    assert surface.equivalent(turned).max() < 1e-4 * size


def test_beehive_in_contact_is_the_rods():
    """Limit between models: the beehive with closing coils is as stiff by bricks as by the rod (0.1 %)
    at five millimetres."""
    installed = load_case("gu2021-beehive-blind").springs[0]
    size = SolidMeshSize(16)
    statics = SolidStatics(SolidWire(installed.wire, size, planes=installed.seats != "clamps"))
    rod = FiniteElementRod(installed.wire, 7e-3, seats=str(installed.seats))
    found = statics.compress([5e-3])
    for state in found:
        assert state.retainer_force == pytest.approx(
            rod.static_point(state.compression).force, rel=1e-3
        )
        assert state.seat_force == pytest.approx(state.retainer_force, rel=1e-6)


def test_mass_scaling_leaves_the_low_modes():
    """Limit: masses scaled for the deformation of sections move frequencies up to 14 kHz by less than
    3e-4 and lengthen the step at least twice."""
    import scipy.sparse as sparse
    from scipy.sparse.linalg import eigsh

    statics = SolidStatics(SolidWire(helix(coils=2.0), SolidMeshSize(16), NO_CONTACT))
    wire, (first, last) = statics.wire, statics.wire.ends
    x, scratch = wire.free_position.ravel(), np.zeros(columns.SECTION_ROWS * columns.STRIDE)
    whole = statics.tangent(wire.free_position, 0.0, None)[statics.free][:, statics.free]
    shape = wire.free_position.shape

    def inverse_mass(scaling: float) -> sparse.csr_matrix:
        """Accelerations of unit forces; a section's forces move that section alone."""
        found = sparse.lil_matrix((x.size, x.size))
        stations = np.arange(first + 1, last)
        for node in range(shape[0]):
            for axis in range(3):
                force = np.zeros(shape)
                force[node, axis] = 1.0
                moved = force.ravel()
                columns.accelerate(
                    x, moved, wire.bricks.mass.ravel(), scratch, shape[0], shape[2], first + 1, last, scaling
                )  # fmt: skip
                moved = moved.reshape(shape)
                for s in stations:
                    rows = np.arange(x.size).reshape(shape)[:, :, s].ravel()
                    found[rows, (3 * node + axis) * shape[2] + s] = moved[:, :, s].reshape(-1, 1)
        return found.tocsr()[statics.free][:, statics.free]

    def lowest(scaling: float) -> np.ndarray:
        mass = sparse.linalg.inv(inverse_mass(scaling).tocsc())
        return (
            np.sort(eigsh(whole, 12, M=(mass + mass.T) / 2, sigma=0.0, return_eigenvectors=False))
            ** 0.5
        )

    assert lowest(5.0) == pytest.approx(lowest(0.0), rel=3e-4)
    steps = [stable_time_step(statics, SolidDynamics(mass_scaling=one)) for one in (0.0, 5.0)]
    assert steps[1] > 2 * steps[0]


def ramp(amplitude: float, duration: float):
    """Motion (m over s) that starts and stops with no acceleration."""

    def motion(time: np.ndarray) -> np.ndarray:
        share = np.clip(time / duration, 0.0, 1.0)
        return amplitude * share**3 * (10 - 15 * share + 6 * share**2)

    return motion


@pytest.mark.parametrize(("mass_damping", "stiffness_damping"), [(0.0, 0.0), (200.0, 4e-6)])
def test_energy_in_balance(clamped, mass_damping, stiffness_damping):
    """Property: work of the retainer is the energy stored and turned to heat, within 1e-4 of the
    largest, with and without damping."""
    statics = SolidStatics(replace(clamped.wire, size=SolidMeshSize(12)))
    dynamics = SolidDynamics(mass_damping, stiffness_damping)
    run = simulate_solid(statics, statics.start(), ramp(3e-3, 1e-3), 2e-5, 75, dynamics)
    assert run.completed
    assert np.abs(run.energy_gap).max() < 1e-4 * np.abs(run.energy[:, columns.WORK_DONE]).max()
    heat = run.energy[-1, columns.HEAT]
    assert heat > 0 if mass_damping else heat == 0.0


def test_slow_motion_is_static(clamped):
    """Limit: moved in eleven periods of its first mode, damped, the spring answers as at rest."""
    statics = SolidStatics(replace(clamped.wire, spring=helix(coils=2.0), size=SolidMeshSize(12)))
    run = simulate_solid(
        statics, statics.start(), ramp(2e-3, 4e-3), 5e-5, 90, SolidDynamics(2000.0, 0.0)
    )
    rest = statics.compress([2e-3])[0]
    assert run.dense_seat_force[-200:].mean() == pytest.approx(rest.seat_force, rel=5e-3)
    assert run.dense_retainer_force[-200:].mean() == pytest.approx(rest.retainer_force, rel=5e-3)


def test_coils_that_meet_conserve_energy():
    """Property: a short spring driven until its coils clash stays in balance, contact included."""
    spring = helix(coils=3.0, pitch=4.2e-3)
    statics = SolidStatics(SolidWire(spring, SolidMeshSize(12), SolidContactLaw()))
    run = simulate_solid(
        statics, statics.start(), ramp(1.5e-3, 5e-4), 1e-5, 80, SolidDynamics(0.0, 2e-6)
    )
    assert run.pair_force.max() > 10.0
    assert np.abs(run.energy_gap).max() < 5e-3 * np.abs(run.energy[:, columns.WORK_DONE]).max()


def test_a_run_repeats_bit_for_bit(clamped):
    """Contract: the same motion gives the same bits."""
    statics = SolidStatics(replace(clamped.wire, spring=helix(coils=2.0), size=SolidMeshSize(12)))
    first, second = (
        simulate_solid(
            statics, statics.start(), ramp(1e-3, 5e-4), 2e-5, 30, SolidDynamics(10.0, 2e-6)
        )
        for _ in range(2)
    )
    assert np.array_equal(first.dense_seat_force, second.dense_seat_force)
    assert np.array_equal(first.position, second.position)


def test_too_coarse_a_mesh_is_refused():
    """Contract: fewer than eight slices per coil make no helix."""
    with pytest.raises(InputError, match="at least 8"):
        SolidMeshSize(6)
