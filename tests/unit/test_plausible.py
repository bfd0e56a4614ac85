"""Nonsense is refused, or named where it comes out, whatever equation it solves; an option lets it
pass.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.cam.closed_form import Zero
from valvetrain.cam.polydyne import Polydyne
from valvetrain.cam.spline import Spline, Stations
from valvetrain.errors import InputError
from valvetrain.quantities.limits import (
    lift_extremes,
    plausible_rest,
    plausible_run,
    refuse_implausible_motion,
)
from valvetrain.solution.static import Leaning, RestPoint, SpringAtRest, StaticCurve, StaticStress
from valvetrain.system.build import build

#: Laws that answer, and whose lift is below the base circle between what they were given.
NEGATIVE = {
    "stations": Stations(
        cam_angles=(0.0, 1.0, 2.0),
        lifts=(0.0, 1e-3, 0.0),
        velocities=(0.0, -0.5, 0.0),
        accelerations=(0.0, 0.0, 0.0),
    ),
    "polydyne": Polydyne(
        maximum_lift=10e-3, opening_start=2.2, closing_end=4.0, dynamic_deflection=0.5
    ),
    "uneven spline": Spline(
        cam_angles=(2.2, 2.6, 3.0, 3.05, 3.1, 3.6, 4.0),
        lifts=(0.0, 1e-4, 2e-4, 9e-3, 2e-4, 1e-4, 0.0),
        degree=5,
        smoothing=0.0,
    ),
}


@pytest.mark.parametrize("kind", NEGATIVE)
def test_a_lift_below_the_base_circle_is_refused(kind):
    law = NEGATIVE[kind]
    dense = np.asarray(law.lift(np.linspace(0.0, 2 * math.pi, 100_001)))
    assert dense.min() < -50e-6
    assert lift_extremes(law)[0] == pytest.approx(dense.min(), rel=0.02)
    with pytest.raises(
        InputError, match=r"the minimum lift is -.* mm, below -0.05 mm: .*implausible=True"
    ):
        refuse_implausible_motion(law, (100.0,))


def test_extremes_are_those_of_a_closed_form():
    """L sin(k x)**4 has the rate 4 L k (3 sqrt(3) / 16) and the second derivative 4 L k**2 at most,
    the one at tan(k x)**2 = 3.
    """
    angles = tuple(np.linspace(1.0, 3.0, 401))
    lifts = tuple(np.sin(np.pi * (np.array(angles) - 1) / 2) ** 4 * 1e-2)
    law = Spline(cam_angles=angles, lifts=(0.0, *lifts[1:-1], 0.0), degree=5, smoothing=0.0)
    least, largest, rate, bend = lift_extremes(law)
    assert least > -1e-6 and largest == pytest.approx(1e-2, rel=1e-4)
    assert rate == pytest.approx(4e-2 * math.pi / 2 * 3 * math.sqrt(3) / 16, rel=1e-3)
    assert bend == pytest.approx(4e-2 * (math.pi / 2) ** 2, rel=1e-3)


def test_a_law_without_lift_is_plausible():
    refuse_implausible_motion(Zero(), (1000.0,))


@pytest.mark.parametrize("name", [summary.name for summary in vt.list_cases()])
def test_every_case_of_the_library_is_far_from_every_limit(name):
    """Half the range is left at three times the speed: a limit that real valvetrains come near to
    is a wrong one.
    """
    problem = build(vt.load_case(name))
    if problem.moves:
        refuse_implausible_motion(
            problem.valve_lift, (1.5 * speed for speed in problem.engine_speeds)
        )


HARD_CARD = """
[spring]
preload = "200 N"
rate = "500 N/mm"
"""
CARD = """
[spring]
preload = "200 N"
rate = "1 N/mm"

[lift_law]
kind = "sine-power"
maximum_lift = "150 mm"
opening_start = "100 deg"
closing_end = "260 deg"
power = 4
"""
NARROW = {"lift_law.opening_start": "179.9 deg", "lift_law.closing_end": "180.1 deg"}


def test_a_motion_that_no_cam_gives_is_refused_before_the_work_and_passes_by_an_option():
    case = vt.load_case("job-t", NARROW)
    with pytest.raises(InputError, match="the lift speed is 4816 m/s, above 50 m/s"):
        vt.simulate(case, models=["massless"])
    (run,) = vt.simulate(case, models=["massless"], implausible=True).solutions
    assert run.status.completed
    words = [word for path, value in NARROW.items() for word in ("--set", f"{path}={value}")]
    assert "--implausible" in sentence(call("run", "job-t", *words))


def test_a_run_with_a_wire_faster_than_any_is_named_and_keeps_its_numbers():
    """A wire struck at v bears v sqrt(2 G rho): beyond 100 m/s no steel holds, and the models do
    not know it.
    """
    case = vt.load_case("job-t", NARROW)
    (run,) = vt.simulate(case, models=["wave-rod"], implausible=True).solutions
    fastest = float(np.max(np.abs(run.channel("axial_velocity"))))
    assert fastest > 1000
    told = plausible_run(run)
    assert (
        told.status.code == "diverged"
        and "100 m/s" in told.status.sentence()
        and "--implausible" in told.status.remedy
    )
    assert told.quantities == run.quantities


def test_a_static_curve_of_nonsense_is_named_and_keeps_its_numbers(tmp_path):
    """A card bears what it is told, and no spring 150 kN."""
    (tmp_path / "hard.toml").write_text(HARD_CARD)
    words = ("static", str(tmp_path / "hard.toml"), "--to", "300 mm", "--json")
    result = call(*words)
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith(
        "failed: hard by massless, static curve: diverged: a spring force is 1.062e+05 N, above 100000 N"
    )
    assert ", at 212.5 mm; " in line and "--implausible" in line
    passed = call(*words, "--implausible")
    assert passed.exit_code == 0 and passed.stderr == ""
    told, through = (
        json.loads(one.stdout)["springs_at_rest"][0]["static_curve"] for one in (result, passed)
    )
    assert told.pop("status")["code"] == "diverged" and through.pop("status")["code"] == "completed"
    assert told == through


def at_rest(**changed: object) -> SpringAtRest:
    """A spring of 40 N/mm on nine points, to 320 N."""
    steps, none = np.linspace(0, 8e-3, 9), np.zeros((9, 0))
    curve = StaticCurve(
        steps, 40e3 * steps, np.full(9, 40e3), none, none, np.zeros(0), none, np.zeros(0)
    )
    return replace(
        SpringAtRest("spring", "finite-element", curve=curve, stress_per_force=1e6), **changed
    )  # type: ignore[arg-type]


def test_each_number_of_a_spring_at_rest_is_held_against_its_range():
    usual = at_rest()
    curve = usual.curve
    assert curve is not None and plausible_rest(usual) is usual
    stress = StaticStress(
        curve.compression,
        np.array([1.0, 2.0]),
        np.outer(curve.compression, [1e9, 2e12]),
        np.zeros((9, 2)),
    )
    wrong = {
        "a shear stress is 12 GPa, above 10 GPa": at_rest(stress=stress),
        "a shear stress is 32 GPa, above 10 GPa": at_rest(stress_per_force=1e8, curve=replace(curve, force=320.0 * (curve.force > 300))),
        "the force on a guide is 2e+05 N, above 100000 N": at_rest(curve=replace(curve, leaning=Leaning(2e-3, 2e5))),
        "a spring force is -1.1e+05 N, below -100000 N": at_rest(points=(RestPoint(5e-3, -1.1e5, 40e3),)),
        "a spring force is 1.2e+05 N, above 100000 N": at_rest(curve=replace(curve, force=1.2e5 * (curve.force > 250))),
    }  # fmt: skip
    for words, one in wrong.items():
        found = plausible_rest(one)
        assert (
            found.curve is not None
            and one.curve is not None
            and found.curve.status.code == "diverged"
        ), words
        assert found.curve.status.message.startswith(words), found.curve.status.message
        assert found.curve.force is one.curve.force and found.points == one.points
    assert plausible_rest(at_rest(curve=None)).curve is None


NARROW_WORDS = [word for path, value in NARROW.items() for word in ("--set", f"{path}={value}")]


def test_a_refinement_of_nonsense_is_refused_before_the_work_and_passes_by_an_option():
    begun = []

    def stop(share, text):
        begun.append(text)
        raise KeyboardInterrupt

    case = vt.load_case("job-t", NARROW)
    with pytest.raises(InputError, match="the lift speed is 4816 m/s, above 50 m/s"):
        vt.refine(case, progress=stop)
    assert "--implausible" in sentence(call("refine", "job-t", *NARROW_WORDS)) and not begun
    with pytest.raises(KeyboardInterrupt):
        vt.refine(case, implausible=True, progress=stop, workers=1)
    assert begun
    rubs = vt.load_case("tdi-pushrod", {"train.valve.friction": "1e9 N"})
    with pytest.raises(InputError, match="the friction in a guide"):
        vt.refine(rubs, "3000 rpm")


def test_a_lift_that_no_cam_gives_has_no_static_curve(tmp_path):
    (tmp_path / "long.toml").write_text(CARD)
    refused = call("static", str(tmp_path / "long.toml"))
    assert refused.exit_code == 2
    assert "the largest lift is 150 mm, above 100 mm" in refused.stderr.splitlines()[-1]
    assert call("static", str(tmp_path / "long.toml"), "--implausible").exit_code == 0
