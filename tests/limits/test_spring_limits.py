"""Limits between spring models and to closed forms, each with its rate."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from spring_parts import OPEN_SPRING, UNIFORM, drive, raised_cosine
from spring_shapes import beehive, conical
from valvetrain.cosserat.static import compress
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.winding import OPEN_END
from valvetrain.springs.chain_layout import chain_from_definition, coil_contacts
from valvetrain.springs.chain_statics import static_curve
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.modal_varied import ModalVaried
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.wave_rod import WaveRod

RATE, MASS = UNIFORM.rate, UNIFORM.active_mass
SPEED, IMPEDANCE = np.sqrt(RATE / MASS), np.sqrt(RATE * MASS)


def order(errors, refinement=2.0):
    return np.log(np.array(errors[:-1]) / np.array(errors[1:])) / np.log(refinement)


def test_chain_frequencies_converge_to_the_bar_at_order_two():
    exact = np.arange(1, 4) * SPEED / 2
    errors = [
        np.abs(
            MultiMassSpring.from_card(RATE, 250.0, MASS, elements=n).frequencies(0.0) / exact - 1
        )
        for n in (20, 40, 80, 160)
    ]
    assert np.all(np.abs(order(errors) - 2) < 0.02)
    # Closed form of the lumped chain: 2 N sin(n pi / 2 N) / (n pi).
    n = np.arange(1, 4)
    assert np.allclose(errors[0], 1 - 40 * np.sin(n * np.pi / 40) / (n * np.pi), rtol=1e-6)


def test_chain_force_converges_to_the_rod_at_order_two():
    """Whole transient, seat force: chain of N masses against a rod of 640 cells, damped alike."""
    time_step = 1 / (SPEED * 640)
    displacement, velocity = raised_cosine(5e-3, 5e-3, time_step, rest=3e-3)
    rod = WaveRod(UNIFORM, 640, friction=25.0)
    reference = drive(rod, rod.initial_state(0.0), displacement, velocity, time_step)[:, 1]
    errors = []
    for elements in (10, 20, 40):
        chain = MultiMassSpring.from_card(RATE, 250.0, MASS, elements=elements, mass_damping=50.0)
        force = drive(chain, chain.initial_state(0.0), displacement, velocity, time_step)[:, 1]
        errors.append(np.sqrt(np.mean((force - reference) ** 2)))
    assert np.all(np.abs(order(errors) - 2) < 0.15)


def test_rod_standing_wave_is_exact_inside_and_order_two_at_the_end():
    """Drive-point dynamic stiffness k b cot b and transfer k b / sin b, b = omega sqrt(m / k)."""
    beta = 2.2
    omega, amplitude = beta * SPEED, 1e-3
    drive_errors, transfer_errors = [], []
    for cells in (40, 80, 160):
        rod = WaveRod(UNIFORM, cells)
        time_step = rod.stable_time_step()
        shape = amplitude * np.sin(beta * np.arange(1, cells) / cells) / np.sin(beta)
        state = rod.initial_state(0.0)
        state[rod.unknowns : 2 * rod.unknowns] = shape * np.sin(omega * time_step) / time_step
        time = np.arange(20 * cells) * time_step
        motion = amplitude * np.sin(omega * time)
        forces = (
            drive(rod, state, motion, omega * amplitude * np.cos(omega * time), time_step) - 250.0
        )
        next_time = len(time) * time_step
        assert np.allclose(
            state[: rod.unknowns], shape * np.sin(omega * next_time), atol=1e-9 * amplitude
        )
        sine = np.sin(omega * time)
        retainer = forces[:, 0] @ sine / (sine @ sine) / amplitude - rod.cell_mass / 2 * omega**2
        seat = forces[:, 1] @ sine / (sine @ sine) / amplitude
        drive_errors.append(abs(retainer - RATE * beta / np.tan(beta)) / RATE)
        transfer_errors.append(abs(seat - RATE * beta / np.sin(beta)) / RATE)
    assert np.all(np.abs(order(drive_errors) - 2) < 0.05) and np.all(
        np.abs(order(transfer_errors) - 2) < 0.05
    )
    assert drive_errors[-1] < 1e-3 and transfer_errors[-1] < 1e-3


def impact(rod: WaveRod, time_step: float, travels: float, speed: float = 1.0) -> np.ndarray:
    """End forces above preload, over v sqrt(k m), after the retainer starts at ``speed`` (m/s) at
    once.
    """
    steps = int(travels / (SPEED * time_step))
    time = np.arange(steps) * time_step
    return (
        drive(rod, rod.initial_state(0.0), speed * time, np.full(steps, speed), time_step) - 250.0
    ) / (speed * IMPEDANCE)


def test_step_change_travels_undistorted():
    """End impact force v sqrt(k m), doubled at the fixed end after one travel, tripled at the
    retainer after two.
    """
    cells = 250
    rod = WaveRod(UNIFORM, cells)
    force = impact(rod, rod.stable_time_step(), 2.9)
    assert np.allclose(force[1 : 2 * cells, 0], 1.0, atol=1e-9)
    assert np.allclose(force[2 * cells + 1 :, 0], 3.0, atol=1e-9)
    assert np.allclose(force[:cells, 1], 0.0, atol=1e-9)
    assert np.allclose(force[cells:, 1][1:], 2.0, atol=1e-9)


@pytest.mark.parametrize(("cells", "overshoot", "front"), [
    (250, 0.11, 2), (60, 0.11, 2),
])  # fmt: skip
def test_dispersion_at_a_step_that_whole_cells_do_not_fit(cells, overshoot, front):
    """The worst train step for the grid (half a cell off): how far the front overshoots and smears
    at the seat is stated here.
    """
    time_step = 1 / (SPEED * (cells + 0.5))
    rod = WaveRod(UNIFORM).with_time_step(time_step)
    assert rod.cells == cells
    seat = impact(rod, time_step, 2.5)[:, 1]
    risen = np.flatnonzero(seat > 1.9)[0] - np.flatnonzero(seat > 0.1)[0]
    assert risen <= front
    assert 0 < np.max(seat) / 2 - 1 < overshoot
    # Away from the front the plateau is right.
    assert np.mean(seat[int(1.2 * cells) : int(2.2 * cells)]) == pytest.approx(2.0, rel=2e-3)


def test_a_chain_or_a_low_courant_number_does_distort_a_step():
    """The same grid at half the step: the property tested above is the scheme's, not the grid's."""
    rod = WaveRod(UNIFORM, 250)
    seat = impact(rod, rod.stable_time_step() / 2, 1.9)[:, 1]
    assert np.max(seat) / 2 - 1 > 0.1


def test_front_decays_by_the_friction_alone():
    """Telegraph equation: the jump of a front falls as exp(-mu t), mu = 60 1/s; the grid shows half
    the jump at the instant of arrival.
    """
    friction, errors = 60.0, []
    for cells in (100, 200, 400):
        rod = WaveRod(UNIFORM, cells, friction=friction)
        seat = impact(rod, rod.stable_time_step(), 1.1)[:, 1]
        errors.append(abs(seat[cells] / np.exp(-friction / SPEED) - 1))
        assert errors[-1] < 1.01 * friction / (SPEED * cells)
    assert np.all(np.abs(order(errors) - 1) < 0.05)


def dynamic_stiffness(model: ModalUniform, omega: float) -> float:
    kappa, share, own = model.modal_stiffness, model.shares, model.circular_frequencies
    moving = kappa * share**2
    return (
        model.spring.rate
        + np.sum(moving - moving * own**2 / (own**2 - omega**2))
        - model.retainer_mass() * omega**2
    )


def test_modes_converge_to_the_exact_wave_solution_at_order_three():
    beta, bare = 2.2, EquivalentSpring(RATE, 250.0, MASS)
    exact = RATE * beta / np.tan(beta)
    errors = [
        abs(dynamic_stiffness(ModalUniform(bare, n), beta * SPEED) - exact)
        for n in (10, 20, 40, 80)
    ]
    assert np.all(np.abs(order(errors) - 3) < 0.2)


def test_modal_oscillator_rings_exactly_at_any_step():
    """Free damped decay sampled at a coarse step against its closed form."""
    model = ModalUniform(UNIFORM, 1, damping_ratio=0.05)
    omega, zeta = model.circular_frequencies[0], 0.05
    damped, time_step = omega * np.sqrt(1 - zeta**2), 0.35 * 2 / omega
    exact = lambda t: 1e-4 * np.exp(-zeta * omega * t) * np.cos(damped * t)
    state = model.initial_state(0.0)
    state[0], state[1] = exact(0.0), (exact(0.0) - exact(-time_step)) / time_step
    drive(model, state, np.zeros(400), np.zeros(400), time_step)
    assert state[0] == pytest.approx(exact(400 * time_step), rel=1e-9)


def test_static_chain_gives_the_rate_integral_of_a_cone():
    """k = G d**4 / [2 n (D1 + D2)(D1**2 + D2**2)], any number of masses, no coil closed."""
    cone = conical(4e-3, 30e-3, 20e-3, 9e-3, 6.0, ends="open")
    exact = cone.material.shear_modulus * 4e-3**4 / (2 * 6.0 * 50e-3 * (30e-3**2 + 20e-3**2))
    for elements in (3, 20, 101):
        layout = chain_from_definition(cone, elements, 0.0)
        assert layout.rate == pytest.approx(exact, rel=1e-9)
        assert static_curve(layout, np.array([5e-3]))[0][0] == pytest.approx(5e-3 * exact, rel=1e-9)
        assert layout.seat_mass + layout.masses.sum() + layout.retainer_mass == pytest.approx(
            cone.mass, rel=1e-6
        )


OPEN_ENDS = {"lower_end": OPEN_END, "upper_end": OPEN_END}


@pytest.mark.parametrize(("spring", "on_seat", "under_retainer"), [
    (OPEN_SPRING, lambda u: u < 1, lambda u: u >= 5),
    (conical(2e-3, 50e-3, 18e-3, 7e-3, 6.0, **OPEN_ENDS), lambda u: u > 0, lambda u: u > 0),
    (conical(2e-3, 18e-3, 50e-3, 7e-3, 6.0, **OPEN_ENDS), lambda u: u > 0, lambda u: u > 0),
    (beehive(2e-3, 40e-3, 25e-3, 3.0, Constant(7e-3), 6.0, **OPEN_ENDS), lambda u: (u < 1) | (u > 3.79), lambda u: u > 2.79),
], ids=["cylinder", "narrow above", "narrow below", "beehive"])  # fmt: skip
def test_the_first_turn_and_coils_that_telescope_can_meet_the_planes(
    spring, on_seat, under_retainer
):
    """The wire rises 7 mm a turn from either plane; a turn that is a wire's thickness narrower than
    its neighbour passes it. The end of a
    cylinder's wire meets the retainer's last node from one turn below, 7 mm less the wire."""
    coil = np.linspace(0.0, 6.0, 61)
    found = coil_contacts(spring, coil, 2e9)
    below = (found.lower == 0) & (found.upper_coil == 0.0)
    above = (found.upper == 60) & (found.upper_coil == 6.0)
    lower, upper = coil[found.upper[below]], (found.lower + found.fraction)[above] / 10
    inner = coil[1:-1]
    assert np.sort(lower) == pytest.approx(inner[on_seat(inner + 1e-9)])
    assert np.sort(upper) == pytest.approx(inner[under_retainer(inner + 1e-9)])
    assert found.gap[below] == pytest.approx(7e-3 * lower, abs=1e-9)
    rise = 7e-3 * (6.0 - upper)
    if spring is OPEN_SPRING:
        rise = np.where(np.isclose(upper, 5.0), 7e-3 - 3.8e-3, rise)
    assert found.gap[above] == pytest.approx(rise, abs=1e-9)


@pytest.mark.parametrize("share", [
    0.75, 0.9,
])  # fmt: skip
def test_coils_of_a_telescoping_cone_land_on_the_seat(share):
    """Each turn sinks by 64 F R**3 / (G d**4) until it lies on the seat, after its own pitch: the
    closing law of cones.

    The largest turns land first and the spring hardens; through the seat it would take less than
    half the force.
    """
    cone = conical(2e-3, 50e-3, 18e-3, 6e-3, 5.0, ends="open")
    assert np.all(cone.telescopes([1.0, 2.5, 5.0])) and not cone.telescopes(0.9)
    assert not np.any(OPEN_SPRING.telescopes(np.linspace(0.0, 6.0, 25)))
    coil = np.linspace(0.0, 5.0, 5001)
    per_force = (
        64 * (cone.mean_diameter.value(coil) / 2) ** 3 / (cone.material.shear_modulus * 2e-3**4)
    )
    compression = share * cone.solid_compression
    exact = brentq(
        lambda force: np.trapezoid(np.minimum(6e-3, force * per_force), coil) - compression,
        0.0,
        500.0,
    )
    through = compression / np.trapezoid(per_force, coil)
    assert exact > 1.5 * through
    chain = static_curve(chain_from_definition(cone, 120, 2e10), np.array([compression]))[0].item()
    rod = FiniteElementRod(cone, 1e-3)
    reached = compress(rod.statics, [compression])[-1]
    assert reached.converged
    assert (chain, reached.retainer_force) == pytest.approx((exact, exact), rel=0.015)
    free = rod.mesh.coil_number > 1.5
    assert np.min(reached.state.position[free, 2]) > -1e-4


def test_open_cylinder_reduces_to_the_closed_forms_of_rate_and_surge():
    equivalent = EquivalentSpring.from_definition(OPEN_SPRING, 2e-3)
    shear, density = OPEN_SPRING.material.shear_modulus, OPEN_SPRING.material.density
    d, diameter, turns = 3.8e-3, 22e-3, 6.0
    rate = shear * d**4 / (8 * diameter**3 * turns)
    assert equivalent.rate == pytest.approx(rate, rel=1e-6)
    assert equivalent.preload == pytest.approx(2e-3 * rate, rel=1e-6)
    assert equivalent.active_mass == pytest.approx(OPEN_SPRING.mass, rel=1e-4)
    # The handbook frequency takes the wire length as n pi D, without the pitch.
    flat = d / (2 * np.pi * turns * diameter**2) * np.sqrt(shear / (2 * density))
    stretched = np.sqrt(np.hypot(np.pi * diameter, 7e-3) / (np.pi * diameter))
    assert equivalent.surge_frequency == pytest.approx(flat / stretched, rel=1e-4)


def varied(modes: int, damping_ratio: float = 0.0) -> ModalVaried:
    frequencies = tuple(np.arange(1, modes + 1) * SPEED / 2)
    return ModalVaried(frequencies, damping_ratio, (0.0, 40e-3), (0.0, 40e-3 * RATE), 8e-3)


@pytest.mark.parametrize("harmonic", [
    3, 9, 21,
])  # fmt: skip
def test_modal_varied_reaches_the_exact_wave_solution_for_harmonics(harmonic):
    """Constant k: transfer k b / sin b at the fixed end, k b cot b at the moving one, as modes are
    added.
    """
    cam_speed = 0.11 * SPEED
    beta = harmonic * 0.11
    angle = 2 * np.pi * np.arange(512) / 512
    lift = 1e-3 * np.cos(harmonic * angle)
    seat_errors, retainer_errors = [], []
    for modes in (40, 80, 160):
        solution = varied(modes).solve(lift, cam_speed)
        shape = np.cos(harmonic * angle) / 256 / 1e-3
        seat, retainer = (
            (f - 8e-3 * RATE) @ shape for f in (solution.seat_force, solution.retainer_force)
        )
        seat_errors.append(abs(seat - RATE * beta / np.sin(beta)) / RATE)
        retainer_errors.append(abs(retainer - RATE * beta / np.tan(beta)) / RATE)
    assert seat_errors[-1] < 2e-4 * beta**2 and np.all(np.abs(order(seat_errors) - 2) < 0.1)
    # The moving end lacks the inertia the modes do not carry, m / 3 less its partial sum: order
    # one.
    assert retainer_errors[-1] < 2e-3 * beta**2 and np.all(np.abs(order(retainer_errors) - 1) < 0.1)


def test_modal_varied_agrees_with_time_integration_of_equation_two():
    from scipy.integrate import solve_ivp

    model, cam_speed = varied(3, 0.05), 0.21 * SPEED
    coefficients = [4e-3, -2.5e-3, 0.9e-3, -0.3e-3, 0.1e-3]

    def lift(angle, derivative=0):
        shift = derivative * np.pi / 2
        return sum(
            c * j**derivative * np.cos(j * angle + shift) for j, c in enumerate(coefficients)
        )

    solution = model.solve(lambda angle: lift(angle), cam_speed, samples=256)
    for n in (1, 2, 3):
        ratio = n * np.pi * SPEED / cam_speed

        def rate(angle, g, n=n, ratio=ratio):
            return [
                g[1],
                -2 / (n * np.pi) * lift(angle, 2) - 2 * 0.05 * ratio * g[1] - ratio**2 * g[0],
            ]

        end = 6 * 2 * np.pi
        angles = end + solution.cam_angle[::32]
        run = solve_ivp(
            rate, (0, end + 2 * np.pi), [0.0, 0.0], rtol=1e-10, atol=1e-14, t_eval=angles
        )
        assert np.allclose(
            run.y[0],
            solution.modal_coordinates[n - 1, ::32],
            rtol=0,
            atol=1e-7 * np.ptp(run.y[0]) + 1e-12,
        )


def test_equation_five_as_printed_differs_in_the_even_modes_alone():
    """The wave equation alternates the sign; the print does not: the gap is 2 pi k sum of the even
    modes.
    """
    lift = 4e-3 * (1 - np.cos(2 * np.pi * np.arange(512) / 512)) ** 3 / 8
    solution = varied(4, 0.02).solve(lift, 0.4 * SPEED)
    even = (
        2 * np.pi * RATE * (2 * solution.modal_coordinates[1] + 4 * solution.modal_coordinates[3])
    )
    assert np.allclose(solution.seat_force_as_printed - solution.seat_force, even, atol=1e-9 * RATE)
    assert np.max(np.abs(even)) > 1.0
