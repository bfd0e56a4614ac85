"""Error bars of two further runs: they hold the value of many more modes (limit between models), do not
vanish where one pair agrees (by hand), are wide where the division is coarse, are absent where nothing is
divided, and stand beside their own run alone.
"""

from __future__ import annotations

from importlib import resources
from types import SimpleNamespace

import pytest

import valvetrain as vt
from valvetrain.cli.published import ErrorBars
from valvetrain.quantities.clash import next_to_largest
from valvetrain.quantities.train_events import marginal_duration
from valvetrain.report.headlines import HeadlineColumn, HeadlineRow
from valvetrain.report.json import study_json
from valvetrain.runs import own_error_bars
from valvetrain.runs.run import run_study
from valvetrain.solution.status import Event
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import Uncertainty


def engine(**options) -> vt.Case:
    """The pushrod template with a card of its own, not one of the library."""
    path = resources.files("valvetrain").joinpath("templates/pushrod.toml")
    case = vt.Case(path.read_text(encoding="utf-8"))
    return case.set(
        {f"train.springs.card.0.options.{key}": value for key, value in options.items()}
    )


def run_of(case: vt.Case, model: str, speed: str, workers: int = 1) -> Study:
    return vt.simulate(
        case.parameters, speed, spring_models=model, spring_set="card", workers=workers
    )


def bars_of(study: Study) -> dict[str, object]:
    return {row.quantity: row for row in study.error_bars.rows}


FORCES = ("minimum_spring_force", "peak_spring_force", "surge_amplitude_force")


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


def bar_by_hand(name: str, order: float, further: dict[float, float]) -> float:
    """Bar of 100 of a quantity in a run with clashes, whose further runs gave others by their ratio."""
    member = SimpleNamespace(model=SimpleNamespace(word="finite-element"), springs=())
    run = SimpleNamespace(
        quantities={name: 100.0, "clash_count": 2.0}, engine_speed=1.0, label="rod", model="finite-element", events=()
    )  # fmt: skip
    ways = [
        (own_error_bars._Further(SimpleNamespace(member=member), ratio, order, None), {name: value})
        for ratio, value in further.items()
    ]
    (row,) = own_error_bars._rows(run, ways, {})
    return row.numerical


def test_the_wider_bar_of_two_further_runs_counts():
    """The rod of the rocker template at 3000 rpm: 3.86 mN s of clash on two meshes, 0.95 on the finest, and a bar of 0.06."""
    name = "minimum_spring_force"
    agreeing = bar_by_hand(name, 1.0, {1.25: 99.0, 1 / 1.5: 99.99})
    assert agreeing == pytest.approx(2 * 1.0 * 1.25 / 0.25)
    assert bar_by_hand(name, 1.0, {1.25: 99.0}) == pytest.approx(3 * 1.0 * 1.25 / 0.25)


def test_what_clashing_coils_make_follows_no_order():
    """A coarser rod, 1 off: smooth numbers by order 2 and a factor of 2, those of clashes by order 1 and Roache's 3."""
    ways = {1 / 1.5: 99.0, 1 / 1.25: 99.0}
    assert bar_by_hand("minimum_spring_force", 2.0, ways) == pytest.approx(2 / (1.25**2 - 1))
    for name in ("largest_clash_impulse", "peak_clash_force", "surge_clash_peak_force"):
        assert bar_by_hand(name, 2.0, ways) == pytest.approx(3 / (1.25 - 1))


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
    lazily = run_of(case, "modal-uniform", "6000 rpm", workers=2)
    at_once = run_study(
        case.parameters,
        engine_speeds=lazily.engine_speeds,
        spring_models=("modal-uniform",),
        spring_sets=("card",),
        workers=1,
        error_bars=True,
    )
    assert at_once.error_bars == lazily.error_bars and len(at_once.error_bars.rows) > 10
    told = {one["quantity"]: one for one in study_json(at_once)["uncertainties"]}
    row = bars_of(at_once)["minimum_spring_force"]
    assert told["minimum_spring_force"]["numerical_uncertainty"]["value"] == row.numerical


def test_what_has_no_bar_is_said():
    study = run_of(engine(), "massless", "6000 rpm")
    assert study.error_bars.rows == ()
    assert study.error_bars.sentences == (
        "No error bars: none by massless, whose spring has no division.",
    )


def rod(elements: int) -> vt.Case:
    spring = vt.Spring(
        wire_diameter="4 mm", mean_diameter="26 mm", pitch="8 mm", total_coils=5, material="EN 10270-1 SH",
        precompression="4 mm", damping={"ratio": 0.03, "ratio_frequency": "500 Hz"},
        options={"finite-element": {"elements_per_coil": elements}},
    )  # fmt: skip
    law = vt.Case("job-t").tree["lift_law"] | {"maximum_lift": "5 mm"}
    return vt.Case(spring=spring, lift_law=law, operation={"cycles": 2})


def test_a_rod_too_coarse_for_a_coarser_one_takes_a_finer_one():
    """Six elements a coil cannot be four; their bar is wider than that of twelve by eight."""
    wide, narrow = (
        bars_of(
            vt.simulate(rod(n).parameters, "3000 rpm", spring_models="finite-element", workers=1)
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
            ways = {"spring_set": card, "workers": 1}
            limit = finest.run(f"{rpm} rpm", "modal-uniform", **ways).quantities
            study = vt.simulate(case.parameters, f"{rpm} rpm", "multi-mass", **ways)
            for row in study.error_bars.rows:
                if row.quantity in names:
                    true = limit[row.quantity]
                    held.append(abs(row.value - true) <= max(row.numerical, 1e-3 * abs(true)))
    assert len(held) > 100 and sum(held) >= 0.95 * len(held)


def test_bars_stored_of_the_rod_stand_beside_the_rod_alone():
    value, bar, speed = 280.4, 0.99, 439.8
    held = Uncertainty(
        "minimum_spring_force", speed, value, bar, None, value, 0.0, (value, value), (value, value)
    )
    columns = [HeadlineColumn(label, speed) for label in ("finite-element", "modal-varied")]
    row = HeadlineRow("", held.quantity, "", "N", (value, 279.9), (None, None))
    rod, modes = ErrorBars({held.quantity: (held,)}).cells(row, columns)
    assert rod == "280.4 ± 0.99" and modes == "279.9"
