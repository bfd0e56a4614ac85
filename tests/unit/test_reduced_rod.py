"""The spring reduced from its rod against that rod: statics and frequencies over lift, motion with
and without clash, in a train. Limit between models, on a spring that is not in the library; the
order and the energy of the model stand in the battery of all models (contract).
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from spring_parts import drive
from spring_shapes import cylindrical
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.condensed import condensed, elastic_statics
from valvetrain.cosserat.contact_points import ContactPoints
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import compress
from valvetrain.errors import InputError
from valvetrain.integrate.contract import Cycles
from valvetrain.integrate.run import run as integrate
from valvetrain.parameters.installed_spring import Guide
from valvetrain.springs import reduced_rod_cache
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import (
    interpolation,
    static_section_loads,
    wire_points,
)
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.springs.stress import LOADS, wire_stress
from valvetrain.system.prescribed import PrescribedSpring

#: A short racing spring: 4.5 mm wire, 24 mm mean diameter, 4.4 active turns, softly damped.
WIRE = cylindrical(4.5e-3, 24e-3, 9.2e-3, 6.2)
PRELOAD_TRAVEL, LIFT = 6e-3, 8e-3
DYNAMICS = RodDynamics(40.0, 4e-6)


@pytest.fixture(scope="module")
def rod() -> FiniteElementRod:
    return FiniteElementRod(WIRE, PRELOAD_TRAVEL, 12, DYNAMICS)


@pytest.fixture(scope="module")
def spring(rod) -> ReducedRod:
    return ReducedRod(rod, LIFT)


def test_contact_points_are_those_of_the_rod_and_their_gradient_is_its_slope(rod):
    points, state = ContactPoints.of(rod.mesh), rod.installed.state
    overlap, gradient = points.overlaps(state)
    line = points.mesh.contact
    gaps = rod.statics.gaps(state.position)[points.group, points.vertex]
    assert np.allclose(-overlap[: len(gaps)], gaps, atol=1e-12)
    assert points.length[: len(gaps)] == pytest.approx(line.length[points.group, points.vertex])
    move = 1e-7 * np.random.default_rng(1).standard_normal(state.position.shape)
    ends = [
        points.overlaps(RodState(state.position + sign * move, state.frame, state.compression))[0]
        for sign in (1, -1)
    ]
    expected = np.einsum("pvk,vk->p", gradient, move)
    assert (ends[0] - ends[1]) / 2 == pytest.approx(expected, abs=2e-9)  # one step to the foot


def test_the_condensed_rod_has_its_frequencies(rod):
    """Rotations at rest, their inertia kept: the first frequencies of the whole rod, and not less."""
    bare = elastic_statics(rod.mesh)
    state = compress(bare, [PRELOAD_TRAVEL])[-1].state
    wire = condensed(bare, bare, state)
    squares = np.linalg.eigvals(np.linalg.solve(wire.mass, wire.stiffness)).real
    found = np.sqrt(np.sort(squares)[:8]) / (2 * np.pi)
    expected = natural_modes(bare, state, 8).natural_frequency
    assert found == pytest.approx(expected, rel=1e-4)
    assert np.all(found >= expected * (1 - 1e-9))


@pytest.mark.parametrize("retainer_displacement", [0.0, 4.44e-3, 7.9e-3])
def test_it_stands_at_rest_and_swings_as_its_rod_does(rod, spring, retainer_displacement):
    """Forces within 0.1 % and six frequencies within 0.5 %, between its tables as well."""
    state = spring.initial_state(retainer_displacement)
    found = spring.force(state, retainer_displacement)
    at = rod._equilibrium(retainer_displacement)
    assert found.retainer == pytest.approx(at.retainer_force, rel=1e-3)
    assert found.seat == pytest.approx(at.seat_force, rel=1e-3)
    expected = natural_modes(rod.statics, at.state, 6).natural_frequency
    assert spring.frequencies(retainer_displacement) == pytest.approx(expected, rel=5e-3)
    shown = spring.outputs(state, retainer_displacement)
    moved = at.state.position[:, 2] - rod.installed.state.position[:, 2]
    at_points = interpolation(rod.mesh.coil_number, wire_points(WIRE.total_coils))
    assert shown.axial_displacement == pytest.approx(at_points @ moved, abs=2e-5)
    for name, load in static_section_loads(rod, [at.state]).items():
        largest = np.max(np.abs(load))
        assert shown.section_loads[name] == pytest.approx(load[0], abs=5e-3 * largest), name


def pulses(cam_speed: float, time_step: float) -> tuple[np.ndarray, np.ndarray]:
    """Two revolutions of a smooth lift event over a third of each."""
    time = np.arange(round(4 * np.pi / cam_speed / time_step) + 1) * time_step
    phase = np.mod(cam_speed * time, 2 * np.pi) / (2 * np.pi / 3) - 1
    inside = np.abs(phase - 0.5) < 0.5
    angle = np.where(inside, np.pi * phase, 0.0)
    rate = cam_speed / (2 * np.pi / 3) * np.pi
    return LIFT * np.sin(angle) ** 4, 4 * LIFT * rate * np.sin(angle) ** 3 * np.cos(angle)


def seat_force(model, cam_speed: float) -> np.ndarray:
    """Seat force (N) over the second revolution every 4 us, below 20 kHz."""
    time_step = 0.9 * model.stable_time_step()
    model = model.with_time_step(time_step)
    lift, velocity = pulses(cam_speed, time_step)
    forces = drive(model, model.initial_state(0.0), lift, velocity, time_step)[:, 1]
    grid = np.arange(0, 4 * np.pi / cam_speed, 4e-6)
    even = np.interp(grid, time_step * np.arange(len(forces)), forces)
    return sosfiltfilt(butter(4, 20e3, fs=2.5e5, output="sos"), even)[len(grid) // 2 :]


def errors(model, expected: np.ndarray, cam_speed: float) -> tuple[float, float]:
    """rms of the difference over the rms of the expected force, and of the peak."""
    found = seat_force(model, cam_speed)
    rms = np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2))
    return float(rms), float(found.max() / expected.max() - 1)


@pytest.mark.parametrize("cam_speed", [340.0, pytest.param(200.0, marks=pytest.mark.long)])
def test_it_moves_as_its_rod_where_coils_meet_and_where_they_do_not(rod, spring, cam_speed):
    """At 340 rad/s coils clash; the chain is several times further off."""
    chain = MultiMassSpring.from_definition(
        WIRE, PRELOAD_TRAVEL, mass_damping=40.0, stiffness_damping=4e-6
    )
    expected = seat_force(rod, cam_speed)
    rms, peak = errors(spring, expected, cam_speed)
    assert rms < 0.01 and abs(peak) < 0.01
    assert errors(chain, expected, cam_speed)[0] > 4 * rms


@dataclass(frozen=True)
class Pulse:
    """The same event as a lift law."""

    continuity: int = 3
    joints: tuple[float, ...] = ()

    def lift(self, cam_angle, derivative=0):
        phase = np.mod(cam_angle, 2 * np.pi) / (2 * np.pi / 3) - 1
        sine, cosine = np.sin(np.pi * phase), np.cos(np.pi * phase)
        value = sine**4 if derivative == 0 else 6 * sine**3 * cosine
        return LIFT * np.where(np.abs(phase - 0.5) < 0.5, value, 0.0)


def test_stress_along_its_wire_is_that_of_its_rod(rod, spring):
    """Largest shear and equivalent stress at the inner fibre of every point of the wire over a
    revolution, with surge: within 1 % of the largest.
    """
    found = []
    for model in (spring, rod):
        run = integrate(PrescribedSpring((model,), Pulse()), 200.0, Cycles(2))
        loads = {name: np.asarray(run.cycle[name]) for name in LOADS}
        found.append(wire_stress(loads, WIRE, wire_points(WIRE.total_coils)))
    for name in ("inner_fibre_shear_stress", "inner_fibre_equivalent_stress"):
        own, expected = (np.max(one[name], axis=0) for one in found)
        assert own == pytest.approx(expected, abs=0.01 * np.max(expected)), name


def test_a_state_changed_from_outside_meets_its_contacts_at_once(spring):
    """The search of a periodic state moves positions: points that were far may then touch."""
    time_step = 0.9 * spring.stable_time_step()
    state, arrays = spring.initial_state(2e-3), (spring.parameters(), spring.integers())
    for _ in range(5):
        spring.kernel(*arrays, state, 2e-3, 0.0, time_step)
    other = spring.initial_state(7.9e-3)
    state[: 2 * spring.unknowns] = other[: 2 * spring.unknowns]
    begun = state.copy()
    fresh = other.copy()
    forces = [spring.kernel(*arrays, one, 7.9e-3, 0.0, time_step) for one in (state, fresh)]
    assert forces[0] == forces[1]
    assert not np.array_equal(begun, state)


def test_points_that_are_left_alone_meet_when_those_do_that_are_always_looked_at(spring):
    """Coils clash at 340 rad/s; forces of every step are the same bit by bit (limit between models)."""
    time_step = 0.8 * spring.stable_time_step()
    time = np.arange(0.0, 2 * np.pi / 340.0, time_step)
    lift = Pulse().lift(340.0 * time)
    waiting = spring.initial_state(lift[0])
    watched, arrays = waiting.copy(), (spring.parameters(), spring.integers())
    accelerations_of_times = 2 * spring.unknowns + 7
    largest = 0.0
    for here, rate in zip(lift, np.gradient(lift, time_step), strict=True):
        watched[accelerations_of_times] = -1.0  # as if they had grown: all points are due
        forces = [spring.kernel(*arrays, one, here, rate, time_step) for one in (waiting, watched)]
        assert forces[0] == forces[1]
        largest = max(largest, forces[0][1])
    assert largest > 1.02 * spring.rod.static_point(PRELOAD_TRAVEL + LIFT).force


def test_ends_that_do_not_pull_carry_nothing_where_they_would(rod):
    """A wire pressed together and let go at once flies up: its seat and retainer do not hold it."""
    holds = ReducedRod(rod, LIFT)
    loose = ReducedRod(replace(rod, pulls=False), LIFT)
    time_step, lowest = 0.9 * loose.stable_time_step(), []
    for spring in (holds, loose):
        state = spring.initial_state(7.9e-3)
        rest = np.zeros(3000)
        lowest.append(drive(spring, state, rest, rest, time_step).min())
    assert lowest[0] < -50.0 and lowest[1] == 0.0
    assert loose.tangent(loose.initial_state(7.9e-3), 0.0) >= 0.0


def test_what_it_does_not_know_is_refused_with_the_name_of_what_does(rod):
    with pytest.raises(InputError, match="use finite-element"):
        ReducedRod(replace(rod, pulls=False, lifting=True))


def test_a_guide_that_the_wire_leans_on_holds_it_at_rest(rod):
    """A tight bore presses on the coils: forces at rest are those of the rod in it."""
    guided = replace(rod, guide=Guide(bore=28.6e-3))
    spring = ReducedRod(guided, 5e-3)
    for lift in (1e-3, 4.1e-3):
        found = spring.force(spring.initial_state(lift), lift).retainer
        assert found == pytest.approx(guided._equilibrium(lift).retainer_force, rel=1e-3)


def test_coils_that_one_end_holds_are_no_pair():
    """Contract: an end of 1.51 coils has turns that never move against each other; each pair that is shown has its gap."""
    end = replace(WIRE.lower_end, inactive_coils=1.5148714432258374)
    wire = replace(WIRE, lower_end=end, upper_end=end)
    spring = ReducedRod(FiniteElementRod(wire, 2e-3, 12, DYNAMICS), 2e-3)
    shown = spring.shown_at(spring.initial_state(1e-3)[None, :], np.full(1, 1e-3), np.zeros(1))
    assert len(shown.upper_coil) == shown.coil_gap.shape[1] > 3
    assert np.all(np.diff(shown.upper_coil) > 0) and np.all(np.isfinite(shown.coil_gap))
    assert shown.upper_coil[-1] < wire.total_coils - 0.5


def test_tables_are_read_where_they_stand_and_made_anew_where_a_file_is_damaged(
    rod, tmp_path, monkeypatch
):
    monkeypatch.setattr(reduced_rod_cache, "_folder", lambda: tmp_path)
    monkeypatch.setattr(reduced_rod_cache, "_MADE", OrderedDict())
    made = ReducedRod(rod, 1e-3).tables
    (file,) = tmp_path.glob("*.npz")
    whole = file.read_bytes()
    assert len(whole) > 1000
    for content in (whole, whole[:-200], b""):
        file.write_bytes(content)
        reduced_rod_cache._MADE.clear()
        found = ReducedRod(rod, 1e-3).tables
        for one in fields(made):
            assert np.array_equal(getattr(found, one.name), getattr(made, one.name))
        assert file.read_bytes() == whole
    assert ReducedRod(rod, 1e-3).tables is found
    stiffer = replace(rod, dynamics=replace(DYNAMICS, contact_stiffness=3e10))
    assert ReducedRod(stiffer, 1e-3).tables is not found
