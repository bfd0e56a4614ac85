"""Facts of a study and of its runs: inputs that have no effect or need care, what a model leaves out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.steel_contacts import default_contacts
from valvetrain.quantities.clash import PULL
from valvetrain.quantities.forces import surge_engine_speeds
from valvetrain.quantities.statics import formula_compression
from valvetrain.quantities.stress import most_force_of_wire
from valvetrain.runs.prepared import FAILURES, Plan, PreparedRun, largest_lift
from valvetrain.runs.stored_error_bars import load_uncertainty
from valvetrain.runs.train_runs import train_point
from valvetrain.runs.workers import map_points
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Detail, Fact
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem
from valvetrain.system.train_system import TrainSystem
from valvetrain.units import believed

Fields = dict[str, Detail]
#: Tensile strength (Pa) above that of any wire of a valve spring.
MAX_STRENGTH = 2.5e9
#: A raw peak over that below 5 kHz from which a spike is reported with its band.
SPIKE = 1.02


def case_facts(problem: Problem, members: Sequence[Member]) -> tuple[Fact, ...]:
    """Facts of the ``members`` of a problem that no run decides."""
    found: list[Fact] = []
    for member in members:
        cards = [spring for spring in member.springs if spring.card is not None]
        if member.model.word == "finite-element" and cards:
            found.append(Fact("assumed-wire"))
        if member.gear is not None:
            contacts_of = member.gear.parameters.contacts
            if contacts := default_contacts(contacts_of):
                found.append(Fact("default-contacts", contacts))
            if not any(one.friction_coefficient for one in contacts_of.values()):
                rolls = member.gear.parameters.follower.shape == "roller"
                found.append(Fact("no-friction", {"place": "valve_tip" if rolls else "cam"}))
            lever = member.gear.parameters.lever
            if lever is not None and lever.stiffness is None:
                found.append(Fact("rigid-lever", {"ratio": lever.valve_arm / lever.drive_arm}))
            ramp = getattr(member.gear.mechanism.kinematics.law, "assumed_ramp", None)
            if ramp is not None:
                found.append(Fact("assumed-ramp", {"velocity": float(ramp)}))
            found += [Fact("card-alone", {"spring": spring.name}) for spring in cards]
        if member.instead:
            found.append(
                Fact("not-the-default", {"model": member.model.word, "reason": member.instead})
            )
        for spring in member.springs:
            found += _spring_facts(member, spring)
    if problem.kind == TRAIN:
        found += _buckling(problem, members)
    return tuple(one for place, one in enumerate(found) if one not in found[:place])


def _spring_facts(member: Member, spring: InstalledSpring) -> Iterator[Fact]:
    name = {"spring": spring.name}
    damping = spring.damping
    if member.model.damped and not (
        damping.mass_damping or damping.stiffness_damping or damping.ratio
    ):
        yield Fact("no-damping", name)
    if spring.card is not None and spring.card.split:
        yield Fact("split-loads", spring.card.split)
    if member.model.word == "multi-mass" and spring.wire is not None:
        yield from _chain_of_wire(member, spring)
    if not spring.clearances(0.0) and any(one.clearances(0.0) for one in member.springs):
        yield Fact("unknown-solid-height", name)
    wire = spring.wire
    if wire is not None and wire.solid_heights_differ:
        heights: Fields = {"stated": wire.solid_height, "computed": wire.computed_solid_height}
        yield Fact("other-solid-height", {**name, **heights})


def _chain_of_wire(member: Member, spring: InstalledSpring) -> Iterator[Fact]:
    """What a chain of masses takes from the rod that it replaces, and what not."""
    from valvetrain.springs.chain_from_rod import match  # most runs have no chain of a wire

    given = dict(spring.options_of("multi-mass"))
    if not getattr(member.model.read_options(given), "from_rod", False):
        return
    try:
        options = member.model.read_options(given | {"from_rod": False})
        with believed():
            compared = match(member.model.make(spring, options, None), spring)
    except FAILURES:  # its run says why
        return
    force_error, second = compared.errors()
    yield Fact("chain-of-wire", {
        "spring": spring.name, "surge_frequency": compared.surge_frequency, "force_error": force_error,
        "second_frequency_error": math.nan if second is None else second,
        "better": "finite-element" if member.instead else "reduced-rod",
    })  # fmt: skip


def _buckling(problem: Problem, members: Sequence[Member]) -> Iterator[Fact]:
    """Wires of a train without a guide that buckle by the formula before the largest lift: the rod at
    rest is not solved for the run of a train.
    """
    for spring in dict.fromkeys(spring for member in members for spring in member.springs):
        if spring.wire is None or spring.guide is not None:
            continue
        limit, opened = (
            formula_compression(spring.wire),
            spring.precompression + largest_lift(problem),
        )
        if limit is not None and limit < opened:
            limits = {"compression": limit, "open_compression": opened}
            yield Fact("buckles", {"spring": spring.name, **limits})


def run_facts(runs: Iterable[Solution]) -> Iterator[Fact]:
    """Facts of single runs: ends that would pull or lift, solids that follow a train, and clash spikes of solids, whose
    raw heights rest on mesh and contact constants.
    """
    forces = ("minimum_spring_force", "minimum_retainer_force")
    for run in runs:
        name: Fields = {"label": run.label, "engine_speed": run.engine_speed}
        if any(event.kind == PULL for event in run.events):
            yield Fact("ends-pull", name)
        if run.model == "solid" and any(run.quantities.get(one, 0.0) < 0 for one in forces):
            yield Fact("ends-bonded", name)
        if driver := run.statistics.get("driver", ""):
            yield Fact("follows-a-train", {**name,
                "driver": driver, "repeats": run.statistics.get("motion_period_count") == 1.0,
                "force_difference": run.quantities["driver_difference_force"],
            })  # fmt: skip
        raw, below_5 = (
            run.quantities.get(f"main_clash_{band}peak_force", 0.0) for band in ("", "below_5_khz_")
        )
        if run.model == "solid" and raw > SPIKE * below_5 > 0:
            heights: Fields = {"raw_force": raw, "force_below_5_khz": below_5}
            yield Fact("spike", {"engine_speed": run.engine_speed, **heights})


def study_facts(
    problem: Problem, solutions: Sequence[Solution], between: Sequence[Solution]
) -> tuple[Fact, ...]:
    """Facts of a study of a problem with its ``solutions``, and with the runs ``between`` the speeds of a sweep."""
    by_speed = sorted((*solutions, *between), key=lambda run: (run.label, run.engine_speed))
    found = (*case_facts(problem, problem.members), *run_facts(by_speed))
    if load_uncertainty(problem.record):  # a published run is reported next to its measured peaks
        return found
    return (*found, *beyond_wire_facts(problem, solutions))


def with_facts(problem: Problem, solutions: Sequence[Solution]) -> tuple[Solution, ...]:
    """The solutions of a problem, each with the facts that concern it."""
    case = {member.label: case_facts(problem, (member,)) for member in problem.members}
    return tuple(
        run.with_facts(facts) if (facts := (*case[run.label], *run_facts((run,)))) else run
        for run in solutions
    )


def beyond_wire_facts(problem: Problem, solutions: Iterable[Solution]) -> Iterator[Fact]:
    """Runs whose peak force is above that at which all coils are closed, and whose stress is above the
    strength of the wire.
    """
    for run in solutions:
        label: Fields = {"label": run.label, "engine_speed": run.engine_speed}
        own = [one.springs for one in problem.members if one.label == run.label]
        every = {one.name: one for member in problem.members for one in member.springs}
        for spring in own[0] if own else every.values():
            if spring.name not in run.springs and len(run.springs) > 1:
                continue
            first = f"{spring.name}_" if len(run.springs) > 1 else ""
            mine = {
                name.removeprefix(first): one
                for name, one in run.quantities.items()
                if name.startswith(first)
            }
            most, force = most_force_of_wire(spring), mine.get("peak_spring_force", 0.0)
            if force > most:
                shear = mine.get("peak_shear_stress", math.nan)
                numbers = {"solid_force": most, "force": force, "stress": shear}
                yield Fact("above-solid", {**label, "spring": spring.name, **numbers})
            names = ("peak_shear_stress", "open_nominal_shear_stress")
            stress = max(mine.get(one, 0.0) for one in names)
            if stress > mine.get("wire_tensile_strength", MAX_STRENGTH):
                yield Fact("above-strength", {**label, "stress": stress})


#: Distance from a swept speed, over the speed, within which an order speed is no other speed: a
#: tenth of the half-width of a resonance at 5 % damping.
SAME = 0.005


def order_speeds(one: PreparedRun, engine_speeds: Sequence[float]) -> tuple[float, ...]:
    """Engine speeds (rad/s) between the swept ones at which a cam order meets a first surge
    frequency; at most as many as were swept, the highest, where orders are low and surge is strong.

    None for springs without surge (massless), or whose runs take minutes.
    """
    if not isinstance(one.system, TrainSystem) or one.member.model.word == "massless":
        return ()
    if one.system.has_large_springs:
        return ()
    first, last = min(engine_speeds), max(engine_speeds)
    found = {
        speed
        for frequency in one.frame.surge_frequencies
        for speed in surge_engine_speeds(frequency, first, last).values()
        if all(abs(speed - swept) > SAME * swept for swept in engine_speeds)
    }
    return tuple(sorted(found)[-len(engine_speeds) :])


def run_between(
    problem: Problem,
    ready: Sequence[PreparedRun],
    plan: Plan,
    engine_speeds: Sequence[float],
    workers: int,
) -> tuple[Solution, ...]:
    """Reduced solutions at the order speeds of every member."""
    points = [
        (index, speed)
        for index, one in enumerate(ready)
        for speed in order_speeds(one, engine_speeds)
    ]
    shared = problem, tuple(ready), replace(plan, whole=False)
    return tuple(map_points(train_point, shared, points, workers, processes=True)) if points else ()
