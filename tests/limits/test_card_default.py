"""A spring known by its card, run by the default model: the exact damped wave equation, and more
modes.
"""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

import valvetrain as vt

RATE, PRELOAD, MASS = 45e3, 420.0, 0.09
DAMPING = {"ratio": 0.02, "ratio_frequency": "350 Hz", "stiffness_share": 0.5}
EVENT = np.radians(118.0)


def lift(cam_angle: float) -> float:
    """A lift (m) with four continuous derivatives over 118 degrees about 180."""
    return 5e-3 * max(0.0, 1 - ((cam_angle - np.pi) / (EVENT / 2)) ** 2) ** 5


def exact_seat_force(
    engine_speed: float, mass_damping: float, stiffness_damping: float, motion=lift
) -> np.ndarray:
    """Force on the fixed end (N) over one cycle of the cam, by harmonics of the lift.

    Closed form: ``U'' + kappa^2 U = 0``, ``kappa^2 = (w^2 - i w a) / (c^2 (1 + i w b))`` with the
    wave's speed ``c = sqrt(k / m)`` in lengths of the spring per second; the force is
    ``k (1 + i w b) U'(0)``.
    """
    count = 2**13
    angle = np.arange(count) * 2 * np.pi / count
    harmonics = np.fft.rfft([motion(one) for one in angle])
    circular = np.arange(len(harmonics)) * engine_speed / 2
    stiff = 1 + 1j * circular * stiffness_damping
    kappa = np.sqrt((circular**2 - 1j * circular * mass_damping) / (RATE / MASS * stiff))
    transfer = np.where(
        circular > 0, RATE * stiff * kappa / np.sin(np.where(kappa == 0, 1, kappa)), RATE
    )
    return PRELOAD + np.fft.irfft(harmonics * transfer, count)


@pytest.mark.parametrize("rpm", [4000, 5600, 6600])
def test_modes_of_a_card_meet_the_wave_equation(rpm):
    """Closed form, within 0.3 % of the preload, by the defaults: model, modes, cycles until it repeats."""
    spring = vt.Spring(preload=PRELOAD, rate=RATE, mass=MASS, damping=DAMPING)
    case = vt.Case(spring=spring, lift_law=lift)
    damping = spring.parameters.damping
    exact = exact_seat_force(rpm * np.pi / 30, damping.mass_damping, damping.stiffness_damping)
    run = case.run(f"{rpm} rpm")
    assert run.model == "modal-uniform" and run.statistics["steady_cycles_count"] > 2
    force = run.quantities["minimum_spring_force"], run.quantities["peak_spring_force"]
    assert force == pytest.approx((exact.min(), exact.max()), abs=3e-3 * PRELOAD)


def default_and_finest(kind: str, rpm: int):
    """The card of a template by its default and by 80 modes, which take the same time step."""
    path = resources.files("valvetrain").joinpath(f"templates/{kind}.toml")
    case = vt.Case(path.read_text(encoding="utf-8"))
    sets = case.parameters.train.springs
    card = next(name for name, springs in sets.items() if all(one.wire is None for one in springs))
    finest = case.set({f"train.springs.{card}.0.options.modal-uniform.modes": 80})
    preload = sum(one.card.preload for one in sets[card])
    return preload, *(one.run(f"{rpm} rpm", spring_sets=card) for one in (case, finest))


@pytest.mark.parametrize("kind", ["pushrod", "finger", "direct", "rocker"])
@pytest.mark.parametrize("rpm", [3000, 6000])
def test_the_default_of_a_card_is_converged(kind, rpm):
    """Order of convergence: every headline number within 1 %, or within 0.5 % of the preload where
    it is near zero; where the motion does not repeat, within the scatter of both from cycle to cycle.
    """
    preload, default, finest = default_and_finest(kind, rpm)
    assert default.model == "modal-uniform"
    assert default.status.completed and finest.status.completed
    forces = (
        "peak_spring_force",
        "minimum_spring_force",
        "surge_amplitude_force",
        "peak_cam_contact_force",
    )
    rooms = dict.fromkeys(forces, 5e-3 * preload) | {
        "peak_valve_lift": 0.0,
        "seating_velocity": 0.0,
    }
    if default.quantities["motion_period_count"] > 0:
        rooms["minimum_cam_contact_force"] = 5e-3 * preload
    else:  # its scatter is not told for the least force on the cam
        rooms = {
            name: room
            + sum(one.quantities.get(f"cycle_scatter_{name}", 0.0) for one in (default, finest))
            for name, room in rooms.items()
        }
    for name, room in rooms.items():
        assert default.quantities[name] == pytest.approx(
            finest.quantities[name], rel=0.01, abs=room
        ), name


def test_a_card_with_much_damping_leaves_out_what_no_longer_oscillates():
    """Limit: 20 % of critical at the first mode leaves four modes below critical, none is refused."""
    spring = vt.Spring(
        preload=PRELOAD, rate=RATE, mass=MASS, damping={"ratio": 0.2, "ratio_frequency": "353.55 Hz", "stiffness_share": 1.0}
    )  # fmt: skip
    assert 3 <= len(spring.frequencies("modal-uniform", 20)) <= 5


@pytest.mark.parametrize("model", ["multi-mass", "wave-rod", "finite-element"])
def test_prescribed_motion_runs_until_it_repeats(model):
    """Limit: the numbers of twenty revolutions, where two miss the least force by half a per cent and more."""
    spring = vt.Spring(
        wire_diameter="4 mm",
        mean_diameter="26 mm",
        pitch="8 mm",
        total_coils=7,
        material="EN 10270-1 SH",
        installed_height="39 mm",
        damping={"ratio": 0.01, "ratio_frequency": "400 Hz"},
        options={"finite-element": {"elements_per_coil": 8}},
    )
    case = vt.Case(spring=spring, lift_law=lift)
    settled = case.run("5900 rpm", models=model).quantities
    long, short = (
        case.set({"operation.cycles": count}).run("5900 rpm", models=model).quantities
        for count in (20, 2)
    )
    surge, least = "surge_amplitude_force", "minimum_spring_force"
    assert settled[surge] == pytest.approx(long[surge], rel=5e-3)
    assert settled["peak_spring_force"] == pytest.approx(long["peak_spring_force"], rel=1e-3)
    assert settled[least] == pytest.approx(long[least], rel=2e-3)
    assert abs(short[least] - long[least]) > 5e-3 * long[least]
