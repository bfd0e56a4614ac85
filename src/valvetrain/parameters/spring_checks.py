"""Refuses springs that cannot exist, each with the reason and the place along the wire."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError
from valvetrain.parameters.curves import Array, Curve
from valvetrain.parameters.material import Material
from valvetrain.units import si

#: Depth, as a share of the wire diameter, up to which free coils may overlap (drawing and rounding slack).
OVERLAP_SLACK = 0.02
#: Turns by which meshes run past both tips, where every curve must still hold a number.
BEYOND_TIPS = 0.5
#: Thinner is no wire (m): its mass and stiffness vanish from the numbers of a computer.
LEAST_LENGTH = 1e-6


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
    @property
    def material(self) -> Material: ...

    def index(self, coil: ArrayLike) -> Array:
        """Mean coil diameter over wire diameter."""

    def coil_gap(self, coil: ArrayLike) -> Array:
        """Free-state gap (m) to the wire one turn below."""


def check_spring(spring: WireShape) -> None:
    """Raise :class:`InputError` when ``spring`` is impossible."""
    for part in ("wire_diameter", "mean_diameter", "pitch"):
        given = getattr(spring, part)
        if not isinstance(given, Curve):
            raise InputError(f"{part} of spring '{spring.name}' is no curve over the coil number; write Constant({given!r}) for one value")
    if not isinstance(spring.material, Material):
        raise InputError(f"material of spring '{spring.name}' is no Material; give one, such as material_by_name('oteva 90 sc')")
    if isinstance(spring.total_coils, str) or not np.isfinite(spring.total_coils) or spring.total_coils <= 0:
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
        _refuse(values < LEAST_LENGTH, coil, spring, f"{label} is less than a micrometre, which no wire is; check its unit")
    _refuse(~np.isfinite(spring.pitch.value(coil)), coil, spring, "pitch is not a finite number")
    _refuse(spring.pitch.value(coil) < 0, coil, spring, "pitch is negative, so the wire runs back through itself; make it positive")
    beyond = np.linspace(-BEYOND_TIPS, spring.total_coils + BEYOND_TIPS, len(coil))
    for law, label in ((spring.wire_diameter, "wire diameter"), (spring.mean_diameter, "mean coil diameter"), (spring.pitch, "pitch")):
        bad = ~(np.isfinite(law.value(beyond)) & np.isfinite(law.derivative(beyond)))
        remedy = f"let its curve go on {BEYOND_TIPS:g} turns past both tips, such as by np.clip of the coil number"
        _refuse(bad, beyond, spring, f"{label} is not a finite number with a slope; {remedy}")
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


def refuse_lost_tip(name: str, kind: str, ground_coils: float, pitch: float, wire: float) -> None:
    """Raise :class:`InputError` where grinding ``ground_coils`` turns at a constant ``pitch`` (m) takes all of the tip's ``wire`` (m)."""
    if ground_coils * pitch > wire * (1 + 1e-9):
        raise InputError(
            f"spring '{name}' has a constant pitch of {pitch * 1e3:.4g} mm, so grinding {ground_coils:g} turns of its {kind} end takes the "
            f"whole tip of the {wire * 1e3:.4g} mm wire; wind the end closed (pitch_with_closed_ends, or a free length), or grind less"
        )


def _refuse(bad: np.ndarray, coil: np.ndarray, spring: WireShape, reason: str) -> None:
    if np.any(bad):
        raise InputError(f"at coil {coil[np.argmax(bad)]:.2f} of spring '{spring.name}' the {reason}")


def _refuse_jumps(spring: WireShape, coil: np.ndarray) -> None:
    """A jump would kink the wire (pitch) or break it (diameters), smeared over one element by every mesh."""
    fine = np.linspace(0.0, spring.total_coils, 4000 * int(np.ceil(spring.total_coils)) + 1)
    wire = float(np.max(spring.wire_diameter.value(coil)))
    pitch, wires, coils = (law.value(fine) for law in (spring.pitch, spring.wire_diameter, spring.mean_diameter))
    for values, scale, what in (
        (pitch, max(wire, float(np.max(np.abs(pitch)))), "pitch jumps, which would kink the wire"),
        (wires, wire, "wire diameter jumps, which no drawn wire does"),
        (coils, wire, "mean coil diameter jumps, which would break the wire"),
    ):
        _refuse(np.abs(np.diff(values, append=values[-1])) > 0.05 * scale, fine, spring, f"{what}; ramp it over a quarter turn or more")
