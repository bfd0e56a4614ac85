"""Published: a catalogue spring known by two loads and a frequency, against the spring formulas
solved by hand.

Rate ``k = G d^4 / (8 D^3 n)`` (EN 13906-1) and first frequency ``f = sqrt(k / m) / 2`` of a wire clamped at both ends with the mass ``m =
rho pi^2 D d^2 n / 4`` of its active coils leave ``d^6 = 32 D^2 k m / (rho pi^2 G)``; neither formula knows the pitch of the helix (0.6 % of
the length of the wire here).
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from architecture.layout import ROOT
from valvetrain.explore.distributions import Prior
from valvetrain.explore.execution import Execution
from valvetrain.explore.identify import run_identification
from valvetrain.explore.requests import Identify

DENSITY, SHEAR_MODULUS, COIL, TOTAL = 7850.0, 79.5e9, 25e-3, 7.0


def test_wire_and_closed_coils_are_those_of_the_formulas() -> None:
    """With even priors, so that the data alone speak."""
    request = Identify.read({"file": ROOT / "examples" / "identify-spring.toml"}).plan
    wire, closed, pitch = request.unknowns
    free = (wire, replace(closed, distribution=Prior("uniform", 0.85, 1.5)), pitch)
    found = run_identification(
        replace(request, unknowns=free, search=request.search.model_copy(update={"draws": 1})),
        Execution(workers=1),
    )
    (seat, high), frequency = (345.0, 735.0), 472.0
    rate = (high - seat) / 10e-3
    mass = rate / (2 * frequency) ** 2
    diameter = (32 * COIL**2 * rate * mass / (DENSITY * math.pi**2 * SHEAR_MODULUS)) ** (1 / 6)
    active = SHEAR_MODULUS * diameter**4 / (8 * COIL**3 * rate)
    assert found.best["wire_diameter"] == pytest.approx(diameter, rel=3e-3)
    assert TOTAL - 2 * found.best["closed_coils"] == pytest.approx(active, rel=1e-2)
    assert found.branches[0].misfit < 1e-6, "three data, three unknowns"
    assert not found.branches[0].information.groups and not found.note
