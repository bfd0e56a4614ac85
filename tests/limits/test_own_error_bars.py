"""Error bars of further runs: they hold the value of many more modes (limit between models), follow the order that
three grids show (closed form), and every completed run has them or says why not.
"""

from __future__ import annotations

import math
from dataclasses import replace
from importlib import resources

import pytest

import valvetrain as vt
from synthetic_study import modal_run, rod_run
from valvetrain.errors import InputError
from valvetrain.findings.facts import Facts
from valvetrain.quantities.clash import next_to_largest
from valvetrain.quantities.train_events import marginal_duration
from valvetrain.runs.api import simulate
from valvetrain.runs.error_bars import grid_bar
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.status import Event
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import REASONS, Uncertainty
from valvetrain.solution.uncertainty import ErrorBars as Bars
from valvetrain.views.json import study_json


def engine(**options) -> vt.Case:
    """The pushrod template with a card of its own, not one of the library."""
    path = resources.files("valvetrain").joinpath("templates/pushrod.toml")
    case = vt.Case(path.read_text(encoding="utf-8"))
    return case.set(
        {f"train.springs.card.0.options.{key}": value for key, value in options.items()}
    )


def run_of(case: vt.Case, model: str, speed: str, workers: int = 1) -> Study:
    ways = {"models": model, "spring_sets": "card", "workers": workers}
    return vt.simulate(case.parameters, speed, compute="error_bars", **ways)


def bars_of(study: Study) -> dict[str, object]:
    return {row.quantity: row for row in study.error_bars.rows}


FORCES = ("minimum_spring_force", "peak_spring_force", "surge_amplitude_force")


@pytest.mark.slow
@pytest.mark.parametrize("rpm", [5000, 6000])
def test_a_coarse_chain_and_the_modes_of_the_default_hold_the_limit(rpm):
    """The chain of five elements is a third off and says so; 40 modes are within a hundredth."""
    speed = f"{rpm} rpm"
    limit = run_of(engine(**{"modal-uniform.modes": 80}), "modal-uniform", speed).solutions[0]
    chain, modes = (
        bars_of(run_of(engine(), model, speed)) for model in ("multi-mass", "modal-uniform")
    )
    for name in FORCES:
        true = limit.quantities[name]
        assert abs(chain[name].value - true) <= chain[name].numerical
        assert abs(modes[name].value - true) <= max(modes[name].numerical, 1e-3 * true)
        assert modes[name].numerical < 0.05 * chain[name].numerical
    assert modes["minimum_spring_force"].numerical < 0.01 * modes["minimum_spring_force"].value


@pytest.mark.parametrize("order", [0.8, 1.0, 1.6, 2.0])
def test_the_order_that_three_grids_show_gives_the_bar(order):
    """Closed form, 100 + h^order: the bar holds the error of 1 of the own grid and is no more than the spread of all."""
    further = [(fine, 100 + fine**-order) for fine in (1.5, 1 / 1.5)]
    found = grid_bar(101.0, further, 2.0)
    assert found.observed_order == pytest.approx(order, rel=1e-6)
    assert found.extrapolated == pytest.approx(100.0)
    spread = 1.5**order - 1.5**-order
    assert found.uncertainty == pytest.approx(max(1.25, spread)) and found.trusted


def test_grids_that_show_no_order_give_their_spread():
    assert grid_bar(100.0, [(1.5, 101.0), (1 / 1.5, 102.0)], 2.0).uncertainty == pytest.approx(
        max(3 * 2 / (1.5**2 - 1), 2)
    )
    assert grid_bar(100.0, [(1.5, 100.0), (1 / 1.5, 100.0)], 2.0).uncertainty == 0.0


def test_two_grids_take_the_order_of_the_scheme():
    """Roache's factor of three."""
    assert grid_bar(101.0, [(1.5, 100.0)], 1.0).uncertainty == pytest.approx(3 * 1.0 * 1.5 / 0.5)
    assert grid_bar(100.0, [(1 / 1.5, 101.0)], 2.0).uncertainty == pytest.approx(3 / (1.5**2 - 1))


def test_a_model_is_judged_by_the_limit_of_another():
    """A reduced rod of 104 whose rod has 101, 100.444 and 102.25 by 1, 1.5 and 2 / 3 grids: that of 100."""
    rods = [(fine, 100 + fine**-2.0) for fine in (1.0, 1.5, 1 / 1.5)]
    assert grid_bar(104.0, rods, 2.0, of_model=True).uncertainty == pytest.approx(1.25 * 4)


def blow(time: float, first: float, last: float, impulse: float, spring: str = "") -> Event:
    """A clash of 1 ms from coil ``first`` to ``last``."""
    details = {"first_pair": first, "last_pair": last, "impulse": impulse}
    return Event("clash", 0.0, time, 1e-3, 100.0, "N", f"{spring}coils 1-2", details)


def test_clashes_that_may_be_one_widen_the_bar_of_the_largest():
    """At one time and next to it; not later, not farther along the wire, not of the other spring."""
    largest = blow(0.02, 1.4, 2.4, 5.0)
    near = blow(0.0205, 2.6, 4.2, 3.0)
    assert next_to_largest((near, largest), "impulse") == 3.0
    others = blow(0.0215, 2.6, 4.2, 3.0), blow(0.0205, 3.5, 4.2, 3.0), blow(0.0205, 2.6, 4.2, 3.0, "inner ")  # fmt: skip
    assert next_to_largest((largest, *others), "impulse") == 0.0
    assert next_to_largest((), "impulse") == 0.0


def test_openings_of_a_few_micrometres_are_there_or_not():
    """Of openings of 3, 4 and 8 um, each of 0.1 ms, two may be missing by another division."""
    lost = [
        Event("loft", 0.0, 0.0, 1e-4, size, "m", "cam", {"cause": "", "landing_force": 1.0})
        for size in (3e-6, 4e-6, 8e-6)
    ]
    assert marginal_duration(lost) == pytest.approx(2e-4)


def test_bars_do_not_depend_on_workers_nor_on_the_way_in():
    case = engine()
    simulated = run_of(case, "modal-uniform", "6000 rpm", workers=2)
    at_once = simulate(
        case.parameters,
        engine_speeds=simulated.engine_speeds,
        models=("modal-uniform",),
        spring_sets=("card",),
        workers=1,
        compute="error_bars",
    )
    assert at_once.error_bars == simulated.error_bars and len(at_once.error_bars.rows) > 10
    told = {one["quantity"]: one for one in study_json(at_once)["uncertainties"]}
    row = bars_of(at_once)["minimum_spring_force"]
    assert told["minimum_spring_force"]["numerical_uncertainty"]["value"] == row.numerical


def test_what_has_no_bar_says_why():
    """A spring without mass under prescribed motion has neither division nor step; in a train it has a step."""
    study = vt.simulate("job-t", "3000 rpm", models="massless", compute="error_bars", workers=1)
    assert study.error_bars.rows == ()
    (without,) = study.error_bars.missing
    assert without.label == "massless" and without.reason in REASONS
    (told,) = study_json(study)["without_error_bars"]
    assert told["code"] == without.reason and told["engine_speed"]["value"] == pytest.approx(3000)
    train = run_of(engine(), "massless", "6000 rpm").error_bars
    assert len(train.rows) > 10 and not train.missing


CASES = [
    ("gu2021-beehive-blind", "4200, 4500 rpm", {"models": "finite-element"}),
    *(pytest.param(name, speeds, {}, marks=pytest.mark.long) for name, speeds in (
        ("tdi-pushrod", "4000, 5500 rpm"), ("vaz-ohc", "4136, 3000 rpm"), ("gu2021-beehive-blind", "8000, 6000 rpm"),
        ("job-t", "3000, 5000 rpm"), ("job-c", "3000, 5000 rpm"), ("uniform-spring", "3000 rpm"), ("direct", "3000, 6000 rpm"),
        ("finger", "3000, 6000 rpm"), ("rocker", "3000, 6000 rpm"), ("pushrod", "3000, 6000 rpm"), ("spring", "3000, 6000 rpm"),
    )),
]  # fmt: skip


@pytest.mark.parametrize(("name", "speeds", "ways"), CASES)
def test_every_completed_run_has_bars_or_a_reason_in_every_interface(name, speeds, ways):
    """Contract: at a speed of the case beside another one, and alone, stored or computed."""
    path = resources.files("valvetrain").joinpath(f"templates/{name}.toml")
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    case = vt.Case(text).parameters if text else name
    *numbers, last = speeds.removesuffix(" rpm").split(", ")
    try:
        chosen = [f"{rpm} rpm" for rpm in (*numbers, last)]
        study = vt.simulate(case, chosen, compute="error_bars", workers=1, **ways)
    except InputError:  # a case without a motion has no runs
        return
    runs = {(run.label, run.engine_speed) for run in study.solutions if run.status.completed}
    barred = {(row.label, row.engine_speed) for row in study.error_bars.rows}
    missing = {(one.label, one.engine_speed) for one in study.error_bars.missing}
    assert all(one.reason in REASONS for one in study.error_bars.missing) and runs
    for label, speed in runs:
        for found in (barred, missing):
            if any(label == one and same_speed(speed, at) for one, at in found):
                break
        else:
            raise AssertionError(f"{label} at {speed} rad/s has neither bars nor a reason")
    answer = study_json(study)
    told = [*answer["uncertainties"], *answer["without_error_bars"]]
    found = {
        (one.get("label"), round((one["engine_speed"] or {"value": 0})["value"])) for one in told
    }
    assert {(label, round(speed * 30 / math.pi)) for label, speed in runs} <= found


def test_a_study_and_a_search_have_the_bars_of_runs_of_their_points():
    """Contract: those of the base and of the least output, and of the best design."""
    vary = 'vary = [{ key = "spring.precompression", low = "6 mm", high = "8 mm" }]'
    file = 'case = "job-c"\nengine_speeds = "4000 rpm"\nspring_models = "modal-uniform"\n'
    points = 'outputs = "peak_spring_force"\npoints = { sampler = "grid", levels = 3 }\n'
    table = vt.study(f"{file}{points}{vary}", workers=1)
    assert list(table.error_bars) == [0]
    alone = vt.Case(vt.load_case("job-c")).set({"spring.precompression": "6 mm"})
    ways = {"models": "modal-uniform", "workers": 1}
    study = vt.simulate(alone.parameters, "4000 rpm", compute="error_bars", **ways)
    row, same = bars_of(study)["peak_spring_force"], table.error_bars[0]["peak_spring_force"]
    assert same.numerical == pytest.approx(row.numerical, rel=1e-6) and row.numerical > 0
    goal = 'objective = [{ quantity = "peak_spring_force", direction = "minimise" }]'
    found = vt.optimise(
        f"{file}{vary}\n{goal}\nsearch = {{ trials = 2, per_round = 2 }}", workers=1
    )
    (bar,) = found.error_bars
    assert bar.quantity == "peak_spring_force" and bar.numerical > 0
    assert bar.value == pytest.approx(min(one.objectives[0] for one in found.trials), rel=1e-3)


def test_a_bar_beyond_its_value_is_a_state_and_no_number_of_a_sentence():
    """Contract: "93 ± 1031 N" was printed."""
    speed = 628.0
    row = Uncertainty(
        "peak_clash_force", speed, 93.0, 1031.0, None, 93.0, 0.0, (93.0,) * 2, (93.0,) * 2, "rod"
    )
    assert not row.resolved and row.rests_on_contact_constants and row.contact_range is None
    told = study_json(Study(CaseRecord("own"), error_bars=Bars((row,))))["uncertainties"][0]
    assert told["resolved"] is False and told["rests_on_contact_constants"] is True
    varied = replace(row, numerical=9.0, contact_stiffness=(60.0, 130.0), damping=(90.0, 95.0))
    assert varied.resolved and not varied.rests_on_contact_constants
    assert varied.contact_range == (60.0, 130.0, ("contact stiffness", "damping"))
    smooth = replace(row, quantity="peak_valve_lift")
    assert not smooth.rests_on_contact_constants


def rod(elements: int) -> vt.Case:
    spring = vt.Spring(
        wire_diameter="4 mm", mean_diameter="26 mm", pitch="8 mm", total_coils=5, material="EN 10270-1 SH",
        precompression="4 mm", damping={"ratio": 0.03, "ratio_frequency": "500 Hz"},
        options={"finite-element": {"elements_per_coil": elements}},
    )  # fmt: skip
    law = vt.Case("job-t").tree["lift_law"] | {"maximum_lift": "5 mm"}
    return vt.Case(spring=spring, lift_law=law, operation={"cycles": 2})


@pytest.mark.slow
def test_a_rod_too_coarse_for_a_coarser_one_takes_a_finer_one():
    """Six elements a coil cannot be four; their bar is wider than that of twelve by eight."""
    wide, narrow = (
        bars_of(
            vt.simulate(
                rod(n).parameters, "3000 rpm", "finite-element", compute="error_bars", workers=1
            )
        )
        for n in (8, 16)
    )
    assert wide["peak_spring_force"].numerical > narrow["peak_spring_force"].numerical > 0


@pytest.mark.long
def test_bars_of_coarse_chains_hold_in_every_template():
    """Coverage: at least 95 of 100 bars of chains of five elements hold the value of 80 modes, in four trains
    at five speeds each.
    """
    names = (
        *FORCES,
        "peak_cam_contact_force",
        "minimum_cam_contact_force",
        "seating_velocity",
        "peak_valve_lift",
    )
    held = []
    for kind in ("pushrod", "finger", "direct", "rocker"):
        case = vt.Case(
            resources.files("valvetrain").joinpath(f"templates/{kind}.toml").read_text("utf-8")
        )
        sets = case.parameters.train.springs
        card = next(
            name for name, springs in sets.items() if all(one.wire is None for one in springs)
        )
        finest = case.set({f"train.springs.{card}.0.options.modal-uniform.modes": 80})
        for rpm in (2500, 3500, 4500, 5200, 5800):
            ways = {"spring_sets": card, "workers": 1}
            limit = finest.run(f"{rpm} rpm", "modal-uniform", **ways).quantities
            study = vt.simulate(
                case.parameters, f"{rpm} rpm", "multi-mass", compute="error_bars", **ways
            )
            for row in study.error_bars.rows:
                if row.quantity in names:
                    true = limit[row.quantity]
                    held.append(abs(row.value - true) <= max(row.numerical, 1e-3 * abs(true)))
    assert len(held) > 100 and sum(held) >= 0.95 * len(held)


def test_bars_stored_of_the_rod_stand_beside_the_rod_alone():
    value, bar, speed = 280.4, 0.99, 439.8
    held = Uncertainty(
        "minimum_spring_force",
        speed,
        value,
        bar,
        None,
        value,
        0.0,
        (value, value),
        (value, value),
        "finite-element",
    )
    runs = [replace(rod_run(speed), quantities={held.quantity: value})]
    other = modal_run(speed)
    runs.append(replace(other, quantities={held.quantity: 279.9}))
    facts = Facts(Study(CaseRecord("own"), solutions=tuple(runs), error_bars=Bars((held,))))
    assert [facts.amount(run, held.quantity).bar for run in runs] == [bar, 0.0]
