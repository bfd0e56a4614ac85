"""Published: the tables of docs/decisions/0077-why-stage-one-is-small.md are what scripts/stage_one.py computes."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from architecture.layout import ROOT

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
import stage_one
import stage_one_parts as parts

from valvetrain.cosserat.modes import natural_modes

PAGE = (ROOT / "docs" / "decisions" / "0077-why-stage-one-is-small.md").read_text(encoding="utf-8")


def printed(first: str) -> list[str]:
    """Cells of the first row of the page that begins so."""
    (line, *_) = [line for line in PAGE.splitlines() if line.startswith(f"| {first} |")]
    return [cell.strip() for cell in line.strip("| ").split("|")]


def numbers(cells: list[str]) -> list[float]:
    """All numbers of some cells."""
    return [float(one) for cell in cells for one in cell.replace("(", " ").replace(")", " ").replace("at", " ").replace(",", "").split()]


def test_the_row_of_the_shipped_spring_is_what_comes_out():
    """The row has the last bits of one machine: half a newton of 800, a tenth of 40."""
    spring, readings = stage_one.SHIPPED.readings()
    row = printed("shipped")
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    assert row[1] == stage_one.cluster(modes.natural_frequency, modes.axial_transmission)
    assert numbers(row[2:]) == pytest.approx(numbers(stage_one.cells(readings)), rel=0.02, abs=0.6)


def test_linear_theory_is_the_rod_at_a_thousandth_of_the_lift():
    spring, rpm, share = parts.rod_of(elements=12), 8000.0, 1e-3
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    angle, force = parts.linear_force(modes.natural_frequency, modes.axial_transmission, modes.axial_stiffness, parts.LAW, rpm)
    rod = stage_one.read(stage_one.moved(spring, rpm, parts.Scaled(parts.LAW, share)))
    assert rod.stage_1 / share == pytest.approx(float(np.ptp(force[angle <= 127])), rel=0.01)


def test_a_retainer_that_tilts_against_no_end_of_stiffness_is_held():
    spring = parts.rod_of(elements=12)
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    frequency, share = parts.tilted_modes(spring, 1e9)
    assert frequency[:12] == pytest.approx(modes.natural_frequency[:12], rel=1e-4)
    assert np.abs(share[:12]) == pytest.approx(np.abs(modes.axial_transmission[:12]), abs=1e-3)
    assert parts.tilted_modes(spring, 0.0)[0][0] < modes.natural_frequency[0]


def test_the_sine_in_a_force_is_found_among_a_ramp_of_noise():
    time = np.linspace(0.0, 4e-3, 200)
    force = 300 + 20 * np.cos(2 * np.pi * 630 * time + 1) + 2 * np.cos(2 * np.pi * 9000 * time)
    size, frequency = stage_one.sine_in(time, force)
    assert size == pytest.approx(40.0, rel=0.02) and frequency == pytest.approx(630.0, abs=2.5)


def test_a_lift_straight_over_pieces_meets_the_law_at_its_stations():
    law = parts.LinearPieces(parts.LAW, 5.0)
    stations, between = np.radians(np.arange(0.0, 360.0, 5.0)), np.radians(np.arange(2.5, 360.0, 5.0))
    assert law.lift(stations) == pytest.approx(parts.LAW.lift(stations), abs=1e-12)
    ends = law.lift(between - np.radians(2.5)), law.lift(between + np.radians(2.49999))
    assert law.lift(between) == pytest.approx((ends[0] + ends[1]) / 2, abs=1e-8)
    assert law.lift(between, 1) == pytest.approx((ends[1] - ends[0]) / np.radians(4.99999), abs=1e-6)
