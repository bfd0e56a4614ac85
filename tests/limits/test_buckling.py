"""Limits: where a rod buckles against Euler's column and Haringx's spring, and what the modes
beyond it are called.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from spring_shapes import cylindrical
from valvetrain.cosserat.mesh import mesh_curve
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.section import round_section
from valvetrain.cosserat.stability import last_before, negative_modes
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import RodStatics, compress
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.quantities.statics import (
    buckling_compression,
    buckling_quantities,
    formula_compression,
    rest_quantities,
)
from valvetrain.runs import buckling, statics
from valvetrain.runs.statics import rod_statics, static_curve
from valvetrain.solution.status import Status
from valvetrain.springs.finite_element import FiniteElementRod

LENGTH, WIRE = 0.1, 2e-3


class StraightWire:
    """A straight wire, beside the axis by the radius that couples are measured with."""

    def position(self, parameter):
        return np.stack([0 * parameter + 5e-3, 0 * parameter, LENGTH * parameter], axis=1)

    def directors(self, parameter):
        return tuple(np.tile(axis, (len(parameter), 1)) for axis in np.eye(3))

    def line_speed(self, parameter):
        return np.full(len(parameter), LENGTH)

    def section(self, parameter, curvature_correction):
        wire = np.full(len(parameter), WIRE)
        return round_section(wire, OTEVA_90_SC), wire


def slender(total_coils: float = 20, **ends):
    """L0/D = 8 and index 10: buckles at 15.84 mm by the formula, before any coils touch."""
    return cylindrical(
        "1 mm", "10 mm", "4 mm", total_coils, name="slender", **({"ends": "open"} | ends)
    )


def test_a_straight_column_loses_the_sign_of_its_tangent_at_the_load_of_euler():
    """4 pi^2 E I / L^2 with both ends held: a perfect column, whose straight path goes on beyond;
    two modes lose their sign together.
    """
    statics = RodStatics(mesh_curve(StraightWire(), np.linspace(0, 1, 65), 0, 64), 0.0)
    second_moment, area, modulus = (
        np.pi / 64 * WIRE**4,
        np.pi / 4 * WIRE**2,
        OTEVA_90_SC.youngs_modulus,
    )
    critical = 4 * np.pi**2 * modulus * second_moment / LENGTH**2
    shortening = critical * LENGTH / (modulus * area)
    beyond = compress(statics, [1.2 * shortening])[-1]
    assert negative_modes(statics, compress(statics, [0.9 * shortening])[-1].state) == 0
    assert negative_modes(statics, beyond.state) == 2
    found = last_before(
        statics,
        free_state(statics.mesh),
        1.2 * shortening,
        lambda state: negative_modes(statics, state) == 0,
    )
    # Engesser: the column is 0.4 % softer for shear and shorter by the strain.
    assert found.compression == pytest.approx(shortening, rel=0.01)


@pytest.mark.parametrize(
    ("wire", "pitch", "coils", "reach"),
    [("1 mm", "4 mm", 20, 0.020), ("1.2 mm", "6 mm", 12, 0.022)],
)
def test_a_slender_spring_buckles_where_haringx_says(wire, pitch, coils, reach):
    """Two springs of L0/D = 8 and 7.2, the rod within 0.7 % of the formula on either mesh, and
    nearer on the finer one.
    """
    spring = cylindrical(wire, "10 mm", pitch, coils, ends="open")
    theory = formula_compression(spring)
    found = [
        static_curve(FiniteElementRod(spring, 0.0, mesh), reach, 6)[0].buckling.compression
        for mesh in (12, 18)
    ]
    assert found == pytest.approx([theory, theory], rel=0.007)
    assert abs(found[1] - theory) < max(abs(found[0] - theory), 1e-3 * theory)


def test_the_place_of_buckling_moves_with_no_step_of_the_curve_and_no_end_of_it():
    rod = FiniteElementRod(slender(), 0.0, 12)
    found = [
        static_curve(rod, reach, steps)[0].buckling
        for reach, steps in ((0.020, 3), (0.020, 24), (0.0165, 9))
    ]
    assert found[0] == found[1]
    # Beyond another end the path has other points; Newton's tolerance over the rate is 0.02 um per
    # point of force.
    assert found[2].compression == pytest.approx(found[0].compression, abs=2e-6)
    assert found[0].height == pytest.approx(0.081 - found[0].compression, abs=1e-12)


def test_the_curve_says_that_it_buckles_and_one_that_stays_below_does_not():
    rod = FiniteElementRod(slender(), 0.0, 12)
    beyond, below = static_curve(rod, 0.020, 10)[0], static_curve(rod, 0.015, 6)[0]
    assert beyond.status.code == "buckled" and "guide it in a bore" in beyond.status.sentence()
    assert f"{beyond.buckling.compression * 1e3:.4g} mm" in beyond.status.sentence()
    assert below.status.completed and below.buckling is None
    # The sentence is true: its rate is lost there.
    assert beyond.stiffness[-1] < 0.2 * beyond.stiffness[0]


def test_closed_ends_and_a_part_of_a_turn_buckle_near_the_formula_too():
    """An end of the wire that loads off the axis opens the pitchfork wider: within 4 %."""
    for spring in (slender(20.3), closed()):
        curve, _ = static_curve(FiniteElementRod(spring, 0.0, 12), 0.018, 6)
        assert curve.buckling.compression == pytest.approx(formula_compression(spring), rel=0.04)


def closed():
    """A spring whose end coils part point by point on the way, so that its tangent jumps by a
    quarter near buckling.
    """
    return cylindrical("1 mm", "10 mm", "4.2 mm", 22, name="closed")


@pytest.mark.long
def test_end_coils_that_part_point_by_point_move_the_place_with_neither_mesh_nor_reach():
    found = [
        static_curve(FiniteElementRod(closed(), 0.0, mesh), reach)[0].buckling.compression
        for mesh, reach in ((12, 0.0165), (12, 0.018), (16, 0.018))
    ]
    assert found[0] == pytest.approx(found[1], abs=2e-5)
    assert found[0] == pytest.approx(found[2], rel=6e-3)


def test_a_short_spring_buckles_nowhere_by_either():
    spring = cylindrical("4 mm", "24 mm", "7.5 mm", 6, ends="open")
    rest = rod_statics(FiniteElementRod(spring, 7e-3, 12), 0.016, 6, 0)
    assert rest.curve.buckling is None and rest.curve.status.completed
    assert buckling_quantities(InstalledSpring(spring, precompression=7e-3), rest, 8e-3) == {}
    assert buckling_compression(0.045, 0.024) == np.inf


def test_the_quantities_carry_what_is_left_at_the_largest_lift():
    spring = InstalledSpring(slender(), precompression=5e-3)
    rest = rod_statics(FiniteElementRod(spring.wire, spring.precompression, 12), 0.018, 6, 0)
    found = buckling_quantities(spring, rest, 12e-3)
    assert found["buckling_clearance"] == pytest.approx(
        found["buckling_compression"] - 17e-3, abs=1e-12
    )
    assert found["formula_buckling_compression"] == pytest.approx(
        found["buckling_compression"], rel=0.01
    )


def test_the_sway_of_a_buckled_spring_is_no_axial_mode():
    """At 19 mm the second mode sways, yet its transmission is -4.6; standing, the spring has its
    surge at 1/2 sqrt(k/m).
    """
    rod = FiniteElementRod(slender(), 0.0, 12)
    buckled, standing = (
        natural_modes(rod.statics, compress(rod.statics, [x])[-1].state, 10) for x in (0.019, 0.010)
    )
    sways = np.flatnonzero(
        (np.abs(buckled.axial_transmission) > 2) & (buckled.axial_energy_share < 1 / 3)
    )
    assert len(sways) and not set(sways) & set(buckled.axial_modes())
    assert standing.axial_energy_share[standing.axial_modes(1)[0]] > 0.9
    mass = float(rod.mesh.node_mass[rod.mesh.first : rod.mesh.last + 1].sum())
    surge = 0.5 * np.sqrt(standing.axial_stiffness / mass)
    assert standing.natural_frequency[standing.axial_modes(1)[0]] == pytest.approx(surge, rel=0.02)


def test_the_modes_about_a_buckled_state_say_so():
    rest = rod_statics(FiniteElementRod(slender(), 0.017, 12), 0.018, 6, 4)
    assert rest.modes.status.code == "buckled"
    assert rod_statics(FiniteElementRod(slender(), 0.012, 12), 0.018, 6, 4).modes.status.completed


def test_a_spring_that_has_lost_its_rate_within_the_first_window_buckles_there(monkeypatch):
    """Beyond L0/D of some 25 the critical point lies below half of the window over which a rate is
    a mean; no sign changes beyond it.
    """
    free, lost, rate = 0.3, 1e-3, 2e3
    force = lambda place: rate * min(place, lost) + 0.05 * rate * max(place - lost, 0.0)
    path = [
        SimpleNamespace(state=SimpleNamespace(compression=place), retainer_force=force(place))
        for place in np.linspace(0, 0.02, 41)
    ]
    monkeypatch.setattr(buckling, "axial_rate", lambda statics, state: rate)
    monkeypatch.setattr(buckling, "_force", lambda rod, states, place: force(place))
    monkeypatch.setattr(buckling, "_lost_sign", lambda rod, states: None)
    rod = SimpleNamespace(statics=None, definition=SimpleNamespace(free_length=free))
    found = buckling.find_buckling(rod, path)
    assert 0 < found.compression <= 0.5 * 0.01 * free + 5e-4


def test_a_curve_that_stops_before_the_installed_state_is_shown_without_it(monkeypatch):
    rod = FiniteElementRod(slender(), 14e-3, 8)
    whole = statics.curve_over

    def stopped(rod, places):
        curve, reached = whole(rod, places[:8])
        return replace(curve, status=Status("not-converged", "no equilibrium beyond")), reached

    monkeypatch.setattr(statics, "curve_over", stopped)
    for modes in (0, 3):
        found = rod_statics(rod, 16e-3, modes=modes)
        assert (
            found.installed is None
            and found.modes is None
            and found.curve.status.code == "not-converged"
        )
    assert rest_quantities(found, []) == {}
