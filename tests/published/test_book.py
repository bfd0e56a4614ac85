"""The validation book: every row within its tolerance, and a fault anywhere in the package turns a
row red.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from validation import (
    beams,
    large_deflection,
    wires,
)
from validation.__main__ import book, chapter_of
from validation.row import Row
from validation.sources import rows_of

from book_page import assert_page_holds
from valvetrain.citations import references
from valvetrain.cosserat import quaternion
from valvetrain.cosserat.static import RodStatics
from valvetrain.solution.uncertainty import Comparison

QUICK = [case for case in book() if not case.slow]
#: Cases that take most of the time: solids, energies and reduced rods; `make validate` runs them too.
LONG = {
    "balance_of_energy", "faces_as_hertz", "faces_that_meet", "waves_and_rotation", "straight_and_curved_bars", "bricks_against_calculix",
    "bricks_in_contact_against_calculix", "reduced_rod_at_rest", "reduced_rod_in_its_train", "reduced_rod_in_motion",
}  # fmt: skip
#: What the rows of each case expect, and how near they must come: no change of the package moves
#: them, and none is left out. Anew:
#: ``python tests/published/test_book.py`` with src and tests on the path.
EXPECTED = Path(__file__).with_name("book_expected.json")

#: Chapter by the topic of its rows, as the tests find them.
OWNERS: dict[str, str] = {}


def red(rows: list[Row]) -> list[str]:
    return [row.name for row in rows if row.status == "FAILS"]


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.name, marks=[pytest.mark.long] if case.name in LONG else [])
        for case in QUICK
    ],
)
def test_rows_stay_within_their_tolerance(case):
    rows = case.rows()
    assert rows
    assert not red(rows)
    assert all(0 < row.tolerance < np.inf and row.reason for row in rows)
    # A limit stands near what is reached: within fifty times of it, or half a per cent of what is
    # expected.
    assert not [
        row.name
        for row in rows
        if row.tolerance > max(50 * abs(row.difference), 0.005 * abs(row.expected))
    ]
    known, kept = references(), json.loads(EXPECTED.read_text(encoding="utf-8"))[case.name]
    assert {row.name: [row.expected, row.tolerance] for row in rows} == {
        name: pytest.approx(due, rel=1e-7) for name, due in kept.items()
    }
    assert all(row.source in known for row in rows if row.source)
    for topic in {
        row.topic for row in rows
    }:  # a table is made by one chapter, whatever --only names
        assert OWNERS.setdefault(topic, chapter_of(case)) == chapter_of(case)
    assert_page_holds(rows)


def row(expected: float, computed: float, tolerance: float, **more) -> Row:
    return Row(
        "springs",
        "a force",
        "",
        "",
        expected,
        computed,
        "N",
        tolerance,
        "seeded",
        "published",
        **more,
    )


@pytest.mark.parametrize(
    ("computed", "tolerance", "band", "why", "status"),
    [
        (283.0, 100.0, None, "", "FAILS"),  # 500 N at 20 %
        (410.0, 100.0, None, "", "met"),
        (283.0, 100.0, (277.0, 289.0), "the flank is soft", "miss (explained)"),
        (260.0, 100.0, (277.0, 289.0), "the flank is soft", "FAILS"),
        (283.0, 100.0, (277.0, 289.0), "", "FAILS"),  # a band needs its reason
        (283.0, np.inf, None, "", "FAILS"),  # neither tolerance nor band
        (500.0, np.inf, None, "", "FAILS"),
        (np.nan, 100.0, (277.0, 289.0), "the flank is soft", "FAILS"),
        (np.nan, np.inf, None, "", "FAILS"),
    ],
)
def test_a_row_is_met_explained_or_red(computed, tolerance, band, why, status):
    assert row(500.0, computed, tolerance, band=band, explanation=why).status == status


@pytest.mark.parametrize("role", ["calibration", "check", "prediction"])
@pytest.mark.parametrize("computed", [283.0, None])
def test_no_role_excuses_a_published_value(role, computed):
    """A prediction as well as a calibrated value is red where nobody has said why it is missed."""
    difference = None if computed is None else computed - 500.0
    item = Comparison(
        "new_peak_force", None, "", "test", "N", 500.0, computed, difference, role, 100.0, "misses"
    )
    (found,) = rows_of("springs", "gu2021", (item,))
    assert found.status == "FAILS" and found.tolerance == 100.0
    (free,) = rows_of(
        "springs",
        "gu2021",
        (Comparison("new_peak_force", None, "", "test", "N", 500.0, 490.0, -10.0, role, None, ""),),
    )
    assert free.tolerance == pytest.approx(15.0) and free.status == "met"


@pytest.mark.parametrize("turns", [1, 2])
@pytest.mark.parametrize("lead", [0.3, 0.15, 0.05])
def test_the_torque_at_the_end_of_a_bent_helix_is_the_slope_of_its_energy(lead, turns):
    """Castigliano: the last end turned a little about the axis, forward and back, all else held."""
    length = turns * 2 * np.pi / np.cos(0.2)
    wire = beams.tube(1.0, 0.77, length)
    mesh, result, torque = beams._bent(
        beams.Helix(1.0, 0.2, wire), beams.Helix(1.0, lead, wire), length, 48 * turns
    )
    statics, last, energy = RodStatics(mesh, options=beams.TIGHT), mesh.last, []
    for turn in (1e-4, -1e-4):
        position, frame = result.state.position.copy(), result.state.frame.copy()
        (x, y), cosine, sine = position[last, :2].copy(), np.cos(turn), np.sin(turn)
        position[last, :2] = cosine * x - sine * y, sine * x + cosine * y
        frame[last + 1] = quaternion.multiply(
            np.array([np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)]), frame[last + 1]
        )
        energy.append(
            statics.assemble(replace(result.state, position=position, frame=frame), False)[0]
        )
    assert torque == pytest.approx((energy[0] - energy[1]) / 2e-4, abs=2e-7)


def test_without_contact_of_its_coils_a_cone_does_not_close(monkeypatch):
    from valvetrain.cosserat import mesh

    monkeypatch.setattr(mesh, "pair_coils", lambda coil, *more: mesh.no_contact(len(coil)))
    monkeypatch.setattr(large_deflection, "mesh_spring", mesh.mesh_spring.__wrapped__)
    found = red(large_deflection.conical_closing())
    assert (
        "conical spring, force at 8.5 mm" in found
        and "conical spring, rate while it closes, 8 to 8.5 mm" in found
    )
    assert "conical spring, force at 5 mm" not in found


def test_ring_section_runs_into_the_straight_bar_and_stands_by_goehners_series():
    """Limits: w to infinity gives the factor one and 1 +- 5 / (4 w); Goehner's terms for rate and
    stress stand by it to 0.4 %.
    """
    assert wires.ring_section(1e4) == pytest.approx((1.0, 1 + 1.25e-4, 1 - 1.25e-4), abs=1e-7)
    for index in (5.0, 8.0, 12.0):
        rate, inner, outer = wires.ring_section(index)
        assert abs(rate - 1 / (1 - 3 / (16 * index**2))) < 0.2 / index**4
        assert inner == pytest.approx(1 + 1.25 / index + 0.875 / index**2 + 1 / index**3, abs=1e-3)
        assert outer == pytest.approx(1 - 1.25 / index + 0.875 / index**2 - 1 / index**3, abs=4e-3)
        assert wires.ring_section(index, 16) == pytest.approx((rate, inner, outer), rel=1e-9)


if __name__ == "__main__":
    parts = []
    for case in QUICK:
        lines = ",\n".join(
            f"  {json.dumps(row.name)}: {json.dumps([row.expected, row.tolerance])}"
            for row in case.rows()
        )
        parts.append(f" {json.dumps(case.name)}: {{\n{lines}\n }}")
    EXPECTED.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")
