"""Studies on the one pipeline: failures as statuses, every model in every system, results that travel."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

import valvetrain as vt
from spring_shapes import cylindrical
from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.runs.api import compare, simulate, sweep
from valvetrain.runs.prepared import prepare
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build

RPM = np.pi / 30
COARSE = {"spring.options.finite-element.elements_per_coil": 8}
#: Models that move in every system and within seconds.
MOVING = tuple(
    word
    for word in registry.names("springs")
    if not (spring_model(word).no_motion or spring_model(word).alone)
)
CARD_MODELS = tuple(word for word in MOVING if not spring_model(word).wire_only)

LAW = """
[lift_law]
kind = "sine-power"
maximum_lift = "7 mm"
opening_start = "120 deg"
closing_end = "240 deg"
power = 4
[operation]
engine_speeds = "4000 rpm"
cycles = 1
output_step = "1 deg"
"""
OUTER = """
[[spring]]
name = "big"
wire_diameter = "4 mm"
mean_diameter = "28 mm"
pitch = "7.5 mm"
total_coils = 6
ends = "open"
material = "OTEVA 90 SC"
precompression = "7 mm"
seats = "clamps"
options = { finite-element = { elements_per_coil = 8 } }
"""
INNER = (
    OUTER.replace('"big"', '"small"')
    .replace('"4 mm"', '"2.8 mm"')
    .replace('"28 mm"', '"19 mm"')
    .replace('"7.5 mm"', '"5.6 mm"')
).replace("total_coils = 6", "total_coils = 8")
NESTED = OUTER + INNER
CARD = '[spring]\nname = "card"\nrate = "30 N/mm"\npreload = "250 N"\nmass = "40 g"\n' + (
    "options = { finite-element = { elements_per_coil = 8 } }\n[spring.damping]\nmass_damping = '100 1/s'\n"
)


@pytest.mark.parametrize("name", ["job-t", "vaz-ohc"])
def test_ready_members_solutions_and_studies_travel_between_processes(name):
    case = load_case(name, {"train.cycles": 1} if name == "vaz-ohc" else {})
    problem = build(case, spring_models=["multi-mass"])
    ready = prepare(problem, problem.members[0], {}, "")
    again = pickle.loads(pickle.dumps(ready))
    assert again.refusal == "" and again.member.label == ready.member.label
    study = simulate(case, engine_speeds=[2000 * RPM], models=["multi-mass"], workers=1)
    back = pickle.loads(pickle.dumps(study))
    assert back.solutions[0].identical(study.solutions[0]) and back.still == study.still
    assert repr(back) == repr(study) and back.quantities == study.quantities


def test_a_run_that_fails_is_a_status_and_the_others_are_kept():
    """A step far beyond the stable one breaks the rod, with half the step too; the exact model
    beside it stays.
    """
    case = load_case("job-t", COARSE | {"spring.options.finite-element.time_step": "1e-4 s"})
    study = simulate(
        case,
        engine_speeds=[8000 * RPM],
        models=["finite-element", "modal-varied"],
        workers=2,
    )
    broken, kept = study.solution("finite-element"), study.solution("modal-varied")
    assert broken.status.code == "diverged" and broken.status.remedy
    assert kept.status.completed and np.isfinite(kept.quantities["peak_spring_force"])
    (sentence,) = study.failures
    assert "finite-element at 8000 rpm" in sentence


def test_a_model_that_cannot_stand_for_a_spring_is_refused_and_the_others_run():
    case = load_case("tdi-pushrod", {"train.cycles": 1})
    study = simulate(case, models=["massless", "wave-rod-clash"], spring_sets=["stock"], workers=1)
    refused = study.solution("wave-rod-clash")
    assert (
        refused.status.code == "refused"
        and "coil gaps" in refused.status.message
        and refused.status.remedy
    )
    assert refused.quantities == {} and len(refused.time) == 0
    assert len(study.solution("massless").time) > 0
    with pytest.raises(InputError, match="coil gaps"):
        simulate(case, models=["wave-rod-clash"], spring_sets=["stock"], workers=1)


def test_a_train_whose_step_cannot_be_is_a_status_of_its_own():
    case = load_case(
        "vaz-ohc", {"train.contacts.cam.contact_stiffness": "2e11 N/mm", "train.cycles": 1}
    )
    study = simulate(case, models=["massless"], spring_sets=["nested-cards"], workers=1)
    (run,) = study.solutions
    assert not run.status.completed and "100 kN/mm" in run.status.sentence()


@pytest.mark.parametrize("speeds", [[0.0], [-100.0], [float("nan")]])
def test_speeds_that_cannot_be_are_refused(speeds):
    for study in (simulate, compare):
        with pytest.raises(InputError, match=r"not positive|finite"):
            study(load_case("job-t"), engine_speeds=speeds)


def test_a_spring_without_a_lift_law_has_statics_and_modes_and_no_motion():
    study = simulate(load_case("clamped-helix", COARSE))
    assert study.solutions == () and study.rest[0].modes is not None and "" in study.still
    for ask in (
        lambda case: simulate(case, engine_speeds=[200.0]),
        lambda case: sweep(case, [200.0]),
    ):
        with pytest.raises(InputError, match="lift law"):
            ask(load_case("clamped-helix"))


@pytest.mark.parametrize("word", MOVING)
def test_nested_springs_under_prescribed_motion_by_every_model(word):
    case = parse_case(NESTED + LAW, "own-pair")
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        study = simulate(case, models=[word], workers=1)
    (run,) = study.solutions
    assert run.status.completed, run.status.sentence()
    assert run.springs == ("outer", "inner")
    for name in ("seat_force", "retainer_force"):
        parts = run.channel(f"outer_{name}") + run.channel(f"inner_{name}")
        assert run.channel(name) == pytest.approx(parts, rel=1e-12)
    assert {"outer", "inner"} <= set(study.still) and len(study.rest) == 2
    static = sum(study.still[name]["preload"] for name in ("outer", "inner"))
    assert run.channel("seat_force")[0] == pytest.approx(static, rel=0.12)
    assert run.quantities["peak_spring_force"] > static


@pytest.mark.parametrize("word", CARD_MODELS)
def test_a_spring_known_by_its_card_under_prescribed_motion_by_every_model_that_can(word):
    case = parse_case(CARD + LAW, "own-card")
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        study = simulate(case, models=[word], workers=1)
    (run,) = study.solutions
    assert run.status.completed, run.status.sentence()
    assert study.still[""]["preload"] == pytest.approx(250.0, rel=1e-6)
    assert run.channel("retainer_force")[0] == pytest.approx(250.0, rel=0.03)
    assert run.quantities["peak_spring_force"] == pytest.approx(250.0 + 30e3 * 7e-3, rel=0.25)


@pytest.mark.parametrize("word", sorted(set(MOVING) - set(CARD_MODELS)))
def test_a_card_says_what_it_lacks_for_the_other_models(word):
    with pytest.raises(InputError, match="known by its card only"):
        simulate(parse_case(CARD + LAW, "own-card"), models=[word], workers=1)


def test_rubbing_of_a_nested_pair_under_prescribed_motion():
    rubbing = '[rubbing]\ncoefficient = 0.15\nnormal_force = "60 N"\n'
    study, pair = (
        simulate(parse_case(text, "own-pair"), models=models, workers=1)
        for text, models in (
            (NESTED + LAW, ["multi-mass"]),
            (NESTED + LAW + rubbing, ["multi-mass", "modal-uniform"]),
        )
    )
    free, rough = (one.solution("multi-mass") for one in (study, pair))
    assert rough.status.completed and free.status.completed
    assert float(np.ptp(rough.channel("energy_dissipated"))) > float(
        np.ptp(free.channel("energy_dissipated"))
    )
    assert pair.solution("modal-uniform").status.code == "refused"


@pytest.mark.parametrize(
    "name", ["gu2021-beehive-blind", pytest.param("vaz-ohc", marks=pytest.mark.long)]
)
def test_a_sweep_keeps_numbers_and_no_channels_and_warns_of_nothing(name):
    case = load_case(name, COARSE if name == "gu2021-beehive-blind" else {})
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        study = sweep(
            case,
            [2000 * RPM, 3000 * RPM],
            models=["multi-mass", "massless"],
            spring_sets=(),
            workers=1,
        )
    assert all(len(run.time) == 0 and run.quantities for run in study.solutions)
    for label in study.labels:
        peak = study.series(label, "peak_spring_force")
        assert list(peak.engine_speed) == pytest.approx([2000, 3000]) and np.all(np.isfinite(peak))
    assert study.comparisons == () and study.findings == ()


def test_a_comparison_of_a_card_takes_the_usual_models_that_can_stand_for_it():
    bare = CARD.replace('mass = "40 g"\n', "")
    for text, words in (
        (CARD, ["massless", "multi-mass", "modal-varied", "wave-rod", "finite-element"]),
        (bare, ["massless"]),
    ):
        study = compare(parse_case(text + LAW, "own-card"), workers=1)
        assert list(study.labels) == words and study.failures == ()
        assert {one.model for one in study.rest} == set(words)


def test_nested_springs_are_told_apart_by_their_names():
    one, two = (
        '[[spring]]\nrate = "30 N/mm"\npreload = "250 N"\nmass = "40 g"\n',
        '[[spring]]\nrate = "10 N/mm"\npreload = "80 N"\n',
    )
    case = parse_case(one + two + LAW, "own-pair")
    assert [spring.name for spring in case.springs] == ["outer", "inner"]
    (run,) = simulate(case, models=["massless"], workers=1).solutions
    # without inner motion nothing surges: the static force is that of both springs
    lift = run.channel("valve_lift")
    assert run.channel("seat_force") == pytest.approx(330.0 + 40e3 * lift, rel=1e-9)
    assert run.quantities.get("surge_peak_force", 0.0) == pytest.approx(0.0, abs=1.0)
    with pytest.raises(InputError, match="both springs are named 'same'"):
        parse_case(one + 'name = "same"\n' + two + 'name = "same"\n' + LAW)


def test_a_refusal_speaks_of_no_time():
    study = simulate(
        parse_case(CARD + LAW, "own-card"), models=["massless", "wave-rod-clash"], workers=1
    )
    (sentence,) = study.failures
    assert "known by its card only" in sentence and "at time" not in sentence


def test_a_train_far_beyond_its_speed_keeps_every_variant_with_its_status():
    case = load_case("vaz-ohc", {"train.cycles": 6})
    study = simulate(
        case,
        engine_speeds=[9500 * RPM],
        models=["massless", "wave-rod"],
        spring_sets=["nested-cards"],
        workers=1,
    )
    for run in study.solutions:
        # how far a train flies is rounding: beyond the speed that wire bears, or not
        word = {"not-converged": "does not repeat", "diverged": "wire struck at"}[run.status.code]
        assert word in run.status.message and run.status.remedy
        assert run.quantities["float_excess_lift"] > 1e-3 and np.all(
            np.isfinite(list(run.quantities.values()))
        )
    assert len(study.failures) == 2
    swept = sweep(case, [9500 * RPM], models=["massless"], spring_sets=["nested-cards"], workers=1)
    assert swept.failures == ()  # in a sweep motion that does not settle is a finding


def test_a_run_is_found_by_its_own_speed_however_high():
    """An SI number may look like a slip of units to a reader; the speed of a run that exists is
    none.
    """
    study = simulate("job-t", "16000 rpm", models=["massless"])
    (speed,) = study.engine_speeds
    assert (
        study.solution("massless", speed)
        is study.solutions[0]
        is study.solution("massless", "16000 rpm")
    )
    assert (
        study.quantities.of_run("massless", speed)
        == study.quantities.of_run("massless", "16000 rpm")
        != {}
    )
    with pytest.raises(InputError, match="without a unit"):
        study.solution("massless", 1700.0)


def test_a_sweep_keeps_whole_solutions_where_asked():
    whole, reduced = (
        vt.sweep("job-t", "2000 rpm", models=["massless"], whole=whole).solutions[0]
        for whole in (True, False)
    )
    assert whole.channels.sizes["sample"] > 0 and not reduced.channels.data_vars
    assert whole.quantities["peak_spring_force"] == pytest.approx(
        reduced.quantities["peak_spring_force"], rel=1e-3
    )


def test_the_static_curve_of_a_spring_of_ones_own_follows_its_rate_until_coils_close():
    """F = G d^4 x / (8 D^3 n) with the active turns of the spring, within 5 % (curvature, ends that
    are not fixed).
    """
    spring = cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
    rate = spring.material.shear_modulus * 3.8e-3**4 / (8 * 22e-3**3 * spring.active_coils)
    for word in ("finite-element", "multi-mass", "massless"):
        curve = vt.static_curve(spring, "2 mm", models=word, steps=8)
        assert curve.force_at("1 mm") == pytest.approx(rate * 1e-3, rel=0.05)
    installed = vt.load_case("gu2021-beehive-blind").springs[0]
    by_case, by_spring = (
        vt.static_curve(one, "8 mm", models="multi-mass", steps=4)
        for one in ("gu2021-beehive-blind", installed)
    )
    assert (by_case.force == by_spring.force).all()


@pytest.mark.parametrize(
    ("wanted", "sentence"),
    [("30 mm", "solid at"), (8, "8 mm"), ("8 kg", "length"), ("0 mm", "positive")],
)
def test_a_static_curve_that_cannot_be_is_refused(wanted, sentence):
    with pytest.raises(vt.InputError, match=sentence):
        vt.static_curve(cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7), wanted)
