"""Unit: every sentence on what a search found, each of its cases once, from made-up numbers."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.explore import optimum_summary as said
from valvetrain.explore.doubts import Doubts
from valvetrain.explore.measure import BELOW, BEYOND, FOUND, LimitFound, Measure, Objective
from valvetrain.explore.outputs import LimitSearch
from valvetrain.explore.space import Varied
from valvetrain.parameters.templates import template_text

RPM = np.pi / 30
MASS = Measure("rest", "wire_mass", (), "wire mass")
SPEED = Measure(
    "limit",
    "minimum_spring_force",
    (),
    "limit speed",
    limit=LimitSearch("minimum_spring_force", False, 0.0, (), RPM),
)
VARIED = tuple(Varied(words, "mm") for words in ("wire", "coil", "pitch"))


def trial(*objectives: float, **changes: object) -> SimpleNamespace:
    told = {
        "number": 7, "objectives": objectives, "feasible": True, "failure": "", "missed": (), "seed": 1, "values": (4e-3, 22e-3, 7e-3),
        "measured": SimpleNamespace(limits={}), "floating": None, "penalties": (0.02, 0.135), "constraints": (0.4, 0.5), "plan": None,
    }  # fmt: skip
    return SimpleNamespace(**told | changes)


def bracket(kind: str, low: float, high: float) -> SimpleNamespace:
    return SimpleNamespace(limits={SPEED: (LimitFound(kind, low * RPM, high * RPM),)})


def design(
    one: SimpleNamespace | None = None, steps: tuple = (), confirmed: tuple = ()
) -> SimpleNamespace:
    return SimpleNamespace(trial=one or trial(0.04), steps=steps, confirmed=confirmed, valley=None)


def step(place: int, improves: bool, objective: float = 0.04) -> SimpleNamespace:
    return SimpleNamespace(index=place, improves=improves, objectives=(objective,))


def search(
    goals: tuple[Measure, ...] = (MASS,), maximise: bool = False, **changes: object
) -> SimpleNamespace:
    plan = SimpleNamespace(
        objectives=tuple(Objective(one, maximise) for one in goals),
        constraints=(),
        varied=VARIED,
        case=None,
    )
    told = {
        "plan": plan, "best": design(), "case": trial(0.05, number=0), "finished": True, "trials": [trial(0.05)] * 41, "feasible": 9,
        "front": (), "best_by_seed": {1: 0.04}, "missed_by_least": None,
        "active": lambda _trial: (), "at_ends": lambda _trial: (),
    }  # fmt: skip
    told |= changes
    last = told["best"].trial.objectives[0] if told["best"] else np.nan
    return SimpleNamespace(**{"history": lambda _seed: np.full(41, last)} | told)


@pytest.fixture(autouse=True)
def bounds(monkeypatch):
    """A bound in words is its number."""
    monkeypatch.setattr(said, "bound_label", lambda _plan, place: f"bound {place}")


@pytest.mark.parametrize(
    ("value", "before", "told"),
    [
        (0.04, 0.05, "−10 g, −20.0 %"),
        (0.05, 0.04, "+10 g, +25.0 %"),
        (0.04, 0.0, "+40 g"),
        (-0.01, 0.04, "−50 g"),
        (0.04, np.nan, "+nan g"),
    ],
)
def test_a_difference_has_its_sign_and_a_share_where_that_says_something(value, before, told):
    assert said.change(MASS, value, before) == told
    assert (
        said.reported(MASS, np.nan) == "no number" and said.reported(MASS, -0.0123456) == "−12.35 g"
    )
    assert said.reported(SPEED, 8123.4 * RPM) == "8123 rpm"


CASE = "The case itself meets every bound."
ANSWERS = {
    "a better one": ({}, "Within all bounds the wire mass falls from 50 g of the case to 40 g (−10 g, −20.0 %)."),
    "a larger one": ({"case": trial(0.032)}, "Within all bounds the wire mass rises from 32 g of the case to 40 g (+8 g, +25.0 %)."),
    "the case": ({"best": design(trial(0.05, number=0))}, "None of 40 trials beats the case itself, whose wire mass is 50 g."),
    "a case that misses": ({"case": trial(0.05, feasible=False, missed=(0.0, 0.1, 0.2))},
                           "The least that meets every bound: wire mass 40 g. The case itself misses: bound 1; bound 2."),
    "a case that fails": ({"case": trial(np.nan, feasible=False, failure="coils overlap"), "maximise": True},
                          "The most that meets every bound: wire mass 40 g. The case itself cannot be computed: coils overlap."),
    "beyond what was searched": (
        {"goals": (SPEED,), "maximise": True, "case": trial(7000 * RPM, measured=bracket(FOUND, 7000, 7010)),
         "best": design(trial(9000 * RPM, measured=bracket(BEYOND, 9000, 9000)))},
        "Within all bounds the limit speed rises from 7000 rpm of the case to 9000 rpm or more (at least +2000 rpm, +28.6 %)."),
    "a case below what was searched": (
        {"goals": (SPEED,), "maximise": True, "case": trial(3000 * RPM, measured=bracket(BELOW, 3000, 3000)),
         "best": design(trial(6000 * RPM, measured=bracket(FOUND, 6000, 6010)))},
        "Within all bounds the limit speed rises from below 3000 rpm of the case to 6000 rpm (+3000 rpm, +100.0 %)."),
    "a front": ({"goals": (MASS, SPEED), "front": (trial(0.05, 8000 * RPM), trial(0.04, 7000 * RPM))},
                f"2 designs beat each other in nothing: wire mass 40 g to 50 g; limit speed 7000 rpm to 8000 rpm. {CASE}"),
    "nothing": ({"best": None, "missed_by_least": (trial(0.04, number=5), "preload")},
                "No trial meets every bound. Trial 5 comes nearest; it misses 'preload' by 14 % of the bound: "
                "loosen that bound, or widen the ranges."),
    "nothing by far": ({"best": None, "missed_by_least": (trial(0.04, number=0, penalties=(1.0, 0.2)), "preload")},
                "No trial meets every bound. Trial 0 comes nearest; it misses 'preload' by 100 % of the bound: "
                "loosen that bound, or widen the ranges."),
    "nothing computed": ({"best": None, "trials": [trial(np.nan, failure="no wire")] * 3}, "None of 3 trials could be computed: no wire"),
}  # fmt: skip


@pytest.mark.parametrize("name", ANSWERS)
def test_the_answer_comes_first(name):
    changes, told = ANSWERS[name]
    found = search(**changes)
    assert said.answer(found) == told == said.sentences(found)[0]
    assert "e+" not in told
    stopped = said.sentences(search(**changes, finished=False))
    assert stopped[0] == f"The search was stopped after {len(found.trials) - 1} trials. {told}"


def by(label: str, case: float, best: float) -> SimpleNamespace:
    """What a model of a name says of the case and of the best design."""
    return SimpleNamespace(label=label, case=trial(case), design=trial(best))


@pytest.mark.parametrize(
    ("confirmed", "told"),
    [
        ((by("rod", 0.05, 0.0405), by("mesh", 0.05, 0.04)), "Within all bounds the wire mass falls from"),
        (
            (by("rod", 0.05, 0.044), by("mesh", 0.05, 0.046), by("lost", 0.05, np.nan)),
            "Confirmed is a change of the wire mass of −4 g, −8.0 % by mesh (−6 g, −12.0 % by rod); by the model of the search the wire "
            "mass falls from 50 g of the case to 40 g (−10 g, −20.0 %).",
        ),
        (
            (by("rod", 0.05, 0.052), by("mesh", 0.05, 0.046)),
            "No gain is confirmed by every model: of the wire mass +2 g, +4.0 % by rod and −4 g, −8.0 % by mesh; by the model of the search "
            "the wire mass falls from",
        ),
    ],
)  # fmt: skip
def test_the_answer_leads_with_the_least_gain_that_other_models_confirm(confirmed, told):
    assert said.answer(search(best=design(confirmed=confirmed))).startswith(told)


STILL = "A small step still improves it ({}): more trials will find more."
DONE = "Small changes of one quantity no longer improve it within the bounds."
LATE = "The best value came with trial {} of 40: more trials may find more."
NARROW = "It is narrow: a hundredth of one range away the wire mass is {}, so count on {}."


def rise(came: int, last: float = 0.04) -> dict:
    """The best so far by trial, its last value from trial ``came`` on."""
    return {
        "history": lambda seed: (
            np.where(np.arange(41) < came, 0.05, last) if seed == 1 else np.full(41, 0.04)
        )
    }


STEPS = {
    "none was tried": (design(), {}, []),
    "none improves": (design(steps=(step(0, False), step(1, False))), {}, [DONE]),
    "two improve, one of them both ways": (
        design(steps=(step(2, True), step(2, True), step(0, True), step(1, False))), {}, [STILL.format("pitch, wire")]),
    "found at nine tenths": (design(), rise(36), []),
    "found late": (design(), rise(37), [LATE.format(37)]),
    "found late by a search that was stopped": (design(), {**rise(37), "finished": False}, []),
    "found late, a step improves": (design(steps=(step(0, True),)), rise(40), [STILL.format("wire")]),
    "the case is best": (design(trial(0.05, number=0)), rise(40, 0.05), []),
    "late in another search of its own seed": (design(trial(0.04, seed=2)), rise(40), []),
    "a front": (design(trial(0.04, 700.0)), {**rise(40), "goals": (MASS, SPEED)}, []),
    "just not narrow": (design(steps=(step(0, False, 0.0449), step(1, False, 0.041))), {}, [DONE]),
    "narrow": (design(steps=(step(0, False, 0.0451), step(1, False, 0.041), step(2, False, np.nan))), {},
               [DONE, NARROW.format("45.1 g to 41 g", "45.1 g")]),
    "narrow beside a case that misses": (design(steps=(step(0, False, 0.0451),)), {"case": trial(0.05, feasible=False)}, [DONE]),
    "narrow without a gain": (design(steps=(step(0, False, 0.0451),)), {"case": trial(0.04)}, [DONE]),
    "narrow at the top": (design(trial(0.06), (step(0, False, 0.054), step(1, False, 0.059))), {"maximise": True},
                          [DONE, NARROW.format("54 g to 59 g", "54 g")]),
}  # fmt: skip


@pytest.mark.parametrize("name", STEPS)
def test_how_far_the_best_can_be_trusted_by_its_steps_and_its_place_in_the_search(name):
    best, changes, told = STEPS[name]
    assert said.trust(search(best=best, **changes))[1:] == tuple(told)


def test_counts_bounds_ends_and_limits_are_told():
    assert said.trust(search())[0] == "9 of 41 designs, the case among them, meet every bound."
    failed = search(
        trials=[trial(0.05), trial(np.nan, failure="no"), trial(np.nan, failure="no")], best=None
    )
    assert said.trust(failed) == (
        "9 of 3 designs, the case among them, meet every bound, 2 could not be computed.",
    )
    found = search(active=lambda _trial: (0, 2), at_ends=lambda _trial: ((0, "low"), (1, "high")))
    assert said.trust(found)[1:] == (
        "What limits it: bound 0; bound 2.",
        "The wire is at the lower end of its range, 4 mm: widen the range.",
        "The coil is at the upper end of its range, 22 mm: widen the range.",
    )
    for kind, told in (
        (FOUND, ("The limit speed is between 8000 and 8010 rpm.",)),
        (BELOW, ()),
        (BEYOND, ("The bound is met up to the highest speed searched, 8000 rpm: search higher.",)),
    ):
        best = design(trial(8000 * RPM, measured=bracket(kind, 8000, 8010)))
        assert said.trust(search((SPEED,), best=best))[1:] == told


def test_another_model_beside_the_search():
    def confirmed(one: SimpleNamespace, case: SimpleNamespace, *goals: Measure) -> SimpleNamespace:
        plan = SimpleNamespace(
            objectives=tuple(Objective(goal, False) for goal in goals or (MASS,)),
            constraints=(SimpleNamespace(measure=MASS),),
        )
        return SimpleNamespace(label="rod", design=one, case=case, plan=plan)

    best, found = trial(0.04), search()
    rows = {
        "By rod: wire mass 41 g against 52 g of the case (−11 g, −21.2 %), where the search has 40 g. All bounds are met.":
            confirmed(trial(0.041), trial(0.052)),
        "By rod: wire mass 41 g against 52 g of the case (−11 g, −21.2 %), where the search has 40 g. "
        "It misses: bound 0, it has 400 g; bound 1.": confirmed(trial(0.041, missed=(0.1, 0.2)), trial(0.052)),
        "By rod, the design cannot be computed: no wire": confirmed(trial(np.nan, failure="no wire"), trial(0.052)),
        "By rod, the case cannot be computed: no rest": confirmed(trial(0.041), trial(np.nan, failure="no rest")),
    }  # fmt: skip
    assert [said.confirmed_text(one, found) for one in rows.values()] == list(rows)
    assert said.trust(search(best=design(best, confirmed=tuple(rows.values()))))[1:] == tuple(rows)
    beyond = confirmed(
        trial(9000 * RPM, measured=bracket(BEYOND, 9000, 9000)),
        trial(7000 * RPM, measured=bracket(FOUND, 7000, 7010)),
        SPEED,
    )
    fast = search((SPEED,), best=design(trial(8800 * RPM, measured=bracket(FOUND, 8800, 8810))))
    told = (
        "limit speed 9000 rpm or more against 7000 rpm of the case, where the search has 8800 rpm"
    )
    assert said.confirmed_text(beyond, fast) == f"By rod: {told}. All bounds are met."


def test_what_designs_as_good_leave_open_is_in_the_verdict_and_no_end_to_widen(monkeypatch):
    """A seat load at the end of its range stood as found, with the advice to widen it."""
    monkeypatch.setattr(said, "best_values", lambda _found: "")
    values = np.array([[4e-3, 22e-3, 7e-3], [4e-3, 18e-3, 7e-3]])
    best = design()
    best.valley = SimpleNamespace(values=values, objectives=np.array([0.04, 0.0401]), open=(1,), ends=lambda _place: (1, 0))  # fmt: skip
    found = search(best=best, at_ends=lambda _trial: ((1, "high"), (2, "low")))
    assert "; coil 18 to 22 mm does as well within 1 %" in said.optimum_verdict(found)
    told = " ".join(said.trust(found))
    assert "pitch is at the lower end" in told and "coil is at the upper end" not in told


def test_another_model_of_an_objective_that_was_put_in_tells_what_is_bounded(monkeypatch):
    """It told the open load that the search had varied, by each model the same."""
    monkeypatch.setattr(said, "same_as_varied", lambda _found, _index: 0)
    bounded = (SimpleNamespace(measure=MASS),) * 2
    plan = SimpleNamespace(objectives=(Objective(MASS, False),), constraints=bounded)
    other = trial(0.04, constraints=(0.4, 0.45))
    one = SimpleNamespace(label="wave-rod", design=other, case=other, plan=plan)
    told = said.confirmed_text(one, search())
    assert told == "By wave-rod: wire mass 450 g, where the search has 500 g. All bounds are met."


def test_what_the_case_misses_stands_behind_what_is_said_of_the_best(monkeypatch):
    """Contract: two thoughts ran together, "the case misses ...; seat load ... does as well"."""
    monkeypatch.setattr(said, "best_values", lambda _found: "coil 22 mm")
    monkeypatch.setattr(said, "_limited", lambda _found: "; bound 1 limits it")
    found = search(case=trial(0.05, feasible=False, missed=(0.0, 0.1)))
    assert said.optimum_verdict(found) == (
        "The least that meets every bound: wire mass 40 g, with coil 22 mm; bound 1 limits it. The case itself misses: bound 1."
    )


def test_doubtful_designs_are_counted_once(monkeypatch):
    """Contract: a line each, some twice, hid the answer."""
    counted = Doubts({3: "at wire = 4 mm: few turns", 5: "at wire = 5 mm: few turns"}, 41)
    monkeypatch.setattr(said, "doubts", lambda *_: counted)
    lines = said.trust(search())
    told = "2 of 41 designs are doubtful, but not the best, such as at wire = 4 mm: few turns."
    assert lines[1] == told and sum("doubtful" in one for one in lines) == 1


def test_a_best_design_that_is_doubtful_says_so_in_the_verdict(monkeypatch):
    """Contract: "30 of 51 designs are doubtful, the best among them" stood lines above the answer."""
    monkeypatch.setattr(said, "best_values", lambda _found: "")
    doubt = Doubts({0: "at wire = 4 mm, coil = 22 mm: few turns; count them."}, 1)
    monkeypatch.setattr(said, "doubts", lambda *_: doubt)
    told = said.optimum_verdict(search())
    assert told.endswith("(−10 g, −20.0 %); the best design is doubtful: few turns.")
    long = "at coil = 22 mm: spring 'outer' of set 'dual': rate and wire make 1.7 turns, of some 3.7: are these the loads of a pair? Then enter both"
    monkeypatch.setattr(said, "doubts", lambda *_: Doubts({0: long}, 1))
    told = said.optimum_verdict(search())
    assert told.endswith(
        "; the best design is doubtful: spring 'outer' of set 'dual': rate and wire make 1.7 turns, of some 3.7."
    )
    monkeypatch.setattr(said, "doubts", lambda *_: Doubts({}, 1))
    assert "doubtful" not in said.optimum_verdict(search())


def test_the_cause_that_nothing_was_computed_is_the_cases_own_else_the_commonest():
    """Contract: the last trial's own refusal stood for a case that lacked the quantity."""
    failed = [trial(np.nan, failure=text) for text in ("no load", "no load", "check wires")]
    told = "None of 3 trials could be computed: {}"
    assert said.answer(search(best=None, trials=failed)) == told.format("no load")
    case = trial(np.nan, failure="no run gave it")
    assert said.answer(search(best=None, trials=failed, case=case)) == told.format("no run gave it")


PAIR = """
[[train.springs.both]]
loads_of = "pair"
preload = "135 lbf"
installed_height = "1.80 in"
open_load = "336 lbf"
open_height = "1.25 in"
solid_height = "1.09 in"
wire_diameter = "0.192 in"
outer_diameter = "1.44 in"

[[train.springs.both]]
loads_of = "pair"
solid_height = "0.90 in"
wire_diameter = "0.130 in"
outer_diameter = "1.03 in"
"""


def test_loads_of_a_pair_and_of_its_outer_spring_are_told_apart_in_one_unit(tmp_path):
    """Contract: three open loads in N and lbf, none marked outer or pair; the rate of the pair is the
    difference of its loads over the lift.
    """
    case, loads = tmp_path / "pair.toml", "train.springs.both.0"
    case.write_text(template_text("pushrod", cards=True) + PAIR, encoding="utf-8")
    found = vt.optimise(
        f"""
case = "{case.as_posix()}"
spring_sets = ["both"]
objective = [{{ quantity = "outer_card_open_force", direction = "minimise", label = "open load" }}]
search = {{ trials = 4, per_round = 2 }}
vary = [
    {{ key = "{loads}.preload", low = "120 lbf", high = "140 lbf", label = "seat load" }},
    {{ key = "{loads}.open_load", low = "300 lbf", high = "336 lbf", label = "open load" }},
]
""",
        workers=1,
    )
    told = found.verdict
    assert told.startswith(
        "Within all bounds the open load of the outer spring falls from 236.9 lbf of the case to "
    )
    number = r"[\d.]+"
    pair = f"pair: seat load ({number}) lbf, open load ({number}) lbf, rate ({number}) lbf/in"
    outer = f"outer spring: seat load {number} lbf, rate {number} lbf/in"
    loads = re.search(f", with {pair}, {outer}[.;]", told)
    assert loads is not None, told
    seat, top, rate = (float(one) for one in loads.groups())
    assert rate == pytest.approx((top - seat) / 0.55, rel=1e-3)  # 1.80 less 1.25 in
    assert "; seat load of the pair 120 to 140 lbf" in told and " N" not in told
