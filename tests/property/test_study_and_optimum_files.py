"""However a file of a study or an optimisation is broken: one sentence with the place, never another error."""

from __future__ import annotations

from pathlib import Path

import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain import InputError
from valvetrain.explore.files import FileText
from valvetrain.explore.measure import OptimumModel
from valvetrain.explore.objective import read_optimum
from valvetrain.explore.requests import Optimise, Study
from valvetrain.explore.study import StudyModel, read_plan

EXAMPLES = Path(__file__).parents[2] / "examples"
FEW = settings(max_examples=120, deadline=None)


def study(text):
    return read_plan(FileText(text, "study.toml", Path(), StudyModel))


def optimum(text):
    return read_optimum(FileText(text, "search.toml", Path(), OptimumModel))


TEXTS = [
    (reader, path.read_text(encoding="utf-8"))
    for reader, pattern in ((study, "studies/*.toml"), (optimum, "optimise-*.toml"))
    for path in sorted(EXAMPLES.glob(pattern))
]


def refused(reader, text: str) -> str:
    """The sentence that refuses a text; empty where it is taken."""
    try:
        reader(text)
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 1100
        return str(error)
    return ""


@pytest.mark.parametrize(("reader", "text"), TEXTS)
def test_the_examples_are_taken(reader, text):
    assert not refused(reader, text)


@FEW
@given(st.sampled_from(TEXTS), st.data())
@pytest.mark.slow
def test_a_file_with_a_piece_replaced_is_taken_or_refused_in_one_sentence(example, data):
    reader, text = example
    begin = data.draw(st.integers(0, len(text) - 1))
    end = data.draw(st.integers(begin, min(len(text), begin + 40)))
    refused(reader, text[:begin] + data.draw(st.text(max_size=20)) + text[end:])


@FEW
@given(st.sampled_from([study, optimum]), st.text(max_size=200))
def test_any_text_is_refused(reader, text):
    assert refused(reader, text)


#: What a value may be, whatever its key: words that mean something somewhere stand among them.
WORDS = (
    "1 mm|-1 mm|nan mm|0 mm|3 furlong|1.0 x case|0 x case|case|1e999 N|6000 rpm|4000:9000:1 rpm|rpm|spring.pitch|engine_speed"
    "|factor|grid|peak_spring_force|preload|minimise|mean"
).split("|")
VALUES = st.one_of(
    st.text(max_size=12),
    st.integers(-(10**20), 10**20),
    st.floats(),
    st.booleans(),
    st.lists(st.integers(-3, 3), max_size=3),
    st.sampled_from(WORDS),
    st.dictionaries(
        st.sampled_from(["quantity", "at_most", "engine_speeds"]),
        st.sampled_from(["clash_count", "3", "9000 rpm"]),
    ),
)


def tables(keys: str, size: int = 5):
    return st.dictionaries(st.sampled_from(keys.split()), VALUES, max_size=size)


OBJECTIVE = "quantity limit_speed engine_speeds over label direction at_most at_least"
VARIED = "key as unit label values low high mean standard_deviation median factor tolerance shape"
KNOWN = {
    study: st.fixed_dictionaries(
        {
            "outputs": st.just(["peak_spring_force"]),
            "points": tables("sampler count seed levels"),
            "vary": tables(VARIED).map(lambda vary: [{"key": "spring.precompression", **vary}]),
        }
    ),
    optimum: st.fixed_dictionaries(
        {
            "objective": tables(OBJECTIVE).map(lambda one: [one]),
            "constraint": tables(OBJECTIVE, 4).map(lambda one: [one]),
            "search": tables("method trials per_round seed local", 3),
            "vary": st.just([{"key": "spring.precompression", "low": "6 mm", "high": "8 mm"}]),
        }
    ),
}


@FEW
@given(st.sampled_from([study, optimum]), st.data())
def test_any_values_of_the_known_keys_are_taken_or_refused_in_one_sentence(reader, data):
    try:
        text = tomlkit.dumps({"case": "job-c"} | data.draw(KNOWN[reader]))
    except (ValueError, UnicodeError):  # what no TOML can hold
        return
    refused(reader, text)


@FEW
@given(st.sampled_from([Study, Optimise]), st.binary(max_size=300))
def test_any_bytes_are_refused(tmp_path_factory, reader, content):
    path = tmp_path_factory.mktemp("bytes", numbered=True) / "search.toml"
    path.write_bytes(content)
    with pytest.raises(InputError) as error:
        reader.read({"file": path}).text  # noqa: B018
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("reader", [Study, Optimise])
def test_what_is_no_file_is_refused(tmp_path, reader):
    for path in (tmp_path, tmp_path / "absent.toml"):
        with pytest.raises(InputError):
            reader.read({"file": path}).text  # noqa: B018
