"""Order evidence: what is said of a spring at rest does not move with the output steps, the
command, the interface or the increments.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import valvetrain as vt
from valvetrain.cli.main import app
from valvetrain.cosserat.rates import axial_rate
from valvetrain.cosserat.static import NewtonOptions, RodStatics, compress
from valvetrain.runs.requests import Static
from valvetrain.runs.static_study import static_study
from valvetrain.springs.spec import spring_model

NAMED = ("preload", "installed_rate", "stiffness_change_compression", "coil_1_2_installed_gap")
ELEMENTS = "spring.options.finite-element.elements_per_coil"
WORDS = (
    "finite-element",
    "massless",
    "multi-mass",
    "modal-varied",
    "modal-uniform",
    "wave-rod",
    "wave-rod-clash",
)


@pytest.fixture(scope="module")
def beehive():
    """The published beehive on a coarse mesh: coils close on the way to the installed state."""
    return vt.load_case("gu2021-beehive-blind", {ELEMENTS: 12})


def named(study):
    return {name: study.quantities[name] for name in NAMED if name in study.quantities}


@pytest.mark.parametrize("word", WORDS)
def test_named_numbers_do_not_move_with_the_output_steps(beehive, word):
    """Bit by bit the same from 3 to 50 steps; a preload read between even steps moved by 2.5 %, a
    rate by 4 %.
    """
    few, *more = (
        named(static_study(Static(case=beehive, models=(word,), steps=steps))) for steps in (3, 50)
    )
    assert {"preload", "installed_rate"} <= set(few)
    assert all(found == few for found in more)


def test_the_curve_says_the_same_between_any_steps(beehive):
    curves = [vt.static_curve(beehive, steps=steps) for steps in (3, 5, 50)]
    for wanted in ("3 mm", "7 mm", "9.123 mm"):
        force, rate = ([curve.force_at(wanted), curve.stiffness_at(wanted)] for curve in curves[:2])
        assert force == rate == [curves[2].force_at(wanted), curves[2].stiffness_at(wanted)]
    # and what stands at a step is what the path has there
    assert curves[0].force_at(curves[0].compression[1]) == pytest.approx(
        curves[0].force[1], rel=2e-4
    )


def test_static_run_modes_and_python_say_one_preload_and_one_rate(beehive):
    """Of the terminal's commands and of Python's functions: the same bits."""
    arguments = ["gu2021-beehive-blind", "--set", f"{ELEMENTS}=12", "--json"]
    said = []
    for command in (["static", *arguments, "--steps", "4"], ["modes", *arguments, "--count", "4"]):
        found = json.loads(CliRunner().invoke(app, command).stdout)["quantities"]
        said.append((found["preload"]["value"], found["installed_rate"]["value"]))
    run = vt.simulate(beehive, "4200 rpm", models=["massless"]).quantities
    said.append((run["preload"], run["installed_rate"]))
    curve = vt.static_curve(beehive, steps=5)
    said.append((curve.force_at("7 mm"), curve.stiffness_at("7 mm")))
    assert len(set(said)) == 1


def test_the_path_does_not_depend_on_its_increments(beehive):
    """One equilibrium at 9.5 mm, in one go and by hundredths of a millimetre: the coils touch
    without friction.
    """
    rod = spring_model("finite-element").build(beehive.springs[0])
    whole, fine = (
        compress(RodStatics(rod.mesh, 2e10, NewtonOptions(largest_increment=most)), [9.5e-3])[-1]
        for most in (9.5e-3, 0.2e-3)
    )
    assert whole.retainer_force == pytest.approx(fine.retainer_force, rel=1e-7)
    np.testing.assert_allclose(whole.state.position, fine.state.position, atol=1e-9)


@pytest.mark.parametrize("compression", [2e-3, 7e-3, 11e-3])
def test_the_rate_is_the_derivative_of_the_force(beehive, compression):
    """Against central differences of the solved force over 0.2 um, coils and seats in contact."""
    rod = spring_model("finite-element").build(beehive.springs[0])
    here = compress(rod.statics, [compression])[-1].state
    low, high = (
        compress(rod.statics, [compression + step], here)[-1].retainer_force
        for step in (-1e-7, 1e-7)
    )
    assert axial_rate(rod.statics, here) == pytest.approx((high - low) / 2e-7, rel=1e-4)


def test_the_installed_rate_does_not_move_with_the_mesh(beehive):
    """Coils close node by node, so the slope has steps; within 1 % from 12 to 48 elements per coil,
    the preload within 0.2 %.
    """
    springs = [
        beehive.springs[0].with_options("finite-element", elements_per_coil=count)
        for count in (12, 24, 48)
    ]
    rods = [spring_model("finite-element").build(spring) for spring in springs]
    rates, preloads = (
        [axial_rate(rod.statics, rod.installed.state) for rod in rods],
        [rod.installed.retainer_force for rod in rods],
    )
    assert np.ptp(rates) < 0.01 * rates[-1] and np.ptp(preloads) < 0.002 * preloads[-1]
