"""Unit: rules of charts: what is shaded, which runs are drawn, marginals in any unit."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from valvetrain.explore.identification_charts import _density


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e6])
def test_a_marginal_of_draws_is_the_same_curve_in_any_unit(scale):
    """Draws of 0 to 1 within bounds of -10 to 10: bars over 1.8 times the middle 90 % alone, as
    many as there are bins, of area one.
    """
    values = scale * np.linspace(0.0, 1.0, 4001)[:, None]
    interval = SimpleNamespace(low=0.05 * scale, high=0.95 * scale)
    found = SimpleNamespace(
        evidence_kind="nested",
        names=("one",),
        values=values,
        weights=np.full(4001, 1 / 4001),
        branch_of=np.zeros(4001, dtype=int),
    )
    edges, heights = _density(
        found, SimpleNamespace(quantities={"one": interval}), 0, 0, -10 * scale, 10 * scale
    )
    assert (edges[0] / scale, edges[-1] / scale) == pytest.approx((0.05 - 0.36, 0.95 + 0.36))
    assert np.sum(heights[1:-1:2] * np.diff(edges[::2])) == pytest.approx(1.0)
    assert np.median(heights[heights > 0]) * scale == pytest.approx(1.0, rel=0.02)
