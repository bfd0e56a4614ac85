"""Unit: what a point tells of events, channels, peaks and curves is what a run of that case tells;
one spring of several by its name.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import valvetrain as vt
from study_parts import identification_plan
from valvetrain.errors import InputError
from valvetrain.explore.execution import Execution
from valvetrain.explore.identification_file import Search
from valvetrain.explore.identify import run_identification
from valvetrain.explore.measurements import Target
from valvetrain.explore.observe import Observed, numbers_of
from valvetrain.explore.outputs import Run
from valvetrain.parameters.toml_text import toml_text

WIRE = {
    "key": "spring.wire_diameter",
    "prior": "normal",
    "mean": "4 mm",
    "standard_deviation": "0.1 mm",
}
BASE = {"case": "job-t", "quantities": {"wire": WIRE}}
PRELOAD = {
    "one": {"quantity": "preload", "value": "212 N", "scatter": "1 N", "spring_model": "wave-rod"}
}


def request_of(measurements: dict[str, object], folder, **more: object):
    return identification_plan(
        toml_text(BASE | more | {"measurements": measurements}), "test", folder
    )


def test_peaks_events_and_traces_are_those_of_the_run(tmp_path) -> None:
    """A train's run at one speed, evaluated for all of them at once, beside the same run by itself."""
    moving = {"engine_speed": "4136 rpm", "spring_model": "modal-uniform", "scatter": "1 %"}
    request = request_of(
        {
            "peak": {**moving, "quantity": "peak_spring_force", "value": "500 N"},
            "angle": {**moving, "quantity": "peak_spring_force_cam_angle", "value": "90 deg", "scatter": "1 deg"},
            "seating": {**moving, "event": "seating", "cam_angle": "180 deg"},
            "trace": {**moving, "channel": "valve_lift", "cam_angles": "60, 91, 359.9 deg", "values": "1, 2, 3 mm"},
        },
        tmp_path, case="vaz-ohc", quantities={"speed": {"key": "train.lash", "prior": "uniform", "low": "0 mm", "high": "0.2 mm"}},
    )  # fmt: skip
    case = Observed(request.case, request.varied, request.targets).case_at((0.0,))
    found = numbers_of(case, (request.targets[0].station,), request.targets)
    (run,) = vt.simulate(case, "4136 rpm", models=["modal-uniform"]).solutions
    assert found is not None
    named = {key.partition(": ")[2]: value for key, value in found.items()}
    assert named["peak_spring_force"] == run.quantities["peak_spring_force"]
    assert named["peak_spring_force_cam_angle"] == run.quantities["peak_spring_force_cam_angle"]
    seating = min(
        event.cam_angle % (2 * math.pi) for event in run.events if event.kind == "seating"
    )
    assert named["seating 1 cam angle"] == pytest.approx(seating, rel=1e-12)
    angle, lift = np.degrees(np.asarray(run.channels["cam_angle"])) % 360, run.channel("valve_lift")
    for asked in (60, 91, 359.9):
        near = lift[np.argsort(np.abs((angle - asked + 180) % 360 - 180))[:2]]
        assert near.min() - 1e-9 <= named[f"valve_lift at {asked:g} deg"] <= near.max() + 1e-9
    assert np.isnan(
        numbers_of(
            case,
            (request.targets[0].station,),
            [Target(request.targets[0].station, "event", "seating", 99)],
        ).popitem()[1]
    )


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
    found = numbers_of(request.case, (request.targets[0].station,), request.targets)
    curve = vt.static_curve("job-t", "10 mm", models="multi-mass", steps=5)
    assert list(found.values()) == pytest.approx(
        [curve.force_at("4 mm"), curve.force_at("8 mm")], rel=1e-9
    )
    height = request.case.springs[0].wire.free_length - 8e-3
    load = Target(Run(None, "multi-mass"), "load", "", height)
    assert numbers_of(request.case, (load.station,), [load])[load.key] == pytest.approx(
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
    quantities = {
        "lash": {"key": "train.lash", "prior": "uniform", "low": "0 mm", "high": "0.2 mm"}
    }
    request = request_of({"curve": outer}, tmp_path, case="vaz-ohc", quantities=quantities)
    with pytest.raises(
        InputError,
        match="4 springs of the case could be meant; give spring, one of 'outer', 'inner'",
    ):
        numbers_of(request.case, (request.targets[0].station,), request.targets)
    forces = []
    for name in ("outer", "inner"):
        named = request_of(
            {"curve": outer | {"spring": name, "spring_set": "nested"}},
            tmp_path,
            case="vaz-ohc",
            quantities=quantities,
        )
        (value,) = numbers_of(named.case, (named.targets[0].station,), named.targets).values()
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


def test_the_case_s_own_values_are_a_start(tmp_path) -> None:
    """A prior far from the case: with one start from the case the search ends where the case is."""
    request = request_of(PRELOAD, tmp_path, search={"from_case": True, "draws": 1})
    found = run_identification(request, Execution(workers=1))
    assert found.best["wire"] == pytest.approx(4e-3, rel=5e-3)


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


def test_conditions_that_one_study_tells_are_computed_together_with_the_same_bits(tmp_path) -> None:
    """Two speeds by one model share a run of the case; a light quantity and another model stand
    alone.
    """
    speeds = {
        name: {
            "channel": "seat_force",
            "cam_angles": "180 deg",
            "values": "500 N",
            "scatter": "1 N",
            "engine_speed": f"{rpm} rpm",
            "spring_model": model,
        }
        for name, rpm, model in (
            ("slow", 2000, "modal-uniform"),
            ("fast", 3000, "modal-uniform"),
            ("other", 3000, "wave-rod"),
        )
    }
    light = {
        "quantity": "peak_spring_force",
        "value": "500 N",
        "scatter": "1 N",
        "engine_speed": "2500 rpm",
        "spring_model": "wave-rod",
    }
    request = request_of(speeds | {"light": light}, tmp_path)
    observed = Observed(request.case, request.varied, request.targets)
    groups = observed.runs
    assert sorted(map(len, groups)) == [1, 1, 2]
    case = observed.case_at((4e-3,))
    for group in groups:
        stations = [observed.stations[place] for place in group]
        alone = [numbers_of(case, (station,), request.targets) for station in stations]
        assert numbers_of(case, stations, request.targets) == {
            key: value for one in alone for key, value in one.items()
        }


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


def test_a_rod_in_motion_tells_its_numbers_at_rest_too(tmp_path) -> None:
    """One run tells both; the same numbers, bit for bit, as each condition by itself."""
    moving = {"engine_speed": "4200 rpm", "spring_model": "finite-element", "scatter": "1 %"}
    request = request_of(
        {
            "preload": {"quantity": "preload", "value": "300 N", "scatter": "1 N"},
            "peak": {**moving, "quantity": "stage_2_peak_force", "value": "800 N"},
        },
        tmp_path,
        case="gu2021-beehive-blind",
    )
    observed = Observed(request.case, request.varied, request.targets)
    assert observed.runs == ((1, 0),)
    apart = {
        key: value
        for one in observed.stations
        for key, value in (numbers_of(request.case, (one,), request.targets) or {}).items()
    }
    together = numbers_of(request.case, observed.stations, request.targets)
    assert together == apart and len(together) == 2
