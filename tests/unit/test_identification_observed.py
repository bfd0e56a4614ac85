"""Unit: what a point tells of peaks and curves is what a run of that case tells;
one spring of several by its name.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from study_parts import identification_plan
from valvetrain.errors import InputError
from valvetrain.explore.execution import Execution
from valvetrain.explore.identification_file import Search
from valvetrain.explore.identify import run_identification
from valvetrain.explore.observe import Target, numbers_of
from valvetrain.explore.outputs import Run
from valvetrain.parameters.toml_text import toml_text

WIRE = {
    "key": "spring.wire_diameter",
    "prior": "normal",
    "mean": "4 mm",
    "standard_deviation": "0.1 mm",
}
LASH = {"lash": {"key": "train.lash", "prior": "uniform", "low": "0 mm", "high": "0.2 mm"}}
BASE = {"case": "job-t", "quantities": {"wire": WIRE}}
PRELOAD = {
    "one": {"quantity": "preload", "value": "212 N", "scatter": "1 N", "spring_model": "wave-rod"}
}


def request_of(measurements: dict[str, object], folder, **more: object):
    return identification_plan(
        toml_text(BASE | more | {"measurements": measurements}), "test", folder
    )


def test_peaks_are_those_of_the_run(tmp_path) -> None:
    """A train's run at one speed, beside the same run by itself."""
    moving = {"engine_speed": "4136 rpm", "spring_model": "modal-uniform", "scatter": "1 %"}
    names = {"peak_spring_force": "500 N", "peak_spring_force_cam_angle": "90 deg"}
    measured = {name: {**moving, "quantity": name, "value": value} for name, value in names.items()}
    request = request_of(measured, tmp_path, case="vaz-ohc", quantities=LASH)
    numbers = numbers_of(request.case, request.fitted.targets[0].station, request.fitted.targets)
    (run,) = vt.simulate(request.case, "4136 rpm", models=["modal-uniform"]).solutions
    assert list(numbers.values()) == [run.quantities[name] for name in names]


def test_curves_and_loads_are_those_of_the_static_curve(tmp_path) -> None:
    request = request_of(
        {
            "curve": {
                "compressions": "4, 8 mm",
                "forces": "1, 2 N",
                "scatter": "1 N",
                "spring_model": "multi-mass",
            }
        },
        tmp_path,
    )
    found = numbers_of(request.case, request.fitted.targets[0].station, request.fitted.targets)
    curve = vt.static_curve("job-t", "10 mm", models="multi-mass", steps=5)
    assert list(found.values()) == pytest.approx(
        [curve.force_at("4 mm"), curve.force_at("8 mm")], rel=1e-9
    )
    height = request.case.springs[0].wire.free_length - 8e-3
    load = Target(Run(None, "multi-mass"), "load", "", height)
    assert numbers_of(request.case, load.station, [load])[load.key] == pytest.approx(
        curve.force_at("8 mm"), rel=1e-9
    )


def test_springs_of_a_pair_are_named(tmp_path) -> None:
    """Loads of outer and inner spring of the nested pair of a train; without a name it is refused
    with the names.
    """
    outer = {
        "compressions": "20 mm",
        "forces": "300 N",
        "scatter": "1 N",
        "spring_model": "massless",
    }
    request = request_of({"curve": outer}, tmp_path, case="vaz-ohc", quantities=LASH)
    with pytest.raises(
        InputError,
        match="4 springs of the case could be meant; give spring, one of 'outer', 'inner'",
    ):
        numbers_of(request.case, request.fitted.targets[0].station, request.fitted.targets)
    forces = []
    for name in ("outer", "inner"):
        named = request_of(
            {"curve": outer | {"spring": name, "spring_set": "nested"}},
            tmp_path,
            case="vaz-ohc",
            quantities=LASH,
        )
        (value,) = numbers_of(
            named.case, named.fitted.targets[0].station, named.fitted.targets
        ).values()
        forces.append(value)
    assert forces[0] > forces[1] > 0, "the outer spring is the stronger one"


@pytest.mark.parametrize(
    ("measured", "words"),
    [
        ({"quantity": "free_swing_force_range", "value": "1 N"}, "no point gives"),
        ({"quantity": "preload", "value": "212 N", "spring_model": "mutli-mass"}, "multi-mass"),
    ],
)
def test_what_no_point_can_tell_is_refused_before_the_search(tmp_path, measured, words) -> None:
    request = request_of({"one": measured | {"scatter": "1 N"}}, tmp_path)
    with pytest.raises(InputError, match=words):
        run_identification(request, Execution(workers=1))


def test_a_request_that_is_too_large_is_refused_with_its_cost(tmp_path) -> None:
    request = request_of(PRELOAD, tmp_path, search={"method": "nested", "live_points": 9_000_000})
    with pytest.raises(InputError, match=r"beyond the bound of .* raise the bound with limit="):
        run_identification(request, Execution(workers=1))


def test_the_case_alone_is_searched_from_with_keep_0(tmp_path) -> None:
    """No other start is computed, and the estimate counts the case among the starts."""
    both, alone = (
        run_identification(
            request_of(
                PRELOAD,
                tmp_path,
                search={"from_case": True, "draws": 1, "starts": 30, "keep": keep},
            ),
            Execution(workers=1),
        )
        for keep in (1, 0)
    )
    assert (
        alone.best["wire"] == pytest.approx(4e-3, rel=5e-3)
        and both.evaluations - alone.evaluations >= 30
    )
    with pytest.raises(
        InputError,
        match=r"search.keep: keep is 0, so that nothing is searched from; set from_case = true",
    ):
        request_of(PRELOAD, tmp_path, search={"keep": 0})
    search = Search(starts=24, keep=0, from_case=True)
    both = search.changed(keep=1, from_case=False)
    assert search.evaluations_of(3) == both.evaluations_of(3) - 24


def test_what_is_only_compared_elsewhere_is_computed_for_the_draws_alone(tmp_path) -> None:
    """Fitted at rest, compared in motion: the run is asked for a few draws, and the percentile
    comes from them.
    """
    measured = {
        "seat": {"quantity": "preload", "value": "212 N", "scatter": "1 N", "spring_model": "wave-rod"},
        "peak": {"quantity": "peak_spring_force", "value": "530 N", "scatter": "8 N", "engine_speed": "2000 rpm", "fit": False,
                 "spring_model": "wave-rod"},
    }  # fmt: skip
    asked = {"rate": {"quantity": "installed_rate", "spring_model": "wave-rod"}}
    found = run_identification(
        request_of(measured, tmp_path, search={"draws": 12}, predictions=asked),
        Execution(workers=1),
    )
    (rate,) = found.predictions
    assert (
        rate.key == "wave-rod: installed_rate"
        and rate.unit == "N/mm"
        and np.isfinite(found.computed[rate.key]).sum() == 12
    )
    assert rate.low < rate.middle < rate.high and rate.best == pytest.approx(rate.middle, rel=0.02)
    seat, peak = found.predicted
    key = "2000 rpm, wave-rod: peak_spring_force"
    assert peak.datum.key == key and np.isfinite(found.computed[key]).sum() == 12
    assert peak.low < peak.middle < peak.high and 0 < peak.percentile < 100
    assert peak.low <= peak.best <= peak.high and seat.best == pytest.approx(212.0, abs=1.0)
