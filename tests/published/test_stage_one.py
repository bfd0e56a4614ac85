"""Published: tables of docs/decisions/0077-why-stage-one-is-small.md are what scripts/stage_one.py
computes.

Compared are, of the levers, the shipped row and (long) a tuned one of a and b, one of e and f, the
mesh and the six turns; and (long) a row
of the installed heights, a column of the lift's share, a row of the integrators, and where corner
and ramp are.
"""

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
    return [
        float(one)
        for cell in cells
        for one in cell.replace("(", " ")
        .replace(")", " ")
        .replace("at", " ")
        .replace(",", "")
        .split()
    ]


def test_the_row_of_the_shipped_spring_is_what_comes_out():
    """The row has the last bits of one machine: half a newton of 800, a tenth of 40."""
    spring, readings = stage_one.SHIPPED.readings()
    row = printed("shipped")
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    assert row[1] == stage_one.cluster(modes.natural_frequency, modes.axial_transmission)
    assert numbers(row[2:]) == pytest.approx(numbers(stage_one.cells(readings)), rel=0.02, abs=0.6)


#: First cell of a row of the levers -> words of the script's own change.
LEVERS = {
    "7.1 coils": "7.1 coils", "+0.3 mm": "+0.3 mm", "upper 0.70": "upper 0.70", "0.03": "damping ratio 0.03",
    "six cam turns instead of two": "6 cam turns from rest", "12 elements per coil": "12 elements per coil",
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("first", LEVERS)
def test_a_row_of_the_levers_is_what_comes_out(first):
    """As the shipped row, spikes to a hundredth."""
    (change,) = [
        one
        for _, changes in stage_one.experiments()
        for one in changes
        if one.words == LEVERS[first]
    ]
    _, _, near, *computed = stage_one.row_of(change)
    row = printed(first)
    assert row[1] in (near, "as shipped") and numbers(row[2:]) == pytest.approx(
        numbers(computed), rel=0.02, abs=0.6
    )


@pytest.mark.long
def test_a_row_of_the_installed_heights_is_what_comes_out(monkeypatch):
    monkeypatch.setattr(stage_one, "INSTALLED", (8.0,))
    row, (*_, line) = printed("8.0 mm"), stage_one.installed().splitlines()
    _, _, near, *computed = [cell.strip() for cell in line.strip("| ").split("|")]
    assert row[1] == near and numbers(row[2:5]) == pytest.approx(
        numbers(computed[:3]), rel=0.02, abs=0.6
    )
    assert row[5] == computed[-1]


@pytest.mark.long
def test_a_column_of_the_lifts_share_is_what_comes_out():
    """A twentieth of the lift, at the speeds of which the page says what is gone."""
    rows = [line for line in PAGE.split("| lift times |")[1].splitlines() if " rpm |" in line][
        : len(parts.SPEEDS)
    ]
    told = [float(row.strip("| ").split("|")[3]) for row in rows]
    found = [
        stage_one.read(stage_one.moved(parts.rod_of(), rpm, parts.Scaled(parts.LAW, 0.05))).stage_1
        / 0.05
        for rpm in parts.SPEEDS
    ]
    assert told == pytest.approx(found, rel=0.02, abs=0.1)


@pytest.mark.long
def test_the_row_of_the_implicit_rule_is_what_comes_out():
    row = printed("HHT, alpha -0.05, 0.5 deg")
    computed = stage_one.by_rule("", stage_one.HilberHughesTaylor(-0.05), 1)
    assert numbers(row[1:]) == pytest.approx(numbers(computed[1:]), rel=0.02, abs=0.6)


@pytest.mark.long
def test_corner_and_ramp_are_where_the_page_says():
    corners = {
        cells[0].strip(): cells[1].strip()
        for cells in (line.strip("| ").split("|") for line in stage_one.kinks().splitlines()[2:])
    }
    assert (
        corners["shipped"]
        == corners["pitch -0.2 mm at coil 2.3"]
        == corners["pitch +0.2 mm at coil 2.3"]
        == "7.10"
    )
    assert (
        f"the corner to {corners['pitch -0.2 mm at coil 1.5']} or {corners['pitch +0.2 mm at coil 1.5']} mm"
        in " ".join(PAGE.split())
    )
    *_, line = stage_one.ramp().splitlines()
    at_120, at_127 = numbers(line.strip("| ").split("|")[1:])
    assert (
        f"({at_120} N at rest)" in " ".join(PAGE.split())
        and f"{at_127:.0f} N are the ramp of the lift up to 127 degrees" in PAGE
    )


def test_a_spring_that_is_not_tuned_says_so():
    with pytest.warns(UserWarning, match=r"not tuned: the preload is missed by \d+\.\d%"):
        parts.tuned(parts.with_coils(parts.WIRE, 6.5), rounds=0)


def test_linear_theory_is_the_rod_at_a_thousandth_of_the_lift():
    spring, rpm, share = parts.rod_of(elements=12), 8000.0, 1e-3
    modes = natural_modes(spring.statics, spring.installed.state, 24)
    angle, force = parts.linear_force(
        modes.natural_frequency, modes.axial_transmission, modes.axial_stiffness, parts.LAW, rpm
    )
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
    stations, between = (
        np.radians(np.arange(0.0, 360.0, 5.0)),
        np.radians(np.arange(2.5, 360.0, 5.0)),
    )
    assert law.lift(stations) == pytest.approx(parts.LAW.lift(stations), abs=1e-12)
    ends = law.lift(between - np.radians(2.5)), law.lift(between + np.radians(2.49999))
    assert law.lift(between) == pytest.approx((ends[0] + ends[1]) / 2, abs=1e-8)
    assert law.lift(between, 1) == pytest.approx(
        (ends[1] - ends[0]) / np.radians(4.99999), abs=1e-6
    )
