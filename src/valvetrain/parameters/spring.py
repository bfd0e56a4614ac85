"""The one definition of a coil spring, from which every spring model is derived."""

from __future__ import annotations

from dataclasses import InitVar, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError
from valvetrain.parameters.curves import (
    Constant,
    Curve,
    CurveField,
    HeightForm,
    add_curves,
    curve_of,
    pitch_with_closed_turns,
)
from valvetrain.parameters.material import MaterialField
from valvetrain.parameters.schema_types import (
    FOLLOWS,
    Name,
    PositiveLength,
    Table,
    guarded,
    problem,
    quantity,
    table,
)
from valvetrain.parameters.solid import computed_solid_height
from valvetrain.parameters.winding import EndCoil, EndField, is_closed, refuse_lost_tip, wind
from valvetrain.units import si

#: A spring of more turns than this is taken for a mistake, and would cost minutes to check.
MAX_COILS = 200.0
TotalCoils = Annotated[float, quantity("ratio", low=0.0, high=MAX_COILS, open_low=True)]
#: Depth, as a share of the wire diameter, up to which free coils may overlap (drawing and rounding
#: slack).
OVERLAP_SLACK = 0.02
#: Turns by which meshes run past both tips, where every curve must still hold a number.
BEYOND_TIPS = 0.5
#: Share by which a stated solid height may be off the computed one without a word.
SAME_HEIGHT = 0.01
#: Thinner is no wire (m): its mass and stiffness vanish from the numbers of a computer.
MIN_LENGTH = 1e-6


#: Curve of a wire -> what refusals call it.
_LABELS = {
    "wire_diameter": "wire diameter", "mean_diameter": "mean coil diameter", "pitch": "pitch",
}  # fmt: skip


def check_spring(spring: SpringDefinition) -> None:
    """Raise :class:`InputError` when ``spring`` is impossible."""
    first, last = spring.free_coils
    if last - first < 0.5:
        raise InputError(
            f"spring '{spring.name}' has {spring.total_coils:g} turns of which {spring.total_coils - (last - first):g} are inactive; "
            "at least half a turn must be free: add turns or hold less"
        )
    coil = np.linspace(0.0, spring.total_coils, max(64, int(64 * spring.total_coils)) + 1)
    for key, label in _LABELS.items():
        _check_curve(spring, key, label, coil)
    _refuse(
        spring.index(coil) <= 1.0,
        coil,
        spring,
        "mean coil diameter does not exceed the wire diameter (index at most 1); widen the coil",
    )
    _refuse_jumps(spring, coil)
    _refuse(
        spring.coil_gap(coil) < -OVERLAP_SLACK * spring.wire_diameter.value(coil),
        coil,
        spring,
        "coil overlaps the one below it in the free state; raise the pitch or thin the wire",
    )
    if (solid := spring.stated_solid_height) is not None and not solid < spring.free_length:
        raise InputError(
            f"spring '{spring.name}' is {spring.free_length * 1e3:.4g} mm long, so it is not solid at {solid * 1e3:.4g} mm; check solid_height"
        )
    if isinstance(spring.pitch, Constant):
        for end, tip in ((spring.lower_end, 0.0), (spring.upper_end, spring.total_coils)):
            wire = float(spring.wire_diameter.value(tip))
            refuse_lost_tip(spring.name, end, spring.pitch.level, wire)


def _check_curve(spring: SpringDefinition, key: str, label: str, coil: Array) -> None:
    """Refuse a diameter or pitch that no wire has at one of the coil numbers ``coil``, or none past the tips."""
    law: Curve = getattr(spring, key)
    values = law.value(coil)
    if key == "pitch":
        faults = {
            "is not a finite number": ~np.isfinite(values),
            "is negative, so the wire runs back through itself; make it positive": values < 0,
        }
    else:
        faults = {
            "is not positive; give a positive length": ~(values > 0),
            "is less than a micrometre, which no wire is; check its unit": values < MIN_LENGTH,
        }
    for fault, bad in faults.items():
        _refuse(bad, coil, spring, f"{label} {fault}")
    beyond = np.linspace(-BEYOND_TIPS, spring.total_coils + BEYOND_TIPS, len(coil))
    _refuse(
        ~(np.isfinite(law.value(beyond)) & np.isfinite(law.derivative(beyond))),
        beyond,
        spring,
        f"{label} is not a finite number with a slope; let its curve continue {BEYOND_TIPS:g} turns past both tips, "
        "such as by np.clip of the coil number",
    )
    # millimetres taken for metres are 0.2 m or more; smaller values meet the checks of the shape
    if (largest := float(np.max(values))) >= 0.2:
        si(largest, key, f"{key} of spring '{spring.name}'")


def _refuse(bad: np.ndarray, coil: np.ndarray, spring: SpringDefinition, reason: str) -> None:
    if np.any(bad):
        raise InputError(
            f"at coil {coil[np.argmax(bad)]:.2f} of spring '{spring.name}' the {reason}"
        )


def _refuse_jumps(spring: SpringDefinition, coil: np.ndarray) -> None:
    """A jump would kink the wire (pitch) or break it (diameters), smeared over one element by every
    mesh.
    """
    fine = np.linspace(0.0, spring.total_coils, 4000 * int(np.ceil(spring.total_coils)) + 1)
    wire = float(np.max(spring.wire_diameter.value(coil)))
    pitch, wires, coils = (
        law.value(fine) for law in (spring.pitch, spring.wire_diameter, spring.mean_diameter)
    )
    for values, scale, what in (
        (pitch, max(wire, float(np.max(np.abs(pitch)))), "pitch jumps, which would kink the wire"),
        (wires, wire, "wire diameter jumps, which no drawn wire does"),
        (coils, wire, "mean coil diameter jumps, which would break the wire"),
    ):
        _refuse(
            np.abs(np.diff(values, append=values[-1])) > 0.05 * scale,
            fine,
            spring,
            f"{what}; ramp it over a quarter turn or more",
        )


def _wound(
    key: str, form: Any, turns: float, wire: Curve, ends: tuple[Any, Any]
) -> tuple[Curve, EndCoil, EndCoil]:
    """Pitch law and both ``ends``, by what is given at ``key``: a pitch, a height or the free length."""
    if key == "free_length":
        return wind(turns, wire, form, *ends)
    closed = tuple(float(is_closed(end)) for end in ends)
    pitch = curve_of(form, turns, wire)
    if isinstance(form, float) and any(closed) and isinstance(wire, Constant):
        pitch = pitch_with_closed_turns(turns, wire.level, form, *closed)
    lower, upper = (end if isinstance(end, EndCoil) else EndCoil(end) for end in ends)
    return pitch, lower, upper


def given_once(**ways: Any) -> tuple[str, Any]:
    """The way that is given, with its value; refuses none and several."""
    given = [key for key, value in ways.items() if value is not None]
    if len(given) > 1:
        raise problem(
            f"{' and '.join(given)} are {'both' if len(given) == 2 else 'all'} given and may contradict each other; give one",
            (given[1],),
        )
    if not given:
        raise problem(f"neither {' nor '.join(ways)} is given; add one")
    return given[0], ways[given[0]]


@table("the spring")
class SpringDefinition(Table):
    """The wire of a coil spring: laws over the coil number ``u`` in [0, total_coils], counted from the lower
    wire tip.

    ``wire_diameter`` and ``mean_diameter`` in m, ``pitch`` = rise of the wire axis per turn dz/du
    in m; a length is a constant, as a pitch that between closed ends. The pitch must be continuous (its slope
    may jump). ``outer_diameter`` may stand in place of the mean one, ``height`` (of the wire axis over the coils) or
    ``free_length`` (m) in place of the pitch, ``ends`` in place of both ends. ``stated_solid_height``, given as
    ``solid_height``: that (m) of a card or drawing, in place of the computed one.
    Raises :class:`InputError` with the reason for a spring that cannot exist.

    >>> spring = SpringDefinition("4 mm", "22 mm", "7 mm", total_coils=7, material="OTEVA 90 SC", ends="open")
    >>> round(spring.free_length * 1e3, 3)  # seven turns of 7 mm, and the wire
    53.0
    """

    wire_diameter: CurveField
    mean_diameter: CurveField = Field(default=FOLLOWS)
    pitch: CurveField = Field(default=FOLLOWS)
    total_coils: TotalCoils = Field(kw_only=True)
    material: MaterialField = Field(kw_only=True)
    lower_end: EndField = Field(default=FOLLOWS)
    upper_end: EndField = Field(default=FOLLOWS)
    hand: Literal["right", "left"] = Field(default="right", description="sense of winding")
    name: Name = Field(default=FOLLOWS)
    stated_solid_height: PositiveLength | None = Field(
        default=None,
        alias="solid_height",
        description="at coil bind, as a card states it; without it computed",
    )
    outer: InitVar[CurveField | None] = Field(default=None, alias="outer_diameter")
    height: InitVar[HeightForm | None] = None
    free: InitVar[PositiveLength | None] = Field(
        default=None,
        alias="free_length",
        description="unloaded length, from which the pitch follows",
    )
    ends: InitVar[EndField | None] = Field(
        default=None, description="kind of both ends; without it closed-ground"
    )

    if TYPE_CHECKING:  # accepted types are wider than the stored ones

        def __init__(
            self, wire_diameter: Any, mean_diameter: Any = None, pitch: Any = None, **more: Any
        ) -> None: ...

    def __post_init__(self, outer: Any, height: Any, free: float | None, ends: Any) -> None:
        turns = self.total_coils
        wire = guarded(curve_of, self.wire_diameter, turns, path=("wire_diameter",))
        key, form = given_once(mean_diameter=self.mean_diameter, outer_diameter=outer)
        mean = guarded(curve_of, form, turns, path=(key,))
        if key == "outer_diameter":
            mean = add_curves(mean, wire, -1.0)
        key, form = given_once(pitch=self.pitch, height=height, free_length=free)
        if ends is not None and (self.lower_end is not None or self.upper_end is not None):
            raise problem(
                "'ends' speaks for both ends, so lower_end and upper_end contradict it; give one or the other",
                ("ends",),
            )
        both = (
            self.lower_end or ends or "closed-ground", self.upper_end or ends or "closed-ground",
        )  # fmt: skip
        pitch, lower, upper = guarded(_wound, key, form, turns, wire, both, path=(key,))
        values = {"wire_diameter": wire, "mean_diameter": mean, "pitch": pitch, "lower_end": lower}
        for name, value in {**values, "upper_end": upper, "name": self.name or "spring"}.items():
            object.__setattr__(self, name, value)
        guarded(check_spring, self)

    def replace(self, **changes: Any) -> SpringDefinition:
        """A copy with the named fields changed."""
        return replace(self, **changes)

    def axial_position(self, coil: ArrayLike) -> Array:
        """Height z (m) of the wire axis above its lower tip at coil number ``coil``."""
        return self.pitch.integral(coil)

    def centreline(self, coil: ArrayLike) -> Array:
        """Wire axis, shape (..., 3), in m; z runs from seat to retainer and z = 0 at the lower tip."""
        coil = np.asarray(coil, dtype=float)
        radius, angle = self.mean_diameter.value(coil) / 2, 2 * np.pi * coil
        sign = 1.0 if self.hand == "right" else -1.0
        return np.stack(
            [radius * np.cos(angle), sign * radius * np.sin(angle), self.axial_position(coil)],
            axis=-1,
        )

    def line_speed(self, coil: ArrayLike) -> Array:
        """Arc length per turn ds/du (m)."""
        coil = np.asarray(coil, dtype=float)
        radius, growth = self.mean_diameter.value(coil) / 2, self.mean_diameter.derivative(coil) / 2
        return np.sqrt((2 * np.pi * radius) ** 2 + growth**2 + self.pitch.value(coil) ** 2)

    def integrate_along_wire(
        self,
        weight: Curve | None = None,
        power: int = 0,
        between: tuple[float, float] | None = None,
    ) -> float:
        """Integral of ``weight(u)**power`` ds over the wire (or ``between`` two coil numbers), in
        SI units.
        """
        first, last = between or (0.0, self.total_coils)
        panels = max(4, int(np.ceil((last - first) * 16)))
        nodes, weights = np.polynomial.legendre.leggauss(4)
        edges = np.linspace(first, last, panels + 1)
        coil = (edges[:-1, None] + np.diff(edges)[:, None] * (nodes + 1) / 2).ravel()
        scale = (np.diff(edges)[:, None] * weights / 2).ravel()
        density = self.line_speed(coil)
        if weight is not None:
            density = density * weight.value(coil) ** power
        return float(scale @ density)

    @cached_property
    def wire_length(self) -> float:
        """Length of the wire axis, tip to tip (m)."""
        return self.integrate_along_wire()

    @cached_property
    def mass(self) -> float:
        """Mass of the whole wire (kg), the ground-off part of the end coils included."""
        return float(
            np.pi / 4 * self.material.density * self.integrate_along_wire(self.wire_diameter, 2)
        )

    @property
    def free_coils(self) -> tuple[float, float]:
        """First and last coil number of the wire that is free to move (between the fixed ends)."""
        return self.lower_end.inactive_coils, self.total_coils - self.upper_end.inactive_coils

    @cached_property
    def active_coils(self) -> float:
        """Turns that deform: total turns less those lying closed on their neighbour at either end."""
        coil = np.linspace(*self.free_coils, 2001)
        above, below = self.coil_gap(coil + 1.0) > 1e-6, self.coil_gap(coil) > 1e-6
        return float((coil[-1] - coil[0]) * np.mean(above | below))

    @property
    def active_mass(self) -> float:
        """Mass of the wire between the fixed ends (kg)."""
        squares = self.integrate_along_wire(self.wire_diameter, 2, self.free_coils)
        return float(np.pi / 4 * self.material.density * squares)

    def index(self, coil: ArrayLike) -> Array:
        """Spring index, mean coil diameter over wire diameter."""
        return self.mean_diameter.value(coil) / self.wire_diameter.value(coil)

    def outer_diameter(self, coil: ArrayLike) -> Array:
        """Mean diameter plus wire diameter (m)."""
        return self.mean_diameter.value(coil) + self.wire_diameter.value(coil)

    def coil_gap(self, coil: ArrayLike) -> Array:
        """Free-state gap (m) between the wire at ``coil`` and one turn below; infinite where there
        is none.
        """
        inside, upper, shift, wire = self._turn_below(coil)
        rise = self.axial_position(upper) - self.axial_position(upper - 1)
        return np.where(inside, np.hypot(rise, shift) - wire, np.inf)

    def _turn_below(self, coil: ArrayLike) -> tuple[Flags, Array, Array, Array]:
        """Whether there is wire one turn below ``coil``; the coil where there is; how much farther out the wire is there than
        one turn below (m), and the mean of both diameters (m).
        """
        coil = np.asarray(coil, dtype=float)
        inside = (coil >= 1.0) & (coil <= self.total_coils)
        upper = np.clip(coil, 1.0, max(self.total_coils, 1.0))
        shift = (self.mean_diameter.value(upper) - self.mean_diameter.value(upper - 1)) / 2
        wire = (self.wire_diameter.value(upper) + self.wire_diameter.value(upper - 1)) / 2
        return inside, upper, shift, wire

    def telescopes(self, coil: ArrayLike) -> Flags:
        """Whether the wire at ``coil`` passes next to the wire one turn below, which then does not
        keep it off the seat.
        """
        inside, _, shift, wire = self._turn_below(coil)
        found: Flags = np.asarray(inside & (np.abs(shift) >= wire), dtype=np.bool_)
        return found

    @cached_property
    def lower_seat_height(self) -> float:
        """Height z (m) of the lower seat plane: it touches the underside of the wire where grinding
        ends.
        """
        end = self.lower_end.ground_coils
        return float(self.axial_position(end) - self.wire_diameter.value(end) / 2)

    @cached_property
    def upper_seat_height(self) -> float:
        """Height z (m) of the retainer plane in the free state."""
        end = self.total_coils - self.upper_end.ground_coils
        return float(self.axial_position(end) + self.wire_diameter.value(end) / 2)

    @cached_property
    def free_length(self) -> float:
        """Unloaded length between the seat planes (m)."""
        return self.upper_seat_height - self.lower_seat_height

    @cached_property
    def solid_height(self) -> float:
        """Length between the seat planes (m) at coil bind: the stated one, else :attr:`computed_solid_height`."""
        stated = self.stated_solid_height
        return self.computed_solid_height if stated is None else stated

    @cached_property
    def computed_solid_height(self) -> float:
        """Length (m) under the force that closes the last coil; see :func:`~valvetrain.parameters.solid.computed_solid_height`."""
        return computed_solid_height(self)

    @property
    def solid_heights_differ(self) -> bool:
        """Whether the stated solid height is off the computed one by more than :data:`SAME_HEIGHT`."""
        stated = self.stated_solid_height
        return stated is not None and abs(self.computed_solid_height / stated - 1) > SAME_HEIGHT

    @property
    def solid_compression(self) -> float:
        """Shortening (m) from the free length at which every coil touches the one below."""
        return self.free_length - self.solid_height

    def refuse_solid(self, compression: float, where: str = "") -> None:
        """Raise :class:`InputError`, of the option ``where``, for a compression (m from the free
        length) that is negative, no number or solid.
        """
        if not 0 <= compression < self.solid_compression:
            raise InputError(
                f"spring '{self.name}' takes no compression of {compression * 1e3:.4g} mm: it is free at 0 and solid at "
                f"{self.solid_compression * 1e3:.4g} mm; choose a height between solid and free",
                where,
            )

    def solid_rise(self, coil: ArrayLike) -> Array:
        """Rise per turn (m) of the wire axis where every coil touches the one below, or next to it."""
        coil = np.asarray(coil, dtype=float)
        wire, (first, last) = self.wire_diameter.value(coil), (0.0, self.total_coils)
        low, high = (
            self.mean_diameter.value(np.clip(coil + away, first, last)) / 2 for away in (-0.5, 0.5)
        )
        rise = np.sqrt(np.maximum(wire**2 - (high - low) ** 2, 0.0))
        found: Array = np.minimum(rise, np.maximum(self.pitch.value(coil), 0.0))
        return found
