"""Contact laws and cam laws: restitution by drop, peak factors of the classical flanks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from validation.row import Row, book_case
from valvetrain.cam.closed_form import Cycloidal, Harmonic, ModifiedSine, Polynomial
from valvetrain.cam.contract import LiftLaw
from valvetrain.contact.dissipative import HuntCrossley

EVENTS = {
    "maximum_lift": 0.008,
    "opening_start": 1.0,
    "opening_end": 2.2,
    "closing_start": 2.4,
    "closing_end": 4.0,
}


@book_case()
def cam_flanks() -> list[Row]:
    """Peak velocity, acceleration and jerk of a unit rise over a unit flank."""
    laws: dict[str, tuple[LiftLaw, tuple[float, ...], float]] = {
        "cycloidal": (Cycloidal(**EVENTS), (2.0, 2 * math.pi, 4 * math.pi**2), 1e-6),
        "harmonic": (Harmonic(**EVENTS), (math.pi / 2, math.pi**2 / 2, math.pi**3 / 2), 1e-6),
        "3-4-5": (
            Polynomial(**EVENTS, exponents=(3, 4, 5)),
            (1.875, 10 / math.sqrt(3), 60.0),
            1e-6,
        ),
        "4-5-6-7": (
            Polynomial(**EVENTS, exponents=(4, 5, 6, 7)),
            (2.1875, 84 / (5 * math.sqrt(5)), 52.5),
            1e-6,
        ),
        "modified sine": (ModifiedSine(**EVENTS), (1.7596, 5.5280, 69.466), 1e-4),
    }
    flank = EVENTS["opening_end"] - EVENTS["opening_start"]
    angle, rows = EVENTS["opening_start"] + flank * np.linspace(1e-9, 1 - 1e-9, 40_001), []
    for name, (law, factors, tolerance) in laws.items():
        for derivative, (word, factor) in enumerate(
            zip(("velocity", "acceleration", "jerk"), factors, strict=True), start=1
        ):
            peak = (
                float(np.max(np.abs(law.lift(angle, derivative))))
                * flank**derivative
                / EVENTS["maximum_lift"]
            )
            rows.append(
                Row(
                    "cam laws",
                    f"{name}, peak {word} factor",
                    "norton2009",
                    "unit rise over a unit flank",
                    factor,
                    peak,
                    "-",
                    tolerance * factor,
                    "closed form" if tolerance < 1e-5 else "printed digits",
                    "closed form" if tolerance < 1e-5 else "recalled",
                )
            )
    return rows


def hunt_crossley_restitution(number: float) -> float:
    """Rebound over arrival at a damping number (lambda / k times the arrival speed): root of Hunt
    and Crossley's implicit relation.
    """
    if number == 0:
        return 1.0
    # e = 1 / number makes the logarithm infinite; the root is below it, and below one.
    high = min(1.0, (1 - 1e-12) / number)
    return float(
        brentq(lambda e: number * (1 + e) - math.log((1 + number) / (1 - e * number)), 1e-9, high)
    )


@book_case()
def restitution_by_drop() -> list[Row]:
    """Rebound of a mass on the Hunt-Crossley law by integration, against the root of their implicit
    closed form.
    """
    from scipy.integrate import solve_ivp

    stiffness, mass, arrival, rows = 1e9, 0.1, 0.5, []
    for number in (0.1, 0.5, 2.0):
        law = HuntCrossley(stiffness, number / arrival)

        def rate(_: float, y: NDArray[np.float64], law: HuntCrossley = law) -> list[float]:
            force = float(law.force(np.array([y[0]]), np.array([y[1]]))[0]) if y[0] > 0 else 0.0
            return [y[1], -force / mass]

        def off(t: float, y: NDArray[np.float64]) -> float:
            return float(y[0]) if t > 1e-9 else 1.0

        off.terminal, off.direction = True, -1  # type: ignore[attr-defined]
        found = solve_ivp(
            rate, (0, 1e-2), [1e-12, arrival], events=off, rtol=1e-9, atol=1e-13, max_step=2e-6
        )
        rows.append(
            Row(
                "contact",
                f"restitution of Hunt and Crossley's law, damping number {number:g}",
                "hunt1975",
                "0.1 kg at 0.5 m/s",
                hunt_crossley_restitution(number),
                float(-found.y[1, -1] / arrival),
                "-",
                1e-6,
                "tolerance of the integrator",
            )
        )
    return rows
