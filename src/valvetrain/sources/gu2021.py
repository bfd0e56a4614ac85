"""Gu, Hou, Keating and Ye (2021): a beehive valve spring with coil collisions, by finite elements,
a modal model and head tests: forces by the stages of the cam cycle, motion of two points of the
wire, collisions of two coils.

Stage I runs from the zero of the cam angle to the beginning of the main lift event, Stage II is the
event, Stage III runs from its end to a whole revolution. The event is the lift law's own
(``event_start`` to ``event_end``, or mirrored about ``nose``), else where the lift is above 4 % of
its largest value; for the beehive Stage I is 0 to 127, II 127 to 233, III 233 to 360 cam degrees.
Without lift, or where the event spans the zero of the cam angle, there are no stages. Forces are
those on the cylinder head. Node n is the wire centre at the end of coil n, n turns from the lower
tip of the wire.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from valvetrain.parameters.summary import percent
from valvetrain.quantities.cycle import Array, Frame, reported_cycle
from valvetrain.quantities.signal import WINDOWS
from valvetrain.solution.comparison import Finding
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import Quantity, same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.sources.contract import Origin, SourceStudy
from valvetrain.sources.gu2021_coils import (
    acceleration_quantities,
    coils_of,
    collision_quantities,
    displacement_quantities,
    separation_angle,
    velocity_quantities,
)
from valvetrain.sources.gu2021_stages import RATTLE, over_phases, rattle, stage_quantities

SOLID, MODAL, TEST = "solid finite elements", "analytical modal", "engine head test"
COUNTERPARTS = {SOLID: "finite-element", TEST: "finite-element", MODAL: "modal-varied"}
ORIGINS = {
    SOLID: Origin("FE", "solid finite elements"),
    MODAL: Origin("AN", "analytical modal model"),
    TEST: Origin("EX", "engine head test"),
}
#: Collisions repeat with the period of the first mode where their distance is within this share of
#: it.
PERIOD_SHARE = 0.05
#: A vibration is where the source says within this angle (rad); it is there where it is this
#: many times that of the modal model.
PLACE, CLEARLY = np.radians(10.0), 3.0
#: Heights of two maxima and the valley between agree within this share of each.
HEIGHT_SHARE = 0.05
STAGE_1 = ("stage_1_minimum_force", "stage_1_maximum_force")
SPIKE = "stage_3_peak_force"
Printed = Mapping[str, PublishedValue]


def quantities(solution: Solution, frame: Frame) -> dict[str, float]:
    """Forces by stage, motion of nodes 1 and 2, and collisions of coils 1 and 2
    (docs/quantities.md); what is not covered is absent.
    """
    if len(solution.time) < 3 or not solution.has("seat_force"):
        return {}
    cycle = reported_cycle(solution)
    surge_frequency, event = frame.surge_frequency, frame.lift_event
    separation = separation_angle(cycle, surge_frequency)
    found = stage_quantities(cycle, separation, event) if event is not None else {}
    coils = coils_of(frame.points)
    found |= displacement_quantities(cycle, event, coils[2]) | velocity_quantities(
        cycle, event, coils[2]
    )
    if cycle.whole:
        found |= acceleration_quantities(cycle, separation, coils) | collision_quantities(
            cycle, separation, surge_frequency, event, found.get("stage_3_peak_cam_angle")
        )
    return found


def by_phase(study: Study) -> dict[Quantity, Array]:
    """Forces and angles of the stages of each finite-element run, once for each phase of the samples
    that the study stored.
    """
    event, found = study.lift_event, dict[Quantity, Array]()
    for run in study.runs("finite-element"):
        if event is None or len(run.time) < 3 or not run.has("seat_force"):
            continue
        cycle = reported_cycle(run)
        separation = separation_angle(cycle, study.quantities.get(Quantity("mode_1_frequency")))
        for name, values in over_phases(cycle, "seat_force", separation, event).items():
            found[Quantity(name, run.engine_speed, run.label)] = values
    return found


def findings(study: Study) -> tuple[Finding, ...]:
    """Findings of the printed values compared with the finite-element runs of this study."""
    found: list[Finding] = []
    for run in study.runs("finite-element"):
        printed = {
            (one.model, one.quantity): one
            for one in study.record.published
            if same_speed(one.engine_speed, run.engine_speed)
        }
        solid = {quantity: one for (model, quantity), one in printed.items() if model == SOLID}
        spike = printed.get((MODAL, SPIKE))
        modal = next(
            (
                one
                for one in study.runs("modal-varied")
                if same_speed(one.engine_speed, run.engine_speed)
            ),
            None,
        )
        found += [*_period(run, solid), *_two_maxima(run, solid), *_where_the_peak_is(run, solid)]
        if modal:
            found += (
                _spikes(run, modal, solid, spike) if spike else _rattle(run, modal, solid, study)
            )
    return tuple(found)


def _rpm(run: Solution) -> str:
    return f"{run.engine_speed * 30 / np.pi:.0f} rpm"


def _period(run: Solution, solid: Printed) -> tuple[Finding, ...]:
    """Collisions once per period of the first mode, where the paper prints their distance."""
    ratio, interval = (
        run.quantities.get(f"clash_interval_{word}")
        for word in ("to_mode_1_period_ratio", "cam_angle")
    )
    printed = solid.get("clash_interval_cam_angle")
    if printed is None or ratio is None or interval is None:
        return ()
    computed = (
        f"{np.degrees(interval):.1f} cam degrees apart, {ratio:.3f} periods of the first mode"
    )
    verdict = (
        "agrees"
        if abs(ratio - 1) <= PERIOD_SHARE
        else f"not seen: {percent(ratio - 1)} from one period"
    )
    statement = f"{_rpm(run)}: coils 1 and 2 meet every {np.degrees(printed.value):.1f} cam degrees, the period of the first mode"
    return (Finding(printed.source, statement, computed, verdict),)


def _two_maxima(run: Solution, solid: Printed) -> tuple[Finding, ...]:
    """Two force maxima in Stage II with a valley between, where the paper prints them."""
    names = tuple(f"stage_2_{word}_force" for word in ("first_peak", "valley", "second_peak"))
    if not set(names) <= set(solid) or "stage_2_peak_force" not in run.quantities:
        return ()
    first, valley, second = (solid[name].value for name in names)
    statement = f"{_rpm(run)}: two force maxima in Stage II, {first:.0f} N and {second:.0f} N with {valley:.0f} N between"
    if not set(names) <= set(run.quantities):
        return (
            Finding(
                solid[names[0]].source,
                statement,
                f"one maximum of {run.quantities['stage_2_peak_force']:.0f} N",
                "not seen",
            ),
        )
    ours = [run.quantities[name] for name in names]
    off = [mine / theirs - 1 for mine, theirs in zip(ours, (first, valley, second), strict=True)]
    computed = f"{ours[0]:.0f} N and {ours[2]:.0f} N with {ours[1]:.0f} N between"
    if max(map(abs, off)) <= HEIGHT_SHARE:
        verdict = f"agrees within {100 * HEIGHT_SHARE:g} %"
    else:
        verdict = f"two maxima; first, valley and second {', '.join(map(percent, off))}"
    return (Finding(solid[names[0]].source, statement, computed, verdict),)


def _where_the_peak_is(run: Solution, solid: Printed) -> tuple[Finding, ...]:
    """The largest force of the cycle in Stage III, where the paper prints it there."""
    names = ("stage_2_peak_force", "stage_2_first_peak_force", "stage_2_second_peak_force")
    lifted = [solid[name].value for name in names if name in solid]
    spike, ours = solid.get(SPIKE), run.quantities
    if spike is None or not lifted or not {SPIKE, names[0]} <= set(ours):
        return ()
    if spike.relation == "at-most" or spike.value <= max(lifted):
        return ()
    statement = (
        f"{_rpm(run)}: the peak force is in Stage III, {spike.value:.0f} N next to "
        f"{max(lifted):.0f} N in Stage II"
    )
    computed = f"{ours[SPIKE]:.0f} N in Stage III, {ours[names[0]]:.0f} N in Stage II"
    verdict = "agrees" if ours[SPIKE] > ours[names[0]] else "not here: Stage II holds the peak"
    return (Finding(spike.source, statement, computed, verdict),)


def _rattle(run: Solution, modal: Solution, solid: Printed, study: Study) -> tuple[Finding, ...]:
    """High-frequency vibration early in Stage III by finite elements and in the test, where the
    paper says the modal model misses it.
    """
    printed, event = solid.get("stage_3_peak_cam_angle"), study.lift_event
    if printed is None or event is None:
        return ()
    mine, theirs = rattle(run, event), rattle(modal, event)
    if mine is None or theirs is None:
        return ()
    (here, place), there = mine, theirs[0]
    statement = (
        f"{_rpm(run)}: high-frequency vibration about {np.degrees(printed.value):.0f} degrees by finite elements and in the test, from the "
        "contact of coils, missing from the modal model"
    )
    computed = f"above {RATTLE / 1e3:g} kHz up to {here:.1f} N, at {np.degrees(place):.0f} degrees; modal model {there:.1f} N"
    if here <= CLEARLY * there:
        verdict = "not seen: the modal model has as much"
    elif abs(place - printed.value) <= PLACE:
        verdict = "agrees"
    else:
        verdict = f"agrees that contact alone brings it, but it is largest {np.degrees(place - printed.value):+.0f} degrees from there"
    return (Finding(printed.source, statement, computed, verdict),)


def _spikes(
    run: Solution, modal: Solution, solid: Printed, spike: PublishedValue
) -> tuple[Finding, ...]:
    """The spike of Stage III by finite elements and by the modal model, where the paper prints
    both.
    """
    printed, here, there = solid.get(SPIKE), run.quantities.get(SPIKE), modal.quantities.get(SPIKE)
    if printed is None or here is None or not there:
        return ()
    most = "at most " if printed.relation == "at-most" else ""
    statement = f"{_rpm(run)}: spike of Stage III {most}{printed.value:.0f} N by finite elements, {spike.value:.0f} N by the modal model"
    theirs, ours = printed.value / spike.value, here / there
    if (ours > 1) == (theirs > 1):
        verdict = f"the sign holds: {ours:.2f} times the modal model's, printed {theirs:.2f}"
    else:
        verdict = (
            f"the other way round here: {ours:.2f} times the modal model's, printed {theirs:.2f}"
        )
    return (Finding(printed.source, statement, f"{here:.0f} N and {there:.0f} N", verdict),)


def notes(study: Study) -> tuple[str, ...]:
    """Contradictions between the numbers of the paper, and the ratio of computed to published ones."""
    return tuple(filter(None, (_stage_1_note(study), _violence_note(study))))


def _stage_1_note(study: Study) -> str:
    """Middle of Stage I against the preload, printed and computed."""
    printed = [one for one in study.record.published if one.model == SOLID]
    preload = next((one.value for one in printed if one.quantity == "preload"), None)
    parts = []
    for run in study.runs("finite-element"):
        theirs = [
            one.value
            for one in printed
            if one.quantity in STAGE_1 and same_speed(one.engine_speed, run.engine_speed)
        ]
        ours = [run.quantities[name] for name in STAGE_1 if name in run.quantities]
        if preload is None or len(theirs) < 2 or len(ours) < 2:
            continue
        mean, own = sum(theirs) / 2, sum(ours) / 2
        parts.append(
            f"{_rpm(run)} {abs(mean - preload):.0f} N {'below' if mean < preload else 'above'} it ({mean:.0f} N, here {own:.0f} N)"
        )
    if not parts:
        return ""
    return (
        f"The source prints a preload of {preload:.0f} N; the middle of its Stage I range "
        f"is {'; '.join(parts)}. Released from its preload a spring swings about it."
    )


def _violence_note(study: Study) -> str:
    """Median ratio of computed to published spike force and coil velocities of Stage III, by engine
    speed.
    """
    parts = []
    for run in study.runs("finite-element"):
        shares = [
            run.quantities[one.quantity] / one.value
            for one in study.record.published
            if one.model == SOLID
            and same_speed(one.engine_speed, run.engine_speed)
            and one.relation != "at-most"
            and one.value
            and "stage_3" in one.quantity
            and one.quantity.endswith(("_force", "_velocity"))
            and one.quantity in run.quantities
        ]
        if len(shares) > 1:
            parts.append(f"{np.median(shares):.2f} at {_rpm(run)} ({len(shares)} values)")
    return (
        f"Spike force and coil velocities of Stage III, computed over published, middle of all: {', '.join(parts)}."
        if parts
        else ""
    )


SPEC = SourceStudy(
    "gu2021",
    quantities,
    by_phase=by_phase,
    findings=findings,
    notes=notes,
    counterparts=COUNTERPARTS,
    origins=ORIGINS,
    counted=("clash", "stage_1_peak"),
    window_names=dict(zip(WINDOWS, ("Stage I", "Stage II", "Stage III"), strict=True)),
    point_names={1.0: "node 1", 2.0: "node 2"},
    case="gu2021-beehive",
)
