"""Property-based: whatever bytes a file of a test holds, it is read or refused with one sentence."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain.compare_test.reader import read_test
from valvetrain.errors import InputError
from valvetrain.measured.tables import text_of
from valvetrain.measured.value_table import is_value_table, values_in

CELLS = st.one_of(
    st.floats(width=32).map(repr),
    st.sampled_from(
        ["N", "mm", "1 %", "-5 %", "", "nan", "1e999", "deg", "peak_lift", '"', "9 rpm"]
    ),
    st.text(max_size=8),
)
ROWS = st.lists(st.lists(CELLS, min_size=1, max_size=6).map(",".join), max_size=8).map("\n".join)
HEADS = st.sampled_from([
    "quantity,unit,value,scatter", "quantity,unit,repeat 1,repeat 2", "quantity,unit,value,scatter,cam angle [deg],angle scatter [deg]",
    "name;unit;value;scatter;engine speed [rpm]", "quantity,unit,value,scatter,cam angle", "quantity,quantity,unit,value", "quantity",
])  # fmt: skip


def read(content):
    try:
        found = values_in(text_of(content, "any"), "any")
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 400
        return
    for one in found.values:
        assert (
            np.all(np.isfinite(one.repeats))
            and (one.scatter > 0 or len(one.repeats) > 1)
            and one.engine_speed >= 0
        )


@settings(max_examples=80, deadline=None)
@given(st.binary(max_size=200))
def test_bytes(content):
    read(content)
    read(b"quantity,unit,value,scatter\n" + content)


@settings(max_examples=100, deadline=None)
@given(HEADS, ROWS)
def test_rows_below_a_heading(head, rows):
    read(f"# engine speed: 4200 rpm\n{head}\n{rows}".encode("utf-8", "surrogatepass"))


@settings(max_examples=40, deadline=None)
@given(st.floats(1.0, 100.0), st.floats(1e-2, 10.0), st.sampled_from(["N", "mm", "m/s", "deg"]))
def test_a_value_comes_back_as_it_was_written(value, scatter, unit):
    text = f"quantity,unit,value,scatter\nlift,{unit},{value!r},{scatter!r}"
    assert is_value_table(text)
    one = values_in(text, "own").values[0]
    factor = {"N": 1.0, "mm": 1e-3, "m/s": 1.0, "deg": np.pi / 180}[unit]
    assert np.allclose(
        (one.value, one.scatter), (value * factor, scatter * factor), rtol=1e-12, atol=0.0
    )


@settings(max_examples=80, deadline=None)
@given(
    st.one_of(st.binary(max_size=200), ROWS.map(str.encode)),
    st.sampled_from([b"", b"\x89HDF\r\n\x1a\n", b"# quantity: valve_lift\n# unit: mm\n"]),
)
def test_a_file_is_cycles_or_values_or_refused(tmp_path_factory, content, begin):
    file = tmp_path_factory.getbasetemp() / "any-test"
    file.write_bytes(begin + content)
    try:
        found = read_test(file)
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 400
        return
    assert found.values is not None
