"""Sentences on what a study was given and does not use."""

from __future__ import annotations

from collections.abc import Iterable

from valvetrain.quantities.buckling import formula_compression
from valvetrain.studies.largest_lift import largest_lift
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem


def undamped_notes(members: Iterable[Member]) -> tuple[str, ...]:
    """A sentence per spring model without damping on the springs whose damping it leaves out."""
    left_out: dict[str, list[str]] = {}
    for member in members:
        for spring in member.springs:
            if not member.model.damped and (
                spring.damping.mass_damping
                or spring.damping.stiffness_damping
                or spring.damping.ratio
            ):
                names = left_out.setdefault(member.model.word, [])
                names += [] if spring.name in names else [spring.name]
    return tuple(
        f"A {word} spring has no inner motion: the damping of {' and '.join(repr(name) for name in names)} has no effect in it."
        for word, names in left_out.items()
    )


def ringing_note(members: Iterable[Member]) -> str:
    """A sentence on the springs to which the case gives no damping although their models have inner
    motion; empty where there are none.
    """
    names: dict[str, None] = {}
    for member in members:
        for spring in member.springs:
            damping = spring.damping
            if member.model.damped and not (
                damping.mass_damping or damping.stiffness_damping or damping.ratio
            ):
                names[repr(spring.name)] = None
    if not names:
        return ""
    springs, its = ("springs", "their") if len(names) > 1 else ("spring", "its")
    return (
        f"The case gives {springs} {' and '.join(names)} no damping, so that surge lives on from cycle to cycle: give {its} "
        "damping, such as 'damping = { ratio = 0.016, ratio_frequency = \"600 Hz\" }' at the first surge frequency (0.016: the beehive of "
        "gu2021)."
    )


def buckling_notes(problem: Problem) -> tuple[str, ...]:
    """A sentence on each wire of a train that buckles by the formula before the largest lift and
    stands in no guide.

    The rod at rest is not solved for a train's run; what it says is a command away.
    """
    found: list[str] = []
    if problem.kind != TRAIN:
        return ()
    for spring in dict.fromkeys(spring for member in problem.members for spring in member.springs):
        place = (
            None
            if spring.wire is None or spring.guide is not None
            else formula_compression(spring.wire)
        )
        if place is not None and place < (
            open_compression := spring.precompression + largest_lift(problem)
        ):
            found.append(
                f"Spring '{spring.name}' buckles at {place * 1e3:.4g} mm compression by the formula of EN 13906-1, before the "
                f"{open_compression * 1e3:.4g} mm at full lift: guide it, or make it shorter or wider; 'valvetrain static' "
                "finds the place by finite elements."
            )
    return tuple(found)
