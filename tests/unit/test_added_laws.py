"""A law of an installed package: one file and one entry point, and a case file may name it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from valvetrain import registry


def python(script: str, *folders: Path, text: str = "", arguments: Sequence[str] = ()) -> str:
    """What ``script`` prints in a process of its own that also finds the packages in ``folders``,
    with ``text`` on its standard input.
    """
    paths = os.pathsep.join(map(str, (*folders, Path(registry.__file__).parents[1])))
    command, own = [sys.executable, "-c", script, *arguments], {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(command, capture_output=True, text=True, input=text, env=own)
    assert done.returncode == 0, done.stderr
    return done.stdout


EXAMPLE = Path(__file__).parents[1] / "example_package"
SPRING_CASE = """
[spring]
name = "own"
wire_diameter = "4 mm"
mean_diameter = "24 mm"
pitch = "7.5 mm"
total_coils = 6
ends = "open"
material = "OTEVA 90 SC"
precompression = "7 mm"
seats = "clamps"
[spring.options.progressive]
rise = 0.5
reach = "8 mm"
[lift_law]
kind = "versine"
maximum_lift = "8 mm"
opening_start = "120 deg"
closing_end = "240 deg"
[operation]
engine_speeds = "3000 rpm"
"""
END_TO_END = """
import pickle, sys
import numpy as np
from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.runs.api import compare
from valvetrain.runs.api import simulate
from valvetrain.runs.api import sweep
from valvetrain.solution.quantity import unit_of
from valvetrain.system.build import build

assert {"progressive"} < set(registry.names("springs")) and {"versine"} < set(registry.names("lifts"))
case = parse_case(sys.stdin.read(), "own-case")
study = simulate(case, models=["progressive", "massless"], workers=1)
run = study.solution("progressive")
assert run.status.completed, run.status.sentence()
(member, _) = build(case, spring_models=["progressive", "massless"]).members
(spring,) = member.system().springs
assert isinstance(spring, SpringModel)
plain = EquivalentSpring.from_installed(case.springs[0])
top = plain.preload + plain.rate * 8e-3 * 1.5
assert abs(run.quantities["raw_peak_spring_force"] - top) < 1e-6 * top, (run.quantities["raw_peak_spring_force"], top)
assert abs(run.channel("valve_lift").max() - 8e-3) < 1e-9
assert study.solution("massless").quantities["peak_spring_force"] < 0.9 * top
assert run.provenance.options["rise"] == 0.5 and run.provenance.options["reach"] == 8e-3
compared = compare(case, models=["progressive", "massless"], workers=1)
still = compared.at_rest("progressive").curve
assert abs(still.force_at(15e-3) - top) < 1e-3 * top
assert len(sweep(case, [200.0, 300.0], models=["progressive"], workers=2).solutions) == 2
assert pickle.loads(pickle.dumps(study)).solution("progressive").identical(run)
# a train by all three: its lift law, a contact of it, its springs
changes = {
    "lift_law": {"kind": "versine", "lift_of": "tappet", "maximum_lift": "5 mm", "opening_start": "90 deg", "closing_end": "270 deg"},
    "train.contacts.seat": {"law": "hardening", "contact_stiffness": "20 kN/mm", "damping": "300 N s/m", "hardening_depth": "30 um"},
    "train.spring_model": "progressive", "train.spring_set": "stock",
    "train.springs.stock.0.options": {"progressive": {"rise": 0.3}},
}
train = load_case("tdi-pushrod", changes)
found = simulate(train, engine_speeds=[2000 * np.pi / 30], models=["progressive"], workers=1)
(run,) = found.solutions
assert run.status.completed, run.status.sentence()
card = train.train.springs["stock"][0].card
lift = run.channel("valve_lift")
expected = card.preload + card.rate * lift * (1 + 0.3 * (lift / 0.01) ** 2)
assert np.allclose(run.channel("retainer_force"), expected, rtol=1e-9), np.max(abs(run.channel("retainer_force") - expected))
seat = run.channel("seat_contact_force")
closed = seat[run.channel("valve_lift") < 1e-6]
assert 100 < np.median(closed) < card.preload + 10
deep = -run.channel("seat_gap")[np.argmax(seat)]
print("seat", float(np.median(closed)), "peak", float(seat.max()), "depth", float(deep))
# a train kind of its own: a torsion spring on the rocker, whose moment follows from the rocker's angle
own = simulate(load_case("tdi-pushrod", {"train.kind": "held-rocker"}), engine_speeds=[200.0], models=["massless"], workers=1)
plain = simulate(load_case("tdi-pushrod"), engine_speeds=[200.0], models=["massless"], workers=1)
(one, *_), (other, *_) = own.solutions, plain.solutions
assert one.status.completed, one.status.sentence()
angle = one.channel("lever_angle")
assert np.allclose(one.channel("rocker_spring_moment"), 20.0 * angle), one.channel("rocker_spring_moment")
assert abs(one.quantities["peak_rocker_spring_moment"] - 20.0 * angle.max()) < 1e-2 and unit_of("peak_rocker_spring_moment") == "N m"
assert one.channels["rocker_spring_moment"].attrs["units"] == "N m"
speeds = [next(iter(study.still.values()))["rigid_contact_loss_engine_speed"] for study in (own, plain)]
assert 1.0 < speeds[0] / speeds[1] < 1.5, speeds  # the spring helps a little
# over processes too
both = sweep(train, [200.0, 260.0], models=["progressive"], spring_sets=["stock"], workers=2)
assert all(run.status.completed for run in both.solutions), both.failures
for key in ("rize", "reech"):
    try:
        load_case("tdi-pushrod", {"train.springs.stock.0.options": {"progressive": {key: 0.3}}})
    except InputError as error:
        assert "progressive" in str(error) and key in str(error), error
    else:
        raise AssertionError(key)
"""


def test_a_package_adds_a_spring_model_a_contact_law_and_a_lift_law_that_run_in_every_study():
    print(python(END_TO_END, EXAMPLE, text=SPRING_CASE))


QUANTITY = """
import json, os, re, sys
from pathlib import Path
from typer.testing import CliRunner
from valvetrain.cli.main import app
from valvetrain.parameters.loading import read_case
from valvetrain.workbench.pages.orders import outputs_for
from valvetrain.workbench.workspace import Workspace

def command(*arguments):
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    return done.stdout

os.chdir(sys.argv[1])
Path("own-case.toml").write_text(sys.stdin.read())
few = ("own-case.toml", "--model", "massless")
terminal = command("run", *few)
swept = command("sweep", *few, "--rpm", "2000:4000:1000 rpm")
many = command("run", *few, "--rpm", "2000:4000:400 rpm")
assert all("mean spring force" in one.lower() for one in (terminal, swept, many)), (terminal, swept, many)
answer = json.loads(command("run", *few, "--json"))
found = answer["runs"][0]["quantities"]["mean_spring_force"]
assert found["unit"] == "N" and found["value"] > 0, found
assert re.search(rf"mean spring force +{found['value']:.3g}", terminal), terminal
workspace = Workspace(Path.cwd())
run = next(run for run in workspace.runs() if run.command == "run")
assert run.answer["runs"][0]["quantities"]["mean_spring_force"]["unit"] == "N", run.answer
assert "mean_spring_force" in {one["value"] for one in outputs_for(read_case(Path("own-case.toml")))}
"""


def test_a_package_adds_a_quantity_to_terminal_json_page_and_workbench(tmp_path):
    python(QUANTITY, EXAMPLE, text=SPRING_CASE, arguments=[str(tmp_path)])


def test_an_added_spring_model_keeps_the_contract():
    code = (
        "import sys; sys.path[:0] = [sys.argv[1]]\n"
        "import numpy as np\n"
        "import spring_parts\n"
        "from own_parts.progressive import ProgressiveSpring\n"
        "import test_spring_models as battery\n"
        "model = ProgressiveSpring(250.0, 30e3, 1e8, 0.04)\n"
        "battery.MODELS.clear(); battery.MODELS['progressive'] = model\n"
        "spring_parts.MODELS['progressive'] = model\n"
        "battery.build_models = lambda: {'progressive': ProgressiveSpring(250.0, 30e3, 1e8, 0.04)}\n"
        "for check in ('test_is_a_spring_model', 'test_kernel_gives_the_forces_of_the_class_and_zero_step_keeps_the_state',\n"
        "              'test_tangent_equals_finite_difference', 'test_force_is_the_energy_gradient',\n"
        "              'test_static_state_stays_and_its_force_is_the_slope_of_its_energy', 'test_slow_motion_follows_the_static_curve',\n"
        "              'test_is_deterministic'):\n"
        "    getattr(battery, check)('progressive')\n"
        "battery.test_energy_balance('progressive', 4e-3, 8e-3)\n"
        "print('kept')"
    )
    tests = Path(__file__).parents[1]
    assert python(code, EXAMPLE, tests, tests / "contracts", arguments=[str(tests)]).split() == [
        "kept"
    ]
