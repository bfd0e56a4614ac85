"""Error bars of trains: the study of one variant, the files that ship, and where they are told and
where not.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.runs import stored_error_bars
from valvetrain.runs.api import simulate
from valvetrain.runs.error_bars import OWN, STIFFNESS_FACTORS, divided
from valvetrain.runs.refine import refined
from valvetrain.solution.definition import is_defined
from valvetrain.solution.uncertainty import CONSTANTS
from valvetrain.system.build import build
from valvetrain.views.json import study_json

RPM = 2 * np.pi / 60


def one_variant(label: str):
    """tdi-pushrod with one of its variants."""
    case = load_case("tdi-pushrod")
    return case.replace(
        train=case.train.replace(
            variants=tuple(
                replace(one, replica=None) for one in case.train.variants if one.label == label
            )
        )
    )


@pytest.fixture(scope="module")
def study():
    told = []
    found = refined(
        one_variant("stock, as printed"),
        (3000 * RPM,),
        workers=1,
        progress=lambda share, words: told.append(share),
    )
    assert told == sorted(told) and told[-1] == 1.0
    return found


def test_rows_hold_the_run_and_cover_the_finer_ones(study):
    """A spring without mass has nothing to divide: step, samples and four contacts remain."""
    names = {name.rpartition(", ")[2] for name in study.values}
    assert names == {
        OWN,
        "step 2",
        "step 3",
        "samples",
        *(f"{word} {n}" for word in CONSTANTS for n in (1, 2)),
    }
    own = study.values[f"stock, as printed, {OWN}"][3000 * RPM]
    fine = study.values["stock, as printed, step 3"][3000 * RPM]
    rows = {row.quantity: row for row in study.rows}
    assert {
        "peak_seat_contact_force",
        "seating_velocity",
        "peak_spring_force",
    } <= rows.keys() and not study.failures
    for name, row in rows.items():
        assert row.value == own[name] and row.label == "stock, as printed" and is_defined(name)
        assert row.contact_stiffness[0] <= row.value <= row.contact_stiffness[1]
        assert abs(fine[name] - row.value) <= row.numerical
        if name.endswith("force") and "minimum" not in name:
            assert row.numerical < 0.01 * abs(row.value), name
    stiff = study.values["stock, as printed, contact stiffness 2"][3000 * RPM]
    assert (
        stiff["lift_loss_displacement"] < own["lift_loss_displacement"]
        and study.stiffness_factors == STIFFNESS_FACTORS
    )


@pytest.mark.parametrize(("name", "variants"), [("tdi-pushrod", 4), ("vaz-ohc", 8)])
def test_shipped_files_belong_to_their_case(name, variants):
    case = load_case(name)
    rows = stored_error_bars.load_uncertainty(case.record())
    assert len({row.label for row in rows}) == variants and {row.label for row in rows} <= {
        one.label for one in case.train.variants
    }
    assert all(0 <= row.numerical and row.damping[0] <= row.value <= row.damping[1] for row in rows)
    assert (
        stored_error_bars.load_uncertainty(load_case(name, {"train.valve.mass": "33 g"}).record())
        == ()
    )


def test_runs_tell_the_bars_of_their_numbers_and_no_others():
    """Fails when train or case have changed since scripts/write_uncertainty.py was run; run it
    again then.
    """
    case = load_case("tdi-pushrod")
    own = simulate(case, workers=1)
    told = study_json(own)["uncertainties"]
    assert len(told) == len(stored_error_bars.load_uncertainty(case.record()))
    assert {one["label"] for one in told} == set(own.labels)


def test_a_member_that_cannot_run_is_named_and_the_others_are_refined():
    """A chain that clashes needs a wire; the cards of this train have none."""
    case = load_case("tdi-pushrod", {"train.spring_model": "wave-rod-clash"})
    found = refined(case, [1000 * np.pi / 30], workers=1)
    assert found.failures and all(
        "wave-rod-clash" in one or "wire" in one for one in found.failures
    )


@pytest.mark.long
def test_a_train_on_finite_elements_gets_bars_from_two_grids():
    """Half the step and 1.5 times the elements, no third grid: the bar is Roache's three times the
    two differences over what a second order leaves of them, and the scatter of the cycles.
    """
    coarse = {
        f"train.springs.nested.{index}.options.finite-element.elements_per_coil": 6
        for index in (0, 1)
    }
    case = load_case("vaz-ohc", coarse)
    variants = tuple(
        one for one in case.train.variants if one.label == "finite elements, lash 0 mm"
    )
    variant = case.replace(train=case.train.replace(variants=variants))
    found = refined(variant, (5500 * RPM,), workers=1)
    names = {name.rpartition(", ")[2] for name in found.values}
    contacts = {f"{word} {n}" for word in CONSTANTS for n in (1, 2)}
    assert names == {OWN, "mesh 2", "step 2", *contacts} and found.rows
    own, halved, finer = (
        found.values[f"finite elements, lash 0 mm, {name}"][5500 * RPM]
        for name in (OWN, "step 2", "mesh 2")
    )
    for row in found.rows:
        step = 3 * abs(own[row.quantity] - halved[row.quantity]) * 4 / 3
        mesh = 3 * abs(own[row.quantity] - finer[row.quantity]) * 2.25 / 1.25
        scatter = own.get(f"cycle_scatter_{row.quantity}", 0.0)
        assert row.step_part == pytest.approx(step), row.quantity
        assert row.numerical == pytest.approx(step + mesh + scatter), row.quantity


def test_modes_that_damping_keeps_from_swinging_are_no_finer_division():
    """Ratio 0.016 at 450 Hz leaves 60 modes below critical, 0.6 none but the first."""
    path = str(Path(__file__).resolve().parents[1] / "net" / "ls-v8.toml")
    for ratio, more in (("0.016", True), ("0.6", False)):
        ratios = {f"train.springs.mydual[{place}].damping.ratio": ratio for place in (0, 1)}
        (member,) = build(load_case(path, ratios)).members
        finer = [divided(member, one, 1.5) for one in member.springs]
        modes = [one.options_of(member.model.word).get("modes") for one in finer]
        assert modes == ([60, 60] if more else [None, None])
