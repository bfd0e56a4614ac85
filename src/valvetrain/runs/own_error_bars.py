"""Error bars of the runs of any case: each run once more, its springs and its step divided more
finely, or more coarsely where the springs are large; springs reduced from their rods
beside those rods.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from valvetrain.integrate.leapfrog import STEP_FRACTION
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.at_rest import AtRest
from valvetrain.runs.error_bars import SPRING_HEADLINES, two_grids
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    integrate_from,
    prepare,
    provenance_of,
    statics_of,
    with_quantities,
)
from valvetrain.runs.refine_trains import DIVISIONS, ROUNDING, divided
from valvetrain.runs.refine_trains import HEADLINES as TRAIN_HEADLINES
from valvetrain.runs.workers import map_points
from valvetrain.solution.definition import label_of
from valvetrain.solution.later import Later
from valvetrain.solution.result import Solution
from valvetrain.solution.uncertainty import ErrorBars, Uncertainty
from valvetrain.springs.modal_uniform import oscillating_modes
from valvetrain.system.problem import Member, Problem, Rest

#: Division of the springs of the further run over that of the case; finite elements, whose cost
#: grows with the square, take the inverse where it can run.
RATIO = 1.5
#: Springs of fewer parts than this surge at other frequencies altogether: the further run takes so many.
FEW, MANY = 20, 60
#: Order assumed of a rod, whose refinement shows it, and of chains and modes, of which few parts are far
#: from the limit.
ROD_ORDER, OTHER_ORDER = 2.0, 1.0
#: Models whose grid follows the time step: their further run takes a shorter step alone, as do
#: modes of which no more oscillate.
BY_STEP = ("wave-rod", "wave-rod-clash")
MODES, REDUCED = "modal-uniform", "reduced-rod"
#: Numbers that differ by a constant from one whose scatter is known, or hold the same peak.
SAME_SCATTER = {
    "lift_loss_displacement": "peak_valve_lift",
    "below_20_khz_peak_spring_force": "peak_spring_force",
    "below_10_khz_peak_spring_force": "peak_spring_force",
}
#: Share of a value that its uncertainty may be without being named.
LARGE = 0.05
#: Names in the sentence on large error bars.
MAX_NAMES = 3
#: Numbers that get a bar where a run has them; counts jump.
NAMES = tuple(
    name
    for name in dict.fromkeys((*TRAIN_HEADLINES, *SPRING_HEADLINES))
    if not name.endswith("_count")
)


#: What a chain of a wire may be off its rod, over its surge amplitude: more than six springs of no
#: library showed in a pushrod train (0.97, 0.97, 0.6 and 3.5). Peaks of clash have no such bound.
CHAIN_OF_WIRE = {
    "minimum_spring_force": 1.0,
    "minimum_retainer_force": 1.0,
    "surge_amplitude_force": 1.0,
    "minimum_cam_contact_force": 4.0,
}


class _Further(NamedTuple):
    """The run of a member with its springs divided otherwise, its division over the own one, and its
    step under the own one (None: what the springs ask for).
    """

    ready: PreparedRun
    ratio: float
    order: float
    steps: float | None


def own_error_bars(
    problem: Problem,
    solutions: Sequence[Solution],
    plan: Plan,
    at_rest: Later[AtRest],
    workers: int,
    tell: Callable[[int, int], None] | None = None,
) -> ErrorBars:
    """Error bars of the completed ``solutions`` of a problem that ran by ``plan``.

    The bar is Roache's for two grids: three times the difference to the limit of the assumed order;
    scatter of a motion that does not repeat is added. ``at_rest``: the springs at rest as computed
    for the solutions. Raises :class:`PointsStopped` when it is stopped.
    """
    further: dict[str, _Further] = {}
    rest = at_rest.value.springs
    undivided: list[str] = []
    reduced = [member for member in problem.members if member.model.word == REDUCED]
    differing: tuple[Uncertainty, ...] = ()
    far: tuple[str, ...] = ()
    if reduced:
        from valvetrain.runs.against_rod import rod_bars  # loads the rod, which few runs need

        differing, far = rod_bars(problem, reduced, solutions, NAMES, rest, workers)
    for member in problem.members:
        if member in reduced:
            continue
        found = _further(problem, member, rest)
        if found is None:
            undivided.append(member.model.word)
        else:
            further[member.label] = found
    runs = [
        run for run in solutions if run.status.completed and run.label in further and run.quantities
    ]
    again = map_points(
        _run_again,
        (problem, further, replace(plan, keep="ends", whole=False, later=False)),
        [_point(run, further[run.label]) for run in runs],
        workers,
        processes=bool(problem.members and problem.members[0].gear),
        tell=tell,
        lost=lambda point: {},
    )
    rows = tuple(
        row
        for run, numbers in zip(runs, again, strict=True)
        for row in _rows(run, numbers, further[run.label])
    )
    barred = {(row.label, row.engine_speed) for row in rows}
    without = [
        f"{run.label} at {run.engine_speed * 30 / math.pi:.6g} rpm"
        for run in solutions
        if run.label in further and (run.label, run.engine_speed) not in barred
    ]
    rows += differing
    return ErrorBars(rows, (*_sentences(rows, further.values(), undivided, without), *far))


def _point(run: Solution, way: _Further) -> tuple[str, float, float | None]:
    """Label, engine speed and time step (s) of a further run, which its finer springs carry."""
    own = run.statistics.get("time_step_duration")
    if way.steps is None or not isinstance(own, (int, float)) or way.ready.system is None:
        return run.label, run.engine_speed, None
    limits = [
        STEP_FRACTION * float(spring.stable_time_step())
        for spring in way.ready.system.springs
        if hasattr(spring, "stable_time_step") and run.model not in BY_STEP
    ]
    return run.label, run.engine_speed, min(float(own) / way.steps, *limits, math.inf)


def _further(problem: Problem, member: Member, rest: Rest) -> _Further | None:
    """A member with its springs divided otherwise, prepared; None where nothing divides them."""
    _, frequencies = statics_of(member, rest)  # numbers are defined by those of the case's own
    rod = member.model.word == "finite-element"
    parts = min(_parts(member, member.springs), default=FEW)
    for factor in (1 / RATIO, RATIO) if rod else (MANY / parts if parts < FEW else RATIO,):
        try:
            springs = tuple(_finer(member, spring, factor) for spring in member.springs)
            divisions = zip(_parts(member, springs), _parts(member, member.springs), strict=True)
            ratios = [new / old for new, old in divisions if new != old]
            if member.model.word in (*BY_STEP, MODES) and max(ratios, default=0.0) < 1.0:
                ratios = [factor]
            if not ratios:
                continue
            ratio = min(ratios, key=lambda one: abs(math.log(one)))  # whole numbers leave less
            pairs = zip(member.springs, springs, strict=True)
            at_rest = {other: rest[own] for own, other in pairs if own in rest}
            other = replace(member, springs=springs)
            ready = prepare(problem, other, at_rest, problem.record.study)
        except FAILURES:
            continue
        if not ready.refusal:
            frame = replace(ready.frame, surge_frequencies=frequencies)
            order, steps = (ROD_ORDER, None) if rod else (OTHER_ORDER, RATIO)
            return _Further(replace(ready, frame=frame), ratio, order, steps)
    return None


def _finer(member: Member, spring: InstalledSpring, factor: float) -> InstalledSpring:
    """A spring divided otherwise, of modes no more than still oscillate."""
    found = divided(member, spring, factor)
    if member.model.word != MODES:
        return found
    (count,) = _parts(member, (found,))
    return found.with_options(MODES, modes=oscillating_modes(found, round(count)))


def _parts(member: Member, springs: Sequence[InstalledSpring]) -> list[float]:
    """Elements, masses or modes of each spring, by the options that its kind of data uses."""
    model, found = member.model, []
    for spring in springs:
        unused = model.options.card_only if spring.card is None else model.options.wire_only
        options = model.read_options(spring.options_of(model.word)).model_dump()
        coils = 1.0 if spring.wire is None else spring.wire.total_coils
        found += [
            options[key] * (coils if key.endswith("_per_coil") else 1.0)
            for key in DIVISIONS
            if key not in unused and options.get(key)
        ]
    return found


def _run_again(
    shared: tuple[Problem, Mapping[str, _Further], Plan], point: tuple[str, float, float | None]
) -> Mapping[str, float]:
    """Numbers of a further run; none of one that failed."""
    (problem, further, plan), (label, engine_speed, step) = shared, point
    ready = further[label].ready
    try:
        provenance = provenance_of(problem, ready.member, engine_speed, plan.created_at)
        found, _ = integrate_from(ready, engine_speed, plan, provenance, time_step=step)
        found = with_quantities(ready, found, plan, {})
    except FAILURES:
        return {}
    return dict(found.quantities) if found.status.completed else {}


def _rows(run: Solution, other: Mapping[str, float], way: _Further) -> Iterable[Uncertainty]:
    if all(other.get(name) == run.quantities.get(name) for name in NAMES):
        return  # the model had no further parts to take: both runs are one
    for name in NAMES:
        value, again = run.quantities.get(name, math.nan), other.get(name, math.nan)
        if not (math.isfinite(value) and math.isfinite(again)) or 0 < abs(value) < ROUNDING:
            continue
        if way.ratio > 1:
            bar = two_grids(value, again, way.ratio, way.order).uncertainty
        else:
            bar = two_grids(again, value, 1 / way.ratio, way.order).finest_index
        bar += run.quantities.get(f"cycle_scatter_{SAME_SCATTER.get(name, name)}", 0.0)
        if _is_chain_of_wire(way.ready.member):
            bar += CHAIN_OF_WIRE.get(name, 0.0) * run.quantities.get("surge_amplitude_force", 0.0)
        best = again if way.ratio > 1 else value
        same = (value, value)
        yield Uncertainty(
            name, run.engine_speed, value, bar, None, best, 0.0, same, same, run.label
        )


def _is_chain_of_wire(member: Member) -> bool:
    return member.model.word == "multi-mass" and any(one.wire is not None for one in member.springs)


def _sentences(
    rows: Sequence[Uncertainty],
    further: Iterable[_Further],
    undivided: Sequence[str],
    without: Sequence[str],
) -> Iterable[str]:
    ways = sorted({one.ratio for one in further})
    none = f"none by {', '.join(dict.fromkeys(undivided))}"
    if rows and ways:
        divided_by = " and ".join(
            f"{max(one, 1 / one):.2g} times {'finer' if one > 1 else 'coarser'}" for one in ways
        )
        end = f"; {none}." if undivided else "."
        yield f"± where there is room: runs repeated, springs and step {divided_by}{end}"
    elif undivided and not rows:
        yield f"No error bars: {none}, whose spring has no division."
    large = sorted(
        (row for row in rows if row.numerical > LARGE * abs(row.value) and row.value),
        key=lambda row: -row.numerical / abs(row.value),
    )
    if large:
        names = list(dict.fromkeys(label_of(row.quantity).lower() for row in large))
        more = f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else ""
        named = f"{', '.join(names[:MAX_NAMES])}{more}"
        yield f"Uncertain by more than {100 * LARGE:.0f} %: {named}."
    if without:
        more = f" and {len(without) - 3} more" if len(without) > 3 else ""
        yield f"No error bar of {', '.join(without[:3])}{more}: that run or its repeat did not settle."
