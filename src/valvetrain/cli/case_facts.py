"""What a case says, in short lines for people."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.parameters.case import SpringCard
from valvetrain.report.values import value_words
from valvetrain.report.words import number, speed_words

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case
    from valvetrain.parameters.spring import SpringDefinition
    from valvetrain.parameters.train import TrainParameters


def case_facts(case: Case) -> list[tuple[str, str]]:
    """(subject, words) of everything the case holds; values that follow from it stand in its named quantities."""
    facts = [("title", case.title)] if case.title else []
    if case.spring is not None:
        facts += _spring_facts(case.spring)
        facts.append(("seats", "end coils may touch flat seats" if case.installation.seats == "planes" else "held ends only"))
    if case.spring_card is not None:
        facts.append(("spring", f"known by its card '{case.spring_card.name}'"))
    if case.lift_law is not None:
        law = case.lift_law
        facts.append(("lift law", f"{law.kind}, lift of the {law.lift_of}"))
    if case.train is not None:
        facts += _train_facts(case.train)
    if case.damping.mass_damping or case.damping.stiffness_damping:
        ratio = "" if case.damping.ratio is None else f"ratio {number(case.damping.ratio)}: "
        mass, stiffness = number(case.damping.mass_damping), number(case.damping.stiffness_damping * 1e6)
        facts.append(("damping", f"{ratio}mass {mass} 1/s, stiffness {stiffness} us"))
    if case.operation.engine_speeds:
        facts.append(("engine speeds", f"{', '.join(map(speed_words, case.operation.engine_speeds))} of the crank"))
    if case.spring is not None:
        facts.append(("rod", f"{case.rod.elements_per_coil} elements per coil, {case.operation.cycles} cam turns, the last one reported"))
    if case.published:
        roles = Counter(value.role for value in case.published)
        facts.append(("published values", ", ".join(f"{count} for {role}" for role, count in roles.items())))
    statuses = Counter(note.status for note in case.notes.values() if note.status)
    if statuses:
        facts.append(("status of values", ", ".join(f"{count} {status}" for status, count in statuses.items())))
    return facts


def _train_facts(train: TrainParameters) -> list[tuple[str, str]]:
    facts = [("train", f"{train.kind}, {train.model} model, {train.spring_model} springs, lash {number(train.lash * 1e3)} mm")]
    for name in train.springs:
        parts = []
        for part in train.spring_parts(name):
            if isinstance(part, SpringCard):
                mass = "" if part.mass is None else f", mass {number(part.mass * 1e3)} g"
                parts.append(f"{part.name}: rate {number(part.rate / 1e3)} N/mm, preload {number(part.preload)} N{mass}")
            else:
                parts.append(f"{part.definition.name}: wire known, installed at {number(part.installed_height * 1e3)} mm")
        facts.append((f"springs '{name}'", "; ".join(parts)))
    return facts


def _spring_facts(spring: SpringDefinition) -> list[tuple[str, str]]:
    ends = [
        f"{side} {end.kind}, {number(end.inactive_coils)} coils held, {number(end.ground_coils)} ground"
        for side, end in (("lower", spring.lower_end), ("upper", spring.upper_end))
    ]
    return [
        ("spring", f"{spring.name}, {spring.hand}-handed"), ("wire diameter", value_words(spring.wire_diameter, "wire_diameter")),
        ("mean coil diameter", value_words(spring.mean_diameter, "mean_diameter")), ("pitch", value_words(spring.pitch, "pitch")),
        ("material", value_words(spring.material, "material")), ("end coils", "; ".join(ends)),
    ]  # fmt: skip


def lift_quantities(case: Case) -> dict[str, float]:
    """Largest lift (m) and its cam angle (rad); empty without a lift law."""
    if case.lift_law is None:
        return {}
    from valvetrain.cam.build import build_lift_law

    law = build_lift_law(case.lift_law)
    angle = np.linspace(0.0, 2 * np.pi, 7201)
    lift = np.asarray(law.lift(angle))
    top = int(np.argmax(lift))
    return {"maximum_lift": float(lift[top]), "maximum_lift_cam_angle": float(angle[top])}
