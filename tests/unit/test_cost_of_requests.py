"""What springs at rest, refinements and run-ups will cost: near to what was measured, and refused
beyond a bound before any work.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case

RPM = math.pi / 30
ELEMENTS, MASSES = (
    "spring.options.finite-element.elements_per_coil",
    "spring.options.multi-mass.masses_per_coil",
)


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (("static", "job-t", "--steps", "100000000"), "TB'"),
        (("modes", "job-t", "--limit", "1 MB"), "--limit '"),
        (("modes", "job-t", "--model", "multi-mass", "--set", f"{MASSES}=2000"), "3 GB'"),
        (
            (
                "modes",
                "job-t",
                "--count",
                "100000",
                "--set",
                "spring.options.finite-element.elements_per_coil=240",
            ),
            "min'",
        ),
        (
            (
                "static",
                "gu2021-beehive-blind",
                "--set",
                "spring.options.finite-element.elements_per_coil=1000",
                "--steps",
                "2000",
            ),
            "--limit '",
        ),
        (("refine", "job-t", "--rpm", "10:9000:1 rpm"), "--limit '"),
        (("refine", "job-t", "--limit", "1 s"), "--limit '"),
        (("run-up", "tdi-pushrod", "--duration", "100000 s"), "--limit '"),
    ],
)
def test_a_request_beyond_its_bound_is_refused_with_its_numbers_and_the_option(
    words, option, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    said = sentence(call(*words))
    assert (
        "this request will take about" in said and "beyond the bound of" in said and option in said
    )
    assert not list(tmp_path.iterdir())


def test_numbers_that_no_computer_counts_to_are_refused():
    assert "is outside 2 to 1000000000" in sentence(
        call("static", "job-t", "--steps", "10000000000")
    )
    assert "2000" in sentence(
        call("static", "job-t", "--model", "multi-mass", "--set", f"{MASSES}=1000000")
    )
    assert "1000" in sentence(
        call("static", "job-t", "--set", "spring.options.finite-element.elements_per_coil=100000")
    )


def measured_job():
    """A spring alone whose lift was measured, as the band of a lift needs it."""
    angles = np.radians(np.arange(90.0, 271.0))
    lifts = 9e-3 * np.clip(1 - ((angles - np.pi) / np.radians(60)) ** 2, 0, None) ** 3
    case = load_case("job-t")
    values = {
        "cam_angles": tuple(angles),
        "lifts": tuple(lifts),
        "noise": 3e-6,
        "band": 0.0,
        "draw": 0,
    }
    return case.replace(lift_law=type(case.lift_law)("measured", values))


def level_force():
    """Two cycles of a force, for a model to be compared with."""
    angles = np.linspace(0.0, 2 * np.pi, 36, endpoint=False)
    return vt.measured.MeasuredCycles(
        "spring_force", "N", angles, np.array([np.full(36, 500.0), np.full(36, 501.0)]), 1500 * RPM
    )


REQUESTS = {
    "simulate": lambda limit: vt.simulate("job-t", "2000 rpm", limit=limit),
    "compare": lambda limit: vt.compare("job-t", "2000 rpm", ["massless", "wave-rod"], limit=limit),
    "sweep": lambda limit: vt.sweep("job-t", "1000:9000:1 rpm", limit=limit),
    "critical_speeds": lambda limit: vt.critical_speeds(
        "tdi-pushrod", "1000:9000:1 rpm", limit=limit
    ),
    "static_curve": lambda limit: vt.static_curve("job-t", limit=limit),
    "refine": lambda limit: vt.refine("job-t", "2000 rpm", limit=limit),
    "run_up": lambda limit: vt.run_up("tdi-pushrod", "1000 rpm", "6000 rpm", "20 s", limit=limit),
    "compare_with_test": lambda limit: vt.compare_test.compare_with_test(
        "job-t", level_force(), limit=limit
    ),
    "lift_band_study": lambda limit: vt.lift.lift_band_study(
        measured_job(), "2000 rpm", limit=limit
    ),
}


#: What a request that is too large can be asked less of; of all others speeds, cycles or unknowns.
FEWER = {
    "static_curve": "steps, modes or unknowns", "refine": "speeds, variants or unknowns", "lift_band_study": "laws, speeds or unknowns",
}  # fmt: skip


@pytest.mark.parametrize("name", REQUESTS)
def test_programs_have_the_bounds_of_the_command_line(name, monkeypatch):
    def work(*given, **options):
        raise AssertionError("work was begun")

    studies = (
        "runs.api.run_study",
        "runs.api.compare_study",
        "runs.api.sweep_study",
        "runs.refine.refined",
        "runs.run_up.run_up_study",
    )
    for place in (*studies, "runs.api.curve_by_model", "lift.band.map_points"):
        monkeypatch.setattr(f"valvetrain.{place}", work)
    fewer = f"choose fewer {FEWER.get(name, 'speeds, cycles or unknowns')}, or"
    with pytest.raises(
        InputError,
        match=rf"this request will take about .*, beyond the bound of 1 MB; {fewer} raise the bound with limit='",
    ):
        REQUESTS[name]("1 MB, 99 d")
    with pytest.raises(InputError, match="'soon' is no bound"):
        REQUESTS[name]("soon")
    with pytest.raises(AssertionError, match="work was begun"):
        REQUESTS[name]("9 d, 9 TB")


def test_static_curves_of_no_step_and_of_countless_steps_are_refused():
    for steps, words in (
        (0, "one or more"),
        (10**400, "this request will take about"),
        (10**8, "TB"),
    ):
        with pytest.raises(InputError, match=words):
            vt.static_curve("job-t", steps=steps)


@pytest.mark.parametrize(
    ("request_of", "words"),
    [
        (lambda: vt.refine("tdi-pushrod", "2000 rpm", limit=5), "'5' is no bound"),
        (lambda: vt.simulate("job-t", limit=[3600]), "is no bound"),
        (lambda: vt.simulate("job-t", workers=1.5), "a whole number is needed; it is 1.5"),
        (lambda: vt.sweep("job-t", workers="two"), "a whole number is needed; it is two"),
        (lambda: vt.refine("job-t", workers=0), "0 is outside 1 to 256"),
        (lambda: vt.map(vt.load_case, ["job-t"], workers=2.0), "a whole number"),
        (lambda: vt.static_curve(None), "'None' is no case"),
        (lambda: vt.simulate(7), "'7' is no case"),
        (lambda: vt.static_curve("job-t", steps=2.5), "a whole number of steps"),
        (lambda: vt.static_curve("job-t", steps="5"), "a whole number of steps"),
        (lambda: vt.static_curve("job-t", models=["massless"]), "is no spring model"),
        (lambda: vt.static_curve("job-t", steps=float("nan")), "a whole number of steps"),
    ],
)
def test_arguments_of_another_kind_are_refused_in_a_sentence(request_of, words):
    with pytest.raises(InputError, match=words):
        request_of()
