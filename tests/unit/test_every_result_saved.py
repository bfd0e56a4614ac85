"""Every result is read as it was saved: properties (arrays and numbers to the bit), and what no file
holds is refused.
"""

import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import valvetrain as vt
from film_parts import turning_motion
from valvetrain.errors import InputError
from valvetrain.rig.alignment import LiftAlignment
from valvetrain.solution.channels import empty_channels
from valvetrain.solution.status import Status
from valvetrain.solution.tree import Trunk

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
import sample_rig
import sample_scan

JOB = vt.Case("job-t")
ANGLE = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
LEVEL = vt.measured.MeasuredCycles(
    "valve_lift", "m", ANGLE, np.full((2, 90), 1e-3), cam_speed=150.0
)


def content(item):
    """A result as plain text, and its arrays with type, shape and bytes."""
    trunk = Trunk()
    tree = trunk.of(item)
    return repr(tree), [(one.dtype, one.shape, one.tobytes()) for one in trunk.arrays]


def read_again(item, folder):
    again = vt.load(vt.save(item, folder / "item.nc"))
    assert type(again) is type(item) and content(again) == content(item)
    assert [path.name for path in folder.iterdir()] == ["item.nc"]
    return again


def table(**options):
    return JOB.study(
        {"spring.wire_diameter": vt.Normal("4 mm", "0.01 mm")}, ["peak_spring_force"], count=3,
        engine_speeds="4000 rpm", models="massless", workers=1, **options,
    )  # fmt: skip


def optimum():
    return vt.Case("job-c").optimise(
        {"spring.precompression": vt.Uniform("5 mm", "9 mm")}, {"solid_force": "minimise"},
        search={"trials": 3, "per_round": 2}, workers=1,
    )  # fmt: skip


def identified():
    return vt.identify(
        {"rate": vt.explore.Prior("uniform", 20e3, 60e3)}, [vt.explore.Datum("force", 280.0, 2.0)],
        lambda points: [{"force": 7e-3 * rate} for (rate,) in points],
    )  # fmt: skip


def fitted():
    low, high = (
        vt.spring_card.SpringLoad("46 mm", "350 N"),
        vt.spring_card.SpringLoad("34 mm", "830 N"),
    )
    return vt.spring_card.spring_from_card(
        vt.spring_card.CatalogueCard(
            wire_diameter="4.4 mm", outer_diameter="32 mm", installed_load=low, open_load=high
        )
    )


def smoothed():
    angles = np.radians(np.arange(90.0, 271.0))
    lifts = 9e-3 * np.clip(1 - ((angles - np.pi) / np.radians(60)) ** 2, 0, None) ** 3
    return vt.measured.smooth_lift(
        angles, lifts + np.random.default_rng(1).normal(0, 3e-6, len(angles))
    )


def recorded():
    def lift(angle):
        return 9e-3 * np.clip(1 - ((np.asarray(angle) - np.pi) / 1.1) ** 2, 0, None) ** 3

    records = sample_rig.record(
        sample_rig.Rig(cycles=4, sampling_rate=20e3), lift, lambda angle: 215 + 26e3 * lift(angle)
    )
    with TemporaryDirectory() as folder:
        sample_rig.WRITERS["rig.csv"](Path(folder) / "rig.csv", records)
        answers = vt.rig.RigAnswers(angle_of="crank", encoder="Crank angle")
        return vt.rig.rig_cycles(Path(folder) / "rig.csv", answers)


def scanned():
    points, _ = sample_scan.cloud(
        sample_scan.springs()["cylindrical"], 4000, sample_scan.Scanner(seed=22)
    )
    with TemporaryDirectory() as folder:
        (Path(folder) / "scan.ply").write_bytes(sample_scan.ply(points))
        return vt.scan.spring_from_scan(Path(folder) / "scan.ply")


RESULTS = {
    "static curve": lambda: JOB.static(steps=8),
    "spring at rest": lambda: vt.simulate(JOB.parameters, "2000 rpm", models="massless").rest,
    "train modes": lambda: vt.runs.train_modes("tdi-pushrod", ["massless"], spring_sets=["stock"]),
    "table": table, "optimum": optimum, "identified": identified, "fit to a card": fitted, "smoothed lift": smoothed,
    "model against test": lambda: vt.compare_test.compare_with_test("job-t", LEVEL, models=["massless"]),
    "measured cycles": lambda: LEVEL, "film": turning_motion, "recording": recorded, "scan": scanned,
    "alignment": lambda: LiftAlignment(*np.arange(len(LiftAlignment.__dataclass_fields__)) * 0.1),
    "several": lambda: {"a": [1, 2.5, (None, np.nan)], ("b", 3): np.array([[1 + 2j], [np.inf]])},
}  # fmt: skip


#: What takes seconds to be made.
LONG = ("film", "recording", "scan")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.long] if name in LONG else []) for name in RESULTS],
)
def test_what_is_loaded_is_what_was_saved(name, tmp_path):
    read_again(RESULTS[name](), tmp_path)


def test_a_study_is_whole_with_failed_runs_critical_speeds_and_static_curves(tmp_path):
    case = vt.Case("tdi-pushrod")
    sweep = case.sweep(
        "7000:7400:200 rpm", "massless", spring_sets="stock", resolution="100 rpm", workers=1
    )
    again = read_again(sweep, tmp_path)
    assert len(again.critical_speeds) == 3 and repr(again) == repr(sweep)
    failed = vt.Solution(
        empty_channels(), status=Status("diverged", "it grew", 0.1, "spring", "run slower")
    )
    again = read_again(replace(sweep, solutions=(failed, *sweep.solutions)), tmp_path)
    assert again.solutions[0].status == failed.status and again.failures
    both = JOB.compare("2000 rpm", ["massless"])
    curve = read_again(both, tmp_path).at_rest("massless").curve
    assert curve.force_at("7.5 mm") == both.at_rest("massless").curve.force_at("7.5 mm") > 0


def test_methods_and_function_write_the_same(tmp_path):
    run = JOB.run("2000 rpm", models="massless")
    assert vt.load(run.save(tmp_path / "run.nc")).identical(run)
    curve = JOB.static(models="massless")
    assert content(vt.load(curve.save(tmp_path / "curve.nc"))) == content(curve)
    assert vt.load(curve.save(tmp_path / "curve.nc")).force_at("7.5 mm") == curve.force_at("7.5 mm")
    cases = vt.load(JOB.save(tmp_path / "case.toml"))
    assert cases == JOB


def test_what_no_file_holds_is_refused_and_nothing_is_written(tmp_path):
    with pytest.raises(
        InputError, match=r"a function \(\[0\]\) cannot be stored in a file; save its"
    ):
        vt.save((len, lambda: 1)[1:], tmp_path / "a.nc")
    with pytest.raises(InputError, match=r"a StaticCurve is saved to a file that ends in \.nc"):
        JOB.static(models="massless").save(tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


def test_a_study_of_functions_is_saved_without_the_function(tmp_path):
    def double(size):
        return 2 * size

    found = vt.Experiment(
        None, vt.Space({"size": vt.Uniform(1.0, 2.0)}), vt.Outputs(["twice"], function=double)
    ).table([[1.5]], workers=1)
    again = vt.load(found.save(tmp_path / "table.nc"))
    assert np.array_equal(again.values, found.values) and again.to_xarray().identical(
        found.to_xarray()
    )
    with pytest.raises(InputError, match="the function 'double' is not in the file"):
        again.plan.experiment.outputs.function(size=1.0)


def test_every_result_with_a_page_writes_it(tmp_path):
    for name, made in {
        "table": table(), "optimum": optimum(),
        "identified": identified(), "test": vt.compare_test.compare_with_test("job-t", LEVEL, models=["massless"]),
    }.items():  # fmt: skip
        files = made.report(tmp_path / name)
        assert files.page == tmp_path / name / "report.html" and files.page.is_file() and files.data
    assert vt.write_study(table(), tmp_path / "again").page.is_file()
    with pytest.raises(InputError, match="a int has no page"):
        vt.write_study(3, tmp_path / "none")
