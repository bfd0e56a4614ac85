"""Unit: the numbers and runs that the first picture of a page is made of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from valvetrain.report.run_charts import with_extremes
from valvetrain.report.sections import at_rest
from valvetrain.runs.api import simulate


def test_the_curve_of_a_force_reaches_its_peak_and_its_minimum():
    """Contract: "peak spring force 1783 N" stood over a curve whose samples reach 1185 N."""
    run = simulate("job-c", "8000 rpm", spring_models=["finite-element"]).solutions[0]
    angle, force = with_extremes(run, "seat_force")
    assert force.max() == run.quantities["raw_peak_spring_force"]
    assert force.min() == run.quantities["minimum_spring_force"]
    assert (np.diff(angle) >= 0).all() and 0 <= angle[0] < angle[-1] <= 360
    assert force.max() > run.channel("seat_force").max() + 5


def test_models_do_not_differ_by_all_of_a_force_that_is_none():
    """Contract: round-off at no compression was drawn as a difference of -100 %."""
    curve = at_rest_curve(np.linspace(0, 8e-3, 9), 40e3)
    off = replace(curve, force=curve.force * 1.01)
    start = replace(curve, force=np.maximum(curve.force, 1e-13))
    found = at_rest.difference(off, start)
    assert np.isnan(found[0]) and found[1:] == pytest.approx(1.0)


def at_rest_curve(compression, rate):
    from valvetrain.solution.static import StaticCurve

    none, size = np.zeros((len(compression), 0)), np.zeros(0)
    return StaticCurve(compression, rate * compression, np.full(len(compression), rate), none, none, size, none, size)  # fmt: skip
