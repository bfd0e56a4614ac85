"""First clauses on runs: limits passed, travel to coil bind, contact, bounce, clash and forces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from valvetrain.quantities.end_events import PULL
from valvetrain.quantities.limits import PassedLimit, passed_limits
from valvetrain.quantities.loss_cause import FLIGHT, leading_loss
from valvetrain.quantities.train_events import (
    counted_losses,
)
from valvetrain.report.clash_clauses import clash_clauses, strike_count
from valvetrain.report.clauses import (
    Clause,
    Runs,
    Worst,
    amount_text,
    counted,
    figure,
    joined,
    quantity_text,
)
from valvetrain.report.fact_texts import on_assumed_ramp, rings
from valvetrain.report.text import CAUSES
from valvetrain.solution.critical import BOUNCE_HEIGHT, FLOAT_LIFT, places_text
from valvetrain.solution.definition import NESTED, label_of
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Event
from valvetrain.solution.study import Study
from valvetrain.system.contract import TRAIN

SEATING = "seating_velocity"
DURATION, GAP = "loss_of_contact_duration", "loft_gap"
SURGE_ORDER = "surge_amplitude_cam_order"
#: Crank angle (rad) of the open valve above which its loss to flex is named.
FLEX_ANGLE = math.radians(1.0)
#: Travel to coil bind (m) below which it is called close (docs/limits.md), that to the piston too.
NEAR = 1e-3
#: What is said of a model whose springs would pull.
ENDS_PULL = "the ends of the spring would lift, which {} does not show (take wave-rod)"
#: What a run says behind it.
DOUBTFUL = ", so that all that follows is doubtful"
#: What is said of a least force below zero.
PULLS = ", where the spring would leave its seat"
#: Word for a spring without travel left.
SOLID = "solid"
#: Labels of which everything is said.
MAX_LABELS = 2


def judged_runs(study: Study) -> Runs:
    """The runs of a study whose numbers count, with the error bars that are known."""
    bars = study.error_bars
    return Runs(tuple(run for run in study.solutions if is_judged(run)), study.still, bars)


def condition_of(runs: Runs) -> str:
    """What a verdict on trains begins with where a run has no spring that damps."""
    undamped = any(run.provenance.system == TRAIN and rings(run) for run in runs.solutions)
    return "without damping of the springs" if undamped else ""


def is_judged(run: Solution) -> bool:
    """Whether the numbers of a run count: it completed, or did not settle."""
    return run.status.code in ("completed", "not-converged")


def run_clauses(runs: Runs) -> Iterator[Clause]:
    """Clauses by importance: what endangers the engine before all else, contact lost before what is
    well, the seating velocity last, angles in cam degrees as along the figures; nothing without runs. Of more than two labels what flex takes,
    a piston far away and the hardest clash are left to the tables.
    """
    if not runs.solutions:
        return
    passed = list(limit_clauses(runs))
    yield from (clause for name, clause in passed if name != SEATING)
    if pulling := ends_that_pull(runs):
        yield Clause(f"{ENDS_PULL.format(pulling[0].model)}{DOUBTFUL}", pulling[0])
    bind = [one for one in (bind_clause(runs),) if one is not None]
    train = any(run.provenance.system == TRAIN for run in runs.solutions)
    contact = sorted(_contact_clauses(runs) if train else (), key=lambda one: not one.lost)
    clashes = clash_clauses(runs, _is_brief(runs))
    # of springs alone clashes come before what is well
    clash_first = not train and any(one.lost for one in clashes) and not _is_solid(bind)
    yield from clashes if clash_first else ()
    if contact and contact[0].lost and not _is_solid(bind):
        yield from (*contact, *bind)
    else:
        yield from (*bind, *contact)
    yield from () if clash_first else clashes
    yield from _force_clauses(runs)
    yield from (clause for name, clause in passed if name == SEATING)


def _is_brief(runs: Runs) -> bool:
    """Whether more than :data:`MAX_LABELS` labels are judged; the clauses are then brief."""
    return runs.labels > MAX_LABELS


def worst_run(runs: Runs) -> Solution | None:
    """The run that most clauses are about, of equal ones the fastest; None without runs."""
    named = [id(one.run) for one in run_clauses(runs) if one.run is not None]
    return max(
        runs.solutions, key=lambda run: (named.count(id(run)), run.engine_speed), default=None
    )


def limit_clauses(runs: Runs) -> Iterator[tuple[str, Clause]]:
    """Quantities that pass a limit, coil bind left out, with the worst run of each; one whose error bar
    reaches back to the limit is not resolved.
    """
    worst: dict[str, tuple[tuple[bool, float], PassedLimit, Solution]] = {}
    for run in runs.solutions:
        for name, one in passed_limits(run.quantities).items():
            rank = passes_resolved(runs, run, one), one.value
            if name not in worst or rank > worst[name][0]:
                worst[name] = rank, one, run
    for name, ((resolved, _), one, run) in worst.items():
        if name.endswith("coil_bind_clearance"):
            continue
        text = runs.text(Worst(name, one.value, run))
        bound = one.phrase.format(quantity_text(name, one.limit))
        if not resolved:
            bound = bound.replace("above", "not resolved from", 1)
        bound += on_assumed_ramp(run.facts) if name == SEATING else ""
        yield name, Clause(f"{label_of(name)} {text}, {bound}", run)


def passes_resolved(runs: Runs, run: Solution, one: PassedLimit) -> bool:
    """Whether a value passes its limit by more than its error bar."""
    return runs.bar(Worst(one.quantity, one.value, run)) < abs(one.value - one.limit)


def ends_that_pull(runs: Runs) -> list[Solution]:
    """The runs in which ends of a spring would lift that its model holds, so that what follows is not right."""
    return [run for run in runs.solutions if any(one.kind == PULL for one in run.events)]


def bind_clause(runs: Runs) -> Clause | None:
    """Travel to coil bind of the spring with the least, of a pair with its name."""
    found = [
        (one, spring)
        for spring in (*NESTED, "")
        if (one := runs.worst(f"{spring}_coil_bind_clearance".strip("_"), least=True)) is not None
    ]
    if not found:
        return None
    one, spring = min(found, key=lambda pair: pair[0].value)
    if runs.reads_alike(one):
        one = replace(one, run=None)
    pair = [name for _, name in found if name]
    whose = (
        f" ({spring} spring{' first' if len(pair) > 1 else '; the other is not checked'})"
        if spring
        else ""
    )
    if 0 <= one.value < NEAR:
        return Clause(f"only {runs.text(one)} clear of coil bind{whose}", one.run)
    if one.value >= 0:
        clash = any(strike_count(runs, run) > 0 for run in runs.solutions)
        still = " at full lift (at rest)" if clash else ""  # coils clash in spite of it
        return Clause(f"clear of coil bind by {runs.text(one)}{still}{whose}", one.run)
    short = runs.text(Worst(one.name, -one.value, one.run))
    return Clause(f"{SOLID} {short} before the largest lift{whose}", one.run)


def _is_solid(bind: Sequence[Clause]) -> bool:
    """Whether a spring is solid before the largest lift, which passes a limit."""
    return any(SOLID in one.text for one in bind)


def _contact_clauses(runs: Runs) -> Iterator[Clause]:
    """Loft, float, bounce and clearance to the piston."""
    loft, lost = runs.worst(GAP, False), runs.worst(DURATION, False)
    if lost is not None and lost.value > 0:
        time = runs.text(lost)
        gap = f"loft of {runs.text(loft)}, " if loft is not None and loft.value > 0 else ""
        places, flight = _places_lost(runs, lost), _flight(runs, loft)
        why = _why_lost(runs, lost)
        yield Clause(
            f"{gap}{time} without contact{places}{why}{flight}"
            if gap
            else f"contact lost{places} for {time}{why}",
            lost.run,
            lost=True,
        )
    elif lost is not None:
        yield Clause("no loft")
    over = runs.worst("float_excess_lift", False)
    if over is not None and over.value > FLOAT_LIFT:
        yield Clause(f"floats {runs.text(over)} above the rigid lift", over.run, lost=True)
    if not _is_brief(runs) and (flex := _flex_clause(runs)) is not None:
        yield flex
    bounces, height = runs.worst("bounce_count", False), runs.worst("bounce_height", False)
    if bounces is not None:
        count = round(bounces.value)
        if count and height is not None and 0 < height.value <= BOUNCE_HEIGHT:
            yield Clause(f"no bounce above {quantity_text('bounce_height', BOUNCE_HEIGHT)}")
        else:
            run = bounces.run if height is None or not count else height.run or bounces.run
            if run is not None and count:
                count = max(1, round(runs.value(run, "bounce_count")))
            size = f" of {runs.text(height)}" if height is not None and height.value > 0 else ""
            high = f" up{size.replace(' of', ' to')}" if count > 1 and size else size
            said = f"{counted(count, 'bounce')}{high if count else ''}"
            yield Clause(said, run if count else None, lost=count > 0)
    piston = runs.worst("minimum_piston_clearance_gap", True)
    if piston is not None and (not _is_brief(runs) or piston.value < NEAR):
        yield Clause(
            f"clear of the piston by {runs.text(piston)}"
            if piston.value > 0
            else "the valve meets the piston",
            piston.run,
            lost=piston.value <= 0,
        )


def _flex_clause(runs: Runs) -> Clause | None:
    """Lift and duration that flex takes, each of the run that loses most of it; None of what is
    small.
    """
    flex = runs.worst("lift_loss_displacement", False)
    if flex is None:
        return None
    run = flex.run or runs.solutions[0]
    shorter = [(angle, one) for one in runs.solutions if (angle := _shorter(runs, one)) > 0]
    angle, other = max(shorter, key=lambda pair: (pair[0], pair[1] is run), default=(0.0, run))
    if not (flex.value > FLOAT_LIFT or angle > FLEX_ANGLE):
        return None
    lift = f"{runs.text(flex)} of lift" if flex.value > 0 else ""
    time = f"{figure(math.degrees(angle), 2)} crank deg of duration at 0.050 in" if angle else ""
    if lift and time and flex.run is not None and other is not run:
        return Clause(f"flex takes {lift} {runs.place(run)} and {time} {runs.place(other)}")
    takes = joined([one for one in (lift, time) if one])
    return Clause(f"flex takes {takes}", flex.run if lift or len(runs.solutions) < 2 else other)


def _shorter(runs: Runs, run: Solution) -> float:
    """Crank angle (rad) that the duration at 0.050 in is shorter than with rigid parts; NaN where one
    is unknown.
    """
    rigid, open_for = (
        runs.value(run, f"{name}_50_thou_open_crank_angle_range")
        for name in ("rigid_valve", "valve")
    )
    return rigid - open_for


def _losses(runs: Runs, found: Worst) -> list[Event]:
    """Losses of contact in the run of a value, the largest gap first."""
    run = found.run or runs.solutions[0]
    return counted_losses(run.events)


def _places_lost(runs: Runs, lost: Worst) -> str:
    """Where contact is lost, unless at the cam alone: the force there does not show other locations."""
    losses = (event for event in _losses(runs, lost) if event.where)
    places = list(dict.fromkeys(places_text(event.where) for event in losses))
    return f" at the {joined(places)}" if places and places != ["cam"] else ""


def _why_lost(runs: Runs, lost: Worst) -> str:
    """Why contact is lost; a gap of vibration that is no flight needs no cause."""
    event = leading_loss(_losses(runs, lost))
    if event is None or (event.size <= FLIGHT and event.details.get("cause") == Cause.VIBRATION):
        return ""
    cause = cause_text(lost.run or runs.solutions[0], event)
    return f" because {cause}" if cause else ""


def cause_text(run: Solution, event: Event, size: bool = True, where: str = "") -> str:
    """The cause of an event, with what surge takes off the spring force ``where``, and its cam order;
    empty where none is known.
    """
    loss = float(event.details.get("spring_force_loss", 0.0))
    order = round(run.quantities.get(SURGE_ORDER, 0.0)) if size else 0
    return cause_phrase(str(event.details.get("cause", "")), loss if size else 0.0, order, where)


def cause_phrase(cause: str, loss: float, order: int, where: str = "") -> str:
    """A cause in words, of surge with the spring force (N) that it takes ``where`` (empty: at that cam
    angle), which is not the surge amplitude, and its cam order, each left out at 0.
    """
    phrase = CAUSES.get(cause, "")
    if cause != Cause.SURGE:
        return phrase
    force = f" by {amount_text(loss, 'N')}{where or ' there'}" if loss else ""
    return f"{phrase}{force}{f' (order {order})' if order else ''}"


def _flight(runs: Runs, loft: Worst | None) -> str:
    """Where the follower leaves the cam and lands in its largest loft."""
    if loft is None or loft.value < FLIGHT:
        return ""
    for event in _losses(runs, loft):
        landing = event.details.get("landing_cam_angle")
        if event.where == "cam" and landing is not None:
            begin, end = (math.degrees(float(one)) % 360 for one in (event.cam_angle, landing))
            return f", leaves the cam at {begin:.0f} cam deg, lands at {end:.0f} cam deg"
    return ""


def _force_clauses(runs: Runs) -> Iterator[Clause]:
    """The least force at the cam, or of the spring, and the largest of a spring alone."""
    lofting = runs.worst(DURATION, False)
    cam = runs.worst("minimum_cam_contact_force", True, lofting.run if lofting else None)
    if cam is not None and cam.value <= 0 and lofting is not None and lofting.value > 0:
        return  # the loft has reported it
    if cam is not None:
        yield Clause(f"minimum cam force {runs.text(cam)}", cam.run)
        return
    peak, least = runs.worst("peak_spring_force", False), runs.worst("minimum_spring_force", True)
    if peak is not None:
        text = f"{label_of('peak_spring_force')} {runs.text(peak)}"
        yield Clause(text, peak.run)
    if least is not None:
        pulls = PULLS if least.value < 0 else ""
        yield Clause(f"minimum {runs.text(least)}{pulls}", least.run)
