"""Time step of the reduced rod: single contacts against closed forms, and springs that clash against a step
ten times finer.
"""

from __future__ import annotations

import numpy as np
import pytest

from spring_parts import drive
from spring_shapes import cylindrical
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.integrate.contract import Cycles, RunOptions
from valvetrain.integrate.run import run as integrate
from valvetrain.quantities.signal import fine_series
from valvetrain.solution.force_peak import filtered_cycle
from valvetrain.springs import reduced_rod_kernel as kernels
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.system.build import build

#: Frequency (rad/s) of a unit mass on its contact; values of a row of the tables.
FREQUENCY, LINE = 1e5, kernels.LINE


def one_mass(damping_time: float, load: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parameters, integers and state of a mass of 1 kg, pressed by ``load`` (N) at a contact that it touches."""
    row = np.eye(1, LINE)[0]
    parts = [
        [0.0, 1.0, 0.0, 0.0, damping_time, 0.0, 0.0, 0.0],
        FREQUENCY**2 * row,
        row,
        np.zeros(5 * LINE),
        np.tile(-load * row, 5),
        np.zeros(5 * LINE),
        np.zeros(LINE),
        np.zeros(2 * LINE * LINE),
        np.tile(row, 2),
        np.tile(row, 2),
    ]
    integers = np.array([1, 1, 5, 2, 4, 1, 0, -1], dtype=np.int64)
    state = np.zeros(kernels.state_size(1, 1, 0))
    return kernels.aligned(np.concatenate(parts)), integers, state


def restitution(share: float, damping: float, phase: float) -> float:
    """Speed of the rebound over that of the impact of a free mass, at a step of ``share`` of 1 / frequency,
    which meets the contact ``phase`` steps after a whole one.
    """
    step = share / FREQUENCY
    arrays = one_mass(damping / FREQUENCY, 0.0)
    arrays[2][:2] = -(3 + phase) * step, 1.0
    for _ in range(round(12 / share)):
        kernels.advance_reduced(*arrays, 0.0, 0.0, step)
    return -float(arrays[2][1])


@pytest.mark.parametrize("damping", [0.0, 0.15, 0.3, 0.6])
def test_a_mass_leaves_a_damped_contact_at_the_speed_of_the_closed_form(damping):
    """With sin a = frequency times damping time / 2 the restitution is exp(-(pi - 2 a) tan a), wherever the impact
    falls within a step; at 0.4 it scattered by 0.02.
    """
    angle = np.arcsin(damping / 2)
    expected = np.exp(-(np.pi - 2 * angle) * np.tan(angle))
    for share, allowed in ((0.2, 0.002), (0.4, 0.007), (0.8, 0.035)):
        found = [restitution(share, damping, phase) for phase in np.arange(0.0, 1.0, 0.1)]
        assert found == pytest.approx(np.full(10, expected), abs=allowed)


def test_a_mass_on_a_damped_contact_swings_as_the_closed_form_of_second_order():
    """A damped oscillation that stays closed, over four periods; the damping was of first order."""
    damping, load, errors = 0.1, 4e-3 * FREQUENCY**2, []
    rest, decay = load / FREQUENCY**2, damping / 2
    turn = np.sqrt(1 - decay**2)
    for share in (0.2, 0.1, 0.05):
        step = share / FREQUENCY
        arrays = one_mass(damping / FREQUENCY, load)
        time = np.arange(round(8 * np.pi / share)) * share

        def swing(at: np.ndarray | float) -> np.ndarray:
            return np.exp(-decay * at) * (np.cos(turn * at) + decay / turn * np.sin(turn * at))

        def rate(at: float) -> float:
            return float(-np.exp(-decay * at) * np.sin(turn * at) / turn)

        arrays[2][0], arrays[2][1] = rest + 1e-3, 1e-3 * FREQUENCY * rate(-share / 2)
        places = []
        for _ in time:
            places.append(float(arrays[2][0]))
            kernels.advance_reduced(*arrays, 0.0, 0.0, step)
        errors.append(np.max(np.abs(np.array(places) - rest - 1e-3 * swing(time))) / 1e-3)
    assert errors[0] < 0.02
    assert errors[0] / errors[1] > 3.5 and errors[1] / errors[2] > 3.5


def test_a_spring_that_clashes_is_of_second_order():
    """Seat force of a short racing spring whose coils clash, every 4 us: its rms error falls by four with half the
    step; it fell by two.
    """
    wire = cylindrical(4.5e-3, 24e-3, 9.2e-3, 6.2)
    spring = ReducedRod(FiniteElementRod(wire, 6e-3, 12, RodDynamics(40.0, 4e-6)), 8e-3)
    duration, traces = 4.5e-3, []
    counts = [1200 * 2**n for n in (1, 2, 3, 5)]
    assert duration / counts[0] < spring.stable_time_step()
    for count in counts:
        time = np.arange(2 * count + 1) * duration / count
        angle = np.where(time < duration, np.pi * time / duration, 0.0)
        lift = 8e-3 * np.sin(angle) ** 4
        rate = 32e-3 * np.pi / duration * np.sin(angle) ** 3 * np.cos(angle)
        forces = drive(spring, spring.initial_state(0.0), lift, rate, duration / count)
        traces.append(forces[:: count // 1200, 1])
    errors = [float(np.sqrt(np.mean((one - traces[-1]) ** 2))) for one in traces[:-1]]
    assert errors[0] / errors[1] > 2.8 and errors[1] / errors[2] > 2.8


@pytest.mark.parametrize("engine_speed", [7000.0, 8000.0, 9000.0])
def test_peaks_at_its_own_step_are_those_of_one_ten_times_finer(engine_speed):
    """Beehive with hard clash, whose spike of 8 us has some four steps: below 10 kHz within 0.1 % (it was 0.35 %),
    below 20 kHz within 0.3 % (it was 1.3 %), and of every instant within 3 % (4.7 %).
    """
    system = build("gu2021-beehive", spring_models=("reduced-rod",)).members[0].system()
    cam_speed, peaks, own = engine_speed * np.pi / 60, [], None
    for finer in (1, 10):
        options = RunOptions(keep="ends", time_step=None if own is None else own / finer)
        run = integrate(system, cam_speed, Cycles(2), options)
        own = float(run.statistics["time_step_duration"])
        time, _, force = fine_series(run, "seat_force")
        even = np.interp(np.arange(0.0, 2 * np.pi / cam_speed, 1e-6), time - time[0], force)
        peaks.append(
            [force.max(), *(filtered_cycle(even, 1e-6, cut).max() for cut in (10e3, 20e3))]
        )
    for found, expected, allowed in zip(*peaks, (3e-2, 1e-3, 3e-3), strict=True):
        assert found == pytest.approx(expected, rel=allowed)
