"""Error bars of the runs of any case: each run on a finer and a coarser grid too, whose series shows its order;
springs reduced from their rods are judged by runs of those rods.
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
from valvetrain.runs.error_bars import (
    DIVISIONS,
    ROUNDING,
    SPRING_HEADLINES,
    TRAIN_HEADLINES,
    divided,
    grid_bar,
)
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
from valvetrain.runs.workers import map_points
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Fact
from valvetrain.solution.uncertainty import ErrorBars, NoErrorBar, Uncertainty
from valvetrain.springs.modal_uniform import oscillating_modes
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem, Rest

#: Fineness of further grids over that of the case, or its inverse, and of those of a time step alone.
RATIO, STEPS = 1.5, (1.5, 2.25)
#: Parts times time steps up to which a further run is finer: some ten seconds of one core. A count, so that a
#: case gives the same numbers on every machine. Above it two coarser runs serve, the second ``1 / NEAR_RATIO``.
BOUND, NEAR_RATIO = 4e8, 1.25
#: Springs of fewer parts than this surge at other frequencies altogether: further runs take this many, and more.
FEW, MANY = 20, 60
#: Order assumed of a rod and of a time step, and of chains and modes, of which few parts are far from the limit, as
#: is what clashing coils make: they meet node by node.
ROD_ORDER, OTHER_ORDER = 2.0, 1.0
OF_CLASHES = ("clash", "peak_spring", "peak_retainer", "below_", "peak_shear")
#: Numbers that the largest clash gives, by the detail of its event.
ONE_CLASH = {"largest_clash_impulse": "impulse", "largest_clash_energy": "energy"}
#: Lengths that jump where a cam that was just touched is left.
OF_LOFT = ("lift_loss_displacement", "loft_gap", "peak_valve_lift")
#: Models whose grid follows the time step: their further run takes a shorter step alone, as do
#: modes of which no more oscillate.
BY_STEP = ("wave-rod", "wave-rod-clash")
ROD, MODES, REDUCED, SOLID = "finite-element", "modal-uniform", "reduced-rod", "solid"
RODS = (ROD, REDUCED)
#: Cam revolutions of springs alone.
REVOLUTIONS = 2
#: Share of the peak force, and of the least one in the largest surge, that a reduced rod may be off its rod.
PEAK_TOO_FAR, MINIMUM_TOO_FAR = 0.01, 0.02
#: Numbers that differ by a constant from one whose scatter is known, or hold the same peak.
SAME_SCATTER = {"lift_loss_displacement": "peak_valve_lift"}
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
    """A member on another grid: its run, how fine it is over the own one (of a rod that judges its reduced rod: over
    that rod), its step under the own one (None: as the springs require), and whether it ends a revolution sooner.
    """

    ready: PreparedRun
    fineness: float
    steps: float | None = None
    sooner: bool = False


class _Point(NamedTuple):
    """A further run: label, engine speed (rad/s), the factor of its grid, time step (s), cam revolutions (None: as
    the plan has them).
    """

    label: str
    engine_speed: float
    factor: float
    time_step: float | None
    cycles: int | None


def own_error_bars(
    problem: Problem,
    solutions: Sequence[Solution],
    plan: Plan,
    at_rest: Rest,
    workers: int,
    tell: Callable[[int, int], None] | None = None,
) -> ErrorBars:
    """Error bars of the completed ``solutions`` of a problem that ran by ``plan``.

    Scatter of a motion that does not repeat is added. ``at_rest``: the springs at rest as computed for the
    solutions. Raises :class:`PointsStopped` when it is stopped.
    """
    runs = [run for run in solutions if run.status.completed and run.quantities]
    numbers = further_numbers(problem, runs, plan, at_rest, workers, tell)
    rows = tuple(row for run in runs for row in _rows(problem, run, numbers.get(_key(run), ())))
    barred = {(row.label, row.engine_speed) for row in rows}
    missing = tuple(
        NoErrorBar(*_key(run), "not-repeated" if _key(run) in numbers else "no-division")
        for run in runs
        if _key(run) not in barred
    )
    facts = (one for run in runs for one in _too_hard(run, numbers.get(_key(run), ())))
    return ErrorBars(rows, missing, tuple(facts))


def _key(run: Solution) -> tuple[str, float]:
    return run.label, run.engine_speed


def further_numbers(
    problem: Problem,
    runs: Sequence[Solution],
    plan: Plan,
    rest: Rest,
    workers: int,
    tell: Callable[[int, int], None] | None = None,
) -> dict[tuple[str, float], list[tuple[float, Mapping[str, float]]]]:
    """Fineness and numbers (SI) of the further runs of each of ``runs``, by label and engine speed (rad/s)."""
    members = {member.label: member for member in problem.members}
    grids = {_key(run): _factors(members[run.label], run) for run in runs}
    ways: dict[tuple[str, float], _Further] = {}
    for label, factor in dict.fromkeys(
        (label, factor) for (label, _), factors in grids.items() for factor in factors
    ):
        if (way := _way(problem, members[label], rest, factor)) is not None:
            ways[label, factor] = way
    points = [
        _point(problem, run, factor, ways[run.label, factor])
        for run in runs
        for factor in grids[_key(run)]
        if (run.label, factor) in ways
    ]
    again = map_points(
        _run_again,
        (problem, ways, replace(plan, whole=False)),
        points,
        workers,
        processes=bool(problem.members and problem.members[0].gear),
        tell=tell,
        lost=lambda point: {},
    )
    found: dict[tuple[str, float], list[tuple[float, Mapping[str, float]]]] = {}
    for point, numbers in zip(points, again, strict=True):
        fineness = ways[point.label, point.factor].fineness
        found.setdefault((point.label, point.engine_speed), []).append((fineness, numbers))
    return found


def _factors(member: Member, run: Solution) -> tuple[float, ...]:
    """Fineness of the further grids of a run over its own."""
    word, parts = member.model.word, _parts(member, member.springs)
    if word == SOLID:  # one coarser mesh: a finer one takes longer than the run
        return (1 / RATIO,)
    if word in BY_STEP or not parts:
        return STEPS if word in BY_STEP or member.gear is not None else ()
    if word not in RODS and min(parts) < FEW:
        return tuple(factor * MANY / min(parts) for factor in (1.0, RATIO))
    finer = _steps(run) * sum(parts) * RATIO**2 <= BOUND
    grids = (RATIO if finer else 1 / NEAR_RATIO, 1 / RATIO)
    return (1.0, *grids) if word == REDUCED else grids


def _steps(run: Solution) -> float:
    """Time steps of a run."""
    step, cycles = (
        run.statistics.get(name) for name in ("time_step_duration", "steady_cycles_count")
    )
    if not isinstance(step, (int, float)) or not step > 0:
        return 0.0
    turns = float(cycles) if isinstance(cycles, (int, float)) else REVOLUTIONS
    return turns * 4 * math.pi / run.engine_speed / float(step)


def _point(problem: Problem, run: Solution, factor: float, way: _Further) -> _Point:
    """A further run with a time step that its springs carry."""
    own, cycles = run.statistics.get("time_step_duration"), None
    settled = run.statistics.get("steady_cycles_count")
    if way.sooner and problem.kind == TRAIN and isinstance(settled, float) and settled > 1:
        cycles = round(settled) - 1
    never_repeats = run.statistics.get("motion_period_count", 1.0) != 1
    if never_repeats and isinstance(settled, float) and run.model not in (*RODS, SOLID):
        # another revolution of a motion that does not repeat is as good as any
        cycles = min(LONG_SEARCH, round(settled))
    if way.steps is None or not isinstance(own, (int, float)) or way.ready.system is None:
        return _Point(run.label, run.engine_speed, factor, None, cycles)
    limits = [
        STEP_FRACTION * float(spring.stable_time_step())
        for spring in way.ready.system.springs
        if hasattr(spring, "stable_time_step") and run.model not in BY_STEP
    ]
    step = min(float(own) / way.steps, *limits, math.inf)
    return _Point(run.label, run.engine_speed, factor, step, cycles)


def _way(problem: Problem, member: Member, rest: Rest, factor: float) -> _Further | None:
    """A member ``factor`` times as finely divided; None where that changes nothing or cannot run."""
    _, frequencies = statics_of(member, rest)  # numbers are defined by those of the case's own
    own, word, other = _parts(member, member.springs), member.model.word, member
    if word == REDUCED:
        other = _as_rod(member)
    by_step = word in BY_STEP or not own
    try:
        springs = tuple(divided(other, spring, factor) for spring in other.springs)
        if other.model.word == MODES:  # no more modes than still oscillate
            counts = _parts(other, springs)
            springs = tuple(
                one.with_options(MODES, modes=oscillating_modes(one, round(count)))
                for one, count in zip(springs, counts, strict=True)
            )
        ratios = [
            new / old for new, old in zip(_parts(other, springs), own, strict=True) if new != old
        ]
        if by_step or (word == MODES and max(ratios, default=0.0) < 1.0):
            ratios = [factor]
        if not ratios and word != REDUCED:
            return None
        pairs = zip(member.springs, springs, strict=True)
        at_rest = {new: rest[old] for old, new in pairs if old in rest}
        ready = prepare(problem, replace(other, springs=springs), at_rest, problem.record.study)
    except FAILURES:
        return None
    if ready.refusal:
        return None
    # of whole numbers the least change
    fineness = min(ratios, key=lambda one: abs(math.log(one)), default=1.0)
    rod = word in (*RODS, SOLID)
    steps = None if rod else max(factor, 1.0) if by_step or min(own) >= FEW else RATIO
    # a rod is not compared from cycle to cycle: one revolution less shows what it still remembers
    sooner = word in RODS and fineness < 1
    frame = replace(ready.frame, surge_frequencies=frequencies)
    return _Further(replace(ready, frame=frame), fineness, steps, sooner)


def _as_rod(member: Member) -> Member:
    """The rods that the springs of a member are reduced from."""
    from valvetrain.springs.finite_element import SPEC  # loads the rod, which few runs need

    options = member.model.read_options
    springs = tuple(
        spring.with_options(ROD, **options(spring.options_of(REDUCED)).model_dump())
        for spring in member.springs
    )
    return replace(member, model=SPEC, springs=springs)


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
    shared: tuple[Problem, Mapping[tuple[str, float], _Further], Plan], point: _Point
) -> Mapping[str, float]:
    """Numbers of a further run; none of one that failed."""
    problem, further, plan = shared
    ready, step = further[point.label, point.factor].ready, point.time_step
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
    problem: Problem, run: Solution, further: Sequence[tuple[float, Mapping[str, float]]]
) -> Iterable[Uncertainty]:
    """Error bars of a run from its ``further`` runs; none where these had no further parts to take."""
    (springs,) = (one.springs for one in problem.members if one.label == run.label)
    known = [
        (fineness, numbers)
        for fineness, numbers in further
        if any(name in numbers and numbers[name] != run.quantities.get(name) for name in NAMES)
    ]
    clashes = run.quantities.get("clash_count", 0.0) > 0
    # one of the runs keeps contact with its cam, and one does so only as far as its surge goes: the next may leave it
    every = (run.quantities, *(numbers for _, numbers in known))
    least = "minimum_cam_contact_force"
    forces = [one[least] for one in every if least in one]
    surge = run.quantities.get("surge_amplitude_force", 0.0)
    touching = bool(forces) and min(forces) <= surge and max(forces) > 0.0
    chain_of_wire = run.model == "multi-mass" and any(spring.wire is not None for spring in springs)
    for name in NAMES:
        value = run.quantities.get(name, math.nan)
        grids = [(fineness, numbers.get(name, math.nan)) for fineness, numbers in known]
        grids = [(fineness, again) for fineness, again in grids if math.isfinite(again)]
        if not grids or not math.isfinite(value) or 0 < abs(value) < ROUNDING:
            continue
        order = ROD_ORDER if run.model in (*RODS, SOLID) else OTHER_ORDER
        if (clashes and any(one in name for one in OF_CLASHES)) or (touching and name in OF_LOFT):
            order = OTHER_ORDER
        found = grid_bar(value, grids, order, of_model=run.model == REDUCED)
        bar = found.uncertainty
        bar += run.quantities.get(f"cycle_scatter_{SAME_SCATTER.get(name, name)}", 0.0)
        if name == "loss_of_contact_duration":
            bar += marginal_duration(run.events)
        if name in ONE_CLASH:
            bar += next_to_largest(run.events, ONE_CLASH[name])
        if chain_of_wire:
            bar += CHAIN_OF_WIRE.get(name, 0.0) * run.quantities.get("surge_amplitude_force", 0.0)
        same = (value, value)
        yield Uncertainty(
            name, run.engine_speed, value, bar, found.observed_order, found.extrapolated, 0.0, same, same, run.label,
        )  # fmt: skip


def _too_hard(run: Solution, further: Sequence[tuple[float, Mapping[str, float]]]) -> list[Fact]:
    """How far the peak, and the least force, of a reduced rod are from its rod's, where that is too far."""
    rod = next((numbers for fineness, numbers in further if fineness == 1), {})
    ends = "peak_spring_force", "minimum_spring_force"
    if run.model != REDUCED or any(name not in rod for name in ends):
        return []
    apart = [abs(run.quantities[name] - rod[name]) for name in ends]
    peak = apart[0] / abs(rod[ends[0]])
    least = apart[1] / max(rod[ends[0]] - rod[ends[1]], 1e-12)
    if peak <= PEAK_TOO_FAR and least <= MINIMUM_TOO_FAR:
        return []
    shares = {"peak_share": peak, "minimum_share": least}
    return [Fact("too-hard", {"label": run.label, "engine_speed": run.engine_speed, **shares})]
