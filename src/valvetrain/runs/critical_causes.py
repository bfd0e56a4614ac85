"""Causes of lost control that one run alone does not show: of critical speeds, each from a run at the critical speed
itself, and whether a loss under surge comes of it. It does not where the train loses contact on springs without surge too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from valvetrain.integrate.contract import Periodic
from valvetrain.quantities.loss_cause import least_force_sample, loss_cause
from valvetrain.quantities.train_events import LOSSES, rigid_cycle
from valvetrain.runs.prepared import Plan, PreparedRun, integrate_from, prepare, with_quantities
from valvetrain.solution.critical import CriticalSpeed
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Detail, Event
from valvetrain.springs.spec import spring_model
from valvetrain.system.problem import Problem

#: Kinds whose events have a cause; a bounce has none.
CAUSED = ("contact-loss", "float")
#: Quantity of the cam order of the largest surge.
SURGE_ORDER = "surge_amplitude_cam_order"
#: How far (of its gap) contact is lost on springs without surge where a loss does not come of surge.
AS_FAR = 0.5
#: Share of a critical speed beyond it at which a cause is looked for where none shows at the speed itself.
BEYOND = 0.005


def without_false_surge(
    problem: Problem, ready: PreparedRun, solution: Solution, plan: Plan
) -> Solution:
    """The run with "the train flexes" as the cause of its losses of contact and floats under surge, where the same train on
    massless springs, which have no surge, goes at least half as far.
    """
    seeming = (one.details.get("cause") == Cause.SURGE for one in solution.events if one.counts)
    if not any(seeming):
        return solution
    far = _far_without_surge(problem, ready, solution, plan)

    def judged(one: Event) -> Event:
        if not one.counts or one.details.get("cause") != Cause.SURGE:
            return one
        if far["float" if one.kind == "float" else "contact-loss"] < AS_FAR * one.size:
            return one
        rest = {name: value for name, value in one.details.items() if name != "spring_force_loss"}
        return replace(one, details=rest | {"cause": Cause.VIBRATION})

    return replace(solution, events=tuple(map(judged, solution.events)))


def _far_without_surge(
    problem: Problem, ready: PreparedRun, solution: Solution, plan: Plan
) -> dict[str, float]:
    """Kind of lost control -> how far (m) the train of a run goes in it on massless springs, whose mass counts by a third;
    -1 where it does not.
    """
    far = dict.fromkeys(CAUSED, -1.0)
    member = replace(ready.member, model=spring_model("massless"), rubbing=None)
    plain = prepare(problem, member, {}, problem.record.study)
    plan = replace(plan, whole=False, keep="ends", implausible=True)
    until = Periodic(compared=False, probed=False)
    run, _ = integrate_from(plain, solution.engine_speed, plan, solution.provenance, periodic=until)
    for one in with_quantities(plain, run, plan, {}).events:
        kind = "contact-loss" if one.kind in LOSSES else one.kind
        if one.counts and kind in far:
            far[kind] = max(far[kind], one.size)
    return far


def with_cause(
    row: CriticalSpeed,
    problem: Problem,
    ready: PreparedRun,
    plan: Plan,
    run: Callable[[float], Solution],
) -> CriticalSpeed:
    """The critical speed with its cause. ``run``: the train with channels and events at an engine
    speed (rad/s).
    """
    if row.kind not in CAUSED or not row.found or ready.motion is None or ready.window is None:
        return row
    beyond = (row.engine_speed + row.ranges[0].upper_engine_speed) / 2
    solution = run(row.engine_speed)
    found = _cause(row, ready, solution)
    if found.get("cause") == Cause.VIBRATION:
        # it is what is left where nothing else shows yet, so a little further on another may
        further = _cause(row, ready, run(min((1 + BEYOND) * row.engine_speed, beyond)))
        found = further if further.get("cause") else found
    if found.get("cause") == Cause.SURGE:
        far = _far_without_surge(problem, ready, solution, plan)[row.kind]
        if far >= AS_FAR * row.limit:
            found = {"cause": Cause.VIBRATION}
    places = row.places
    opens = (
        least_force_sample(solution, places, ready.window)
        if row.kind == "contact-loss" and len(solution.time)
        else None
    )
    order = solution.quantities.get(SURGE_ORDER, math.nan)
    return replace(
        row,
        cause=str(found.get("cause", "")),
        spring_force_loss=float(found.get("spring_force_loss", 0.0)),
        surge_order=round(order) if math.isfinite(order) else 0,
        cam_angle=math.nan if opens is None else float(solution.cam_angle[opens]) % math.tau,
    )


def _cause(row: CriticalSpeed, ready: PreparedRun, solution: Solution) -> Mapping[str, Detail]:
    """Details of the cause in a run; none of one without channels."""
    if not len(solution.time) or ready.motion is None or ready.window is None:
        return {}
    rigid = rigid_cycle(solution, ready.motion.table(solution.engine_speed / 2))
    return loss_cause(solution, rigid, row.kind, row.places, ready.window)
