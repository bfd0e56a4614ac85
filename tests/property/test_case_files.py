"""Whatever a case file holds, reading it gives a Case or an InputError of one line, never another
exception.
"""

from __future__ import annotations

import json
import re
import string
from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from valvetrain.cam import build_lift_law
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import LIBRARY, load_case, parse_case
from valvetrain.units import DIMENSIONS, format_quantity, parse_quantities, parse_quantity

TEXTS = {path.stem: path.read_text() for path in sorted(LIBRARY.glob("*.toml"))}
SHORT = {name: text.split("# ----")[0] for name, text in TEXTS.items()}
KEYS = sorted(
    {
        word
        for text in SHORT.values()
        for word in re.split(r"[\s=\[\]]", text)
        if word.isidentifier()
    }
)
QUIET = settings(deadline=None, max_examples=120, suppress_health_check=[HealthCheck.too_slow])


def read(text: str) -> Case | None:
    """The case, or None after an InputError that is one readable line."""
    try:
        case = parse_case(text, where="case.toml")
        if case.lift_law is not None:
            build_lift_law(case.lift_law).lift([0.0, 1.0], 2)
    except InputError as error:
        message = str(error)
        assert message and "\n" not in message and len(message) < 800
        return None
    return case


@QUIET
@given(st.sampled_from(sorted(SHORT)), st.data())
def test_truncated_files(name, data):
    text = SHORT[name]
    read(text[: data.draw(st.integers(0, len(text)))])


@QUIET
@given(st.sampled_from(sorted(SHORT)), st.data())
def test_mutated_characters(name, data):
    text = SHORT[name]
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        length = data.draw(st.integers(0, 6))
        text = text[:start] + data.draw(st.text(max_size=6)) + text[start + length :]
    read(text)


@QUIET
@given(st.sampled_from(sorted(SHORT)), st.data())
def test_shuffled_lines(name, data):
    lines = SHORT[name].splitlines()
    picked = data.draw(st.lists(st.integers(0, len(lines) - 1), max_size=len(lines)))
    read("\n".join(lines[index] for index in picked))


numbers = st.one_of(
    st.integers(-(10**30), 10**30), st.floats(), st.sampled_from([0, -1, 1, 7, 1e-300, 1e300])
)
units = st.sampled_from(
    [
        "mm",
        "m",
        "N",
        "deg",
        "rpm",
        "Hz",
        "1/s",
        "s",
        "%",
        "",
        "GPa",
        "kg/m^3",
        "mm^2",
        "furlong",
        "-",
        "mm mm",
    ]
)
quantity_texts = st.builds(lambda number, unit: f"{number} {unit}", numbers, units)
words = st.sampled_from(["open", "closed", "spline", "zero", "OTEVA 90 SC"])
leaves = st.one_of(numbers, quantity_texts, st.text(max_size=12), st.booleans(), words)
names = st.one_of(st.sampled_from(KEYS), st.text(string.ascii_lowercase + "_- .é", max_size=12))
values = st.recursive(
    leaves,
    lambda inner: st.one_of(st.lists(inner, max_size=5), st.dictionaries(names, inner, max_size=5)),
    max_leaves=12,
)


def as_toml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list):
        return "[" + ", ".join(map(as_toml, value)) + "]"
    if isinstance(value, dict):
        return (
            "{"
            + ", ".join(f"{json.dumps(key)} = {as_toml(item)}" for key, item in value.items())
            + "}"
        )
    return repr(value)


@QUIET
@given(
    st.dictionaries(
        st.sampled_from([*KEYS, "spring", "lift_law", "rubbing", "published"]), values, max_size=6
    )
)
def test_random_tables(tree):
    read("\n".join(f"{json.dumps(key)} = {as_toml(value)}" for key, value in tree.items()))


@QUIET
@given(st.sampled_from([name for name in SHORT if name != "clamped-helix"]), st.data())
def test_one_value_replaced(name, data):
    lines = SHORT[name].splitlines()
    index = data.draw(
        st.sampled_from(
            [
                number
                for number, line in enumerate(lines)
                if "=" in line and not line.startswith("#")
            ]
        )
    )
    lines[index] = lines[index].split("=")[0] + "= " + as_toml(data.draw(values))
    read("\n".join(lines))


@settings(QUIET, max_examples=60)
@given(st.binary(max_size=400))
def test_random_bytes(tmp_path_factory, content):
    path = Path(tmp_path_factory.mktemp("case")) / "case.toml"
    path.write_bytes(content)
    try:
        load_case(path)
    except InputError as error:
        assert "\n" not in str(error)


@settings(QUIET, max_examples=60)
@given(st.text(max_size=60))
def test_random_names(name):
    assume(not Path(name[:50]).is_file() if "\0" not in name else True)
    assume(name not in SHORT)
    with pytest.raises(InputError):
        load_case(name)


@pytest.mark.parametrize("name", sorted(SHORT))
def test_the_unmutated_files_are_cases(name):
    assert isinstance(read(TEXTS[name]), Case) and isinstance(read(SHORT[name]), Case)


@settings(QUIET, max_examples=300)
@given(
    st.sampled_from(sorted(DIMENSIONS)),
    st.floats(-1e12, 1e12).filter(lambda value: value == 0 or abs(value) > 1e-12),
)
def test_units_survive_the_round_trip(name, value):
    text = format_quantity(value, DIMENSIONS[name].default_unit, digits=None)
    assert parse_quantity(text, name) == pytest.approx(value, rel=1e-15, abs=1e-300)


@settings(QUIET, max_examples=300)
@given(
    st.one_of(st.text(max_size=30), quantity_texts),
    st.sampled_from([*sorted(DIMENSIONS), None, "N/m^1.5"]),
)
def test_any_text_is_a_quantity_or_an_input_error(text, dimension):
    for reader in (parse_quantity, parse_quantities):
        try:
            reader(text, dimension)
        except InputError as error:
            assert str(error)
