"""A run's main numbers come from what the integrator saw: they do not depend on how many samples
are kept of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from valvetrain.integrate.contract import Cycles, Periodic, RunOptions
from valvetrain.integrate.run import run
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.evaluate import evaluate
from valvetrain.runs.api import simulate
from valvetrain.runs.error_bars import TRAIN_HEADLINES
from valvetrain.runs.prepared import Plan, prepare, with_quantities
from valvetrain.runs.stored_error_bars import load_uncertainty
from valvetrain.solution.definition import topics
from valvetrain.solution.netcdf import load_netcdf, save_netcdf
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.result import Solution
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.prescribed import PrescribedSpring

SAMPLES = (360, 1440)
#: Numbers that agree to 0.1 % whatever is kept, raw fronts of less than a microsecond among them.
FORCES = (
    "peak_spring_force", "minimum_spring_force", "peak_retainer_force", "minimum_retainer_force", "raw_peak_spring_force",
    "raw_peak_retainer_force", "main_clash_below_5_khz_peak_force", "main_clash_impulse",
    "main_clash_cam_angle", "main_clash_peak_force", "dissipated_energy", "coil_bind_clearance",
)  # fmt: skip
CLASHES = (
    "clash_energy",
    "largest_clash_energy",
    "largest_clash_impulse",
    "peak_clash_force",
    "surge_clash_peak_force",
)
STRESSES = ("peak_shear_stress", "peak_equivalent_stress")
#: Raw numbers that every step counts for: the same to rounding.
ON_EVERY_STEP = (
    "raw_peak_spring_force", "raw_peak_spring_force_cam_angle", "minimum_spring_force", "raw_peak_retainer_force", "minimum_retainer_force",
    "main_clash_peak_force",
)  # fmt: skip


@cache
def solutions(case: str, word: str) -> tuple[Solution, ...]:
    """The second cam turn at the case's highest speed, with each number of samples at one time
    step.
    """
    problem = build(load_case(case), spring_models=(word,))
    ready, (spring,) = prepare(problem, problem.members[0], {}, ""), problem.springs
    frame = replace(
        ready.frame, surge_frequencies=(EquivalentSpring.from_installed(spring).surge_frequency,)
    )
    cam_speed = problem.engine_speeds[-1] / 2
    interval = 2 * np.pi / cam_speed / max(SAMPLES)
    # The rod cuts a sample into its records of end forces first: 3, 5 and 10 of them, all of which
    # a multiple of 15 allows.
    steps = np.ceil(interval / (0.8 * spring_model(word).build(spring).stable_time_step()))
    time_step = interval / (15 * np.ceil(steps / 15) if word == "finite-element" else steps)
    return tuple(
        evaluate(run(ready.system, cam_speed, Cycles(2), RunOptions(samples, time_step)), frame)
        for samples in SAMPLES
    )


def agree(found: Sequence[Solution]) -> None:
    """The runs show the same clashes, to rounding that grew through them."""
    *others, finest = found
    assert finest.quantities["clash_count"] > 1
    for other in others:
        assert other.quantities["clash_count"] == finest.quantities["clash_count"]
        assert [other.quantities[name] for name in CLASHES] == pytest.approx(
            [finest.quantities[name] for name in CLASHES], rel=1e-3
        )


@pytest.mark.parametrize("case", ["job-c", "gu2021-beehive-blind"])
@pytest.mark.parametrize("word", ["finite-element", "multi-mass"])
def test_main_numbers_do_not_depend_on_the_samples_kept(case, word):
    coarse, fine = (found.quantities for found in solutions(case, word))
    names = FORCES + (STRESSES if word == "finite-element" else ())
    for name in names:
        assert coarse[name] == pytest.approx(fine[name], rel=1e-3), name
    if word == "finite-element":
        for name in ON_EVERY_STEP:
            assert coarse[name] == pytest.approx(fine[name], rel=1e-9), name


def test_the_largest_force_of_the_rod_is_that_of_all_steps_and_not_of_its_record():
    """The record of end forces, one in some 14 steps, misses the top of the raw front by 2 to 6 %."""
    coarse = solutions("gu2021-beehive-blind", "finite-element")[0]
    recorded, highest = coarse.channel("seat_force_fine"), coarse.channel("seat_force_highest")
    assert np.all(highest >= recorded.max(axis=1)) and np.all(
        coarse.channel("seat_force_lowest") <= recorded.min(axis=1)
    )
    late = coarse.cam_angle > 2 * np.pi + np.radians(240)
    assert np.max(highest[late]) > 1.01 * np.max(recorded[late])
    within = np.diff(coarse.time)[0] * (1 + 1e-9)
    assert np.all(
        (coarse.channel("seat_force_highest_time") - coarse.time >= -1e-15) & (highest > 0)
    )
    assert np.max(coarse.channel("seat_force_highest_time") - coarse.time) < within


def test_the_step_that_samples_round_moves_no_headline_number_by_more_than_its_error_bar():
    """The rod's own step is cut to a whole number per sample, 1 to 3 % apart; error bars: the rows
    that ship with the case.
    """
    case = load_case("gu2021-beehive-blind")
    problem = build(case, spring_models=("finite-element",))
    ready, (spring,) = prepare(problem, problem.members[0], {}, ""), problem.springs
    frame = replace(
        ready.frame, surge_frequencies=(EquivalentSpring.from_installed(spring).surge_frequency,)
    )
    speed = problem.engine_speeds[-1]

    def solved(samples):
        return evaluate(run(ready.system, speed / 2, Cycles(2), RunOptions(samples)), frame)

    first = solved(720)
    for samples in (
        1440,
        1000,
        1100,
        900,
        1200,
        800,
    ):  # which of them moves it is the step's affair
        second = solved(samples)
        ratio = second.statistics["time_step_duration"] / first.statistics["time_step_duration"]
        if 0.005 < abs(ratio - 1) < 0.05:
            break
    else:
        pytest.fail("no number of samples moves the step by 0.5 to 5 %")
    found = [first, second]
    bars = {
        row.quantity: row.numerical
        for row in load_uncertainty(case.record())
        if row.engine_speed and same_speed(row.engine_speed, speed)
    }
    names = [name for name in (*FORCES, *STRESSES) if name in bars]
    assert {
        "peak_spring_force",
        "main_clash_peak_force",
        "main_clash_cam_angle",
        "main_clash_impulse",
        "peak_shear_stress",
    } <= {*names}
    for name in names:
        assert abs(found[0].quantities[name] - found[1].quantities[name]) <= bars[name], name


@pytest.mark.parametrize("case", ["job-c", "gu2021-beehive-blind"])
@pytest.mark.parametrize("word", ["finite-element", "multi-mass", "wave-rod-clash"])
def test_clashes_do_not_depend_on_the_samples_kept(case, word):
    found = solutions(case, word)
    agree(found)
    assert len(found) == len(SAMPLES) and found[0].quantities["peak_clash_force"] > 0


@pytest.mark.parametrize("word", ["finite-element", "multi-mass"])
def test_clashes_of_a_train_depend_neither_on_the_samples_nor_on_what_is_kept(word):
    problem = build(load_case("vaz-ohc"), spring_models=(word,))
    ready = prepare(problem, problem.members[0], {}, "")
    cam_speed = problem.engine_speeds[-1] / 2
    time_step = runner(
        ready.system, cam_speed, TrainOptions(max(SAMPLES)), rest=ready.rest
    ).time_step * (1 + 1e-9)
    kept = [(samples, "all") for samples in SAMPLES] + [(SAMPLES[0], "ends")]
    found = [
        evaluate(
            run(
                ready.system, cam_speed, Cycles(1), RunOptions(samples, time_step, keep, ready.rest)
            ),
            ready.frame,
        )
        for samples, keep in kept
    ]
    agree(found)
    assert {event.where.split()[0] for event in found[0].events if event.kind == "clash"} <= {
        "outer",
        "inner",
    }


@pytest.mark.parametrize("word", ["finite-element", "multi-mass"])
def test_clashes_of_a_pair_under_prescribed_motion_name_their_spring(word, tmp_path):
    """The same with every kind of channels kept, and again from the file, though its samples alone
    would show other clashes.
    """
    problem = build(load_case("vaz-ohc"), spring_models=(word,))
    pair = PrescribedSpring(
        tuple(spring_model(word).build(spring) for spring in problem.springs), problem.valve_lift
    )
    found = [
        evaluate(run(pair, 300.0, Cycles(1), RunOptions(360, keep=keep)))
        for keep in ("all", "contacts", "ends")
    ]
    agree(found)
    save_netcdf(found[0], tmp_path / "run.nc")
    assert evaluate(load_netcdf(tmp_path / "run.nc")).identical(found[0])


@pytest.mark.parametrize(
    ("case", "word"), [("gu2021-beehive-blind", "multi-mass"), ("job-c", "finite-element")]
)
def test_surge_orders_do_not_depend_on_the_samples_kept(case, word):
    """High frequencies of clashes fold into the low orders of coarse samples; the force is read as
    finely as it is known.
    """
    found = []
    for step in ("1 deg", "0.25 deg"):
        study = simulate(load_case(case, {"operation.output_step": step}), models=[word], workers=1)
        found.append(study.solutions[-1].quantities)
    names = [
        name
        for name in found[1]
        if name.startswith("surge_") and name.endswith("_force") and "clash" not in name
    ]
    assert len(names) == 41
    scale = max(found[1][name] for name in names)
    assert [found[0][name] for name in names] == pytest.approx(
        [found[1][name] for name in names], abs=1e-3 * scale
    )


def test_seating_of_a_train_does_not_depend_on_the_samples_kept():
    """The touch is found on every step; 360 to 1440 samples are all made of the same 2880 steps."""
    study = build(load_case("tdi-pushrod"), spring_set=("stock",))
    system = study.members[0].system()
    found = []
    for samples in SAMPLES:
        run_of = run(system, study.engine_speeds[0] / 2, Cycles(3), RunOptions(samples))
        seat = [event for event in run_of.events if event.kind == "touch" and event.where == "seat"]
        found.append(
            max((event.details["largest_gap"], event.cam_angle, event.size) for event in seat)
        )
    assert found[0] == found[1] and found[0][2] > 0.1


#: Cases, variants and changes in which the train floats, loses contact, surges and closes quietly;
#: noses off every grid of samples.
TURNED = {
    "lift_law.opening_start": "90.47 deg",
    "lift_law.opening_end": "180.47 deg",
    "lift_law.closing_start": "180.47 deg",
    "lift_law.closing_end": "270.47 deg",
}
TRAINS = (
    ("tdi-pushrod", "stock", TURNED), ("tdi-pushrod", "performance, as printed, zeta 0.5", TURNED),
    ("vaz-ohc", "six masses, lash 0.1 mm", {}), ("vaz-ohc", "single mass, lash 0 mm", {}),
)  # fmt: skip


@pytest.mark.parametrize(("case", "label", "changes"), TRAINS)
def test_no_headline_number_of_a_train_depends_on_the_samples_kept(case, label, changes):
    """Whatever stands at the head of a report, or gets an error bar; a number that is added there
    is tested here from then on.
    """
    sets = "as printed" if "as printed" in label else ()
    problem = build(load_case(case, changes), spring_set=sets)
    member = next(one for one in problem.members if one.label == label)
    ready, speed = prepare(problem, member, {}, ""), problem.engine_speeds[-1]
    step = runner(ready.system, speed / 2, TrainOptions(2880), rest=ready.rest).time_step * (
        1 + 1e-9
    )
    found = []
    for samples in (360, 2880):
        options = RunOptions(samples, step, rest=ready.rest, window=ready.window, nose=ready.nose)
        found.append(
            with_quantities(
                ready, run(ready.system, speed / 2, Periodic(), options), Plan(), {}
            ).quantities
        )
    names = {
        name
        for name in (*TRAIN_HEADLINES, *(one for topic in topics().values() for one in topic))
        if name in found[-1]
    }
    named = (
        "peak_valve_acceleration",
        "loss_of_contact_duration",
        "minimum_cam_contact_force",
        "nose_cam_contact_force",
    )
    assert names.issuperset((*named, "peak_spring_force", "lift_loss_displacement", "loft_gap"))
    for name in names:
        coarse, fine = (one[name] for one in found)
        assert coarse == pytest.approx(fine, rel=1e-3, abs=1e-9), name
    places = [one["peak_cam_contact_force_cam_angle"] for one in found]
    assert places[0] == places[1]
