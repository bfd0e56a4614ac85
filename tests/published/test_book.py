"""The validation book: every row within its tolerance, and a fault anywhere in the package turns a row red."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from valvetrain.citations import references
from valvetrain.validation import beams, laws, models, springs, stresses, waves
from valvetrain.validation.__main__ import book, main, page, run_book
from valvetrain.validation.row import Row

QUICK = [case for case in book() if not case.slow]


def stated(text: str) -> list[tuple[str, ...]]:
    """Rows of a page without what was computed: name, input, source, expected value with its unit, tolerance and the reason for it."""
    cells = [tuple(part.strip() for part in line.split(" | ")) for line in text.splitlines() if line.startswith("| ")]
    return [row[:4] + row[6:8] for row in cells if len(row) == 9]


COMMITTED = stated((Path(__file__).resolve().parents[2] / "docs" / "validation.md").read_text(encoding="utf-8"))


def red(rows: list[Row]) -> list[str]:
    return [row.name for row in rows if row.status == "FAILS"]


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_rows_stay_within_their_tolerance(case):
    rows = case.rows()
    assert rows
    assert not red(rows)
    assert all(row.tolerance > 0 and row.reason for row in rows)
    known = references()
    assert all(row.source in known for row in rows if row.source)
    anew = "run python -m valvetrain.validation --page docs/validation.md"
    assert not [line for line in stated(page(rows)) if line not in COMMITTED], anew
    # a value off by a third of its size (or a tenth of its unit, where nothing is expected) is no agreement
    wrong = [replace(row, computed=row.expected + (abs(row.expected) / 3 or 0.1), expected_miss="") for row in rows]
    assert [row.status for row in wrong] == ["FAILS"] * len(rows)
    assert [replace(row, computed=row.expected).status for row in rows] == ["met"] * len(rows)


def test_page_holds_every_row():
    rows = [row for case in QUICK[:8] for row in case.rows()]
    text = page(rows)
    for row in rows:
        assert row.name.replace("|", "/") in text
    assert "FAILS |" not in text.replace("fail |", "")


def test_the_command_fails_when_a_row_fails(monkeypatch, capsys):
    wrong = Row("springs", "a wrong row", "", "", 1.0, 1.2, "N", 0.1, "seeded")
    monkeypatch.setattr("valvetrain.validation.__main__.run_book", lambda **options: [wrong])
    assert main([]) == 1
    assert "a wrong row" in capsys.readouterr().out


def test_quick_run_leaves_out_the_studies_of_whole_sources(monkeypatch):
    monkeypatch.setattr("valvetrain.validation.__main__.book", lambda: tuple(c for c in book() if c.slow or c.name == "stress_factors"))
    assert {row.topic for row in run_book(quick=True)} == {"stress"}


def test_a_fault_in_the_sections_torsion_turns_rows_red(monkeypatch):
    from valvetrain.cosserat import mesh, section

    def soft(*arguments):
        found = section.round_section(*arguments)
        return section.Section(**{name: getattr(found, name) * (0.98 if name == "torsion" else 1.0) for name in found.__slots__})

    monkeypatch.setattr(mesh, "round_section", soft)
    assert "rate of a cylinder" in red(springs.rates_of_shaped_springs())
    assert red(springs.clamped_helix_frequencies())
    assert red(springs.curvature_of_the_bar())


def test_the_chord_in_place_of_the_arc_length_turns_rows_red(monkeypatch):
    from valvetrain.cosserat import mesh

    monkeypatch.setattr(mesh, "_arc_length", lambda curve, start, end: 0.99 * np.abs(end - start) * curve.line_speed((start + end) / 2))
    assert red(springs.trial_spring())


def test_a_fault_in_the_rods_bending_turns_rows_red(monkeypatch):
    from valvetrain.cosserat import energy_kernels

    whole = energy_kernels.bend_terms
    monkeypatch.setattr(energy_kernels, "bend_terms", lambda f, n, q, k, rest, *more: whole(f, n, q, k, 0.99 * rest, *more))
    assert red(beams.helix_under_large_compression())


def test_a_fault_in_the_time_march_turns_rows_red(monkeypatch):
    from valvetrain.cosserat import transient

    whole = transient.fill_buffer

    def heavy(mesh, state, dynamics, time_step):
        buffer = whole(mesh, state, dynamics, time_step)
        from valvetrain.cosserat.layout import row

        row(buffer, "IM", mesh.vertices)[:] *= 0.9
        return buffer

    monkeypatch.setattr(transient, "fill_buffer", heavy)
    assert red(waves.end_impact())


def test_a_fault_in_the_stress_factor_turns_rows_red(monkeypatch):
    from valvetrain.springs import stress

    monkeypatch.setitem(stress.CURVATURE_FACTORS, "wahl", lambda w: (4 * w - 1) / (4 * w - 4))
    assert "factor of wahl at index 5" in red(stresses.stress_factors())


def test_a_fault_in_the_chain_turns_rows_red(monkeypatch):
    from valvetrain.springs.multi_mass import MultiMassSpring

    whole = MultiMassSpring.frequencies
    monkeypatch.setattr(MultiMassSpring, "frequencies", lambda self, *a: 1.01 * whole(self, *a))
    assert len(red(models.chain_surge())) == 3


def test_a_fault_in_the_wave_rod_turns_rows_red(monkeypatch):
    from valvetrain.springs.wave_rod import WaveRod

    whole = WaveRod.parameters
    monkeypatch.setattr(WaveRod, "parameters", lambda self: whole(self) * [1, 1, 1.1, 1, 1])
    assert red(models.wave_rod_impact())


def test_a_fault_in_a_lift_law_turns_rows_red(monkeypatch):
    from valvetrain.cam.cycloidal import Cycloidal

    whole = Cycloidal.lift
    monkeypatch.setattr(
        Cycloidal, "lift", lambda self, angle, derivative=0: whole(self, angle, derivative) * (1.001 if derivative == 2 else 1)
    )
    assert red(laws.cam_flanks()) == ["cycloidal, peak acceleration factor"]


def test_a_fault_in_a_contact_law_turns_rows_red(monkeypatch):
    from valvetrain.contact.hunt_crossley import HuntCrossley

    whole = HuntCrossley.force
    monkeypatch.setattr(HuntCrossley, "force", lambda self, depth, rate: whole(self, depth, 0.9 * rate))
    assert len(red(laws.restitution_by_drop())) == 3


def test_a_fault_in_the_coil_contact_turns_rows_red(monkeypatch):
    from valvetrain.cosserat import mesh

    monkeypatch.setattr(mesh, "pair_coils", lambda coil, *more: mesh.no_contact(len(coil)))
    assert "beehive with coil contact, force at 7 mm" in red(models.rod_against_solid_with_contact())
