"""One state of a spring at rest: what it carries at a height, at a load, as installed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RestPoint:
    """A spring at rest at one compression; SI, None where the model or the spring does not tell.

    ``compression`` from the free length (m), ``height`` between the seats (m), ``force`` (N),
    ``stiffness`` dF/dx (N/m).
    ``nominal_shear_stress``: by EN 13906-1 from the force; ``shear_stress`` and
    ``equivalent_stress``: the largest at the inner fibre along
    the wire, from its section loads (Pa). On the retainer by the wire: ``torque`` about the axis (N
    m, positive where it would turn the
    retainer the way the wire rises), ``moment`` across the axis about the middle of its plane (N
    m), ``side_force`` (N); ``rotation`` of a
    retainer that may turn (rad, as ``torque``).
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
    """Name -> value (SI) of all that a point tells, ``before`` in front of each name.

    >>> named(RestPoint(7e-3, 280.0, 40e3), "installed_")
    {'installed_compression': 0.007, 'installed_force': 280.0, 'installed_rate': 40000.0}
    """
    told = {name: getattr(point, field) for field, name in POINT_QUANTITIES.items()}
    return {before + name: float(value) for name, value in told.items() if value is not None}
