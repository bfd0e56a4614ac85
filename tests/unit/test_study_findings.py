"""Every rule on studies of points: one study in which it holds and one in which it does not; codes and fields, no sentences."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.explore.distributions import Uniform, Values
from valvetrain.explore.engine import Evaluation
from valvetrain.explore.outputs import Outputs
from valvetrain.explore.samplers import listed, sampler
from valvetrain.explore.space import Space, Varied
from valvetrain.explore.study import run_experiment
from valvetrain.explore.study_answer import StudyAnswer
from valvetrain.explore.study_facts import StudyFacts
from valvetrain.explore.study_rules import at_end_of_range
from valvetrain.explore.table import StudyTable
from valvetrain.findings.engine import judge
from valvetrain.findings.words import Words
from valvetrain.parameters.templates import template_text
from valvetrain.views.results import figures_of


def ramp(lash, width):
    """Touch on a ramp of 0.6, then on the flank; the lift falls with the lash."""
    speed = 0.1 + 0.1 * lash if lash <= 0.6 else 0.16 + 4 * (lash - 0.6)
    return {
        "seating_velocity": speed + 1e-6 * width,
        "peak_valve_lift": 1 - lash,
        "clash_energy": 1 - lash,
    }


def valley(lash, width):
    return {"seating_velocity": (lash - 0.5) ** 2 + 1e-3 * width, "clash_energy": 1.0}


def noise(lash, width):
    return {"seating_velocity": float(np.random.default_rng(int(1e9 * lash)).normal())}


def linear(lash, width):
    return {"seating_velocity": 1 + 10 * lash + width, "clash_energy": 2.0}


def tied(lash, width):
    return {"seating_velocity": float(lash > 0.5), "clash_energy": 2.0}


def breaks(lash, width):
    if lash > 0.7:
        raise ValueError("the coils overlap")
    return linear(lash, width)


def never(lash, width):
    raise ValueError("the coils overlap")


def space(**more) -> Space:
    return Space([Varied("lash", distribution=Uniform(0.0, 1.0), **more), Varied("width", distribution=Uniform(0.0, 1.0))])  # fmt: skip


def of_function(function, word: str, **options) -> StudyTable:
    names = ("seating_velocity", "clash_energy") if function is not noise else "seating_velocity"
    experiment = Evaluation(None, space(), Outputs(names, function=function))
    return run_experiment(experiment, sampler(word), options, workers=1)


def along_lash(function, count: int = 11) -> StudyTable:
    """A grid along the lash alone."""
    one = Space([Varied("lash", distribution=Values(tuple(np.linspace(0, 1, count)))), Varied("width")])  # fmt: skip
    experiment = Evaluation(
        None, one, Outputs(("seating_velocity", "clash_energy"), function=function)
    )
    return run_experiment(experiment, sampler("grid"), {}, workers=1)


SPRING = """
case = "job-c"
engine_speeds = "4000 rpm"
spring_models = "modal-uniform"
outputs = "peak_spring_force"
points = {{ sampler = "grid", levels = 3 }}
vary = [{{ key = "spring.precompression", low = "6 mm", high = "{} mm" }}]
"""


def barred(high: float) -> StudyTable:
    table = vt.study(SPRING.format(high), workers=1)
    assert table.error_bars
    return table


def without_output() -> StudyTable:
    table = of_function(linear, "grid", levels=3)
    values = table.values.copy()
    values[:, 1] = np.nan
    return replace(table, values=values)


def cards(load: str) -> StudyTable:
    """Springs of cards whose turns no spring has."""
    from valvetrain.parameters.loading import parse_case

    case = parse_case(template_text("pushrod", cards=True))
    one = Varied("train.springs.dual.0.open_load", "N", distribution=Values((1040.0, float(load))))
    experiment = Evaluation(case, Space([one]), Outputs("outer_card_rate", spring_set="dual"))
    return run_experiment(experiment, listed(np.array([[1040.0], [float(load)]])), {}, workers=1)


#: Name -> a study.
STUDIES = {
    "ramp": lambda: along_lash(ramp),
    "valley": lambda: along_lash(valley),
    "map": lambda: of_function(linear, "grid", levels=4),
    "tied": lambda: of_function(tied, "grid", levels=4),
    "draws": lambda: of_function(linear, "sobol", count=64),
    "sobol": lambda: of_function(linear, "saltelli", count=64),
    "noise": lambda: of_function(noise, "sobol", count=32),
    "still": lambda: of_function(
        lambda lash, width: {"seating_velocity": 1.0, "clash_energy": 1.0}, "sobol", count=16
    ),
    "breaks": lambda: of_function(breaks, "grid", levels=4),
    "never": lambda: of_function(never, "grid", levels=2),
    "without": without_output,
    "narrow": lambda: barred(6.0000001),
    "wide": lambda: barred(8.0),
    "doubtful": lambda: cards("500"),
    "sound": lambda: cards("1030"),
}


@cache
def table(name: str) -> StudyTable:
    return STUDIES[name]()


@cache
def answer(name: str) -> StudyAnswer:
    return StudyAnswer(table(name), words=Words())


#: Rule -> a study in which it holds, and one in which it does not. J111 and J133: see below.
RULES = {
    "J101": ("never", "breaks"), "J112": ("ramp", "valley"), "J113": ("valley", "ramp"), "J114": ("ramp", "valley"), "J120": ("still", "draws"),
    "J121": ("noise", "draws"), "J122": ("draws", "noise"), "J130": ("breaks", "map"), "J131": ("without", "map"),
    "J132": ("doubtful", "sound"), "J134": ("narrow", "wide"),
}  # fmt: skip


@pytest.mark.parametrize("code", RULES)
def test_a_rule_holds_where_it_should_and_nowhere_else(code):
    holds, not_there = RULES[code]
    assert code in answer(holds).findings.codes
    assert code not in answer(not_there).findings.codes
    assert all(one.text and one.code.startswith("J") for one in answer(holds).findings)


def test_points_within_the_error_bar_have_no_best():
    """Of a verdict that claims none, no point is marked, in the rows and in the figure."""
    no_best, best = answer("narrow"), answer("wide")
    assert no_best.verdict.code == "J134" and no_best.verdict.mark == "warn"
    assert not {"J111", "J112", "J113"} & {*no_best.findings.codes}
    shown = (no_best, best)
    assert [{one.mark for one in each.lines} for each in shown] == [{""}, {"", "ok"}]
    stars = [[one.name for one in next(iter(figures_of(each).values())).data] for each in shown]
    assert ["best" in names for names in stars] == [False, True]


def test_a_best_point_says_how_many_are_as_good():
    """Closed form: half of the 16 points have the least value of the step."""
    assert answer("tied").verdict.fields["near"] == "7 more"
    assert not answer("map").verdict.fields["near"]


def test_a_best_point_at_the_end_is_said_to_be_one_and_its_quantity_is_named_once():
    assert answer("wide").verdict.fields["end"] and not answer("valley").verdict.fields["end"]
    name = table("wide").plan.varied[0].shown_name
    assert [name in row.label for row in answer("wide").lines] == [True, False, False]


def test_points_that_differ_in_engine_speed_alone_have_no_best():
    text = """
    case = "job-c"
    spring_models = "massless"
    outputs = "peak_spring_force"
    points = { sampler = "grid", levels = 3 }
    vary = [{ key = "engine_speed", low = "2000 rpm", high = "4000 rpm" }]
    """
    assert StudyAnswer(vt.study(text, workers=1)).findings.codes == ("J111",)


def test_the_quantity_that_moves_the_draws_is_named_with_its_share_and_its_side():
    for name in ("draws", "sobol"):
        one = answer(name).verdict
        first, second = StudyFacts(table(name)).effects("seating_velocity")
        assert one.fields["leader"] == "lash" and one.fields["verb"] == "rises"
        assert first.varied.key == "lash" and first.share > 0.9 > second.high
        assert first.low <= first.share <= first.high
        low, high = one.fields["low"].value, one.value
        assert (low, high) == tuple(np.percentile(table(name).column("seating_velocity"), [5, 95]))


def test_what_moves_the_output_most_is_said_with_its_amount():
    """Closed form: over its range the lash changes 1 + 10 lash + width by 10."""
    first, *_ = StudyFacts(table("map")).effects("seating_velocity")
    assert first.varied.key == "lash" and first.change == pytest.approx(10)
    names = [row.label for row in answer("map").lines if row.remark]
    assert names == ["lash", "width"]  # the rows say what moves the best point, the most first
    assert answer("draws").verdict.fields["by"].value == pytest.approx(10, rel=0.1)


def test_the_edge_of_the_flat_part_is_that_of_the_function():
    """Closed form: the flank begins at 0.6, and a value of the next point is given."""
    one = answer("ramp").verdict
    assert one.fields["side"] == "up to" and one.fields["point"].endswith("0.6")
    assert one.value == pytest.approx(0.16, abs=1e-5)
    assert one.fields["reference"].value == pytest.approx(0.56, abs=1e-5)


def test_the_case_is_the_design_with_its_value_and_not_the_one_with_zero():
    """A grid with 0 in it named that design the case, whatever the case has (7 mm here)."""
    for values, place in (("0, 5, 7, 9", 2), ("0, 5, 9", None)):
        lengths = tuple(float(one) * 1e-3 for one in values.split(","))
        one = Space([Varied("spring.precompression", "mm", distribution=Values(lengths))])
        experiment = Evaluation("job-c", one, Outputs("preload", rest_model="massless"))
        facts = StudyFacts(run_experiment(experiment, sampler("grid"), {}, workers=1))
        assert facts.ends.get("case") == place


def test_zero_lash_is_no_choice():
    best = StudyFacts(along_lash(lambda lash, width: {"seating_velocity": lash, "clash_energy": 1.0})).ends  # fmt: skip
    assert best["best"] == 0  # a function has no lash of a train
    one = Space([Varied("train.lash", "mm", distribution=Values((0.0, 1e-4, 2e-4)))])
    values = np.array([[0.1], [0.2], [0.3]])
    plan = replace(table("map").plan, experiment=Evaluation(None, one, Outputs("seating_velocity", function=linear)))  # fmt: skip
    made = replace(table("map"), plan=plan, inputs=1e-4 * np.array([[0.0], [1.0], [2.0]]), values=values,
                   runs=plan.runs * 3, statuses=table("map").statuses[:3])  # fmt: skip
    assert StudyFacts(made).ends["best"] == 1
    assert not at_end_of_range(StudyFacts(made), 1)  # a lower value was tried


def test_a_finding_has_its_numbers_in_si_and_another_system_of_units():
    facts = StudyFacts(table("wide"))
    si, other = (judge(facts, answer_rules(), Words(units)) for units in ("si", "imperial"))
    assert si.codes == other.codes and si[0].value == other[0].value and si[0].text == other[0].text
    assert si[0].reason != other[0].reason


def answer_rules():
    from valvetrain.explore.study_rules import RULES as rules

    return rules


def test_the_step_runs_the_best_point_again():
    step = answer("wide").next_step
    assert (
        step
        == "valvetrain run job-c --set 'spring.precompression=6 mm' --rpm 4000 --model modal-uniform"
    )


@pytest.mark.parametrize("name", sorted(STUDIES))
def test_rows_and_columns_fit_and_the_first_figure_can_be_drawn(name):
    shown = answer(name)
    assert len(shown.lines) <= 12 and {len(one.cells) for one in shown.lines} <= {
        len(shown.headings)
    }
    assert all(len(row) == len(one.columns) for one in shown.tables().values() for row in one.rows)
    figures = figures_of(shown)
    assert bool(figures) == (name not in ("never",))
    assert all(fig.data and len(fig.data[0].x) for fig in figures.values())
