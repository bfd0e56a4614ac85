"""Critical speeds as numbers: smooth in the inputs (property), found again by an optimiser
(property), independent of grid, model and division within what is printed (limit between models), with a
cause that no grid moves (property), and what a sweep says between its speeds (property). On the pushrod template, of no source.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import valvetrain as vt
from valvetrain.findings.rules_train import cause_text
from valvetrain.findings.table import findings_of
from valvetrain.parameters.loading import parse_case
from valvetrain.quantities.clash import PULL
from valvetrain.quantities.train_events import counted_losses
from valvetrain.runs import critical_scan
from valvetrain.runs.critical_speeds import standing_force
from valvetrain.runs.prepared import prepare
from valvetrain.solution.critical import RPM
from valvetrain.solution.status import Cause
from valvetrain.system.build import build

TEMPLATE = Path(vt.__file__).parent / "templates" / "pushrod.toml"


#: Speeds around the float of the template on massless springs.
SPEEDS = "6020:6100:40 rpm"


def float_speed(mass: float, speeds: str = SPEEDS, model: str = "massless") -> float:
    """Float speed (rpm) of the template with a valve of ``mass`` (kg), the nominal value alone."""
    case = vt.Case(TEMPLATE).set({"train.valve.mass": mass})
    row = case.critical_speeds(
        speeds, models=[model], spring_sets=["card"], ranges=False, workers=1
    ).of("float")
    assert row is not None and row.found
    return row.engine_speed / RPM


def slopes(model: str, speeds: str) -> list[float]:
    """Central differences of the float speed (rpm/kg) by steps of 0.01 and 0.1 %."""
    mass = 0.145
    found = []
    for step in (1e-4 * mass, 1e-3 * mass):
        high, low = (float_speed(mass + sign * step, speeds, model) for sign in (1, -1))
        found.append((high - low) / (2 * step))
    return found


def test_the_float_speed_moves_smoothly_with_the_valve_mass() -> None:
    """It was a staircase of 6.25 rpm: the difference by 0.01 % (0.2 rpm) was zero."""
    fine, coarse = slopes("massless", SPEEDS)
    assert fine < 0 and fine == pytest.approx(coarse, rel=0.05)


@pytest.mark.slow
def test_repeats_from_the_motion_of_a_near_speed_find_what_those_from_rest_find(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Limit between starts: nominal speed and range over damping of a float, with surge."""

    def float_row():
        row = vt.Case(TEMPLATE).critical_speeds(
            "6950:7050:100 rpm", models=["modal-uniform"], spring_sets=["card"], workers=1
        ).of("float")  # fmt: skip
        assert row is not None
        damped = [one.engine_speed for one in row.members if one.cause == "damping"]
        return np.array([row.engine_speed, *damped]) / RPM

    near = float_row()
    monkeypatch.setattr(critical_scan, "CLOSE", -1.0)
    assert near[0] == pytest.approx(float_row()[0], abs=0.1)
    assert near == pytest.approx(float_row(), abs=2.0)


@pytest.mark.long
def test_the_float_speed_moves_smoothly_with_surge_as_well() -> None:
    fine, coarse = slopes("modal-uniform", "6900:7100:100 rpm")
    assert fine < 0 and fine == pytest.approx(coarse, rel=0.05)


@pytest.mark.long
def test_an_optimiser_finds_the_valve_mass_of_a_float_speed() -> None:
    target = float_speed(0.1443, SPEEDS)
    mass = brentq(lambda one: float_speed(one, SPEEDS) - target, 0.1435, 0.1455, xtol=1e-6)
    assert float_speed(mass, SPEEDS) == pytest.approx(target, abs=1.0)
    assert mass == pytest.approx(0.1443, abs=1e-5)


def test_a_sweep_runs_what_lies_between_its_speeds() -> None:
    """Between 6000 and 6500 rpm order 7 of the surge unloads the spring altogether."""
    study = vt.sweep(
        str(TEMPLATE),
        "6000:6500:500 rpm",
        spring_sets=["card"],
        critical_speeds=False,
        workers=1,
    )
    least = min(study.between, key=lambda run: run.quantities["minimum_spring_force"])
    swept = study.solutions[-1].quantities["minimum_spring_force"]
    assert least.quantities["minimum_spring_force"] == 0 < swept
    assert 6400 * RPM < least.engine_speed < 6500 * RPM
    assert len(study.solutions) == 2  # files and pages hold the speeds that were requested


def test_no_critical_speed_is_that_of_a_run_whose_ends_would_pull() -> None:
    """Plain runs near order 7 of a surge that little damps: the ends pull where the search says so, and not where it
    found that control is lost.
    """
    case = vt.Case(TEMPLATE).set({"train.springs.card.0.damping.ratio": 0.0096})
    rows = case.critical_speeds(
        "6300:6600:150 rpm", "modal-uniform", spring_sets="card", ranges=False, workers=1
    )

    def pulls(engine_speed: float) -> bool:
        run = case.run(engine_speed, "modal-uniform", spring_sets="card")
        return any(event.kind == PULL for event in run.events)

    assert any(row.pulled for row in rows)
    for row in rows:
        assert not row.found or not pulls(row.engine_speed)
        for span in row.pulled:
            assert pulls(span.lower_engine_speed) and pulls(span.upper_engine_speed)


def test_the_margin_at_standstill_is_that_of_the_springs() -> None:
    """Closed form of the bucket template: preload and rate at a tenth of the lift, less weight."""
    text = TEMPLATE.with_name("direct.toml").read_text(encoding="utf-8")
    problem = build(parse_case(text), spring_set=("stiff",))
    ready = prepare(problem, problem.members[0], {}, "")
    weight = (0.045 + 0.095 + 0.048 / 3) * 9.81
    expected = 320.0 + 42e3 * 0.1 * 7.9e-3
    assert standing_force(ready) == pytest.approx(expected, abs=weight + 3.0)


@pytest.mark.long
def test_a_graze_is_one_whatever_speeds_are_searched() -> None:
    """Kind and ends hang on the margin at standstill, not on the largest among the speeds searched."""
    case = vt.Case(TEMPLATE).set({"train.valve.mass": "140 g"})
    wide, near = (
        case.critical_speeds(speeds, spring_sets="card", workers=1).of("contact-loss")
        for speeds in ("3000:8000:500 rpm", "6000:8000:500 rpm")
    )
    assert wide.onset == near.onset
    assert wide.engine_speed == pytest.approx(near.engine_speed, rel=1e-3)
    assert wide.span.upper_engine_speed == pytest.approx(near.span.upper_engine_speed, rel=5e-3)


@pytest.mark.long
@pytest.mark.parametrize("spring_set", ["card", "wire"])
def test_other_grids_models_and_divisions_lie_inside_what_is_printed(spring_set: str) -> None:
    case = vt.Case(TEMPLATE)
    printed = case.critical_speeds("3000:9000:500 rpm", spring_sets=[spring_set], workers=1)
    others = [
        case.critical_speeds(
            f"3000:9000:{step} rpm", spring_sets=[spring_set], ranges=False, workers=1
        )
        for step in (250, 100)
    ]
    if spring_set == "card":
        for options in (
            {"multi-mass": {"elements": 48}},
            {"modal-uniform": {"modes": 20}},
        ):
            ((model, table),) = options.items()
            ((name, value),) = table.items()
            changed = case.set({f"train.springs.card.0.options.{model}.{name}": value})
            others.append(
                changed.critical_speeds(
                    "3000:9000:500 rpm",
                    models=[model],
                    spring_sets=[spring_set],
                    ranges=False,
                    workers=1,
                )
            )
    missed = []
    for row in printed:
        inside = row.span
        assert inside is not None, row
        for other in others:
            one = other.of(row.kind)
            assert one is not None
            low, high = inside.lower_engine_speed - RPM, inside.upper_engine_speed + RPM
            if not low <= (one.engine_speed if one.found else np.inf) <= high:
                missed.append(f"{row.kind} {row.text}: {one.text}")
    assert not missed


def test_the_cause_of_a_loss_of_contact_is_the_same_on_every_grid() -> None:
    """By the next speed swept it was surge, inertia or vibration."""
    found = [
        vt.sweep("tdi-pushrod", speeds, models=["multi-mass"], spring_sets="stock", workers=1)
        for speeds in ("6800:7000:200 rpm", "6820:6970:50 rpm")
    ]  # fmt: skip
    coarse, fine = (one.critical_speeds.of("contact-loss") for one in found)
    assert coarse.cause == fine.cause == Cause.SURGE
    assert coarse.spring_force_loss == pytest.approx(fine.spring_force_loss, rel=0.02)
    assert coarse.surge_order == fine.surge_order
    assert coarse.cam_angle == pytest.approx(fine.cam_angle, abs=math.radians(0.5))
    verdicts = [findings_of(one).verdict for one in found]
    assert [one.code for one in verdicts] == ["W101", "W101"]
    assert verdicts[0].value / RPM == pytest.approx(6863, abs=1) and coarse.surge_order == 6
    assert math.degrees(coarse.cam_angle) == pytest.approx(158, abs=0.5)


def test_run_sweep_row_and_event_log_give_one_cause_of_one_loss() -> None:
    """Contract: of the same loss the sweep said inertia, the row surge and the log that the train vibrates. Rigid parts
    lose contact at 7148 rpm: above 98 % of that it is inertia to all of them.
    """
    ways = {"models": ["multi-mass"], "spring_sets": "stock", "workers": 1}
    sweep = vt.sweep("tdi-pushrod", "6800:7000:200 rpm", **ways)
    row = sweep.critical_speeds.of("contact-loss")
    for engine_speed, cause in ((row.engine_speed / RPM + 3, row.cause), (7200.0, Cause.INERTIA)):
        study = vt.simulate("tdi-pushrod", f"{engine_speed} rpm", **ways)
        causes = {one.details["cause"] for one in counted_losses(study.solutions[0].events)}
        assert causes == {cause}
        said = cause_text(cause, study.solutions[0].quantities["surge_amplitude_cam_order"])
        assert findings_of(study).verdict.fields["cause"] == said
    assert findings_of(sweep).verdict.fields["cause"] == cause_text(row.cause, row.surge_order)


def test_the_curve_of_a_sweep_reaches_zero_where_contact_is_marked_as_lost() -> None:
    row = vt.critical_speeds(
        "tdi-pushrod", "6800:7000:200 rpm", models=["multi-mass"], spring_sets="stock", ranges=False, workers=1
    ).of("contact-loss")  # fmt: skip
    above = [force for speed, force, _ in row.curve if speed > row.engine_speed * (1 + 1e-6)]
    below = [force for speed, force, _ in row.curve if speed < row.engine_speed * (1 - 1e-6)]
    assert above[0] == 0 and 0 < below[-1] < 5
