"""Results in the units of the field and as frames in SI; no plotting is loaded before a figure is drawn."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from synthetic_study import at_rest, own_study, rod_run
from valvetrain.errors import InputError, MissingExtraError


def test_results_are_asked_in_the_units_of_the_field():
    curve, study = at_rest()[0].curve, own_study()
    assert curve.force_at("7.5 mm") == curve.force_at(7.5e-3) == pytest.approx(41e3 * 7.5e-3)
    assert curve.stiffness_at("0.2 inch") == pytest.approx(41e3)
    run = study.solution("finite-element", "5600 rpm")
    assert study.quantities.of_run("finite-element", "5600 rpm") == dict(run.quantities)
    with pytest.raises(InputError, match="7 m of compression can only be meant as 7 mm"):
        curve.force_at(7)
    with pytest.raises(InputError, match="can only be meant as 5600 rpm"):
        study.solution("finite-element", 5600)


def test_frames_hold_every_value_in_si():
    run, rest, study = rod_run(), at_rest()[0], own_study()
    table = run.to_pandas()
    pair = run.channels["upper_coil"].values[1]
    assert table.index.name == "time" and len(table) == len(run.time)
    assert np.array_equal(table[f"coil_gap[{pair:g}]"], run.channel("coil_gap")[:, 1])
    assert table.attrs["units"][f"coil_gap[{pair:g}]"] == "m"
    assert len(run.reduced().to_pandas()) == 0
    assert np.array_equal(rest.curve.to_pandas()["force"], rest.curve.force)
    assert list(rest.modes.to_pandas()["axial"]) == [False, True, True, False, True]
    rows = study.to_pandas()
    assert list(rows.columns) == ["quantity", "label", "engine_speed", "value", "unit"]
    assert len(rows) == len(study.quantities)
    assert rows.set_index("quantity").loc["preload", "value"] == study.quantities["preload"]


def test_without_pandas_one_sentence_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match="needs pandas, which is not installed; install it"):
        rod_run().to_pandas()


def test_results_load_no_plotting_until_asked():
    code = "import sys, valvetrain.solution.study; print([m for m in ('plotly', 'pandas', 'valvetrain.views') if m in sys.modules])"
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout.strip()
        == "[]"
    )
