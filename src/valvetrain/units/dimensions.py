"""The dimensions that the package speaks of, and the units it reads.

Angles carry a dimension of their own here, so "2100 rpm" (an angular speed) is never mistaken for
"35 Hz" (a frequency).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Dimension:
    """A kind of quantity: its SI unit, the unit suggested to users, how it is spoken of and the unit
    suggested to users of inches and pounds, where theirs is another one.
    """

    si_unit: str
    default_unit: str
    phrase: str
    inch_unit: str = ""

    def written(self, number: str = "1", inches_first: bool = False) -> str:
        """``number`` with its unit as a remedy shows it, in both systems where they differ.

        >>> DIMENSIONS["stiffness"].written(), DIMENSIONS["angle"].written("3")
        ("'1 N/mm' or '1 lbf/in'", "'3 deg'")
        """
        units = [unit for unit in (self.default_unit, self.inch_unit) if unit]
        units = units[::-1] if inches_first else units
        return " or ".join(f"'{number} {unit}'" for unit in units) or f"'{number}'"


DIMENSIONS: dict[str, Dimension] = {
    "length": Dimension("m", "mm", "a length", "in"),
    "area": Dimension("m^2", "mm^2", "an area", "in^2"),
    "force": Dimension("N", "N", "a force", "lbf"),
    "moment": Dimension("N*m", "N m", "a moment", "lbf in"),
    "stiffness": Dimension("N/m", "N/mm", "a stiffness", "lbf/in"),
    "line stiffness": Dimension("N/m^2", "N/mm^2", "a stiffness per length", "lbf/in^2"),
    "rotational stiffness": Dimension("N*m/rad", "N m/rad", "a rotational stiffness"),
    "pressure": Dimension("Pa", "MPa", "a pressure or stress", "ksi"),
    "modulus": Dimension("Pa", "GPa", "an elastic modulus", "ksi"),
    "mass": Dimension("kg", "g", "a mass", "lb"),
    "moment of inertia": Dimension("kg*m^2", "kg mm^2", "a moment of inertia", "lb in^2"),
    "density": Dimension("kg/m^3", "kg/m^3", "a density", "lb/in^3"),
    "angle": Dimension("rad", "deg", "an angle"),
    "angular speed": Dimension("rad/s", "rpm", "a rotational speed"),
    "time": Dimension("s", "s", "a time"),
    "frequency": Dimension("1/s", "Hz", "a frequency"),
    "damping rate": Dimension("1/s", "1/s", "a damping rate"),
    "damping": Dimension("N*s/m", "N s/mm", "a damping constant", "lbf s/in"),
    "velocity": Dimension("m/s", "mm/s", "a velocity", "in/s"),
    "acceleration": Dimension("m/s^2", "mm/s^2", "an acceleration", "in/s^2"),
    "impulse": Dimension("N*s", "N s", "an impulse"),
    "energy": Dimension("J", "J", "an energy"),
    "power": Dimension("W", "W", "a power"),
    "cam velocity": Dimension("m/rad", "mm/deg", "a lift per angle"),
    "cam acceleration": Dimension("m/rad^2", "mm/deg^2", "a lift per angle squared"),
    "ratio": Dimension("", "", "a plain number"),
}

#: The units that are read, in the words of pint.
DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
second = [time] = s = sec
gram = [mass] = g
radian = [angle] = rad
minute = 60 * second = min
hour = 60 * minute = h
degree = 0.017453292519943295 * radian = deg = degrees
turn = 6.283185307179586 * radian = rev = revolution
rpm = turn / minute
hertz = 1 / second = Hz
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
joule = newton * meter = J
watt = joule / second = W
horsepower = 550 * foot * pound_force / second = hp
inch = 0.0254 * meter = in = inches
foot = 12 * inch = ft
thou = 0.001 * inch = mil
pound = 0.45359237 * kilogram = lb
ounce = pound / 16 = oz
pound_force = pound * 9.80665 * meter / second ** 2 = lbf
kilogram_force = kilogram * 9.80665 * meter / second ** 2 = kgf = kp
gram_force = 0.001 * kilogram_force = gf
ounce_force = pound_force / 16 = ozf
decanewton = 10 * newton = daN
psi = pound_force / inch ** 2
ksi = 1000 * psi
percent = 0.01 = pct
"""


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
DEFAULT: dict[str, tuple[float, tuple[tuple[str, float], ...]]] = {
    unit: (
        value,
        tuple(
            (f"[{name}]", float(power))
            for name, power in zip(
                ("angle", "length", "mass", "time"), (angle, length, mass, time), strict=True
            )
            if power
        ),
    )
    for (length, mass, time, angle), units in _BY_POWERS.items()
    for unit, value in units.items()
}
