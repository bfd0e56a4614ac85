"""Sentences on what a study was given and does not use."""

from __future__ import annotations

from collections.abc import Iterable

from valvetrain.system.problem import Member


def undamped_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence per spring model without damping on the springs whose damping it leaves out."""
    left_out: dict[str, list[str]] = {}
    for member in members:
        for spring in member.springs:
            if not member.model.damped and (spring.damping.mass_damping or spring.damping.stiffness_damping or spring.damping.ratio):
                names = left_out.setdefault(member.model.word, [])
                names += [] if spring.name in names else [spring.name]
    return tuple(
        f"A {word} spring has no inner motion: the damping of {' and '.join(repr(name) for name in names)} has no effect in it."
        for word, names in left_out.items()
    )
