"""Unit evidence: a spring at heights and loads asked for, its stress there and at solid, and what
is refused.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import valvetrain as vt
from valvetrain.cli.main import app
from valvetrain.parameters.loading import parse_case
from valvetrain.quantities.statics import solid_quantities
from valvetrain.runs.requests import Static
from valvetrain.runs.static_study import static_study

TEXT = """
[spring]
wire_diameter = "4 mm"
mean_diameter = "24 mm"
total_coils = 8
free_length = "52 mm"
material = "OTEVA 90 SC"
installed_height = "45 mm"
options.finite-element.elements_per_coil = 12
"""
#: EN 13906-1 by hand: 6 active turns, index 6, k = 6.5 / 5.25.
RATE = 79.6e9 * 4e-3**4 / (8 * 24e-3**3 * 6)
SHEAR = 6.5 / 5.25 * 8 * 24e-3 / (np.pi * 4e-3**3)


@pytest.fixture(scope="module")
def case():
    return parse_case(TEXT)


def at_rest(case, steps=4, **options):
    return static_study(Static(case=case, steps=steps, **options)).rest


@pytest.mark.parametrize("word", ["finite-element", "multi-mass", "massless", "modal-uniform"])
def test_heights_and_loads_are_solved_by_every_model(case, word):
    """Force and EN 13906-1 shear at 40 mm within 1.5 % of the closed form; the height of a load
    gives that load back.
    """
    (one,) = at_rest(case, models=(word,), heights=(40e-3, 52e-3), loads=(300.0, 0.0))
    at_height, free, loaded, unloaded = one.points
    assert at_height.force == pytest.approx(12e-3 * RATE, rel=0.015)
    assert at_height.nominal_shear_stress == pytest.approx(12e-3 * RATE * SHEAR, rel=0.015)
    assert at_height.stiffness == pytest.approx(RATE, rel=0.015)
    assert free.force == pytest.approx(0.0, abs=1e-4) and unloaded.compression == pytest.approx(
        0.0, abs=1e-9
    )
    assert loaded.force == pytest.approx(300.0, rel=1e-9) and loaded.height == pytest.approx(
        52e-3 - 300 / RATE, abs=0.2e-3
    )
    (again,) = at_rest(case, models=(word,), steps=17, heights=(loaded.height,))[0].points
    assert again.force == pytest.approx(300.0, rel=1e-9)


def test_stress_along_the_wire_is_that_of_the_section_loads(case):
    """Of the rod: somewhat above the nominal shear, as the ends take the load off the axis; von
    Mises near sqrt(3) of it.
    """
    (one,) = at_rest(case, heights=(40e-3,))
    (point,) = one.points
    assert 1.0 < point.shear_stress / point.nominal_shear_stress < 1.15
    assert point.equivalent_stress == pytest.approx(np.sqrt(3) * point.shear_stress, rel=0.03)
    assert one.stress.shear_at(np.array([12e-3])).max() == pytest.approx(
        point.shear_stress, rel=1e-3
    )


def test_solid_force_and_stress_are_those_of_en_13906_1(case):
    """F = R (L0 - Lc) and its shear, of a cylindrical spring of even pitch."""
    found = solid_quantities(case.springs[0].wire)
    assert found["solid_force"] == pytest.approx(RATE * 20e-3, rel=1e-3)
    assert found["solid_nominal_shear_stress"] == pytest.approx(RATE * 20e-3 * SHEAR, rel=1e-3)


def test_a_run_without_lift_says_the_stress_as_installed(case):
    found = vt.simulate(case).quantities
    assert found["installed_nominal_shear_stress"] == pytest.approx(
        found["preload"] * SHEAR, rel=1e-4
    )
    assert found["installed_shear_stress"] > found["installed_nominal_shear_stress"]
    assert found["solid_force"] == pytest.approx(RATE * 20e-3, rel=1e-3)


def test_the_command_writes_them(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "own.toml"
    path.write_text(TEXT, encoding="utf-8")
    runner = CliRunner()
    whole = json.loads(
        runner.invoke(
            app, ["static", str(path), "--steps", "4", "--load", "300 N", "--json"]
        ).stdout
    )
    (point,) = whole["springs_at_rest"][0]["points"]
    assert point["force"] == {"value": pytest.approx(300.0), "unit": "N"}
    assert set(point) >= {
        "height",
        "compression",
        "rate",
        "shear_stress",
        "retainer_torque",
        "retainer_moment",
        "retainer_side_force",
    }
    for words, mass in ((("--attached-mass", "50 g"), 0.05), (("--free-end",), 0.0)):
        told = runner.invoke(app, ["modes", str(path), "--count", "4", *words, "--json"]).stdout
        (rest,) = json.loads(told)["springs_at_rest"]
        assert rest["modes"]["attached_mass"] == {"value": mass, "unit": "kg"}


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["static", "--height", "30 mm"], "solid at 32.6"),
        (["static", "--height", "53 mm"], "free at 52 mm"),
        (["static", "--load", "90000 N"], "beyond it, give less"),
        (["static", "--load", "-5 N"], "zero or more"),
        (["modes", "--free-end", "--attached-mass", "5 g"], "no mass attached"),
        (["modes", "--attached-mass", "-5 g"], "zero or more"),
        (["modes", "--free-end", "--model", "multi-mass"], "finite-element"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_sentence(tmp_path, command, words):
    path = tmp_path / "own.toml"
    path.write_text(TEXT, encoding="utf-8")
    found = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
    assert found.exit_code != 0
    assert words in str(found.exception) + found.output


def test_a_retainer_that_may_turn_carries_no_torque(case):
    free = parse_case(TEXT + 'retainer_rotation = "free"\n')
    still = [at_rest(one)[0].installed for one in (case, free)]
    assert still[1].torque == 0.0 and abs(still[0].torque) > 0.01
    assert still[0].rotation is None and abs(still[1].rotation) > 1e-3
    assert still[1].force < still[0].force
    with pytest.raises(vt.InputError, match="retainer_rotation"):
        parse_case(TEXT + 'retainer_rotation = "loose"\n')
