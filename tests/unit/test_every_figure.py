"""Every figure of every page carries the series, unit and sign that it names, and nothing else:
read back beside what was written down.
"""

from __future__ import annotations

import re
from functools import cache
from itertools import combinations

import numpy as np
import pytest

from known_figures import FIGURES, STUDIES, expected
from valvetrain.registry import names as registered_names
from valvetrain.report.chart import Chart, HeatMap
from valvetrain.report.page import Page, charts
from valvetrain.report.study import study_page
from valvetrain.solution.study import Study


@cache
def page_of(name: str) -> tuple[Study, Page]:
    """The study of that name and its page."""
    study = STUDIES[name]()
    return study, study_page(study)


def carried(chart: Chart):
    """Panels as they are written down: title, axes, and the numbers by the name of their layer."""
    return [
        (
            panel.title,
            panel.x_label,
            panel.y_label,
            {
                layer.name: (
                    np.asarray(layer.x),
                    np.asarray(layer.z if isinstance(layer, HeatMap) else layer.y),
                )
                for layer in panel.layers
            },
        )
        for panel in chart.panels
    ]


@pytest.mark.parametrize("name", STUDIES)
def test_figures_carry_what_they_name(name):
    study, page = page_of(name)
    for chart in charts(page):
        known = expected(study, chart.key)
        assert known is not None, (
            f"write down in known_figures.py what the figure '{chart.key}' carries"
        )
        found = carried(chart)
        assert [panel[:3] for panel in found] == [panel[:3] for panel in known], chart.key
        for panel, (_, _, axis, layers), theirs in zip(chart.panels, found, known, strict=True):
            assert sorted(layer.name for layer in panel.layers) == sorted(theirs[3]), (
                f"{chart.key}, {axis}"
            )
            for layer, (x, y) in theirs[3].items():
                place, size = (
                    f"{chart.key}, {axis}: {layer}",
                    max(float(np.nanmax(np.abs(y))), 1e-12),
                )
                np.testing.assert_allclose(layers[layer][0], x, rtol=1e-6, atol=1e-6, err_msg=place)
                np.testing.assert_allclose(
                    layers[layer][1], y, rtol=1e-6, atol=2e-5 * size, err_msg=place
                )


def test_every_kind_of_figure_was_drawn():
    drawn = [chart.key for name in STUDIES for chart in charts(page_of(name)[1])]
    assert not [
        pattern for pattern in FIGURES if not any(re.fullmatch(pattern, key) for key in drawn)
    ]


def test_every_section_of_the_registry_stood_on_a_page():
    shown = {section.key for name in STUDIES for section in page_of(name)[1].sections}
    assert (
        not set(registered_names("sections"))
        - shown
        - {"uncertainty", "critical-speeds", "timing", "lift-by-speed", "strength"}
    )  # which have tests of their own


def test_no_line_can_stand_for_another():
    """The made-up numbers would hide a swap if two lines of one panel were alike."""
    for chart in [chart for name in STUDIES for chart in charts(page_of(name)[1])]:
        for _, _, axis, layers in carried(chart):
            rows = [y for _, y in layers.values() if np.ndim(y) == 1 and len(y) > 20]
            for one, other in combinations(rows, 2):
                assert len(one) != len(other) or not np.array_equal(one, other, equal_nan=True), (
                    chart.key,
                    axis,
                )


def test_axes_reach_over_what_they_carry():
    """A given range holds all numbers of its panel and not twice as much; a cam turn is 0 to 360
    degrees.
    """
    for name in STUDIES:
        for chart in charts(page_of(name)[1]):
            for panel in chart.panels:
                x, y = (
                    np.concatenate([np.ravel(getattr(layer, side)) for layer in panel.layers])
                    for side in ("x", "y")
                )
                if "cam angle (cam" in panel.x_label and "spikes" not in chart.key:
                    assert panel.x_range == (0, 360), chart.key
                for values, given, clipped in (
                    (x, panel.x_range, "spikes" in chart.key),
                    (y, panel.y_range, chart.key == "static-1"),
                ):
                    if given is None:
                        continue
                    low, high = np.nanmin(values), np.nanmax(values)
                    assert clipped or (given[0] <= low + 1e-6 and high - 1e-6 <= given[1]), (
                        chart.key,
                        panel.y_label,
                    )
                    assert given[1] - given[0] <= 3.1 * max(high - low, abs(high), 1.0), (
                        chart.key,
                        panel.y_label,
                    )
