"""What a case file says, as short lines, and the quantities that follow before any run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.errors import InputError
from valvetrain.mechanism.pushrod import pushrod_length
from valvetrain.parameters.steel_contacts import default_contacts
from valvetrain.parameters.summary import amount, number, value_text

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case
    from valvetrain.parameters.installed_spring import InstalledSpring
    from valvetrain.parameters.spring import SpringDefinition
    from valvetrain.parameters.train import TrainParameters
    from valvetrain.quantities.kinematics import RigidTable
    from valvetrain.solution.static import RestPoint
    from valvetrain.system.problem import Problem

#: Spring -> its states with the valve closed and at full lift, or why there are none.
Loads = Mapping["InstalledSpring", "tuple[RestPoint, RestPoint] | str"]
NO_LOADS: Loads = MappingProxyType({})


def case_facts(case: Case, loads: Loads = NO_LOADS) -> list[tuple[str, str]]:
    """(subject, text) of everything the case holds; values that follow from it are rows and named quantities. ``loads``: of
    :func:`spring_loads`, why a spring has none.
    """
    facts: list[tuple[str, str]] = []
    for spring in case.springs:
        facts += _spring_facts(spring)
        facts += [("loads", text) for text in _no_load(loads, spring)]
    if case.lift_law is not None:
        facts.append(("lift law", f"{case.lift_law.kind}, lift of the {case.lift_law.lift_of}"))
    if case.train is not None:
        train = case.train
        facts.append(
            (
                "train",
                f"{train.kind}, {train.model} model, {train.model_of()} springs, lash {amount(train.lash * 1e3, 'mm')}",
            )
        )
        facts.append(("", "one valve and its cam: masses, forces and power are per valve"))
        if contacts := default_contacts(train.contacts):
            places = str(contacts["places"]).replace("_", " ")
            facts.append(("contacts", f"usual steel values at {places}"))
        if (lever := train.lever) is not None:
            bends = (
                "rigid"
                if lever.stiffness is None
                else f"{amount(lever.stiffness / 1e6, 'kN/mm')} at the valve tip"
            )
            facts.append(("rocker", f"ratio {lever.valve_arm / lever.drive_arm:.3g}, {bends}"))
        if train.pushrod is not None:
            facts.append(("pushrod", _pushrod_fact(train)))
        springs = train.springs.get(train.spring_set, ())
        if texts := [", ".join((_spring_fact(one), *_no_load(loads, one))) for one in springs]:
            facts.append((f"springs '{train.spring_set}'", "; ".join(texts)))
        for spring in springs:
            facts += _split_loads(spring)
    if case.points:
        facts.append(
            (
                "points on the wire",
                ", ".join(
                    f"{name.replace('_', ' ')} at coil {coil:g}"
                    for name, coil in case.points.items()
                ),
            )
        )
    if assumed := case.record().assumed:
        facts.append(("assumed", ", ".join(assumed)))
    return facts


def _pushrod_fact(train: TrainParameters) -> str:
    rod = train.pushrod
    assert rod is not None
    length = pushrod_length(train)
    between = f"{amount(length * 1e3, 'mm')} between its balls, " if isfinite(length) else ""
    stiffness = (
        "rigid"
        if rod.stiffness is None
        else f"stiffness {amount(rod.stiffness * 1e-6, 'kN/mm')} along its axis"
    )
    return f"{between}mass {number(rod.mass * 1e3)} g, {stiffness}"


def spring_loads(case: Case, problem: Problem | None) -> Loads:
    """The springs in use of a case at rest, with the valve closed and at full lift: wires by the finite-element rod,
    cards by their rate.
    """
    from valvetrain.runs.prepared import largest_lift
    from valvetrain.runs.statics import point_of
    from valvetrain.system.build import default_model

    if problem is None or not problem.moves:
        return NO_LOADS
    lift = largest_lift(problem)
    found: dict[InstalledSpring, tuple[RestPoint, RestPoint] | str] = {}
    train = case.train
    springs = () if train is None else train.springs.get(train.spring_set, ())
    for spring in (*case.springs, *springs):
        closed = spring.precompression
        try:
            model = problem.model_of(default_model(spring), spring)
            found[spring] = point_of(spring, model, closed), point_of(spring, model, closed + lift)
        except InputError as error:
            found[spring] = error.reason
    return found


def _no_load(loads: Loads, spring: InstalledSpring) -> list[str]:
    found = loads.get(spring)
    return [f"no load at full lift: {found}"] if isinstance(found, str) else []


def _spring_fact(spring: InstalledSpring) -> str:
    if spring.card is None:
        return f"{spring.name}: wire known, compressed {amount(spring.precompression * 1e3, 'mm')} when installed"
    card = spring.card
    mass = "" if card.mass is None else f", mass {number(card.mass * 1e3)} g"
    return f"{card.name}: rate {amount(card.rate / 1e3, 'N/mm')}, preload {amount(card.preload, 'N')}{mass}"


def _spring_facts(spring: InstalledSpring) -> list[tuple[str, str]]:
    facts = (
        _wire_facts(spring.wire)
        if spring.wire is not None
        else [("spring", f"known by its card, {_spring_fact(spring)}")]
    )
    if spring.wire is not None:
        facts.append(
            (
                "seats",
                "end coils may touch flat seats"
                if spring.seats == "planes"
                else "inactive ends only",
            )
        )
    facts += _split_loads(spring)
    if spring.guide is not None:
        facts.append(("guide", f"{spring.guide.summary()}, without friction"))
    damping = spring.damping
    if damping.mass_damping or damping.stiffness_damping:
        ratio = "" if damping.ratio is None else f"ratio {number(damping.ratio)}: "
        mass, stiffness = number(damping.mass_damping), number(damping.stiffness_damping * 1e6)
        facts.append(("damping", f"{ratio}mass {mass} 1/s, stiffness {stiffness} µs"))
    for word, options in spring.options.items():
        facts.append(
            (
                f"options of {word}",
                ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in options.items()),
            )
        )
    return facts


def _wire_facts(wire: SpringDefinition) -> list[tuple[str, str]]:
    ends = [
        f"{side} {end.kind}, {number(end.inactive_coils)} coils inactive, {number(end.ground_coils)} ground"
        for side, end in (("lower", wire.lower_end), ("upper", wire.upper_end))
    ]
    return [
        ("spring", f"{wire.name}, {wire.hand}-handed"),
        ("wire diameter", value_text(wire.wire_diameter)),
        ("mean coil diameter", value_text(wire.mean_diameter)),
        ("pitch", value_text(wire.pitch)),
        ("material", value_text(wire.material)),
        ("end coils", "; ".join(ends)),
    ]


def case_quantities(case: Case, problem: Problem | None) -> dict[str, float]:
    """Named quantities (SI) of the springs of a case, of a nested pair with ``outer_`` and
    ``inner_`` in front, and of its lift, of a train also at the valve.
    """
    from valvetrain.quantities.forces import bind_clearances
    from valvetrain.quantities.statics import design_quantities
    from valvetrain.quantities.train_numbers import margin_quantities
    from valvetrain.quantities.valve_events import rigid_events
    from valvetrain.runs.prepared import largest_lift

    springs = case.springs or (case.train.spring_parts() if case.train is not None else ())
    places = ("",) if len(springs) == 1 else ("outer_", "inner_")
    found = {
        place + name: value
        for place, spring in zip(places, springs, strict=False)
        for name, value in design_quantities(spring).items()
    }
    if problem is None or case.lift_law is None:
        return found
    angle = np.linspace(0.0, 2 * np.pi, 7201)
    lift = np.asarray(problem.valve_lift.lift(angle))
    top = int(np.argmax(lift))
    found |= {"maximum_lift": float(lift[top]), "maximum_lift_cam_angle": float(angle[top])}
    largest = found["maximum_lift"]
    if case.train is not None:
        largest = largest_lift(problem)
        found |= {"rigid_maximum_valve_lift": largest}
        gear = problem.members[0].gear
        events = {} if gear is None else rigid_events(gear.mechanism.kinematics)
        found |= {name: one for name, one in events.items() if name.endswith("_range")}
        rigid = rigid_at_top(case, problem)
        found |= {} if rigid is None else margin_quantities(rigid)
    return found | bind_clearances(springs, largest)


def rigid_at_top(case: Case, problem: Problem | None) -> RigidTable | None:
    """The train of a case with rigid parts at the red line, else at its highest engine speed; None where it names none."""
    from valvetrain.quantities.kinematics import rigid_table
    from valvetrain.springs.spec import spring_model
    from valvetrain.system.train_system import TrainSystem

    top = case.operation.top_speed
    member = None if problem is None or not top else problem.members[0]
    if member is None or member.gear is None:
        return None
    system = replace(member, model=spring_model("massless")).system()
    if not isinstance(system, TrainSystem):
        return None
    return rigid_table(system, member.gear.parameters, top / 2)


def _split_loads(spring: InstalledSpring) -> list[tuple[str, str]]:
    """How the total loads of a pair were split between its springs."""
    card = spring.card
    if card is None or not card.split:
        return []
    by, shares = card.split, list[str]()
    for name in ("outer", "inner"):
        rate, load, free = (
            float(by[f"{name}_{end}"]) for end in ("rate", "preload", "free_length")
        )
        rate_text, length = amount(rate / 1e3, "N/mm"), amount(free * 1e3, "mm")
        shares.append(f"{name} {rate_text}, {amount(load, 'N')}, free length {length}")
    split = f"split by {by['rates_by']}, {by['preloads_by']}: {'; '.join(shares)}"
    return [("total loads", split)]
