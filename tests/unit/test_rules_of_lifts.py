"""Every rule on measured lifts on two lobes: one in which it holds and one in which it does not; codes and numbers."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from known_lifts import polar_table, three_arc
from valvetrain.findings.words import Words
from valvetrain.lift.answer import LiftAnswer, answer_of_band, answer_of_law, answer_of_stations
from valvetrain.lift.band import CarriedSpread, LiftBandStudy
from valvetrain.lift.figures import LobeResult, lift_figures, pair_figures
from valvetrain.lift.rules import RULES, LiftFacts
from valvetrain.lift.shape import with_contour
from valvetrain.lift.timing import typed_figures
from valvetrain.measured.cam_events import CamEvents
from valvetrain.measured.contours import Follower
from valvetrain.measured.lift_file import LiftAnswers, lifts_in
from valvetrain.measured.lift_smoothing import smooth_lift
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.study import Study

ANGLES = np.arange(90.0, 271.0)
LIFTS = 9.0 * np.clip(1 - ((ANGLES - 180) / 60) ** 2, 0, None) ** 3
HEAD = "cam angle [deg]; valve lift [mm]"
#: A case with a float speed of 7000 ± 39.2 rpm and a force.
CARRIED = LiftBandStudy(
    Study(CaseRecord("own")),
    (
        CarriedSpread("float_engine_speed", "massless", None, 7000 * np.pi / 30, 20 * np.pi / 30, 16),
        CarriedSpread("peak_spring_force", "massless", 500.0, 900.0, 5.0, 16),
    ),
)  # fmt: skip


def table(
    noise: float,
    slip: float = 0.0,
    head: str = HEAD,
    velocity: float = 0.0,
    sign: float = 1.0,
    scale: float = 1.0,
    **answers,
):
    """A lobe of 9 mm with ``noise`` (mm); one station ``slip`` (mm) too high; a column of velocity of that sign; and the
    lift of that sign.
    """
    lifts = (
        scale * LIFTS
        + np.random.default_rng(7).normal(0, noise, len(ANGLES))
        + slip * (ANGLES == 150)
    )
    lifts = sign * lifts
    columns = [ANGLES, lifts] + [velocity * np.gradient(LIFTS)] * bool(velocity)
    rows = ["; ".join(f"{one:.5f}" for one in row) for row in zip(*columns, strict=True)]
    names = head + "; velocity" * bool(velocity)
    return lifts_in("\n".join([names, *rows]).encode(), "own.txt", LiftAnswers(**answers))[0]


def loose(result: LobeResult) -> LobeResult:
    """The same with three times the spread."""
    return replace(
        result, figures=tuple(replace(one, spread=3 * one.spread) for one in result.figures)
    )


def far_apart() -> LobeResult:
    """Stations every 5 deg."""
    measured = replace(table(3e-3), cam_angles=np.radians(ANGLES[::5]), lifts=1e-3 * LIFTS[::5])
    law = smooth_lift(measured.cam_angles, measured.lifts)
    return loose(LobeResult(measured, law, lift_figures(law)))


def without(first: float, last: float) -> LobeResult:
    """No stations between two angles (deg)."""
    kept = (first > ANGLES) | (last < ANGLES)
    measured = table(3e-3)
    law = smooth_lift(measured.cam_angles[kept], measured.lifts[kept])
    return LobeResult(measured, law, lift_figures(law))


def lobe(noise: float = 3e-3, band: float | None = None, **more) -> LobeResult:
    measured = table(noise, **more)
    law = smooth_lift(measured.cam_angles, measured.lifts, None, band)
    return LobeResult(measured, law, lift_figures(law))


@cache
def answers() -> dict[str, LiftAnswer]:
    intake, exhaust = (replace(lobe().measured, name=name) for name in ("intake", "exhaust"))
    law = lobe().smoothed
    both = tuple(LobeResult(one, law, lift_figures(law)) for one in (intake, exhaust))
    failed = replace(CARRIED, failures=("draw 3: diverged",))
    facts = {
        "good": LiftFacts((lobe(),)), "slip": LiftFacts((lobe(slip=-0.05),)), "noisy": LiftFacts((loose(lobe(100e-3)),)),
        "dusty": LiftFacts((lobe(slip=0.05),)), "mended": LiftFacts((lobe(slip=0.05, mend=True),)), "falling": LiftFacts((lobe(sign=-1.0),)),
        "far": LiftFacts((far_apart(),)),
        "inches": LiftFacts((lobe(1e-4, scale=1 / 25.4),)), "gap": LiftFacts((without(171, 189),)),
        "wrong": LiftFacts((lobe(velocity=-1.0),)), "right": LiftFacts((lobe(velocity=1.0),)), "tight": LiftFacts((lobe(band=1e-6),)),
        "both": LiftFacts(both, pair_figures(law, law)), "case": LiftFacts((lobe(),), carried=CARRIED, file="case.toml"),
        "failed": LiftFacts((lobe(),), carried=failed), "told": LiftFacts((lobe(direction="forward", zero="file"),)),
    }  # fmt: skip
    turn = np.linspace(0, 2 * np.pi, 721)[:-1]
    contour = polar_table(turn, three_arc(turn))
    (arcs,) = lifts_in(contour, "contour.csv", LiftAnswers(follower="flat"))
    law = smooth_lift(arcs.cam_angles, arcs.lifts)
    facts["arcs"] = LiftFacts((LobeResult(arcs, law, lift_figures(law)),))
    clean = replace(facts["good"].lobes[0].smoothed, base=0.0, runout=0.0)
    facts["clean"] = LiftFacts((replace(facts["good"].lobes[0], smoothed=clean),))
    steep = tuple(
        replace(one, value=10 * one.value) if one.name == "largest_acceleration" else one
        for one in lobe().figures
    )
    facts["steep"] = LiftFacts((replace(lobe(), figures=steep),))
    first, second = (replace(lobe().measured, name=f"lift-{number}") for number in (1, 2))
    facts["events"] = LiftFacts(tuple(replace(lobe(), measured=one) for one in (first, second)))
    law = replace(lobe(), measured=replace(lobe().measured, lift_of="tappet"))
    facts["small"] = LiftFacts((with_contour(law, 10e-3, Follower()),))
    cam = CamEvents.of({"IVO": "5 ATDC", "IVC": "32.5 ABDC"}, "intake")
    facts["typed"] = LiftFacts(timing=typed_figures([cam]))
    return {name: LiftAnswer(one) for name, one in facts.items()}


#: Code -> where it holds, where it does not.
HOLDS = {
    "L201": ("failed", "case"), "L202": ("slip", "good"), "L203": ("wrong", "right"), "L204": ("noisy", "good"), "L205": ("dusty", "mended"),
    "L206": ("far", "noisy"), "L207": ("steep", "good"), "L208": ("arcs", "good"), "L209": ("small", "good"), "L210": ("case", "good"),
    "L211": ("good", "slip"), "L212": ("typed", "good"), "L213": ("inches", "good"),
    "L214": ("gap", "mended"), "L220": ("tight", "good"),
    "L230": ("good", "clean"), "L231": ("right", "good"), "L232": ("good", "told"), "L233": ("falling", "good"), "L234": ("mended", "dusty"),
    "L235": ("events", "good"),
}  # fmt: skip


@pytest.mark.parametrize("code", HOLDS)
def test_a_rule_holds_in_one_lobe_and_not_in_the_other(code):
    there, elsewhere = (answers()[name].findings.codes for name in HOLDS[code])
    assert code in there and code not in elsewhere


def test_every_rule_has_its_lobes():
    assert {rule.code for rule in RULES} == set(HOLDS)


@pytest.mark.parametrize(
    ("name", "code", "value"),
    [
        ("good", "L211", pytest.approx(9.0025e-3, rel=1e-4)), ("slip", "L202", pytest.approx(0.045e-3, rel=0.2)),
        ("noisy", "L204", pytest.approx(100e-6, rel=0.15)), ("both", "L211", pytest.approx(0, abs=1e-3)),
        ("dusty", "L205", pytest.approx(0.05e-3, rel=0.1)), ("mended", "L211", pytest.approx(9.0025e-3, rel=1e-4)),
        ("case", "L210", pytest.approx(7000 * np.pi / 30)), ("failed", "L201", None), ("wrong", "L203", None),
        ("inches", "L213", pytest.approx(9e-3 / 25.4, rel=1e-2)), ("gap", "L214", pytest.approx(np.radians(20))),
        ("small", "L209", pytest.approx(10e-3)), ("typed", "L212", pytest.approx(np.radians(207.5))),
    ],
)  # fmt: skip
def test_a_verdict_is_the_doubt_first(name, code, value):
    verdict = answers()[name].verdict
    assert verdict.code == code and (value is None or verdict.value == value)


def test_the_station_that_slipped_is_named_and_marked():
    answer = answers()["slip"]
    assert np.degrees(answer.verdict.fields["angle"].value) == pytest.approx(150)
    assert len(answer.tables()["off"].rows) == 1
    marked = [one for one in answer.lines if one.mark == "warn"]
    assert len(marked) == 1 and not [one for one in answers()["good"].lines if one.mark == "warn"]


def test_results_of_python_have_answers():
    measured = table(3e-3)
    codes = [answer_of_stations(measured).verdict.code, answer_of_law(lobe().smoothed).verdict.code]
    assert codes == ["L211", "L211"] and answer_of_band(CARRIED).verdict.code == "L210"
    assert "thou" in str(LiftAnswer(answers()["slip"].facts, words=Words("imperial")).verdict)
