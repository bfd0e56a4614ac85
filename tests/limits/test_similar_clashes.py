"""Clashes follow the motion: a spring that is twice as fast at twice the speed has the same, and so has one whose
cam is turned, wherever its cycle begins.

Oracle: similarity. With a quarter of the density, twice the speed, twice the mass damping and half of all other
damping times, every time of the motion halves while forces and lengths stay; impulses halve. The factors are
powers of two, so all rounds alike. The step of a rod is given, since by default it is a whole part of a record of
forces whose spacing stays at 4 us, and it is damped by its mass, since its stiffness damping relaxes in 4 us.
"""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.quantities.clash import clash_events
from valvetrain.runs.api import simulate

ENGINE_SPEED = 7000 * np.pi / 30
COUNTED = ("peak_clash_force", "surge_clash_peak_force", "clash_energy", "largest_clash_energy")


def clashing(model: str, faster: float = 1.0, turn: float = 0.0, revolutions: int = 20):
    """Standard job C, ``faster`` by this factor in all its times, the cam turned by ``turn`` degrees."""
    changes = {
        "operation.cycles": revolutions,
        "spring.material": {
            "name": "steel",
            "youngs_modulus": "206 GPa",
            "shear_modulus": "79.6 GPa",
            "density": f"{7850 / faster**2!r} kg/m^3",
        },
        "spring.damping": {"mass_damping": f"{120.637 * faster!r} 1/s"}
        if model == "finite-element"
        else {"stiffness_damping": f"{8.48826e-6 / faster!r} s"},
        "spring.contact.damping_time": f"{1e-6 / faster!r} s",
        "spring.options.finite-element": {
            "curvature_correction": False,
            "time_step": f"{0.2 / faster!r} us",
        },
        "lift_law.opening_start": f"{127 + turn!r} deg",
        "lift_law.closing_end": f"{233 + turn!r} deg",
    }
    study = simulate(
        load_case("job-c", changes),
        engine_speeds=[faster * ENGINE_SPEED],
        models=[model],
        workers=1,
    )
    (run,) = study.solutions
    assert run.status.completed
    return run


def clashes(run):
    return [event for event in run.events if event.kind == "clash"]


def around(angles) -> np.ndarray:
    return np.sort(np.mod(np.asarray(angles), 2 * np.pi))


@pytest.fixture(scope="module")
def plain():
    return clashing("multi-mass")


def assert_same(one, other, share: float, faster: float = 1.0):
    """The same clashes to a ``share``, of a run that is ``faster`` by this factor."""
    assert one.quantities["clash_count"] == other.quantities["clash_count"] > 10
    for name in COUNTED:
        assert other.quantities[name] == pytest.approx(one.quantities[name], rel=share), name
    impulses = [run.quantities["largest_clash_impulse"] for run in (one, other)]
    assert faster * impulses[1] == pytest.approx(impulses[0], rel=share)


def assert_same_main_clash(one, other, turn: float, share: float, faster: float = 1.0):
    """The main clash, counted from the event; filters make its force differ near the ends of a record."""
    angles, impulses = (
        [run.quantities[f"main_clash_{name}"] for run in (one, other)]
        for name in ("cam_angle", "impulse")
    )
    assert angles[1] == pytest.approx((angles[0] + np.radians(turn)) % (2 * np.pi), abs=3e-3)
    assert faster * impulses[1] == pytest.approx(impulses[0], rel=share)


@pytest.mark.slow
def test_a_spring_twice_as_fast_at_twice_the_speed_has_the_same_clashes(plain):
    fast = clashing("multi-mass", 2.0)
    assert fast.quantities["raw_peak_spring_force"] == pytest.approx(
        plain.quantities["raw_peak_spring_force"], rel=1e-9
    )
    assert_same(plain, fast, 1e-6, 2.0)
    assert_same_main_clash(plain, fast, 0.0, 1e-6, 2.0)
    np.testing.assert_allclose(
        [event.cam_angle for event in clashes(fast)],
        [event.cam_angle for event in clashes(plain)],
        atol=1e-6,
    )


def test_so_has_a_rod_of_finite_elements():
    """The main clash to 1 %, since it is read from the record of forces."""
    slow, fast = (clashing("finite-element", faster, revolutions=2) for faster in (1.0, 2.0))
    assert_same(slow, fast, 1e-3, 2.0)
    assert_same_main_clash(slow, fast, 0.0, 0.01, 2.0)


@pytest.mark.parametrize("turn", [37.0, 120.0, 180.0])
def test_a_turned_cam_has_the_same_clashes(plain, turn):
    """At 180 degrees the event itself goes over the end of the cycle, so no main clash is told after it."""
    turned = clashing("multi-mass", turn=turn)
    assert_same(plain, turned, 1e-4)
    if turn < 180.0:
        assert_same_main_clash(plain, turned, turn, 1e-3)
    one, other = (around([event.cam_angle for event in clashes(run)]) for run in (plain, turned))
    moved = around(one + np.radians(turn))
    np.testing.assert_allclose(other, moved, atol=np.radians(0.05))


@pytest.mark.parametrize("faster", [0.5, 3.0])
def test_clashes_read_from_samples_follow_the_frequency_of_the_spring(faster):
    from dataclasses import replace

    from synthetic_train import ANGLE, CAM_SPEED, train

    force = np.zeros((len(ANGLE), 2))
    for first in (100, 400, 403, 700, 712, 900):  # contacts that ring, merge and stay apart
        force[first : first + 2, 0] = 50.0
        force[first + 4 : first + 9, 1] = 80.0
    gap = np.where(force > 0, -1e-6, 1e-4)
    run = train(pairs={"spring": (np.array([2.0, 2.5]), force, gap)})
    quick = replace(run, provenance=replace(run.provenance, engine_speed=faster * 2 * CAM_SPEED))
    quick = replace(quick, channels=run.channels.assign_coords(time=("sample", run.time / faster)))
    plain, found = (
        clash_events(one, surge_frequencies=(frequency,))
        for one, frequency in ((run, 500.0), (quick, faster * 500.0))
    )
    assert len(plain) == len(found) > 1
    for one, other in zip(plain, found, strict=True):
        assert other.size == one.size and other.cam_angle == one.cam_angle
        assert other.details["impulse"] == pytest.approx(one.details["impulse"] / faster)
