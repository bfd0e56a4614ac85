"""Searches whose end is known on paper: lightest spring of a rate, force of a straight spring,
front of two objectives, rigid theory.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from train_parts import SINGLE_MASS
from valvetrain.explore.limit_speed import BELOW, BEYOND, FOUND, find_limit
from valvetrain.explore.outputs import LimitSearch

LIGHTEST = """
case = "job-c"
objective = [{{ quantity = "wire_mass", direction = "minimise" }}]
constraint = [{{ quantity = "estimated_rate", at_least = "40 N/mm" }}]
vary = [
  {{ key = "spring.wire_diameter", low = "3 mm", high = "4.2 mm" }},
  {{ key = "spring.mean_diameter", low = "18 mm", high = "30 mm" }},
]
search = {{ method = "{method}", trials = 48, seed = {seed} }}
"""


@pytest.mark.slow
@pytest.mark.parametrize("method", ["tpe", "nsga2"])
def test_the_lightest_spring_of_a_rate_is_that_of_the_formula(method):
    """k = G d^4 / (8 D^3 n), m = rho pi^2/4 d^2 D n without pitch: at fixed k d^2 goes with D^1.5,
    so the narrowest coil is lightest.
    """
    found = vt.optimise(LIGHTEST.format(method=method, seed=1), workers=1)
    turns = (
        79.6e9 * 4e-3**4 / (8 * 24e-3**3 * float(found.case.constraints[0]))
    )  # as the rate of the case has it
    assert 3 < turns < 7
    wire = (40e3 * 8 * 18e-3**3 * turns / 79.6e9) ** 0.25
    best = found.best.trial
    assert best.values == pytest.approx([wire, 18e-3], rel=2e-3)
    assert found.active(best) == (0,) and 1 in found.at_ends(best)
    mass = (
        7850
        * np.pi
        / 4
        * wire**2
        * vt.load_case("job-c", {"spring.mean_diameter": "18 mm"}).spring.wire_length
    )
    assert float(best.objectives[0]) == pytest.approx(mass, rel=5e-3)


@pytest.mark.slow
def test_a_front_of_two_objectives_is_the_curve_between_their_ends():
    """m ~ d^2 D, f = d / (2 pi n D^2) sqrt(G / 2 rho): at any mass the narrowest coil surges
    highest, so the front lies at that end.
    """
    found = vt.optimise(
        """
case = "job-c"
objective = [
  { quantity = "wire_mass", direction = "minimise" },
  { quantity = "estimated_surge_frequency", direction = "maximise" },
]
vary = [
  { key = "spring.wire_diameter", low = "3 mm", high = "4.2 mm" },
  { key = "spring.mean_diameter", low = "18 mm", high = "26 mm" },
]
search = { method = "nsga2", trials = 160, per_round = 16, seed = 2 }
""",
        workers=1,
    )
    mass, frequency = np.array([one.objectives for one in found.front]).T
    coil = np.array([one.values[1] for one in found.front])
    assert len(found.front) > 8 and np.all(np.diff(mass) > 0) and np.all(np.diff(frequency) > 0)
    assert np.median(coil) < 18.5e-3
    on_the_end = vt.study(
        """
case = "job-c"
outputs = ["wire_mass", "estimated_surge_frequency"]
points = { sampler = "list" }
vary = [{ key = "spring.wire_diameter", values = "3, 3.3, 3.6, 3.9, 4.2 mm" }]
changes = { "spring.mean_diameter" = "18 mm" }
""",
        workers=1,
    )
    best = np.interp(
        mass, on_the_end.column("wire_mass"), on_the_end.column("estimated_surge_frequency")
    )
    assert np.all(frequency <= best * (1 + 2e-3)) and np.median(frequency / best) > 0.97


def answered(limit: LimitSearch, law) -> tuple[object, int]:
    """A search for a limit speed with a closed form in place of runs; its bracket and the points it
    took.
    """
    speeds: list[float] = []
    found = find_limit(limit, lambda speed: speeds.append(speed) or law(speed))
    assert len(set(speeds)) == len(speeds)
    return found, len(speeds)


@pytest.mark.parametrize("step", [12.5, 25.0, 50.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_limit_speed_does_not_depend_on_the_grid(step, sign):
    """Growth with the square of the speed: the bound is met at its root, to the resolution, on any
    grid.
    """
    bound = 613.0
    limit = LimitSearch(
        "q", sign > 0, sign * (bound / 100) ** 2, tuple(np.arange(300.0, 1000.1, step)), 1.0
    )
    found, count = answered(limit, lambda speed: sign * (speed / 100) ** 2)
    assert found.kind == FOUND and found.low <= bound < found.high and found.high - found.low <= 1.0
    assert abs(found.value - bound) <= 1.0 and count < 700 / step + 8


@pytest.mark.parametrize("step", [20.0, 40.0])
def test_a_resonance_between_the_points_of_the_grid_is_found_by_its_flanks(step):
    """One resonance, half as wide as the step, that leaves the bound between two points."""

    def law(speed: float) -> float:
        return 1.0 / np.sqrt((1 - (speed / 610.0) ** 2) ** 2 + (0.03 * speed / 610.0) ** 2)

    bound = 20.0
    root = next(speed for speed in np.arange(500.0, 610.0, 0.01) if law(speed) > bound)
    found, _ = answered(
        LimitSearch("q", True, bound, tuple(np.arange(500.0, 901.0, step)), 1.0), law
    )
    assert found.kind == FOUND and abs(found.value - root) <= 1.0


def test_bounds_that_are_never_or_always_left_are_told_apart():
    speeds = (100.0, 200.0, 300.0)
    assert answered(LimitSearch("q", True, 1.0, speeds, 1.0), lambda speed: 2.0)[0].kind == BELOW
    assert answered(LimitSearch("q", True, 1.0, speeds, 1.0), lambda speed: 0.5)[0].kind == BEYOND
    found, _ = answered(
        LimitSearch("q", True, 1.0, speeds, 1.0), lambda speed: 0.5 if speed <= 250 else np.nan
    )
    assert (
        found.kind == FOUND and abs(found.low - 250.0) <= 1.0
    )  # a run that fails counts as beyond the bound


@pytest.mark.long
def test_the_least_open_load_is_that_of_rigid_theory(tmp_path):
    """Spring force P + k x over inertia m a(x) of the 3-4-5 polynomial, 1.3 at its least: with P
    given, k follows from the worst place.
    """
    (tmp_path / "train.toml").write_text(SINGLE_MASS)
    (tmp_path / "search.toml").write_text("""
case = "train.toml"
objective = [{ quantity = "card_open_force", direction = "minimise" }]
constraint = [{ quantity = "minimum_spring_margin_ratio", at_least = 1.3, engine_speeds = "6000 rpm" }]
vary = [
  { key = "train.springs.card.0.preload", low = "200 N", high = "300 N" },
  { key = "train.springs.card.0.open_load", low = "400 N", high = "1200 N" },
]
search = { trials = 40 }
""")
    found = vt.optimise(tmp_path / "search.toml", workers=1)
    share = np.linspace(0.0, 1.0, 20001)
    lift = 9e-3 * (10 * share**3 - 15 * share**4 + 6 * share**5)
    rate = 2 * np.pi * 50 / np.radians(70)  # of the share, cam at 3000 rpm
    slowing = -9e-3 * (60 * share - 180 * share**2 + 120 * share**3) * rate**2
    mass = 0.125 + 0.030 / 3  # Rayleigh's third of the spring
    slow = slowing > 0
    needed = 1.3 * mass * slowing[slow]

    def open_load(preload: float) -> float:
        return preload + 9e-3 * float(np.max((needed - preload) / lift[slow]))

    preloads = np.linspace(200.0, 300.0, 501)
    least = min(open_load(one) for one in preloads)
    assert float(found.best.trial.objectives[0]) == pytest.approx(least, rel=0.01)
    assert float(found.best.trial.objectives[0]) == pytest.approx(
        open_load(float(found.best.trial.values[0])), rel=0.01
    )
