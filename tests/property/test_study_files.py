"""However a study file is broken: one sentence with the place, never another error."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from valvetrain import InputError
from valvetrain.explore.study import StudyText, read_plan, read_study_file

FILES = sorted((Path(__file__).parents[2] / "examples" / "studies").glob("*.toml"))
TEXTS = [path.read_text(encoding="utf-8") for path in FILES]
FEW = settings(max_examples=120, deadline=None)


def refused(text: str) -> str:
    """The sentence that refuses a text; empty where it is taken."""
    try:
        read_plan(StudyText(text, "study.toml", Path()))
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


@FEW
@given(st.text(max_size=200))
def test_any_text_is_refused(text):
    assert refused(text)


VALUES = st.one_of(
    st.text(max_size=12),
    st.integers(-(10**20), 10**20),
    st.floats(),
    st.booleans(),
    st.lists(st.integers(-3, 3), max_size=3),
    st.sampled_from(
        [
            "1 mm",
            "-1 mm",
            "nan mm",
            "0 mm",
            "3 furlong",
            "6000 rpm",
            "spring.pitch",
            "engine_speed",
            "factor",
            "grid",
        ]
    ),
)
KEYS = [
    "key",
    "as",
    "unit",
    "label",
    "values",
    "low",
    "high",
    "mean",
    "standard_deviation",
    "median",
    "factor",
    "tolerance",
    "shape",
]


@FEW
@given(
    st.dictionaries(st.sampled_from(KEYS), VALUES, max_size=5),
    st.dictionaries(st.sampled_from(["sampler", "count", "seed", "levels"]), VALUES),
)
def test_any_values_of_the_known_keys_are_taken_or_refused_in_one_sentence(vary, points):
    import tomlkit

    tree = {
        "case": "job-c",
        "outputs": ["peak_spring_force"],
        "points": points,
        "vary": [{"key": "spring.precompression", **vary}],
    }
    try:
        text = tomlkit.dumps(tree)
    except (ValueError, UnicodeError):  # what no TOML can hold
        return
    refused(text)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('kind = "tolerance"', 'kind = "tolerances"', "kind"),
        ('sampler = "saltelli"', 'sampler = "sobol"', "needs the sampler saltelli"),
        ('outputs = ["peak_spring_force"', 'outputs = ["peak_spring_forc"', "docs/quantities.md"),
        (
            'case = "gu2021-beehive-blind"',
            'case = "gu2021-beehiv"',
            "did you mean gu2021-beehive or gu2021-beehive-blind",
        ),
        ('tolerance = "0.02 mm"', 'tolerance = "0.02 N"', "spring.wire_diameter"),
        (
            'tolerance = "0.02 mm"',
            'tolerance = "0.02 mm"\nlow = "1 mm"\nvalues = "1 mm"',
            "several ways",
        ),
        ('tolerance = "0.02 mm"', "", "no way"),
        ('tolerance = "0.02 mm"', 'tolerence = "0.02 mm"', "did you mean tolerance"),
        ('key = "spring.wire_diameter"', 'key = "spring.wire_diametre"', "spring.wire_diametre"),
        ('key = "spring.precompression"', 'key = "spring.wire_diameter"', "varied twice"),
        ("count = 640", "cuont = 640", "did you mean count"),
        ('as = "factor"', 'as = "times"', "vary.2.as"),
        ('engine_speeds = "8000 rpm"', 'engine_speeds = "8000 mm"', "engine_speeds"),
        (
            'spring_models = ["multi-mass"]',
            'spring_models = ["multimass"]',
            "did you mean multi-mass",
        ),
    ],
)
def test_a_slip_is_named_with_its_place_and_remedy(old, new, words):
    text = next(one for one in TEXTS if 'kind = "tolerance"' in one)
    assert old in text
    said = refused(text.replace(old, new, 1))
    assert words in said and said.startswith("study.toml")


@pytest.mark.parametrize("name", ["absent.toml", "folder", "binary.toml"])
def test_what_is_no_study_file_is_refused(tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError):
        read_study_file(tmp_path / name)
