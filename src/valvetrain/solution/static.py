"""Static compression of a spring: force and stiffness over compression, with coils closing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.solution.display import Saveable, frame, span, value_text
from valvetrain.solution.modes import ModalResult, check_shapes
from valvetrain.solution.status import COMPLETED, Status
from valvetrain.units import Given, si

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, slots=True)
class RestPoint:
    """A spring at rest at one compression; SI, None where the model or the data of the spring do
    not give it.

    ``compression`` from the free length (m), ``height`` between the seats (m), ``force`` (N),
    ``stiffness`` dF/dx (N/m). ``nominal_shear_stress``: by EN 13906-1 from the force;
    ``shear_stress`` and ``equivalent_stress``: the largest at the inner fibre along the wire, from
    its section loads (Pa). On the retainer by the wire: ``torque`` about the axis (N m, positive in
    the sense in which the wire rises), ``moment`` across the axis about the middle of its plane (N
    m), ``side_force`` (N); ``rotation`` of a retainer that may turn (rad, as ``torque``).
    """

    compression: float
    force: float
    stiffness: float
    height: float | None = None
    nominal_shear_stress: float | None = None
    shear_stress: float | None = None
    equivalent_stress: float | None = None
    torque: float | None = None
    moment: float | None = None
    side_force: float | None = None
    rotation: float | None = None


#: Field of a point -> name of its quantity.
POINT_QUANTITIES = {
    "compression": "compression", "height": "height", "force": "force", "stiffness": "rate", "nominal_shear_stress": "nominal_shear_stress",
    "shear_stress": "shear_stress", "equivalent_stress": "equivalent_stress", "torque": "retainer_torque", "moment": "retainer_moment",
    "side_force": "retainer_side_force", "rotation": "retainer_rotation_angle",
}  # fmt: skip


def named(point: RestPoint, before: str = "") -> dict[str, float]:
    """Name -> value (SI) of all values of a point, each name with the prefix ``before``.

    >>> named(RestPoint(7e-3, 280.0, 40e3), "installed_")
    {'installed_compression': 0.007, 'installed_force': 280.0, 'installed_rate': 40000.0}
    """
    values = {name: getattr(point, field) for field, name in POINT_QUANTITIES.items()}
    return {before + name: float(value) for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True)
class Buckling:
    """Where a spring under rising compression buckles: ``compression`` from the free length and
    ``height`` (m), ``force`` (N).
    """

    compression: float
    height: float
    force: float


@dataclass(frozen=True, slots=True)
class Leaning:
    """A spring in a guide: ``compression`` from the free length (m) at which its wire first touches
    a wall, and ``force``, the sum of the normal forces there (N) at the end of the curve.
    """

    compression: float
    force: float


@dataclass(frozen=True, eq=False)
class StaticCurve(Saveable):
    """Static curve from the free state; SI, dimensions after the names.

    ``compression`` (step) m, ``force`` (step) N, ``stiffness`` (step) N/m tangent; ``coil_gap``
    (step, coil_pair) m and ``coil_contact_force`` (step, coil_pair) N with ``upper_coil``
    (coil_pair); ``axial_position`` (step, wire_point) m with ``coil_number`` (wire_point). Arrays
    that a model does not compute have zero pairs or points. ``path``: the same curve on points that
    do not depend on the number of steps, the installed state among them, used for interpolation.
    ``buckling``: None where the spring does not buckle or the model cannot predict it; ``leaning``:
    None where it touches no guide.

    >>> import numpy as np
    >>> steps, none = np.linspace(0, 8e-3, 9), np.zeros((9, 0))
    >>> curve = StaticCurve(steps, 40e3 * steps, np.full(9, 40e3), none, none, np.zeros(0), none, np.zeros(0))
    >>> round(curve.force_at("7.5 mm"), 9)
    300.0
    >>> curve
    StaticCurve: 0 to 8 mm in 9 steps, 0 to 320 N, completed
      stiffness 40 N/mm first, 40 N/mm last
    """

    compression: Array
    force: Array
    stiffness: Array
    coil_gap: Array
    coil_contact_force: Array
    upper_coil: Array
    axial_position: Array
    coil_number: Array
    status: Status = COMPLETED
    path: StaticCurve | None = None
    buckling: Buckling | None = None
    leaning: Leaning | None = None

    def __post_init__(self) -> None:
        steps, pairs, points = len(self.compression), len(self.upper_coil), len(self.coil_number)
        expected = {
            "force": (steps,), "stiffness": (steps,), "coil_gap": (steps, pairs),
            "coil_contact_force": (steps, pairs), "axial_position": (steps, points),
        }  # fmt: skip
        check_shapes(self, "a static curve", expected)

    def __repr__(self) -> str:
        reach = f"{span(self.compression, 'm')} in {len(self.compression)} steps, {span(self.force, 'N')}"
        lines = [f"StaticCurve: {reach}, {self.status.sentence()}"]
        if len(self.compression):
            pairs = f"; {len(self.upper_coil)} coil pairs" if len(self.upper_coil) else ""
            lines.append(
                f"stiffness {value_text(self.stiffness[0], 'N/m')} first, {value_text(self.stiffness[-1], 'N/m')} last{pairs}"
            )
        return "\n  ".join(lines)

    def to_pandas(self) -> pandas.DataFrame:
        """Force, stiffness, gaps and contact forces of the coils (SI) by compression (m);
        ``attrs["units"]`` holds the units.
        """
        columns: dict[str, Array] = {
            "compression": self.compression,
            "force": self.force,
            "stiffness": self.stiffness,
        }
        units = {"compression": "m", "force": "N", "stiffness": "N/m"}
        for name, unit, values in (
            ("coil_gap", "m", self.coil_gap),
            ("coil_contact_force", "N", self.coil_contact_force),
        ):
            names = [f"{name}[{coil:g}]" for coil in self.upper_coil]
            columns |= dict(zip(names, np.asarray(values).T, strict=True))
            units |= dict.fromkeys(names, unit)
        return frame(columns, "compression", units)

    def force_at(self, compression: Given) -> float:
        """Force (N) at a compression (m, "7.5 mm" or a pint quantity), a cubic of force and slope
        between the points of ``path``.

        Raises :class:`InputError` outside the curve.
        """
        known, place = self._place(compression)
        low = min(
            max(int(np.searchsorted(known.compression, place)) - 1, 0),
            max(len(known.compression) - 2, 0),
        )
        pair = slice(low, low + 2)
        ends, force, slope = known.compression[pair], known.force[pair], known.stiffness[pair]
        if len(ends) < 2 or not np.all(np.isfinite(slope)):
            return float(np.interp(place, known.compression, known.force))
        span = float(ends[1] - ends[0])
        t = (place - float(ends[0])) / span
        bend = span * (slope - (force[1] - force[0]) / span)
        return float(
            force[0] + t * (force[1] - force[0]) + t * (1 - t) * ((1 - t) * bend[0] - t * bend[1])
        )

    def stiffness_at(self, compression: Given) -> float:
        """Tangent stiffness (N/m) at a compression, as :meth:`force_at`, straight between the
        points of ``path``.
        """
        known, place = self._place(compression)
        return float(np.interp(place, known.compression, known.stiffness))

    def _place(self, given: Given) -> tuple[StaticCurve, float]:
        compression = si(given, "compression", "compression")
        first, last = float(self.compression[0]), float(self.compression[-1])
        if not first - 1e-12 <= compression <= last + 1e-12:
            reach = f"{first * 1e3:g} to {last * 1e3:g} mm"
            raise InputError(
                f"compression {compression * 1e3:g} mm is outside the static curve ({reach}); compute it further"
            )
        return self.path or self, compression


@dataclass(frozen=True, eq=False)
class StaticStress:
    """Stress at the inner fibre over compression: ``compression`` (n,) m, ``coil_number`` (p,),
    ``shear`` and ``equivalent`` (n, p) Pa.
    """

    compression: Array
    coil_number: Array
    shear: Array
    equivalent: Array

    def shear_at(self, compression: Array) -> Array:
        """Shear (m, p) Pa at compressions (m,) m, straight between the steps and level beyond them."""
        return np.stack(
            [np.interp(compression, self.compression, column) for column in self.shear.T], axis=-1
        )


@dataclass(frozen=True, eq=False)
class SpringAtRest:
    """One installed spring at rest: ``spring`` names the spring, ``model`` the spring model.

    ``curve``: static curve from the free state; ``modes``: natural frequencies about the installed
    state; ``stress``: stress over compression; each None where the model does not give it.
    ``facts``: mesh by label; ``wall_time`` (s). ``installed``: the installed state; ``points``:
    requested states. ``stress_per_force``: nominal shear by EN 13906-1 (Pa per N).
    """

    spring: str
    model: str
    precompression: float = 0.0
    curve: StaticCurve | None = None
    modes: ModalResult | None = None
    stress: StaticStress | None = None
    facts: Mapping[str, float | int | str] = field(default_factory=dict)
    wall_time: float = 0.0
    installed: RestPoint | None = None
    points: tuple[RestPoint, ...] = ()
    stress_per_force: float | None = None
