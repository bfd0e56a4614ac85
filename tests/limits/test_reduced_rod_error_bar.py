"""The error bar of a reduced rod holds its difference from the rod under the motion that the run found
(limit between models; property: it names the rod where it is too far off).
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.runs import against_rod


@pytest.fixture(scope="module")
def study():
    return vt.simulate("job-c", "3000 rpm", spring_models=["reduced-rod", "finite-element"])


def test_the_bar_holds_what_the_rod_has(study):
    reduced, rod = study.solutions
    bars = {row.quantity: row for row in study.error_bars.rows if row.label == "reduced-rod"}
    assert {"peak_spring_force", "minimum_spring_force"} <= set(bars)
    for name in ("minimum_spring_force", "below_20_khz_peak_spring_force"):
        value = rod.quantities[name]
        assert abs(reduced.quantities[name] - value) < bars[name].numerical + 0.005 * value
        assert bars[name].numerical < 0.05 * value


def test_a_run_too_far_off_names_the_rod(study, monkeypatch):
    said = " ".join(study.error_bars.sentences)
    assert "difference from its rod" in said and "take finite-element" not in said
    monkeypatch.setattr(against_rod, "TOO_FAR", 1e-9)
    again = vt.simulate("job-c", "3000 rpm", spring_models=["reduced-rod"])
    assert "take finite-element there" in " ".join(again.error_bars.sentences)
    assert np.isfinite([row.numerical for row in again.error_bars.rows]).all()


def test_a_sweep_of_a_spring_alone_compares_it_with_its_rod_too():
    """Contract: the lift law drives both, though runs of a sweep keep no channels."""
    swept = vt.sweep("job-c", "3000 rpm", "reduced-rod", workers=1)
    assert not len(swept.solutions[0].time)
    assert "difference from its rod" in " ".join(swept.error_bars.sentences)
