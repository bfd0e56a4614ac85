"""
Scipy on the float speed
========================

Any function of a case is one that scipy can take. Here it looks for the mass of the valve with which the
valve floats from 7200 rpm on.
"""

from math import pi

from scipy.optimize import brentq

import valvetrain as vt

case = vt.Case("tdi-pushrod")
options = {"models": "massless", "spring_sets": "stock", "ranges": False}


def float_speed(mass):
    found = case.set({"train.valve.mass": mass}).critical_speeds("6000:8000:2000 rpm", **options)
    return found.of("float").engine_speed * 30 / pi


mass = brentq(lambda mass: float_speed(mass) - 7200, 0.040, 0.070, xtol=1e-5)
print(f"float from 7200 rpm on with a valve of {1e3 * mass:.0f} g")
