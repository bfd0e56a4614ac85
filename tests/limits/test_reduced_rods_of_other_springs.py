"""A reduced rod of a spring that is in no library says where its clash is too hard for it (contract); at
rest and in motion without that it stands in the validation book.
"""

from __future__ import annotations

import pytest
from validation.against_rod import difference_from_rods
from validation.reduced_rods import OTHER_SPRINGS, Pulse, other_spring

import valvetrain as vt
from fact_parts import with_code


@pytest.mark.slow
def test_a_spike_that_is_too_high_is_said():
    """Coils of the cone clash at 250 rad/s: its rms is within 1 %, a spike is not."""
    largest = OTHER_SPRINGS["conical"][2]
    found = difference_from_rods([other_spring("conical")], Pulse(largest), 250.0)
    assert found is not None and found.rms < 0.01 < found.peak
    assert found.too_far.startswith("peak ")


@pytest.mark.slow
def test_a_run_whose_clash_is_too_hard_says_so():
    """At 10000 rpm the peak of job C is 12 % off that of its rod, at 2000 rpm, where no coil clashes, none is."""
    speeds = ["2000 rpm", "10000 rpm"]
    study = vt.simulate("job-c", speeds, models=["reduced-rod"], compute="error_bars", workers=1)
    (fact,) = with_code(study.error_bars.facts, "too-hard")
    assert fact.fields["engine_speed"] == max(study.engine_speeds)
    assert fact.fields["peak_share"] > 0.01
    rods = vt.simulate("job-c", speeds, models=["finite-element"], workers=1)
    shares = [
        abs(run.quantities["peak_spring_force"] / rod.quantities["peak_spring_force"] - 1)
        for run, rod in zip(study.solutions, rods.solutions, strict=True)
    ]
    assert shares[0] < 0.01 < 0.05 < shares[1]
