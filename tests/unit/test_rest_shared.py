"""Property: every train of a study is brought to rest once, however many runs, labels and speeds share
it; trains that differ in lash or spring model differ in their rest.
"""

from __future__ import annotations

import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.runs.requests import Static
from valvetrain.runs.static_study import static_study


def test_the_springs_of_the_set_in_use_come_first():
    """Contract: not a card of another set, of 17.4 N/mm throughout; coils of the outer spring in use close in the
    lift: 17.1 N/mm installed, 22.9 at full lift.
    """
    study = static_study(Static(case=load_case("vaz-ohc")))
    assert [(one.spring, one.model) for one in study.rest[:2]] == [
        ("outer", "finite-element"),
        ("inner", "finite-element"),
    ]
    assert len(study.rest) == 4
    outer = study.rest[0]
    lifted = outer.precompression + 9.7e-3
    rates = [float(outer.curve.stiffness_at(at)) for at in (outer.precompression, lifted)]
    assert rates == pytest.approx([17.1e3, 22.9e3], rel=0.01)
