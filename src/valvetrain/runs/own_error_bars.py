"""Error bars of the runs of any case: each run twice more, its springs and its step divided more
finely and more coarsely; springs reduced from their rods are compared with those rods, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from valvetrain.integrate.contract import STEP_FRACTION, Keep, Periodic
from valvetrain.integrate.train_channels import LONG_SEARCH
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.clash import next_to_largest
from valvetrain.quantities.train_events import marginal_duration
from valvetrain.runs.at_rest import AtRest
from valvetrain.runs.error_bars import DOUBTFUL, SPRING_HEADLINES, two_grids
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
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem, Rest

#: Divisions of the springs of the two further runs over that of the case, or their inverse: two, since one pair may agree
#: by chance. Finite elements, whose cost grows with the square, take the inverse of both where those can run.
RATIO, NEAR_RATIO = 1.5, 1.25
#: Springs of fewer parts than this surge at other frequencies altogether: a further run takes this many.
FEW, MANY = 20, 60
#: Factor on the larger of two bars, where a bar of one pair has Roache's three.
SAFETY = 2.0
#: Order assumed of a rod, whose refinement shows it, and of chains and modes, of which few parts are far
#: from the limit, as is what clashing coils of a rod make: they meet node by node.
ROD_ORDER, OTHER_ORDER = 2.0, 1.0
#: That of a reduced rod, whose shapes change with its division: its numbers show none (as far from those of 1.5
#: times fewer elements as from those of 1.5 times more, at the median), so the difference itself is taken.
NO_ORDER = 0.0
OF_CLASHES = ("clash", "peak_spring", "peak_retainer", "below_", "peak_shear")
#: Numbers that the largest clash gives, by the detail of its event.
ONE_CLASH = {"largest_clash_impulse": "impulse", "largest_clash_energy": "energy"}
#: Lengths that jump where a cam that was just touched is left.
OF_LOFT = ("lift_loss_displacement", "loft_gap", "peak_valve_lift")
#: Models whose grid follows the time step: their further run takes a shorter step alone, as do
#: modes of which no more oscillate.
BY_STEP = ("wave-rod", "wave-rod-clash")
ROD, MODES, REDUCED, SOLID = "finite-element", "modal-uniform", "reduced-rod", "solid"
#: Numbers that differ by a constant from one whose scatter is known, or hold the same peak.
SAME_SCATTER = {
    "lift_loss_displacement": "peak_valve_lift",
    "below_20_khz_peak_spring_force": "peak_spring_force",
    "below_10_khz_peak_spring_force": "peak_spring_force",
}
#: Share of a value that its uncertainty may be without being named.
LARGE = 0.05
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
    """The run of a member with its springs divided otherwise, its division over the own one, its
    step under the own one (None: as the springs require), and whether it ends a revolution sooner.
    """

    ready: PreparedRun
    ratio: float
    order: float
    steps: float | None
    sooner: bool = False


class _Point(NamedTuple):
    """A further run: label, engine speed (rad/s), its place among those of the label, time step (s),
    cam revolutions (None: as the plan has them).
    """

    label: str
    engine_speed: float
    place: int
    time_step: float | None
    cycles: int | None


def own_error_bars(
    problem: Problem,
    solutions: Sequence[Solution],
    plan: Plan,
    at_rest: Later[AtRest],
    workers: int,
    tell: Callable[[int, int], None] | None = None,
) -> ErrorBars:
    """Error bars of the completed ``solutions`` of a problem that ran by ``plan``.

    The bar is the larger of those of two pairs of grids, twice the difference to the limit of the
    assumed order, or Roache's three times that of one pair; scatter of a motion that does not
    repeat is added. ``at_rest``: the springs at rest as computed for the solutions. Raises
    :class:`PointsStopped` when it is stopped.
    """
    further: dict[str, list[_Further]] = {}
    rest = at_rest.value.springs
    undivided: list[str] = []
    reduced = [member for member in problem.members if member.model.word == REDUCED]
    from_rods: Mapping[tuple[str, float], Mapping[str, float]] = {}
    far: tuple[str, ...] = ()
    if reduced:
        from valvetrain.runs.against_rod import (
            differences_from_rods,
        )  # loads the rod, which few runs need

        from_rods, far = differences_from_rods(problem, reduced, solutions, rest, workers)
    for member in problem.members:
        found = _further(problem, member, rest)
        if not found:
            undivided.append(member.model.word)
        else:
            further[member.label] = found
    runs = [
        run for run in solutions if run.status.completed and run.label in further and run.quantities
    ]
    points = [
        _point(problem, run, place, way)
        for run in runs
        for place, way in enumerate(further[run.label])
    ]
    again = map_points(
        _run_again,
        (problem, further, replace(plan, whole=False, later=False)),
        points,
        workers,
        processes=bool(problem.members and problem.members[0].gear),
        tell=tell,
        lost=lambda point: {},
    )
    numbers: dict[tuple[str, float], list[tuple[_Further, Mapping[str, float]]]] = {}
    for point, found_again in zip(points, again, strict=True):
        way = further[point.label][point.place]
        numbers.setdefault((point.label, point.engine_speed), []).append((way, found_again))
    rows = tuple(
        row
        for run in runs
        for key in [(run.label, run.engine_speed)]
        for row in _rows(run, numbers[key], from_rods.get(key, {}))
    )
    barred = {(row.label, row.engine_speed) for row in rows}
    without = [
        f"{run.label} at {run.engine_speed * 30 / math.pi:.6g} rpm"
        for run in solutions
        if run.label in further and (run.label, run.engine_speed) not in barred
    ]
    ways = [way for several in further.values() for way in several]
    return ErrorBars(rows, (*_sentences(rows, ways, undivided, without), *far))


def _point(problem: Problem, run: Solution, place: int, way: _Further) -> _Point:
    """A further run with a time step that its springs carry."""
    own, cycles = run.statistics.get("time_step_duration"), None
    settled = run.statistics.get("steady_cycles_count")
    if way.sooner and problem.kind == TRAIN and isinstance(settled, float) and settled > 1:
        cycles = round(settled) - 1
    never_repeats = run.statistics.get("motion_period_count", 1.0) != 1
    if never_repeats and isinstance(settled, float) and run.model not in (ROD, SOLID):
        # another revolution of a motion that does not repeat is as good as any
        cycles = min(LONG_SEARCH, round(settled))
    if way.steps is None or not isinstance(own, (int, float)) or way.ready.system is None:
        return _Point(run.label, run.engine_speed, place, None, cycles)
    limits = [
        STEP_FRACTION * float(spring.stable_time_step())
        for spring in way.ready.system.springs
        if hasattr(spring, "stable_time_step") and run.model not in BY_STEP
    ]
    step = min(float(own) / way.steps, *limits, math.inf)
    return _Point(run.label, run.engine_speed, place, step, cycles)


def _further(problem: Problem, member: Member, rest: Rest) -> list[_Further]:
    """A member with its springs divided otherwise, prepared; empty where nothing divides them."""
    rod = member.model.word in (ROD, REDUCED)
    parts = min(_parts(member, member.springs), default=FEW)
    if rod:
        order = ROD_ORDER if member.model.word == ROD else NO_ORDER
        ways = [_way(problem, member, rest, (1 / RATIO, RATIO), None, order)]
        # a rod is not compared from cycle to cycle: one revolution less shows what it still remembers
        ways += [_way(problem, member, rest, (1 / NEAR_RATIO,), None, order, sooner=True)]
    elif member.model.word == SOLID:  # one coarser mesh: a finer one takes longer than the run
        ways = [_way(problem, member, rest, (1 / RATIO,), None, ROD_ORDER)]
    elif member.model.word in BY_STEP:
        ways = [_way(problem, member, rest, (one,), one) for one in (RATIO, NEAR_RATIO)]
    else:
        finer = MANY / parts if parts < FEW else NEAR_RATIO
        ways = [_way(problem, member, rest, (finer,), RATIO if parts < FEW else NEAR_RATIO)]
        ways += [_way(problem, member, rest, (1 / RATIO,), 1.0)]
    return [way for way in ways if way is not None]


def _way(
    problem: Problem,
    member: Member,
    rest: Rest,
    factors: Sequence[float],
    steps: float | None,
    order: float = OTHER_ORDER,
    sooner: bool = False,
) -> _Further | None:
    """The first of ``factors`` on the division of the springs that can run; None: none can."""
    _, frequencies = statics_of(member, rest)  # numbers are defined by those of the case's own
    for factor in factors:
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
            return _Further(replace(ready, frame=frame), ratio, order, steps, sooner)
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
    shared: tuple[Problem, Mapping[str, Sequence[_Further]], Plan], point: _Point
) -> Mapping[str, float]:
    """Numbers of a further run; none of one that failed."""
    problem, further, plan = shared
    ready, step = further[point.label][point.place].ready, point.time_step
    # the stress of the wire is found from all of the motion, and is a number of springs alone
    keep: Keep = "all" if plan.keep == "all" and problem.kind != TRAIN else "ends"
    plan = replace(plan, keep=keep, cycles_to_settle=point.cycles or plan.cycles_to_settle)
    try:
        provenance = provenance_of(problem, ready.member, point.engine_speed, plan.created_at)
        # the rattle of a rod is known from the run itself
        periodic = Periodic(probed=ready.member.model.word != ROD)
        found, _ = integrate_from(
            ready, point.engine_speed, plan, provenance, time_step=step, periodic=periodic
        )
        found = with_quantities(ready, found, plan, {})
    except FAILURES:
        return {}
    return dict(found.quantities) if found.status.completed else {}


def _rows(
    run: Solution,
    further: Sequence[tuple[_Further, Mapping[str, float]]],
    from_rods: Mapping[str, float],
) -> Iterable[Uncertainty]:
    """Error bars of a run from its further runs, with the differences ``from_rods`` that are known;
    none where these had no further parts to take.
    """
    known = [
        (way, numbers)
        for way, numbers in further
        if any(name in numbers and numbers[name] != run.quantities.get(name) for name in NAMES)
    ]
    clashes = run.quantities.get("clash_count", 0.0) > 0
    touching = _may_leave_the_cam(run, known)
    chain_of_wire = run.model == "multi-mass" and any(
        spring.wire is not None for way, _ in known for spring in way.ready.member.springs
    )
    for name in NAMES:
        value = run.quantities.get(name, math.nan)
        pairs = [(way, numbers[name]) for way, numbers in known if name in numbers]
        pairs = [(way, again) for way, again in pairs if math.isfinite(again)]
        if not pairs or not math.isfinite(value) or 0 < abs(value) < ROUNDING:
            continue
        of_clash = clashes and any(one in name for one in OF_CLASHES)
        order = OTHER_ORDER if of_clash else ROD_ORDER
        doubtful = of_clash or len(pairs) < 2 or (touching and name in OF_LOFT)
        safety = DOUBTFUL if doubtful else SAFETY
        bar = max(_bar(value, again, way, min(way.order, order), safety) for way, again in pairs)
        bar += run.quantities.get(f"cycle_scatter_{SAME_SCATTER.get(name, name)}", 0.0)
        bar += abs(from_rods.get(name, 0.0))
        if name == "loss_of_contact_duration":
            bar += marginal_duration(run.events)
        if name in ONE_CLASH:
            bar += next_to_largest(run.events, ONE_CLASH[name])
        if chain_of_wire:
            bar += CHAIN_OF_WIRE.get(name, 0.0) * run.quantities.get("surge_amplitude_force", 0.0)
        finest, best = max((way.ratio, again) for way, again in pairs)
        same = (value, value)
        yield Uncertainty(
            name,
            run.engine_speed,
            value,
            bar,
            None,
            best if finest > 1 else value,
            0.0,
            same,
            same,
            run.label,
        )


def _may_leave_the_cam(
    run: Solution, known: Sequence[tuple[_Further, Mapping[str, float]]]
) -> bool:
    """Whether one of the runs keeps contact with its cam, and one does so only as far as its surge goes: the next may leave it."""
    name, surge = "minimum_cam_contact_force", run.quantities.get("surge_amplitude_force", 0.0)
    found = (run.quantities, *(numbers for _, numbers in known))
    forces = [numbers[name] for numbers in found if name in numbers]
    return bool(forces) and min(forces) <= surge and max(forces) > 0.0


def _bar(value: float, again: float, way: _Further, order: float, safety: float) -> float:
    """Bar of ``value`` by one further run, finer or coarser."""
    if order == NO_ORDER:
        return DOUBTFUL * abs(value - again)
    if way.ratio > 1:
        return two_grids(value, again, way.ratio, order, safety).uncertainty
    return two_grids(again, value, 1 / way.ratio, order, safety).finest_index


def _sentences(
    rows: Sequence[Uncertainty],
    further: Sequence[_Further],
    undivided: Sequence[str],
    without: Sequence[str],
) -> Iterable[str]:
    ways = sorted({one.ratio for one in further}, reverse=True)
    none = f"none by {', '.join(dict.fromkeys(undivided))}"
    if rows and ways:
        large = sorted(
            (row for row in rows if row.numerical > LARGE * abs(row.value) and row.value),
            key=lambda row: -row.numerical / abs(row.value),
        )
        names = list(dict.fromkeys(label_of(row.quantity).lower() for row in large))
        more = f", {len(names) - 1} more" if len(names) > 1 else ""
        over = f"; over {100 * LARGE:.0f} %: {names[0]}{more}" if names else ""
        divided_by = [f"{max(one, 1 / one):.3g}" for one in ways]
        if any(one > 1 for one in ways):
            sides = ["finer" if one > 1 else "coarser" for one in ways]
            pairs = zip(divided_by, sides, strict=True)
            how = " and ".join(f"{number} times {side}" for number, side in pairs)
        else:
            how = f"{' and '.join(divided_by)} times coarser"
        if any(one.ready.member.model.word == SOLID for one in further):
            how += " (of solid along the wire alone, not in the section)"
        yield f"± from runs {how} (all: --json){over}{f'; {none}' if undivided else ''}."
    elif undivided and not rows:
        yield f"No error bars: {none}, whose spring has no division."
    if without:
        more = f" and {len(without) - 3} more" if len(without) > 3 else ""
        yield f"No error bar of {', '.join(without[:3])}{more}: that run or its repeat did not settle."
