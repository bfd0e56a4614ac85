"""What stands beside a run in the figures of the page is its own: bars of its number and speed, the
static curve of its spring.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import at_rest, own_study, published_study, rod_run
from valvetrain.report.chart import Line, Marks
from valvetrain.report.sections import coils as stress
from valvetrain.report.sections import published
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.uncertainty import Uncertainty


def lines(chart, panel):
    return {layer.name: layer for layer in chart.panels[panel].layers if isinstance(layer, Line)}


@pytest.mark.parametrize("speed", [None, 400.0, 0.4])
@pytest.mark.parametrize(("model", "bar"), [("finite-element", True), ("massless", False)])
def test_a_ratio_carries_the_bar_of_its_own_number_and_speed_alone(monkeypatch, speed, model, bar):
    """6 N of 300 N given are 2 % to either side; at rest as at any speed, however low, and of the
    finite elements only.
    """
    others = {None, 400.0, 0.4} - {speed}
    rows = [
        Uncertainty(
            "preload",
            at,
            310.0,
            6.0 if at == speed else 90.0,
            2.0,
            310.0,
            0.0,
            (310.0, 310.0),
            (310.0, 310.0),
            "finite-element",
        )
        for at in (*others, speed)
    ]
    monkeypatch.setattr(published, "load_uncertainty", lambda record: tuple(rows))
    row = Comparison(
        "preload",
        speed,
        model,
        "engine head test",
        "N",
        300.0,
        315.0,
        15.0,
        "check",
        None,
        "",
        "table 1",
    )
    chart = published.ratio_chart(replace(published_study(), comparisons=(row,)))
    spans = [
        layer.x[:2] for layer in chart.panels[0].layers if layer.name == "numerical uncertainty"
    ]
    assert [list(one) for one in spans] == (
        [[pytest.approx(1.03), pytest.approx(1.07)]] if bar else []
    )


@pytest.mark.parametrize(("told", "left"), [(3, 0), (3, 1), (1, 4), (25, 2)])
def test_values_without_a_ratio_are_counted_under_the_figure(told, left):
    """What a run did not compute, what is zero in the source and what came out infinite has no
    ratio; none at all has no figure.
    """
    row = Comparison(
        "preload",
        None,
        "finite-element",
        "test",
        "N",
        300.0,
        315.0,
        15.0,
        "check",
        None,
        "",
        "table 1",
    )
    without = [
        replace(row, computed=None),
        replace(row, published=0.0),
        replace(row, computed=np.inf),
        replace(row, computed=None),
    ]
    study = replace(published_study(), comparisons=(*without[:left], *(row,) * told))
    chart = published.ratio_chart(study)
    (marks,) = [one for one in chart.panels[0].layers if isinstance(one, Marks)]
    assert marks.x == pytest.approx(np.full(told, 1.05)) and len(set(marks.y)) == told
    assert ("without a ratio" in chart.caption) == bool(left)
    assert not left or f" {left} values without a ratio are in the table only." in chart.caption
    assert published.ratio_chart(replace(study, comparisons=tuple(without))) is None


@pytest.mark.parametrize(
    ("before", "own", "found"),
    [
        ((), True, True),
        ((("inner", 2.0),), True, True),
        ((("spring", None),), True, True),
        ((("inner", 2.0), ("spring", None)), True, True),
        ((("inner", 2.0),), False, False),
        ((("spring", None),), False, False),
        ((), False, False),
    ],
)
def test_the_stress_of_a_run_stands_beside_the_static_curve_of_its_own_spring(before, own, found):
    """Rows at rest of another spring (twice the stress), or of this one without stress, stand
    before it: 41 MPa per mm, from 7 mm on.
    """
    first, *rest = at_rest()

    def row(name: str, share: float | None):
        return replace(
            first,
            spring=name,
            stress=None
            if share is None
            else replace(first.stress, shear=share * first.stress.shear),
        )

    study = replace(
        own_study(), rest=(*(row(*one) for one in before), *((first, *rest) if own else ()))
    )
    chart = stress.stress_chart(study, rod_run(), "spring", "stress", "Wire stress")
    still = [lines(chart, panel).get("static curve at the same lift") for panel in (0, 1)]
    if not found:
        assert still == [None, None]
        return
    assert still[0].y == pytest.approx(np.full(len(still[0].x), 41.0 * 16), rel=1e-6)
    assert [still[1].y.min(), still[1].y.max()] == pytest.approx([41.0 * 7, 41.0 * 16], rel=1e-6)
