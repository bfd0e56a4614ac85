"""Words from outside reach names, files, pages, decks and terminals as words: nothing in them is
run, read or computed.
"""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import modal_run, own_study, record, rod_run, train_run, train_study
from unit.cli_parts import SMALL
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.views.answer import Answer
from valvetrain.views.files import csv_of
from valvetrain.views.page import page_of
from valvetrain.views.results import write_study

COMMENT = "<!--<script>"
BREAKS_OUT = "</script><script>lost()</script>"
QUOTES = "\"'><img src=x onerror=lost()>&amp;"


def with_key(key: str, value: str) -> str:
    """The small case with one more key, at the top or in its spring."""
    table, _, name = key.rpartition(".")
    line = f"{name} = {json.dumps(value)}\n"
    small = SMALL.replace('title = "Small spring in motion"\n', "")
    return line + small if not table else SMALL.replace("[spring]\n", f"[spring]\n{line}", 1)


@pytest.mark.parametrize("key", ["name", "title", "spring.name"])
@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("a\n*INCLUDE, INPUT=x", "U\\+000A"),
        ("\x1b[2Jgone", "U\\+001B"),
        ("a\u2028b", "U\\+2028"),
        ("a\u202eb", "U\\+202E"),
        ("a" * 1001, "1001"),
    ],
)
def test_control_characters_and_endless_words_are_refused_at_reading(key, value, said):
    with pytest.raises(InputError, match=said) as refusal:
        parse_case(with_key(key, value), where="case.toml")
    assert (
        key in str(refusal.value)
        and str(refusal.value).isprintable()
        and len(str(refusal.value)) < 300
    )


@pytest.mark.parametrize("name", ["a/b", "../../outside", "a\\b", "n" * 81])
def test_the_name_of_a_case_names_no_other_place(name):
    with pytest.raises(InputError, match="name"):
        parse_case(with_key("name", name))


def test_a_file_of_an_endless_name_still_gives_a_case_of_a_usable_name(tmp_path):
    path = tmp_path / f"{'é' * 120}.toml"
    path.write_text(SMALL, encoding="utf-8")
    assert len(load_case(path).name) <= 80


@pytest.mark.parametrize("value", ["Große Feder Nr. 5, 2.º lote", "弁ばね", "a–b (1 × 2)"])
def test_words_of_any_language_are_names(value):
    case = parse_case(with_key("spring.name", value))
    assert case.require_spring().name == value


def test_a_long_description_of_several_lines_is_kept():
    text = "first\nsecond\tthird\n" * 100
    assert parse_case(with_key("description", text)).description == text


def hostile_study(words: str):
    """A study of one's own whose every free word is hostile."""
    told = record(title=f"title {words}", description=words, remarks=(words,))
    runs = (rod_run(label=f"rod {words}"), modal_run())
    return replace(own_study(runs), record=told, notes=(words,))


def test_labels_of_a_train_stay_words_in_every_script_of_its_page():
    runs = (
        train_run(label=COMMENT, spring_set=BREAKS_OUT),
        train_run(label=QUOTES, spring_set=COMMENT),
    )
    html = page_of(Answer(replace(train_study(), solutions=runs)))
    assert COMMENT not in html and "<script>lost" not in html and "<img src=x" not in html


@pytest.mark.parametrize("words", ["=1+1", "+cmd", "-x", "@SUM(A1)", "\tx", "\rx", '="a",b'])
def test_a_cell_of_words_is_no_formula(words):
    _, row = csv.reader(io.StringIO(csv_of(["word"], [[words]]), newline=""))
    assert row == [f"'{words}"]


@pytest.mark.parametrize(
    ("value", "cell"),
    [
        (-1.5, "-1.5"),
        (np.float64(-2.0).item(), "-2.0"),
        ("-1.5", "-1.5"),
        ("+3e-4", "+3e-4"),
        (-7, "-7"),
    ],
)
def test_numbers_stay_numbers(value, cell):
    assert csv_of(["number"], [[value]]).splitlines()[1] == cell


def test_no_cell_of_any_written_table_is_a_formula(tmp_path):
    words = "=HYPERLINK(1),=2"
    study = hostile_study(words)
    runs = tuple(
        replace(run, provenance=replace(run.provenance, label=words, case_name=words))
        for run in study.solutions
    )
    written = write_study(replace(study, solutions=runs), tmp_path, page=False)
    tables = [path for path in written.data if path.suffix == ".csv"]
    assert len(tables) > 4
    for path in tables:
        with path.open(encoding="utf-8", newline="") as lines:
            assert not [
                cell
                for row in csv.reader(lines)
                for cell in row
                if cell.startswith(("=", "+", "@"))
            ], path.name


def test_names_of_files_fit_any_file_system(tmp_path):
    written = write_study(
        own_study((rod_run(label="バ" * 80), rod_run(label="バ" * 80, bounces=1))),
        tmp_path,
        page=False,
    )
    assert max(len(path.name.encode()) for path in written.data) < 200
