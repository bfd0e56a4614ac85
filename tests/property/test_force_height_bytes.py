"""Property-based: whatever bytes a table of a spring tester holds, it is read or refused with one
sentence.
"""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain.errors import InputError
from valvetrain.measured.force_height import force_height_in
from valvetrain.measured.tables import read_text_table, text_of

NUMBERS = st.one_of(
    st.floats(width=32).map(repr),
    st.integers(-400, 400).map(str),
    st.sampled_from(["1,5", ".", "-", "nan", "1e999"]),
)
LINES = st.lists(
    st.lists(NUMBERS, min_size=1, max_size=3).map(";".join) | st.text(max_size=12), max_size=30
).map("\n".join)


def read(content, columns=("height", "force")):
    try:
        found = force_height_in(
            read_text_table(text_of(content, "any"), "any"), "any", columns, "mm", "N", 0.05
        )
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 600
        return
    assert (
        np.all(np.diff(found.heights) < 0)
        and np.all(np.isfinite(found.forces))
        and found.forces[-1] > found.forces[0]
    )


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=300))
def test_bytes(content):
    read(content)


@settings(max_examples=150, deadline=None)
@given(LINES)
def test_lines_of_numbers_and_words(text):
    read(text.encode("utf-8", "surrogatepass"), ())


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.floats(-50, 80), st.floats(-500, 1500)), min_size=6, max_size=60))
def test_any_stations(rows):
    read("\n".join(f"{height!r} {force!r}" for height, force in rows).encode())
    read(
        "\n".join(f"{height!r} {force!r}" for height, force in rows).encode(),
        ("compression", "force"),
    )
