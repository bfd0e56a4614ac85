"""Property-based: whatever bytes a file of lifts holds, it is read or refused with one sentence."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain.errors import InputError
from valvetrain.measured.lift_file import LiftAnswers, lifts_in
from valvetrain.measured.lift_smoothing import smooth_lift

ANSWERS = LiftAnswers(angle_of="cam", lift_of="tappet", lift_unit="mm")
NUMBERS = st.one_of(
    st.floats(width=32).map(repr),
    st.integers(-400, 400).map(str),
    st.sampled_from(["1,5", "1.5e3", ".", "-", "nan", "0x1f", "1e999"]),
)
LINES = st.lists(
    st.lists(NUMBERS, min_size=1, max_size=4).map(" ".join) | st.text(max_size=12), max_size=30
).map("\n".join)


def read(content):
    try:
        lobes = lifts_in(content, "any", ANSWERS)
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 600
        return
    for lobe in lobes:
        assert np.all(np.isfinite(lobe.lifts)) and np.all(np.diff(lobe.cam_angles) > 0)
        try:
            smooth = smooth_lift(lobe.cam_angles, lobe.lifts)
        except InputError as error:
            assert "\n" not in str(error)
            continue
        assert np.all(np.isfinite(smooth.coefficients)) and smooth.noise > 0


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=300))
def test_bytes(content):
    read(content)


@settings(max_examples=150, deadline=None)
@given(LINES)
def test_lines_of_numbers_and_words(text):
    read(text.encode("utf-8", "surrogatepass"))


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-5, 15), min_size=8, max_size=80))
def test_any_lifts_at_whole_degrees(lifts):
    read("\n".join(f"{angle} {lift!r}" for angle, lift in enumerate(lifts)).encode())
