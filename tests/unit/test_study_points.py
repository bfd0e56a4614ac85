"""A point of a study: a quantity varied as the case file would have it, and the same bits as a run
of that case.
"""

from __future__ import annotations

import math
import shlex
from dataclasses import replace

import pytest

from unit.cli_parts import SMALL
from valvetrain import InputError, load_case, simulate, study
from valvetrain.errors import UnusualValueWarning
from valvetrain.explore.case_paths import nominal, vary
from valvetrain.explore.distributions import LogNormal, Normal, Uniform, Values
from valvetrain.explore.engine import Evaluation
from valvetrain.explore.evaluate import evaluate
from valvetrain.explore.outputs import Outputs, Run
from valvetrain.explore.space import ENGINE_SPEED, Space, Varied
from valvetrain.explore.study_facts import StudyFacts
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.quantities.request import LIGHT, PointRequest

RPM, LBF = math.pi / 30, 4.4482216152605
BEEHIVE = load_case("gu2021-beehive-blind")


def parts(case):
    return case.springs, case.lift_law, case.operation, case.train, case.published, case.notes


@pytest.mark.parametrize(
    ("key", "value", "unit", "text"),
    [
        ("spring.wire_diameter", 3.7e-3, "mm", "0.0037 m"),
        ("spring.total_coils", 7.25, "", 7.25),
        ("spring.material.shear_modulus", 80e9, "GPa", "80000000000.0 Pa"),
        ("lift_law.maximum_lift", 9e-3, "mm", "0.009 m"),
        ("spring.damping.ratio", 0.02, "", 0.02),
        ("spring.options.multi-mass.masses_per_coil", 16.0, "", 16),
        ("operation.cycles", 3.0, "", 3),
    ],
)
def test_a_varied_value_is_what_set_on_the_command_line_gives(key, value, unit, text):
    varied = vary(BEEHIVE, {Varied(key, unit): value})
    read = load_case("gu2021-beehive-blind", {key: text})
    assert parts(varied)[:5] == parts(read)[:5] and varied != BEEHIVE
    assert key in varied.changed


def test_a_factor_scales_every_knot_of_a_curve_and_an_offset_shifts_it():
    wide = vary(
        BEEHIVE, {Varied("spring.mean_diameter", operation="factor"): 1.01}
    ).spring.mean_diameter
    assert wide.values == pytest.approx(
        [1.01 * one for one in BEEHIVE.spring.mean_diameter.values], rel=1e-12
    )
    wide = vary(
        BEEHIVE, {Varied("spring.mean_diameter", "mm", "offset"): 2e-4}
    ).spring.mean_diameter
    assert wide.values == pytest.approx(
        [one + 2e-4 for one in BEEHIVE.spring.mean_diameter.values], rel=1e-12
    )


def test_a_factor_on_the_gaps_leaves_closed_coils_closed():
    """The file of the beehive tells its pitch by clearances: the pitch less the wire."""
    spread = vary(BEEHIVE, {Varied("spring.pitch.clearances", operation="factor"): 1.1}).spring
    before = BEEHIVE.spring
    for coil in (0.5, 2.0, 4.0):
        gaps = [
            float(one.pitch.value(coil) - one.wire_diameter.value(coil)) for one in (spread, before)
        ]
        assert gaps[0] == pytest.approx(1.1 * gaps[1], abs=1e-12)
    assert float(spread.pitch.value(0.0)) == float(before.pitch.value(0.0))


def test_one_place_of_a_row_of_numbers_can_be_varied():
    moved = vary(BEEHIVE, {Varied("spring.pitch.coils.2", operation="offset"): 0.05}).spring.pitch
    assert moved.coils[2] == pytest.approx(1.175)
    wider = vary(
        BEEHIVE, {Varied("spring.mean_diameter.values.2", "mm"): 17e-3}
    ).spring.mean_diameter
    assert wider.values == (*BEEHIVE.spring.mean_diameter.values[:2], 17e-3)


def test_a_set_of_springs_in_a_train_is_varied_by_its_place():
    train = load_case("tdi-pushrod")
    stiff = vary(train, {Varied("train.springs.stock.0.preload", operation="factor"): 1.1}).train
    assert stiff.springs["stock"][0].card.preload == pytest.approx(
        1.1 * train.train.springs["stock"][0].card.preload, rel=1e-12
    )
    assert stiff.springs["performance"] == train.train.springs["performance"]


def test_a_case_that_a_program_changed_part_by_part_is_refused():
    """Its text no longer gives it, so what follows from a value could not follow a change of it."""
    case = BEEHIVE.replace(springs=(replace(BEEHIVE.springs[0], precompression=6.5e-3),))
    with pytest.raises(InputError):
        vary(case, {Varied("spring.precompression", "mm", "offset"): 1e-4})
    with pytest.raises(InputError):
        Evaluation(case, Space({"spring.precompression": [6e-3]}), Outputs("preload"))
    assert vary(case, {Varied(ENGINE_SPEED, "rpm"): 700.0}) is case


@pytest.mark.parametrize("key", ["operation.engine_speeds", "operation.cam_speeds"])
def test_speeds_of_a_case_are_not_varied_without_effect(key):
    """The runs of a study have speeds of their own: every point would be the same run."""
    with pytest.raises(InputError, match=ENGINE_SPEED):
        Evaluation(BEEHIVE, Space({key: [500.0, 600.0]}), Outputs("peak_spring_force"))


@pytest.mark.parametrize(
    ("name", "file_key", "object_key", "value", "unit"),
    [
        ("gu2021-beehive-blind", "spring.wire_diameter", "springs.0.wire.wire_diameter", 3.8e-3, "mm"),
        ("gu2021-beehive-blind", "spring.precompression", "springs.0.precompression", 6e-3, "mm"),
        ("vaz-ohc", "train.springs.nested.1.wire_diameter", "train.springs.nested.1.wire.wire_diameter", 2.5e-3, "mm"),
    ],
)  # fmt: skip
def test_keys_of_files_and_of_case_objects_name_the_same_value(
    name, file_key, object_key, value, unit
):
    for case in (load_case(name), load_case(name, {"operation.cycles": 3})):
        one, other = (vary(case, {Varied(key, unit): value}) for key in (file_key, object_key))
        assert parts(one) == parts(other) and parts(one) != parts(case)
        assert nominal(case, Varied(file_key, unit)) == nominal(case, Varied(object_key, unit))


@pytest.mark.parametrize(
    ("varied", "value", "words"),
    [
        (Varied("spring.wire_diametr", operation="factor"), 1.1, "did you mean wire_diameter"),
        (Varied("spring.wire_diameter", "mm"), 30e-3, ""),
        (Varied("spring.wire_diameter", "N"), 3e-3, "length"),
        (Varied("spring.hand", operation="factor"), 2.0, "no number with a unit"),
        (Varied("spring.material", operation="factor"), 2.0, "name one of its parts"),
        (Varied("spring.wire_diameter", operation="offset"), 1e-4, "unit of the same kind"),
        (Varied("spring.total_coils", "mm", "offset"), 1e-4, "plain number"),
        (Varied("title", operation="factor"), 2.0, "quantity that moves"),
        (Varied("spring.total_coils.3"), 2.0, "plain value"),
        (Varied("operation.engine_speeds.9", "rpm"), 2.0, "no place in a list"),
    ],
)
def test_what_cannot_be_varied_is_refused_with_one_sentence(varied, value, words):
    with pytest.raises(InputError) as caught:
        vary(BEEHIVE, {varied: value})
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "operation", "unit", "words"),
    [
        ("", "value", "", "no key"),
        ("a..b", "value", "", "no key"),
        ("a", "times", "", "value, factor or offset"),
        ("a", "factor", "mm", "plain number"),
        ("a", "value", "parsec per fortnight", "nit"),
    ],
)
def test_a_varied_quantity_that_makes_no_sense_is_refused(key, operation, unit, words):
    with pytest.raises(InputError, match=words):
        Varied(key, unit, operation)


@pytest.mark.parametrize(
    "build",
    [
        lambda: Uniform(2.0, 1.0),
        lambda: Uniform(math.nan, 1.0),
        lambda: Normal(0.0, 0.0),
        lambda: Normal(0.0, 1.0, 3.0, 2.0),
        lambda: Normal(0.0, 1.0, 50.0, 60.0),
        lambda: LogNormal(-1.0, 2.0),
        lambda: LogNormal(1.0, 1.0),
        lambda: Values(()),
        lambda: Values((math.inf,)),
    ],
)
def test_a_distribution_that_makes_no_sense_is_refused(build):
    with pytest.raises(InputError):
        build()


def test_what_stands_in_the_case_is_found_in_whatever_form():
    assert nominal(BEEHIVE, Varied("spring.wire_diameter", "mm")) == 3.7709e-3
    assert nominal(BEEHIVE, Varied("spring.pitch", operation="factor")) == 1.0
    assert nominal(BEEHIVE, Varied("spring.mean_diameter", "mm", "offset")) == 0.0
    assert nominal(BEEHIVE, Varied("spring.mean_diameter.values.2", "mm")) == pytest.approx(
        17.5931e-3, rel=1e-12
    )
    for key in ("spring.pitch", "spring.nothing"):
        with pytest.raises(InputError):
            nominal(BEEHIVE, Varied(key, "mm"))


def numbers(case, model, engine_speed, outputs=(), values=(), spring_set="", rest_model=""):
    return evaluate(
        case,
        dict(values),
        Run(engine_speed, model, spring_set),
        PointRequest(tuple(outputs), rest_model),
    )


@pytest.mark.parametrize("model", ["multi-mass", "wave-rod-clash", "modal-varied"])
def test_a_point_has_the_bits_of_a_run_of_the_varied_case(model):
    values = (
        (Varied("spring.wire_diameter", "mm"), 3.75e-3),
        (Varied("spring.pitch.clearances", operation="factor"), 1.01),
    )
    run = simulate(vary(BEEHIVE, dict(values)), 6000 * RPM, models=[model])
    (solution,) = run.solutions
    every = numbers(BEEHIVE, model, 6000 * RPM, values=values)
    assert every.status == solution.status
    assert {name: every.values.get(name) for name in solution.quantities} == dict(
        solution.quantities
    )
    assert {name: every.values.get(name) for name in run.still[""]} == run.still[""]
    few = numbers(BEEHIVE, model, 6000 * RPM, sorted(LIGHT), values)
    asked = {name: value for name, value in solution.quantities.items() if name in LIGHT}
    assert few.values == asked and len(asked) > 10


@pytest.mark.parametrize("chosen", ["stock", "performance"])
def test_a_point_of_a_train_has_the_bits_of_its_run(chosen):
    case, model = load_case("tdi-pushrod"), "massless"
    (solution,) = simulate(case, 5000 * RPM, models=[model], spring_sets=[chosen]).solutions
    found = numbers(case, model, 5000 * RPM, spring_set=chosen)
    assert {name: found.values.get(name) for name in solution.quantities} == dict(
        solution.quantities
    )


def test_numbers_at_rest_come_from_the_model_asked_for():
    """Preload and rate are those of ``valvetrain static --model multi-mass``; without a model
    those of the rod, as in a run.
    """
    from valvetrain.runs.requests import Modes
    from valvetrain.runs.static_study import static_study

    case = parse_case(SMALL)
    told = ("preload", "installed_rate", "mode_1_frequency")
    static = static_study(Modes(case=case, models=("multi-mass",), count=12)).still[""]
    chain = numbers(case, "multi-mass", None, told, rest_model="multi-mass")
    assert [chain.values[name] for name in told] == [static[name] for name in told]
    rod = numbers(case, "multi-mass", None, told)
    assert (
        rod.values["preload"] == pytest.approx(chain.values["preload"], rel=0.02)
        and rod.values["preload"] != chain.values["preload"]
    )


def test_a_varied_engine_speed_is_the_speed_of_the_run():
    speed = ((Varied(ENGINE_SPEED, "rpm"), 6000 * RPM),)
    wanted = ("peak_spring_force",)
    assert numbers(BEEHIVE, "massless", None, wanted, speed) == numbers(
        BEEHIVE, "massless", 6000 * RPM, wanted
    )


@pytest.mark.parametrize(
    ("values", "code", "words"),
    [
        (((Varied("spring.wire_diameter", "mm"), 30e-3),), "refused", ""),
        (((Varied("lift_law.maximum_lift", "mm"), 40e-3),), "refused", "coil bind"),
        (((Varied(ENGINE_SPEED, "rpm"), -1.0),), "refused", "positive"),
    ],
)
def test_a_point_that_cannot_be_keeps_its_status_and_sentence(values, code, words):
    found = numbers(BEEHIVE, "multi-mass", 6000 * RPM, ("peak_spring_force",), values)
    assert found.status.code == code and words in found.status.sentence() and not found.values


def test_a_warning_of_a_trial_names_its_values_and_one_of_the_case_does_not():
    """Which of the trials a card warning was about could not be told."""
    text = template_text("pushrod", cards=True)
    case = parse_case(text)
    key = "train.springs.dual.0.open_load"
    with pytest.warns(UnusualValueWarning) as caught:
        vary(case, {Varied(key, "lbf", label="open load"): 420 * LBF})
    (told,) = {str(one.message) for one in caught}
    assert told.startswith(
        "at open load = 420 lbf: spring 'outer' of set 'dual': rate, wire and coil diameter"
    )
    with pytest.warns(UnusualValueWarning):
        doubtful = parse_case(text.replace('open_load = "234 lbf"', 'open_load = "420 lbf"'))
    with pytest.warns(UnusualValueWarning) as caught:
        vary(doubtful, {Varied("train.valve.mass", "g"): 0.12})
    assert not any(str(one.message).startswith("at ") for one in caught)


def test_keys_that_move_alike_are_each_varied_and_the_step_sets_every_one():
    keys = ["spring.precompression", "spring.wire_diameter"]
    table = study(f"""
case = "job-c"
engine_speeds = "4000 rpm"
spring_models = "massless"
outputs = "peak_spring_force"
vary = [{{ key = {keys}, as = "factor", values = "1, 1.02" }}]
""", workers=1)  # fmt: skip
    (both,) = table.plan.varied
    assert both.also == tuple(keys[1:])
    one_by_one = vary(table.plan.case, {Varied(key, operation="factor"): 1.02 for key in keys})
    assert parts(vary(table.plan.case, {both: 1.02})) == parts(one_by_one)
    (run,) = simulate(one_by_one, "4000 rpm", models=["massless"]).solutions
    assert table.column("peak_spring_force")[1] == run.quantities["peak_spring_force"]
    words = shlex.split(StudyFacts(table).command(1))
    assert [word.partition("=")[0] for word in words if "=" in word] == keys
    with pytest.raises(InputError, match="moves alone"):
        Varied("spring.precompression", also=(ENGINE_SPEED,))
