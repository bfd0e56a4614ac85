"""Any solution read back from its file is the one that was written."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from valvetrain.solution.channels import spring_channels
from valvetrain.solution.netcdf import load_netcdf, save_netcdf
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.status import STATUS_CODES, Event, Status

WORDS = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
FLOATS = st.floats(allow_nan=False)
SCALARS = st.one_of(st.integers(-(2**53), 2**53), FLOATS, WORDS, st.booleans())


@st.composite
def solutions(draw) -> Solution:
    samples, points, pairs = (
        draw(st.integers(1, 4)),
        draw(st.integers(1, 3)),
        draw(st.integers(1, 3)),
    )

    def block(*shape):
        return draw(arrays(float, shape, elements=st.floats()))

    values = {
        "seat_force": block(samples), "axial_position": block(samples, points), "coil_gap": block(samples, pairs),
        "contact_status": draw(arrays(np.int64, (samples, pairs), elements=st.integers(0, 3))),
    }  # fmt: skip
    channels = spring_channels(
        block(samples), block(samples), values, coil_number=block(points), upper_coil=block(pairs)
    )
    details = st.dictionaries(WORDS, SCALARS, max_size=2)
    events = st.lists(
        st.builds(Event, WORDS, FLOATS, FLOATS, FLOATS, FLOATS, WORDS, WORDS, details), max_size=2
    )
    status = draw(st.builds(Status, st.sampled_from(STATUS_CODES), WORDS, FLOATS, WORDS, WORDS))
    provenance = draw(
        st.builds(
            Provenance,
            WORDS,
            WORDS,
            FLOATS,
            WORDS,
            WORDS,
            WORDS,
            st.dictionaries(WORDS, WORDS, max_size=2),
            details,
            WORDS,
            st.lists(WORDS, max_size=2).map(tuple),
        )
    )
    return Solution(channels, tuple(draw(events)), status, draw(details), provenance)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(solution=solutions())
def test_round_trip(solution):
    with tempfile.TemporaryDirectory() as folder:
        path = save_netcdf(solution, Path(folder) / "file")
        assert load_netcdf(path).identical(solution)
