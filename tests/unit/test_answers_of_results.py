"""Contract: notes, critical speeds and modes are said in words where a result is shown; arguments that
a function does not have, and numbers of keys that a case lacks, are answered by one sentence or taken.
"""

from __future__ import annotations

import math

import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.solution.modes import SpringModes

SPRING = vt.Spring(
    wire_diameter="4.1 mm", mean_diameter="25 mm", total_coils=7.2, pitch="7.9 mm",
    material="EN 10270-2 VDSiCr", installed_height="42 mm",
)  # fmt: skip


def test_every_mode_of_a_spring_has_a_kind_and_surge_follows_from_it():
    modes = SPRING.modes(24)
    assert isinstance(modes, SpringModes) and len(modes.kinds) == 24
    surge = SPRING.frequencies()
    assert len(surge) >= 3 and list(surge) == list(modes.surge_frequencies)
    shares = [
        one for one, kind in zip(modes.axial_share, modes.kinds, strict=True) if kind == "surge"
    ]
    assert min(shares) >= 1 / 2
    assert "lateral" in repr(modes) and set(modes.to_pandas()["kind"]) == set(modes.kinds)


@pytest.mark.parametrize("name", ["refine", "run", "compare", "sweep", "critical_speeds", "static"])
def test_an_unknown_argument_is_answered_by_one_sentence(name):
    with pytest.raises(InputError, match="there is no 'modul'"):
        getattr(vt.Case("job-t"), name)(modul="massless")


def test_a_key_that_the_case_lacks_takes_a_bare_si_number():
    case = vt.Case("tdi-pushrod").set({"train.cycles": 2})
    assert "friction" not in case.text
    table = case.study(
        {"train.valve.friction": [1.0, 30.0]}, ["peak_valve_lift"], sampling="grid",
        engine_speeds="2000 rpm", models="massless", spring_sets="stock", workers=1,
    )  # fmt: skip
    assert all(math.isfinite(one) for one in table.values.ravel())
