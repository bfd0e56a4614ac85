"""Error bars of the runs of any case: each run once more, its springs divided more finely, or more
coarsely where they are large.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from valvetrain.runs.at_rest import AtRest
from valvetrain.runs.error_bars import SPRING_HEADLINES, two_grids
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    integrate_point,
    prepare,
    provenance_of,
    statics_of,
    with_quantities,
)
from valvetrain.runs.refine_trains import HEADLINES as TRAIN_HEADLINES
from valvetrain.runs.refine_trains import ROUNDING, divided
from valvetrain.runs.workers import map_points
from valvetrain.solution.definition import label_of
from valvetrain.solution.later import Later
from valvetrain.solution.result import Solution
from valvetrain.solution.uncertainty import ErrorBars, Uncertainty
from valvetrain.system.problem import Member, Problem, Rest

#: Division of the springs of the further run over that of the case; finite elements, whose cost
#: grows with the square, take the inverse.
RATIO = 1.5
#: Share of a value that its uncertainty may be without being named.
LARGE = 0.05
#: Numbers that get a bar where a run has them; counts jump.
NAMES = tuple(
    name
    for name in dict.fromkeys((*TRAIN_HEADLINES, *SPRING_HEADLINES))
    if not name.endswith("_count")
)


class _Further(NamedTuple):
    """The run of a member with its springs divided otherwise; whether more finely."""

    ready: PreparedRun
    finer: bool


def own_error_bars(
    problem: Problem,
    solutions: Sequence[Solution],
    plan: Plan,
    at_rest: Later[AtRest],
    workers: int,
    tell: Callable[[int, int], None] | None = None,
) -> ErrorBars:
    """Error bars of the completed ``solutions`` of a problem that ran by ``plan``.

    The bar is Roache's for two grids: three times the difference, over the ratio squared less one;
    scatter of a motion that does not repeat is added. ``at_rest``: the springs at rest as computed
    for the solutions. Raises :class:`PointsStopped` when it is stopped.
    """
    further: dict[str, _Further] = {}
    rest = at_rest.value.springs
    undivided: list[str] = []
    for member in problem.members:
        found = _further(problem, member, rest)
        if found is None:
            undivided.append(member.model.label)
        else:
            further[member.label] = found
    runs = [
        run for run in solutions if run.status.completed and run.label in further and run.quantities
    ]
    again = map_points(
        _run_again,
        (problem, further, replace(plan, keep="ends", whole=False, later=False)),
        [(run.label, run.engine_speed) for run in runs],
        workers,
        processes=bool(problem.members and problem.members[0].gear),
        tell=tell,
        lost=lambda point: {},
    )
    rows = tuple(
        row
        for run, numbers in zip(runs, again, strict=True)
        for row in _rows(run, numbers, further[run.label].finer)
    )
    return ErrorBars(rows, tuple(_sentences(rows, further.values(), undivided)))


def _further(problem: Problem, member: Member, rest: Rest) -> _Further | None:
    """A member with its springs divided otherwise, prepared; None where nothing divides them."""
    finer = member.model.word != "finite-element"
    springs = tuple(
        divided(member, spring, RATIO if finer else 1 / RATIO) for spring in member.springs
    )
    if springs == member.springs:
        return None
    at_rest = {
        other: rest[own] for own, other in zip(member.springs, springs, strict=True) if own in rest
    }
    try:
        ready = prepare(problem, replace(member, springs=springs), at_rest, problem.record.study)
    except FAILURES:
        return None
    _, frequencies = statics_of(member, rest)  # numbers are defined by those of the case's own
    return _Further(
        replace(ready, frame=replace(ready.frame, surge_frequencies=frequencies)), finer
    )


def _run_again(
    shared: tuple[Problem, Mapping[str, _Further], Plan], point: tuple[str, float]
) -> Mapping[str, float]:
    """Numbers of a further run; none of one that failed."""
    (problem, further, plan), (label, engine_speed) = shared, point
    ready = further[label].ready
    try:
        provenance = provenance_of(problem, ready.member, engine_speed, plan.created_at)
        found = integrate_point(ready, engine_speed, plan, provenance)
        found = with_quantities(ready, found, plan, {})
    except FAILURES:
        return {}
    return dict(found.quantities) if found.status.completed else {}


def _rows(run: Solution, other: Mapping[str, float], finer: bool) -> Iterable[Uncertainty]:
    for name in NAMES:
        value, again = run.quantities.get(name, math.nan), other.get(name, math.nan)
        if not (math.isfinite(value) and math.isfinite(again)) or 0 < abs(value) < ROUNDING:
            continue
        if finer:
            bar = two_grids(value, again, RATIO).uncertainty
        else:
            bar = two_grids(again, value, RATIO).finest_index
        bar += run.quantities.get(f"cycle_scatter_{name}", 0.0)
        best = again if finer else value
        same = (value, value)
        yield Uncertainty(
            name, run.engine_speed, value, bar, None, best, 0.0, same, same, run.label
        )


def _sentences(
    rows: Sequence[Uncertainty], further: Iterable[_Further], undivided: Sequence[str]
) -> Iterable[str]:
    ways = {one.finer for one in further}
    none = f"none by {' and '.join(dict.fromkeys(undivided))}, which nothing divides"
    if rows:
        ways_in_text = ((True, "more finely"), (False, "more coarsely"))
        way = " or ".join(text for finer, text in ways_in_text if finer in ways)
        end = f"; {none}." if undivided else "."
        yield f"± (if there is room) is numerical: runs repeated, springs divided {RATIO:g} times {way}{end}"
    elif undivided:
        yield f"No error bars: {none}."
    large = sorted(
        (row for row in rows if row.numerical > LARGE * abs(row.value) and row.value),
        key=lambda row: -row.numerical / abs(row.value),
    )
    if large:
        named = ", ".join(dict.fromkeys(label_of(row.quantity).lower() for row in large))
        yield f"Uncertain by more than {100 * LARGE:.0f} %: {named}."
