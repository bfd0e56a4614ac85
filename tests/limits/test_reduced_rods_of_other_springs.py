"""A reduced rod of a spring that is in no library says where its clash is too hard for it (contract); at
rest and in motion without that it stands in the validation book.
"""

from __future__ import annotations

from valvetrain.validation.against_rod import difference_from_rods
from valvetrain.validation.reduced_rods import OTHER_SPRINGS, Pulse, other_spring


def test_a_spike_that_is_too_high_is_said():
    """Coils of the cone clash at 250 rad/s: its rms is within 1 %, a spike is not."""
    largest = OTHER_SPRINGS["conical"][2]
    found = difference_from_rods([other_spring("conical")], Pulse(largest), 250.0)
    assert found is not None and found.rms < 0.01 < found.peak
    assert found.too_far.startswith("peak ")
