"""SI values of the units that cases usually name, so that reading them needs no units library: exactly the floats that pint finds."""

from __future__ import annotations

#: Powers of length, mass, time and angle -> unit -> SI value of one.
_BY_POWERS: dict[tuple[float, float, float, float], dict[str, float]] = {
    (1, 0, 0, 0): {
        "m": 1.0, "mm": 0.001, "cm": 0.01, "um": 1e-06, "µm": 1e-06, "in": 0.0254, "inch": 0.0254, "thou": 2.54e-05, "mil": 2.54e-05,
        "ft": 0.30479999999999996,
    },
    (1, 1, -2, 0): {"N": 1.0, "kN": 1000.0, "lbf": 4.4482216152605, "kgf": 9.80665},
    (0, 1, -2, 0): {"N/mm": 1000.0, "N/m": 1.0, "lbf/in": 175.1268352464764, "kN/mm": 1000000.0},
    (0, 1, 0, 0): {"kg": 1.0, "g": 0.001, "lb": 0.45359237, "oz": 0.028349523125},
    (-1, 1, -2, 0): {
        "Pa": 1.0, "kPa": 1000.0, "MPa": 1000000.0, "GPa": 1000000000.0, "bar": 100000.0, "psi": 6894.757293168362,
        "ksi": 6894757.293168363, "N/mm^2": 1000000.0, "N/m^2": 1.0, "N/mm/mm": 1000000.0, "N/m/m": 1.0,
    },
    (0, 0, 0, 1): {"rad": 1.0, "deg": 0.017453292519943295, "degrees": 0.017453292519943295},
    (0, 0, -1, 1): {"rpm": 0.10471975511965977, "rad/s": 1.0, "deg/s": 0.017453292519943295},
    (0, 0, 1, 0): {"s": 1.0, "ms": 0.001, "us": 1e-06, "min": 60.0},
    (0, 0, -1, 0): {"Hz": 1.0, "kHz": 1000.0, "1/s": 1.0, "1/min": 0.016666666666666666, "MHz": 1000000.0},
    (-3, 1, 0, 0): {"kg/m^3": 1.0, "g/cm^3": 999.9999999999999, "g/mm^3": 999999.9999999999},
    (1, 0, -1, 0): {"mm/s": 0.001, "m/s": 1.0, "km/s": 1000.0},
    (1, 0, -2, 0): {"mm/s^2": 0.001, "m/s^2": 1.0},
    (0, 1, -1, 0): {"N*s/m": 1.0, "N*s/mm": 1000.0, "N s/mm": 1000.0, "N s/m": 1.0},
    (2, 1, -2, 0): {"J": 1.0, "mJ": 0.001, "N*m": 1.0, "N m": 1.0, "N mm": 0.001},
    (2, 1, -3, 0): {"W": 1.0},
    (2, 0, 0, 0): {"m^2": 1.0, "mm^2": 1e-06},
    (2, 1, -2, -1): {"N*m/rad": 1.0, "N m/rad": 1.0, "N mm/rad": 0.001},
    (2, 1, 0, 0): {"kg*m^2": 1.0, "kg mm^2": 1e-06, "kg m^2": 1.0, "g mm^2": 1e-09},
    (1, 1, -1, 0): {"N*s": 1.0, "N s": 1.0, "mN s": 0.001},
    (1, 0, 0, -1): {"m/rad": 1.0, "mm/deg": 0.057295779513082325, "mm/rad": 0.001},
    (1, 0, 0, -2): {"m/rad^2": 1.0, "mm/deg^2": 3.282806350011744, "mm/rad^2": 0.001},
    (-0.5, 1, -2, 0): {"N/mm^1.5": 31622.776601683792, "N/m^1.5": 1.0},
    (-1, 0, 1, 0): {"s/m": 1.0},
    (3, 0, 0, 0): {"mm^3": 1e-09, "m^3": 1.0},
    (0, 0, -2, 1): {"rad/s^2": 1.0, "deg/s^2": 0.017453292519943295},
    (1, 1, -2, -1): {"N/rad": 1.0, "N/deg": 57.29577951308232},
    (3, 1, -2, 0): {"N m^2": 1.0, "N mm^2": 1e-06},
    (-1, 1, 0, 0): {"kg/m": 1.0},
    (2, 1, -1, -1): {"N m s/rad": 1.0},
    (1, 0, -3, 0): {"m/s^3": 1.0, "mm/s^3": 0.001},
    (0, 0, 0, -1): {"1/rad": 1.0},
    (1, 1, -3, 0): {"N/s": 1.0},
    (1, 0, 1, -1): {"m s/rad": 1.0},
    (1, 0, 2, -2): {"m s^2/rad^2": 1.0},
}  # fmt: skip
#: Unit -> SI value of one, and its dimension as ``text`` writes it.
USUAL: dict[str, tuple[float, tuple[tuple[str, float], ...]]] = {
    unit: (
        value,
        tuple(
            (f"[{name}]", float(power))
            for name, power in zip(("angle", "length", "mass", "time"), (angle, length, mass, time), strict=True)
            if power
        ),
    )
    for (length, mass, time, angle), units in _BY_POWERS.items()
    for unit, value in units.items()
}
