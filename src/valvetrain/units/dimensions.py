"""The dimensions that the package speaks of, and the units it reads.

Angles carry a dimension of their own here, so "2100 rpm" (an angular speed) is never mistaken for "35 Hz" (a frequency).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Dimension:
    """A kind of quantity: its SI unit, the unit suggested to users and how it is spoken of."""

    si_unit: str
    usual_unit: str
    phrase: str


DIMENSIONS: dict[str, Dimension] = {
    "length": Dimension("m", "mm", "a length"),
    "area": Dimension("m^2", "mm^2", "an area"),
    "force": Dimension("N", "N", "a force"),
    "moment": Dimension("N*m", "N m", "a moment"),
    "stiffness": Dimension("N/m", "N/mm", "a stiffness"),
    "line stiffness": Dimension("N/m^2", "N/mm^2", "a stiffness per length"),
    "rotational stiffness": Dimension("N*m/rad", "N m/rad", "a rotational stiffness"),
    "pressure": Dimension("Pa", "MPa", "a pressure or stress"),
    "modulus": Dimension("Pa", "GPa", "an elastic modulus"),
    "mass": Dimension("kg", "g", "a mass"),
    "moment of inertia": Dimension("kg*m^2", "kg mm^2", "a moment of inertia"),
    "density": Dimension("kg/m^3", "kg/m^3", "a density"),
    "angle": Dimension("rad", "deg", "an angle"),
    "angular speed": Dimension("rad/s", "rpm", "a rotational speed"),
    "time": Dimension("s", "s", "a time"),
    "frequency": Dimension("1/s", "Hz", "a frequency"),
    "damping rate": Dimension("1/s", "1/s", "a damping rate"),
    "damping": Dimension("N*s/m", "N s/mm", "a damping constant"),
    "velocity": Dimension("m/s", "mm/s", "a velocity"),
    "acceleration": Dimension("m/s^2", "mm/s^2", "an acceleration"),
    "impulse": Dimension("N*s", "N s", "an impulse"),
    "energy": Dimension("J", "J", "an energy"),
    "power": Dimension("W", "W", "a power"),
    "cam velocity": Dimension("m/rad", "mm/deg", "a lift per angle"),
    "cam acceleration": Dimension("m/rad^2", "mm/deg^2", "a lift per angle squared"),
    "ratio": Dimension("", "", "a plain number"),
}

#: The units that are read, in the words of pint.
DEFINITIONS = """
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
inch = 0.0254 * meter = in
foot = 12 * inch = ft
thou = 0.001 * inch = mil
pound = 0.45359237 * kilogram = lb
ounce = pound / 16 = oz
pound_force = pound * 9.80665 * meter / second ** 2 = lbf
kilogram_force = kilogram * 9.80665 * meter / second ** 2 = kgf
psi = pound_force / inch ** 2
ksi = 1000 * psi
percent = 0.01 = pct
"""
