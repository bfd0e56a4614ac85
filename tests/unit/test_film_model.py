"""Unit: where the sections of a run lie on the wire, for the film of a spring; coil numbers in
closed form.

A model of a bar tells the share of the compliance passed. A turn of a round wire yields with the
third power of its mean diameter, so the
share up to a turn is that of the integral of the diameter's third power: the turn itself of a
cylinder, a fourth power of a cone.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import interp1d

from synthetic_spring import bump, run
from valvetrain.errors import InputError
from valvetrain.film.model import _at, _moved
from valvetrain.parameters.constructors import conical, cylindrical
from valvetrain.parameters.installed_spring import InstalledSpring, SpringCard
from valvetrain.parameters.spring import OPEN_END

TURNS, SHARES = 6.0, np.array([0.0, 0.1, 0.25, 0.5, 0.75, 1.0])
ENDS = {"closed_coils": 0, "lower_end": OPEN_END, "upper_end": OPEN_END}
CYLINDER = cylindrical(3.8e-3, 22e-3, 9e-3, TURNS, **ENDS)
CONE = conical(3.8e-3, 32e-3, 22e-3, 9e-3, TURNS, **ENDS)


def solution(places: np.ndarray):
    """A run whose section at a place moves by that place in mm at full lift, its points in falling
    order.
    """
    moved = {
        "axial_displacement": lambda degrees: (
            -1e-3 * np.outer(bump(degrees, 180, 106), places[::-1])
        )
    }
    return run(
        {"valve_lift": lambda degrees: 9e-3 * bump(degrees, 180, 106), **moved},
        coil_number=places[::-1],
    )


def cone_turn(share: np.ndarray) -> np.ndarray:
    low, high = 32.0**4, 22.0**4
    return TURNS * ((low + share * (high - low)) ** 0.25 - 32.0) / (22.0 - 32.0)


@pytest.mark.parametrize(
    "wire, turns", [(CYLINDER, TURNS * SHARES), (CONE, cone_turn(SHARES))], ids=["cylinder", "cone"]
)
def test_shares_of_a_bar_are_turned_into_coil_numbers(wire, turns):
    angle, coil, moved = _moved(
        solution(SHARES), "spring", InstalledSpring(wire=wire, precompression=5e-3)
    )
    assert coil == pytest.approx(turns, abs=0.05)
    at_full_lift = moved[np.argmin(np.abs(angle - np.pi))]
    assert at_full_lift == pytest.approx(-1e-3 * SHARES, abs=1e-9), (
        "each section keeps its own motion"
    )


def test_coil_numbers_stay_what_they_are():
    _, coil, _ = _moved(
        solution(TURNS * SHARES), "spring", InstalledSpring(wire=CYLINDER, precompression=5e-3)
    )
    assert coil == pytest.approx(TURNS * SHARES, abs=1e-12)


def test_shares_of_a_card_have_no_coil_numbers():
    with pytest.raises(InputError, match="card without turns"):
        _moved(solution(SHARES), "spring", InstalledSpring(card=SpringCard(30e3, 300.0)))


def test_a_model_without_sections_is_refused():
    with pytest.raises(InputError, match="no displacement of coils"):
        _moved(
            run({"valve_lift": lambda degrees: 9e-3 * bump(degrees, 180, 106)}),
            "spring",
            InstalledSpring(card=SpringCard(30e3, 300.0)),
        )


def test_displacements_between_the_points_of_the_wire_and_beyond_them():
    """By scipy between them; the wire below lies on the seat and moves with the first point, that
    above with the last.
    """
    rng = np.random.default_rng(4)
    coil = np.array([0.75, 1.0, 1.6, 3.0, 4.25])
    moved, turns = rng.normal(size=(7, 5)), np.array([0.0, 0.75, 0.9, 1.0, 2.3, 2.999, 4.25, 5.0])
    assert _at(moved, coil, turns) == pytest.approx(
        interp1d(coil, moved, axis=1)(np.clip(turns, 0.75, 4.25)), abs=1e-12
    )
