"""Experiments: a space and outputs of a case or a function, and the verbs on them, beside single
runs and closed forms.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from study_parts import identification_plan
from valvetrain.explore.engine import Interrupted
from valvetrain.explore.files import FileText
from valvetrain.explore.study import StudyModel, read_plan

PRECOMPRESSION = vt.Space({"spring.precompression": vt.explore.Prior("uniform", 6e-3, 8e-3)})
UNIT_NORMAL = vt.explore.Prior("normal", centre=0.0, spread=1.0)


def paraboloid(x, y):
    return {"height": (x - 0.3) ** 2 + (y + 0.2) ** 2, "sum": x + y}


def line(intercept, slope):
    return {f"at {x}": intercept + slope * x for x in (0, 1, 2)}


def function_of(function, names, space):
    return vt.Experiment(None, vt.Space(space), vt.Outputs(names, function=function))


def test_the_dataset_of_an_experiment_equals_single_runs_bit_for_bit():
    outputs = vt.Outputs(
        ["peak_spring_force", "peak_valve_lift"],
        engine_speeds="4000, 5000 rpm",
        spring_models=["massless", "multi-mass"],
    )
    found = vt.Experiment("job-c", PRECOMPRESSION, outputs).run([[6e-3], [8e-3]], workers=1)
    assert found.peak_spring_force.dims == ("point", "speed", "model")
    assert found.peak_spring_force.attrs["units"] == "N"
    assert set(found.status.values.ravel()) == {"completed"}
    for point, value in enumerate(("6 mm", "8 mm")):
        case = vt.load_case("job-c", {"spring.precompression": value})
        for speed in (4000, 5000):
            runs = vt.simulate(case, f"{speed} rpm", models=["massless", "multi-mass"])
            for run in runs.solutions:
                one = found.isel(point=point).sel(speed=speed, model=run.label)
                assert float(one.peak_spring_force) == run.quantities["peak_spring_force"]
                assert float(one.peak_valve_lift) == run.quantities["peak_valve_lift"]


def test_a_function_is_evaluated_at_the_points_and_refusals_keep_their_sentence():
    def root(x):
        return math.sqrt(x)

    experiment = function_of(root, ["root"], {"x": vt.explore.Prior("uniform", -1.0, 4.0)})
    table = experiment.table([[4.0], [-1.0]], workers=1)
    found = table.to_xarray()
    assert found.root.dims == ("point",) and found.x.values.tolist() == [4.0, -1.0]
    assert found.root.values[0] == 2.0 and np.isnan(found.root.values[1])
    assert found.status.values.tolist() == ["completed", "refused"]
    assert table.failures and "domain" in table.failures[0]


def test_the_calibration_of_a_linear_model_is_its_closed_form_posterior():
    measured, error = np.array([1.0, 2.2, 2.9]), 0.2
    experiment = function_of(
        line,
        ["at 0", "at 1", "at 2"],
        {"intercept": UNIT_NORMAL, "slope": UNIT_NORMAL},
    )
    data = [vt.explore.Datum(f"at {x}", value, error) for x, value in enumerate(measured.tolist())]
    found = experiment.calibrate(data, workers=1)
    design = np.array([[1.0, x] for x in range(3)])
    covariance = np.linalg.inv(np.eye(2) + design.T @ design / error**2)
    mean = covariance @ design.T @ measured / error**2
    assert list(found.best.values()) == pytest.approx(mean, rel=1e-5)
    quantities = found.branches[0].quantities.values()
    assert [one.deviation for one in quantities] == pytest.approx(
        np.sqrt(np.diag(covariance)), rel=1e-5
    )
    between = covariance[0, 1] / math.sqrt(covariance[0, 0] * covariance[1, 1])
    assert found.branches[0].correlation[0, 1] == pytest.approx(between, abs=1e-5)


def test_a_calibration_of_a_case_finds_the_value_that_made_the_measurements():
    outputs = vt.Outputs(
        ["peak_spring_force"], engine_speeds="4000 rpm", spring_models=["multi-mass"]
    )
    experiment = vt.Experiment("job-t", PRECOMPRESSION, outputs)
    truth = float(experiment.run([[6.6e-3]], workers=1).peak_spring_force.squeeze())
    search = vt.explore.Search(draws=25)
    measured = [vt.explore.Datum("peak_spring_force", truth, 0.5)]
    found = experiment.calibrate(measured, search, workers=1)
    assert found.best["spring.precompression"] == pytest.approx(6.6e-3, rel=1e-4)
    draws = found.to_xarray()
    assert draws["spring.precompression"].dims == ("draw",)
    with pytest.raises(vt.InputError, match="did you mean peak_spring_force"):
        experiment.calibrate([vt.explore.Datum("peak_spring_forces", truth, 0.5)], workers=1)


def test_an_interrupted_sample_continues_without_computing_a_point_again(tmp_path):
    calls: list[float] = []
    stop_at = 7

    def square(x):
        calls.append(x)
        if len(calls) == stop_at:
            raise KeyboardInterrupt
        return x * x

    experiment = function_of(square, ["square"], {"x": vt.explore.Prior("uniform", 0.0, 1.0)})
    options = {"count": 20, "seed": 3}
    with pytest.raises(Interrupted) as stopped:
        experiment.sample(options=options, workers=1, output=tmp_path)
    codes = [one.code for one in stopped.value.result.statuses]
    done = codes.count("completed")
    assert done + codes.count("interrupted") == 20 and done < stop_at
    stop_at, calls = 0, []
    table = experiment.sample(options=options, workers=1, output=tmp_path)
    assert table.completed.all() and table.computed == len(calls) == 20 - done
    assert np.array_equal(table.values, table.inputs**2)


def test_optimise_finds_the_minimum_of_a_function_within_a_constraint():
    """Of x + y at least 0.5 the nearest point to (0.3, -0.2) is (0.5, 0)."""
    wide = vt.explore.Prior("uniform", -1.0, 1.0)
    experiment = function_of(paraboloid, ["height", "sum"], {"x": wide, "y": wide})
    found = experiment.optimise(
        [{"quantity": "height", "direction": "minimise"}],
        [{"quantity": "sum", "at_least": 0.5}],
        {"trials": 60},
        workers=1,
    )
    assert found.best.trial.values == pytest.approx([0.5, 0.0], abs=0.01)
    trials = found.to_xarray()
    assert trials.sizes["trial"] == len(found.trials)
    assert float(trials.objective_1.where(trials.feasible).min()) == pytest.approx(0.08, abs=0.002)


@pytest.mark.parametrize(
    ("case", "outputs", "words"),
    [
        ("job-c", vt.Outputs(["f"], function=paraboloid), "a case or a function"),
        (None, vt.Outputs(["peak_spring_force"]), "a case or a function"),
    ],
)
def test_an_experiment_has_a_case_or_a_function(case, outputs, words):
    with pytest.raises(vt.InputError, match=words):
        vt.Experiment(case, PRECOMPRESSION, outputs)


STUDY = """
case = "job-c"
engine_speeds = "4000 rpm"
spring_models = "massless"
outputs = "peak_spring_force"
{tables}
"""
OLD = """
[set]
"operation.cycles" = 3
[quantities.wire]
key = "springs.0.wire.wire_diameter"
prior = "uniform"
low = "3.9 mm"
high = "4.1 mm"
"""
NEW = """
[changes]
"operation.cycles" = 3
[[vary]]
label = "wire"
key = "spring.wire_diameter"
distribution = "uniform"
low = "3.9 mm"
high = "4.1 mm"
"""
MEASURED = '[measurements.load]\nquantity = "preload"\nvalue = "250 N"\nscatter = "1 N"\nspring_model = "massless"\n'


def test_both_vocabularies_of_files_say_the_same_of_studies_and_identifications():
    old, new = (
        read_plan(FileText(STUDY.format(tables=tables), "study", Path(), StudyModel))
        for tables in (OLD, NEW)
    )
    assert [(one.distribution, one.label) for one in old.varied] == [
        (one.distribution, one.label) for one in new.varied
    ]
    first, second = (one.experiment.evaluate([4e-3], one.experiment.tasks[0]) for one in (old, new))
    assert first == second
    first, second = (
        identification_plan('case = "job-c"\n' + tables + MEASURED, "file", Path())
        for tables in (OLD, NEW)
    )
    for one, other in zip(first.unknowns, second.unknowns, strict=True):
        assert (one.title, one.prior, one.unit) == (other.title, other.prior, other.unit)
    assert first.case == second.case
    assert first.data == second.data


def test_a_distribution_may_be_left_to_its_other_keys():
    normal = NEW.replace('distribution = "uniform"\nlow = "3.9 mm"\nhigh = "4.1 mm"', "{}")
    for words, prior in (
        ('low = "3.9 mm"\nhigh = "4.1 mm"', vt.explore.Prior("uniform", 3.9e-3, 4.1e-3)),
        (
            'mean = "4 mm"\nstandard_deviation = "0.1 mm"',
            vt.explore.Prior("normal", centre=4e-3, spread=1e-4),
        ),
        ('tolerance = "0.03 mm"', vt.explore.Prior("normal", 3.97e-3, 4.03e-3, 4e-3, 1e-5)),
    ):
        text = normal.format(words)
        study = read_plan(FileText(STUDY.format(tables=text), "study", Path(), StudyModel))
        request = identification_plan('case = "job-c"\n' + text + MEASURED, "file", Path())
        for found in (study.varied[0].distribution, request.unknowns[0].prior):
            assert found.kind == prior.kind
            assert (found.low, found.high) == pytest.approx((prior.low, prior.high))
            assert (found.centre, found.spread) == pytest.approx(
                (prior.centre, prior.spread), nan_ok=True
            )
