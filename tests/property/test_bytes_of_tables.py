"""Property-based: whatever bytes a table of lifts, forces or values holds, it is read or refused with one sentence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain.compare_test.reader import read_test
from valvetrain.errors import InputError
from valvetrain.measured.force_height import force_height_in
from valvetrain.measured.lift_file import LiftAnswers, lifts_in
from valvetrain.measured.lift_smoothing import smooth_lift
from valvetrain.measured.tables import read_text_table, text_of
from valvetrain.measured.value_table import is_value_table, values_in

ANSWERS = LiftAnswers(angle_of="cam", lift_of="tappet", lift_unit="mm")
NUMBERS = st.one_of(
    st.floats(width=32).map(repr),
    st.integers(-400, 400).map(str),
    st.sampled_from(["1,5", "1.5e3", ".", "-", "nan", "0x1f", "1e999"]),
)
CELLS = st.one_of(
    NUMBERS,
    st.sampled_from(["N", "mm", "1 %", "-5 %", "", "deg", "peak_lift", '"', "9 rpm"]),
    st.text(max_size=8),
)
ROWS = st.lists(st.lists(CELLS, min_size=1, max_size=6).map(",".join), max_size=8).map("\n".join)
HEADS = st.sampled_from([
    "quantity,unit,value,scatter", "quantity,unit,repeat 1,repeat 2", "quantity,unit,value,scatter,cam angle [deg],angle scatter [deg]",
    "name;unit;value;scatter;engine speed [rpm]", "quantity,unit,value,scatter,cam angle", "quantity,quantity,unit,value", "quantity",
])  # fmt: skip


def lines(mark: str):
    return st.lists(
        st.lists(NUMBERS, min_size=1, max_size=4).map(mark.join) | st.text(max_size=12), max_size=30
    ).map("\n".join)


def lifts(content):
    for lobe in lifts_in(content, "any", ANSWERS):
        assert np.all(np.isfinite(lobe.lifts)) and np.all(np.diff(lobe.cam_angles) > 0)
        civil(law, lobe)


def law(lobe):
    smooth = smooth_lift(lobe.cam_angles, lobe.lifts)
    assert np.all(np.isfinite(smooth.coefficients)) and smooth.noise > 0


def forces(content, columns=("height", "force")):
    table = read_text_table(text_of(content, "any"), "any")
    found = force_height_in(table, "any", columns, "mm", "N", 0.05)
    assert np.all(np.diff(found.heights) < 0) and np.all(np.isfinite(found.forces))
    assert found.forces[-1] > found.forces[0]


def values(content):
    for one in values_in(text_of(content, "any"), "any").values:
        assert np.all(np.isfinite(one.repeats)) and one.engine_speed >= 0
        assert one.scatter > 0 or len(one.repeats) > 1


def civil(read, *given):
    try:
        read(*given)
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 600


@pytest.mark.parametrize("read", [lifts, forces, values])
@settings(max_examples=120, deadline=None)
@given(content=st.binary(max_size=300))
def test_bytes(read, content):
    civil(read, content)
    civil(values, b"quantity,unit,value,scatter\n" + content[:200])


@settings(max_examples=150, deadline=None)
@given(lines(" "), lines(";"), HEADS, ROWS)
def test_lines_of_numbers_and_words(lobe, stations, head, rows):
    civil(lifts, lobe.encode("utf-8", "surrogatepass"))
    civil(forces, stations.encode("utf-8", "surrogatepass"), ())
    civil(values, f"# engine speed: 4200 rpm\n{head}\n{rows}".encode("utf-8", "surrogatepass"))


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-50, 80), st.floats(-500, 1500)), min_size=6, max_size=60),
    st.lists(st.floats(-5, 15), min_size=8, max_size=80),
)
def test_any_stations(rows, heights):
    text = "\n".join(f"{height!r} {force!r}" for height, force in rows).encode()
    civil(forces, text)
    civil(forces, text, ("compression", "force"))
    civil(lifts, "\n".join(f"{angle} {lift!r}" for angle, lift in enumerate(heights)).encode())


@settings(max_examples=40, deadline=None)
@given(st.floats(1.0, 100.0), st.floats(1e-2, 10.0), st.sampled_from(["N", "mm", "m/s", "deg"]))
def test_a_value_comes_back_as_it_was_written(value, scatter, unit):
    text = f"quantity,unit,value,scatter\nlift,{unit},{value!r},{scatter!r}"
    assert is_value_table(text)
    one = values_in(text, "own").values[0]
    factor = {"N": 1.0, "mm": 1e-3, "m/s": 1.0, "deg": np.pi / 180}[unit]
    given, due = (one.value, one.scatter), (value * factor, scatter * factor)
    assert np.allclose(given, due, rtol=1e-12, atol=0.0)


@settings(max_examples=80, deadline=None)
@given(
    st.one_of(st.binary(max_size=200), ROWS.map(str.encode)),
    st.sampled_from([b"", b"\x89HDF\r\n\x1a\n", b"# quantity: valve_lift\n# unit: mm\n"]),
)
def test_a_file_is_cycles_or_values_or_refused(tmp_path_factory, content, begin):
    file = tmp_path_factory.getbasetemp() / "any-test"
    file.write_bytes(begin + content)
    civil(read_test, file)
