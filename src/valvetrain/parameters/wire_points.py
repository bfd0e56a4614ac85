"""Points on the wire of a case: which a published study reads, and whether they lie on the wire."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from numbers import Real

from valvetrain import registry
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.installed_spring import InstalledSpring


def point_problem(study: str, points: Mapping[str, float], springs: Iterable[InstalledSpring]) -> tuple[str, str] | None:
    """Why ``points`` (name -> coil number) cannot be read: the name of the first that cannot, empty for all, and a sentence.

    None where all can: their ``study`` names each, and each lies between the lower tip and the end of the shortest wire.
    """
    if not points:
        return None
    if not study:
        return "", "the points are those that a published study reads; name it in 'study', or remove them"
    names = tuple(word.replace(" ", "_") for word in registry.find("sources", study).point_names.values())
    coils = min((spring.wire.total_coils for spring in springs if spring.wire is not None), default=math.inf)
    for name, coil in points.items():
        if name not in names:
            told = nearest(name, names) if names else "it names none; remove them"
            return name, f"study '{study}' reads no point '{name[:40]}'; {told}"
        if isinstance(coil, bool) or not isinstance(coil, Real) or not math.isfinite(coil):
            return name, f"{coil!r} is no coil number; give a number of coils from the lower tip"
        if not 0 <= coil <= coils:
            return name, f"coil {coil:g} lies beyond the wire of {coils:g} coils; give a number from 0 to {coils:g}"
    return None
