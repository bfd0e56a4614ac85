"""However an optimisation file is broken: one sentence with the place, never another error."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain import InputError
from valvetrain.explore.objective import read_optimum
from valvetrain.explore.optimum_file import OptimumText, read_optimum_file

FILES = sorted((Path(__file__).parents[2] / "examples").glob("optimise-*.toml"))
TEXTS = [path.read_text(encoding="utf-8") for path in FILES]
FEW = settings(max_examples=40, deadline=None)


def refused(text: str) -> str:
    """The sentence that refuses a text; empty where it is taken."""
    try:
        read_optimum(OptimumText(text, "search.toml", Path()))
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 1100
        return str(error)
    return ""


@pytest.mark.parametrize("text", TEXTS, ids=[path.stem for path in FILES])
def test_the_examples_are_taken(text):
    assert not refused(text)


@FEW
@given(st.sampled_from(TEXTS), st.data())
def test_a_file_with_a_piece_replaced_is_taken_or_refused_in_one_sentence(text, data):
    begin = data.draw(st.integers(0, len(text) - 1))
    end = data.draw(st.integers(begin, min(len(text), begin + 40)))
    refused(text[:begin] + data.draw(st.text(max_size=20)) + text[end:])


VALUES = st.one_of(
    st.text(max_size=12),
    st.integers(-(10**20), 10**20),
    st.floats(),
    st.booleans(),
    st.lists(st.integers(-3, 3), max_size=3),
    st.sampled_from(
        [
            "1 mm",
            "1.0 x case",
            "0 x case",
            "case",
            "nan N",
            "1e999 N",
            "peak_spring_force",
            "preload",
            "minimise",
            "mean",
            "4000:9000:1 rpm",
            "rpm",
        ]
    ),
    st.dictionaries(
        st.sampled_from(["quantity", "at_most", "engine_speeds"]),
        st.sampled_from(["clash_count", "3", "9000 rpm"]),
    ),
)
KEYS = [
    "quantity",
    "limit_speed",
    "engine_speeds",
    "over",
    "label",
    "direction",
    "at_most",
    "at_least",
]


@FEW
@given(
    st.dictionaries(st.sampled_from(KEYS), VALUES, max_size=5),
    st.dictionaries(st.sampled_from(KEYS), VALUES, max_size=4),
    st.dictionaries(
        st.sampled_from(["method", "trials", "per_round", "seed", "seeds", "local"]),
        VALUES,
        max_size=3,
    ),
)
def test_any_values_of_the_known_keys_are_taken_or_refused_in_one_sentence(
    objective, constraint, search
):
    import tomlkit

    tree = {
        "case": "job-c",
        "objective": [objective],
        "constraint": [constraint],
        "search": search,
        "vary": [{"key": "spring.precompression", "low": "6 mm", "high": "8 mm"}],
    }
    try:
        text = tomlkit.dumps(tree)
    except (ValueError, UnicodeError):  # what no TOML can hold
        return
    refused(text)


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes_are_refused(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("bytes", numbered=True) / "search.toml"
    path.write_bytes(content)
    with pytest.raises(InputError) as error:
        read_optimum_file(path)
    assert "\n" not in str(error.value)
