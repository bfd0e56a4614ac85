"""Refuses springs that cannot exist, each with the reason and the place along the wire."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError
from valvetrain.parameters.curves import Array, Curve
from valvetrain.units import si

#: Depth, as a share of the wire diameter, up to which free coils may overlap (drawing and rounding slack).
OVERLAP_SLACK = 0.02


class WireShape(Protocol):
    """What the checks ask of a spring; lengths in m over the coil number."""

    @property
    def name(self) -> str: ...
    @property
    def hand(self) -> str: ...
    @property
    def total_coils(self) -> float: ...
    @property
    def free_coils(self) -> tuple[float, float]: ...
    @property
    def wire_diameter(self) -> Curve: ...
    @property
    def mean_diameter(self) -> Curve: ...
    @property
    def pitch(self) -> Curve: ...

    def index(self, coil: ArrayLike) -> Array:
        """Mean coil diameter over wire diameter."""

    def coil_gap(self, coil: ArrayLike) -> Array:
        """Free-state gap (m) to the wire one turn below."""


def check_spring(spring: WireShape) -> None:
    """Raise :class:`InputError` when ``spring`` is impossible."""
    if not np.isfinite(spring.total_coils) or spring.total_coils <= 0:
        raise InputError(f"spring '{spring.name}' has {spring.total_coils} turns; give a positive number of total_coils")
    if spring.hand not in ("right", "left"):
        raise InputError(f"hand '{spring.hand}' of spring '{spring.name}' is unknown; use right or left")
    first, last = spring.free_coils
    if last - first < 0.5:
        raise InputError(
            f"spring '{spring.name}' has {spring.total_coils:g} turns of which {spring.total_coils - (last - first):g} are inactive; "
            "at least half a turn must be free: add turns or hold less"
        )
    coil = np.linspace(0.0, spring.total_coils, max(64, int(64 * spring.total_coils)) + 1)
    for law, label in ((spring.wire_diameter, "wire diameter"), (spring.mean_diameter, "mean coil diameter")):
        values = law.value(coil)
        _refuse(~(values > 0), coil, spring, f"{label} is not positive; give a positive length")
    _refuse(~np.isfinite(spring.pitch.value(coil)), coil, spring, "pitch is not a finite number")
    _refuse(spring.pitch.value(coil) < 0, coil, spring, "pitch is negative, so the wire runs back through itself; make it positive")
    for law, quantity in ((spring.wire_diameter, "wire_diameter"), (spring.mean_diameter, "mean_diameter"), (spring.pitch, "pitch")):
        # millimetres taken for metres are 0.2 m or more; smaller values meet the checks of the shape
        if (largest := float(np.max(law.value(coil)))) >= 0.2:
            si(largest, quantity, f"{quantity} of spring '{spring.name}'")
    thick = spring.index(coil) <= 1.0
    _refuse(thick, coil, spring, "mean coil diameter does not exceed the wire diameter (index at most 1); widen the coil")
    _refuse_jumps(spring, coil)
    gap = spring.coil_gap(coil)
    _refuse(
        gap < -OVERLAP_SLACK * spring.wire_diameter.value(coil),
        coil,
        spring,
        "coil overlaps the one below it in the free state; raise the pitch or thin the wire",
    )


def _refuse(bad: np.ndarray, coil: np.ndarray, spring: WireShape, reason: str) -> None:
    if np.any(bad):
        raise InputError(f"at coil {coil[np.argmax(bad)]:.2f} of spring '{spring.name}' the {reason}")


def _refuse_jumps(spring: WireShape, coil: np.ndarray) -> None:
    """A jump of the pitch would be a kink of the wire, smeared over one element by every mesh."""
    fine = np.linspace(0.0, spring.total_coils, 4000 * int(np.ceil(spring.total_coils)) + 1)
    pitch = spring.pitch.value(fine)
    scale = max(float(np.max(spring.wire_diameter.value(coil))), float(np.max(np.abs(pitch))))
    _refuse(
        np.abs(np.diff(pitch, append=pitch[-1])) > 0.05 * scale,
        fine,
        spring,
        "pitch jumps, which would kink the wire; ramp it over a quarter turn or more",
    )
