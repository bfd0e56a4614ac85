"""What a case file says, as short lines, and the quantities that follow before any run."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.parameters.steel_contacts import default_contacts
from valvetrain.parameters.summary import number, value_text
from valvetrain.report.text import amount, speed_text

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case
    from valvetrain.parameters.installed_spring import InstalledSpring
    from valvetrain.parameters.spring import SpringDefinition
    from valvetrain.system.problem import Problem


def case_facts(case: Case) -> list[tuple[str, str]]:
    """(subject, text) of everything the case holds; values that follow from it are in its named
    quantities.
    """
    facts = [("title", case.title)] if case.title else []
    for spring in case.springs:
        facts += _spring_facts(spring)
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
        facts.append(
            (
                "contacts",
                ", ".join(
                    f"{place.replace('_', ' ')} {contact.law}"
                    for place, contact in train.contacts.items()
                ),
            )
        )
        if said := default_contacts(train.contacts):
            facts.append(("", said))
        for name, springs in train.springs.items():
            facts.append((f"springs '{name}'", "; ".join(map(_spring_fact, springs))))
            facts += [
                ("", spring.card.remark) for spring in springs if spring.card and spring.card.remark
            ]
    if case.operation.engine_speeds:
        facts.append(
            (
                "engine speeds",
                f"{', '.join(map(speed_text, case.operation.engine_speeds))} of the crank",
            )
        )
    if case.operation.red_line is not None:
        facts.append(("red line", f"{speed_text(case.operation.red_line)} of the crank"))
    if case.springs:
        cycles = case.operation.cycles or "until the motion repeats"
        facts.append(("cam revolutions", f"{cycles}, the last one reported"))
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
    if case.published:
        roles = Counter(value.role for value in case.published)
        facts.append(
            ("published values", ", ".join(f"{count} for {role}" for role, count in roles.items()))
        )
    statuses = Counter(note.status for note in case.notes.values() if note.status)
    if statuses:
        facts.append(
            (
                "status of values",
                ", ".join(f"{count} {status}" for status, count in statuses.items()),
            )
        )
    return facts


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
    if spring.card is not None and spring.card.remark:
        facts.append(("", spring.card.remark))
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
        ("wire diameter", value_text(wire.wire_diameter, "wire_diameter")),
        ("mean coil diameter", value_text(wire.mean_diameter, "mean_diameter")),
        ("pitch", value_text(wire.pitch, "pitch")),
        ("material", value_text(wire.material, "material")),
        ("end coils", "; ".join(ends)),
    ]


def case_quantities(case: Case, problem: Problem | None) -> dict[str, float]:
    """Named quantities (SI) of the springs of a case, of a nested pair with ``outer_`` and
    ``inner_`` in front, and of its lift, of a train also at the valve.
    """
    from valvetrain.quantities.statics import design_quantities
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
    return (
        found if case.train is None else found | {"rigid_maximum_valve_lift": largest_lift(problem)}
    )
