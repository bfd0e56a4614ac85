"""The figure of a surrogate: computed along x, predicted along y, both in the unit shown, and the
line on which they would agree.
"""

from __future__ import annotations

import numpy as np

from valvetrain.explore.study_charts import surrogate_chart
from valvetrain.explore.surrogate import Surrogate
from valvetrain.report.chart import Line, Marks


def test_points_stand_where_their_numbers_say():
    computed, predicted = np.array([10e-3, 12e-3, 17e-3]), np.array([11e-3, 12e-3, 20e-3])
    one = Surrogate(
        "clash_energy",
        (600.0, "multi-mass", ""),
        ("rate",),
        1.8e-3,
        0.6,
        1.0,
        predicted,
        computed,
        np.zeros(1),
        np.ones(1),
        np.zeros(1),
        np.ones(1),
        None,
    )
    chart = surrogate_chart(one, "first")
    (panel,) = chart.panels
    line, marks = panel.layers
    assert isinstance(line, Line) and isinstance(marks, Marks) and chart.key == "first-surrogate"
    np.testing.assert_allclose(marks.x, [10, 12, 17])  # mJ
    np.testing.assert_allclose(marks.y, [11, 12, 20])
    np.testing.assert_allclose(line.x, [10, 20])
    np.testing.assert_allclose(line.y, [10, 20])
    assert (
        panel.x_label == "computed: clash energy (mJ)"
        and panel.y_label == "surrogate"
        and panel.x_range == panel.y_range
    )
    assert panel.x_range[0] <= 10 and panel.x_range[1] >= 20
    assert (
        "errs by 1.8 mJ (rms) at each of its 3 points left out in turn" in chart.caption
        and chart.title == "Surrogate of the clash energy"
    )
