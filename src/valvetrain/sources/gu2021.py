"""Gu, Hou, Keating and Ye (2021): a beehive valve spring with coil collisions, by finite elements, a modal model and head tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.frame import Frame
from valvetrain.solution.comparison import Finding
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.record import PublishedValue
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.sources.contract import Origin, SourceStudy
from valvetrain.sources.gu2021_collisions import collision_quantities, separation_angle
from valvetrain.sources.gu2021_nodes import acceleration_quantities, displacement_quantities, velocity_quantities
from valvetrain.sources.gu2021_stages import stage_quantities

SOLID, MODAL, TEST = "solid finite elements", "analytical modal", "engine head test"
COUNTERPARTS = {SOLID: "finite-element", TEST: "finite-element", MODAL: "modal-varied"}
ORIGINS = {
    SOLID: Origin("FE", "solid finite elements"),
    MODAL: Origin("AN", "analytical modal model"),
    TEST: Origin("EX", "engine head test"),
}
#: Collisions repeat with the period of the first mode where their distance is within this share of it.
PERIOD_SHARE = 0.05
#: Sizes that agree to within this share are called the same.
SAME_SHARE = 0.1


def quantities(solution: Solution, frame: Frame) -> dict[str, float]:
    """Forces by stage, motion of nodes 1 and 2, and collisions of coils 1 and 2 (docs/quantities.md); what is not covered is absent."""
    if len(solution.time) < 3 or not solution.has("seat_force"):
        return {}
    cycle = reported_cycle(solution)
    surge_frequency, event = frame.surge_frequency, frame.lift_event
    separation = separation_angle(cycle, surge_frequency)
    found = stage_quantities(cycle, separation, event) if event is not None else {}
    found |= displacement_quantities(cycle, event) | velocity_quantities(cycle, event)
    if cycle.whole:
        found |= acceleration_quantities(cycle, separation) | collision_quantities(cycle, separation, surge_frequency, event)
    return found


def findings(study: Study) -> tuple[Finding, ...]:
    """What the paper found in words beside the finite-element runs of this study."""
    found: list[Finding] = []
    for run in study.runs("finite-element"):
        speed = f"{run.engine_speed * 30 / np.pi:.0f} rpm"
        published = {one.quantity: one for one in study.record.published if _stands_for(one, run)}
        for build in (_period, _double_hump, _spike_beside_modal):
            one = build(study, run, published, speed)
            if one is not None:
                found.append(one)
    return tuple(found)


def _stands_for(value: PublishedValue, run: Solution) -> bool:
    return value.model == SOLID and same_speed(value.engine_speed, run.engine_speed)


Build = Callable[[Study, Solution, Mapping[str, PublishedValue], str], Finding | None]


def _period(study: Study, run: Solution, published: Mapping[str, PublishedValue], speed: str) -> Finding | None:
    ratio, interval = (run.quantities.get(f"clash_interval_{word}") for word in ("to_mode_1_period_ratio", "cam_angle"))
    if ratio is None or interval is None:
        return None
    words = f"{speed}: {np.degrees(interval):.1f} cam degrees apart, {ratio:.3f} periods of the first mode"
    verdict = "agrees" if abs(ratio - 1) <= PERIOD_SHARE else f"not seen: {ratio - 1:+.0%} from one period"
    return Finding("section 4", "coils 1 and 2 collide once per period of the first mode", words, verdict)


def _double_hump(study: Study, run: Solution, published: Mapping[str, PublishedValue], speed: str) -> Finding | None:
    """Two force maxima in Stage II with a valley between, where the paper prints them."""
    if "stage_2_valley_force" not in published or "stage_2_peak_force" not in run.quantities:
        return None
    first, valley, second = (run.quantities.get(f"stage_2_{word}_force") for word in ("first_peak", "valley", "second_peak"))
    if first is None or valley is None or second is None:
        return Finding("section 4", _HUMPS, f"{speed}: one maximum of {run.quantities['stage_2_peak_force']:.0f} N", "not seen")
    words = f"{speed}: {first:.0f} N and {second:.0f} N with {valley:.0f} N between"
    return Finding("section 4", _HUMPS, words, "agrees" if second > first else "two maxima, but the first is the higher one")


_HUMPS = "the force in Stage II has two maxima, the second the higher one"


def _spike_beside_modal(study: Study, run: Solution, published: Mapping[str, PublishedValue], speed: str) -> Finding | None:
    modal = next((one for one in study.runs("modal-varied") if same_speed(one.engine_speed, run.engine_speed)), None)
    here = run.quantities.get("stage_3_peak_force")
    there = None if modal is None else modal.quantities.get("stage_3_peak_force")
    if here is None or there is None:
        return None
    words = f"{speed}: {here:.0f} N by finite elements, {there:.0f} N by the modal model"
    if here > there * (1 + SAME_SHARE):
        verdict = "agrees"
    else:
        verdict = "about the same here" if here > there * (1 - SAME_SHARE) else "the other way round here"
    return Finding("section 4", "a modal model without coil contact misses the spikes of Stage III", words, verdict)


def notes(study: Study) -> tuple[str, ...]:
    """Where the paper's numbers contradict each other, and how far the predictions of this study stand from them."""
    return tuple(note for note in (_stage_1_note(study), *_prediction_notes(study)) if note)


def _stage_1_note(study: Study) -> str:
    """Stage I swings about the preload, or it does not: the paper's numbers and ours."""
    printed = {(one.quantity, one.engine_speed): one.value for one in study.record.published if one.model == SOLID}
    preload = printed.get(("preload", None))
    told = []
    for run in study.runs("finite-element"):
        pairs = [(key, run.quantities.get(f"stage_1_{key}_force")) for key in ("minimum", "maximum")]
        theirs = [value for (name, speed), value in printed.items() if same_speed(speed, run.engine_speed) and name in _STAGE_1]
        ours = [value for _, value in pairs if value is not None]
        if preload is None or len(theirs) < 2 or len(ours) < 2:
            continue
        mean, own, side = sum(theirs) / 2, sum(ours) / 2, "below" if sum(theirs) / 2 < preload else "above"
        told.append(f"{run.engine_speed * 30 / np.pi:.0f} rpm {abs(mean - preload):.0f} N {side} it (mean {mean:.0f} N, here {own:.0f} N)")
    if not told:
        return ""
    return f"Stage I should swing about the preload, which the source prints as {preload:.0f} N; its middle stands at {'; '.join(told)}."


_STAGE_1 = ("stage_1_minimum_force", "stage_1_maximum_force")


def _prediction_notes(study: Study) -> tuple[str, ...]:
    """Middle ratio of computed to published force spikes and velocities after the event, by engine speed."""
    told = []
    for run in study.runs("finite-element"):
        shares = [
            run.quantities[one.quantity] / one.value for one in study.record.published
            if _stands_for(one, run) and one.relation != "at-most" and one.value and one.quantity in run.quantities and _is_violent(one.quantity)
        ]  # fmt: skip
        if len(shares) > 1:
            told.append(f"{np.median(shares):.2f} at {run.engine_speed * 30 / np.pi:.0f} rpm ({len(shares)} values)")
    return (f"Spike force and coil velocities after the event, computed over published, middle of all: {', '.join(told)}.",) if told else ()


def _is_violent(name: str) -> bool:
    return "stage_3" in name and name.endswith(("_force", "_velocity"))


SPEC = SourceStudy(
    "gu2021", quantities, findings=findings, notes=notes, counterparts=COUNTERPARTS, origins=ORIGINS, counted=("clash", "stage_1_peak")
)
