"""Engines of ``valvetrain new --like``: every number has a source or a range, and control ends where the page says."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import pytest

import valvetrain as vt
from unit.cli_parts import call
from valvetrain.errors import InputError
from valvetrain.parameters.overrides import is_note
from valvetrain.parameters.templates import engine_names, engine_text

PAGE = (Path(__file__).parents[2] / "docs" / "engines.md").read_text(encoding="utf-8")
#: Coordinates of the drawing and speeds that are run: choices, not data.
CHOSEN = {"train.pushrod.lower_end", "train.lever.pivot", "train.valve.opening_direction", "operation.engine_speeds"}  # fmt: skip
NUMBER = re.compile(r"(-?[\d.]+) ?(.*)")
RANGE = re.compile(r"([\d.]+) to ([\d.]+) ?([^:]*)")


def numbers(item, path=""):
    """Key path and note, or bare value, of everything that holds a number."""
    if is_note(item) or not isinstance(item, (dict, list)):
        value = item["value"] if isinstance(item, dict) else item
        if isinstance(value, (int, float)) or NUMBER.match(str(value)):
            yield path, item
        return
    for key, value in item.items() if isinstance(item, dict) else enumerate(item):
        yield from numbers(value, f"{path}.{key}" if path else str(key))


@pytest.mark.parametrize("name", engine_names())
def test_every_number_has_a_source_or_lies_in_the_range_assumed(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        case = vt.Case.like(name)
    bare = [path for path, item in numbers(case.tree) if not isinstance(item, dict)]
    assert set(bare) - {"title"} == CHOSEN
    for path, item in numbers(case.tree):
        if path not in CHOSEN and item["status"] == "assumed":
            value, unit = NUMBER.match(str(item["value"])).groups()
            low, high, of = RANGE.match(item["source"]).groups()
            assert float(low) <= float(value) <= float(high) and of == unit, path
        elif path not in CHOSEN:
            assert item["status"] == "published" and len(item["source"]) > 10, path


@pytest.mark.parametrize("name", engine_names())
@pytest.mark.parametrize("key", ["valve_lift", "rocker_ratio", "preload", "open_load"])
def test_springs_lift_and_ratio_are_never_assumed(name, key):
    notes = vt.Case.like(name).parameters.notes
    assert any(path.endswith(key) and note.status == "published" for path, note in notes.items())


def test_the_page_has_a_row_for_every_engine():
    assert set(re.findall(r"^\| `([\w-]+)` \|", PAGE, re.M)) == set(engine_names())


@pytest.mark.parametrize("name", engine_names())
def test_the_limit_of_the_page_holds(name):
    """The bounce that costs power is not reached at the lower end of the page's range, and passed at its upper end."""
    row = re.search(rf"^\| `{name}` \|.*$", PAGE, re.M).group()
    low, high = re.search(r"(\d{4}) to (\d{4}) rpm", row).groups()
    case = vt.Case.like(name)
    bounce = [
        case.run(f"{speed} rpm", outputs=["bounce_height"]).quantities["bounce_height"]
        for speed in (low, high)
    ]
    assert bounce[0] < case.parameters.limits.bounce < bounce[1]


def test_a_file_is_written_and_what_goes_not_with_it_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call("new", "mine", "--like", "ls-dual").exit_code == 0
    assert Path("mine.toml").read_text(encoding="utf-8") == engine_text("ls-dual").replace("NAME.toml", "mine.toml")  # fmt: skip
    for more in (("--kind", "pushrod"), ("--lift", "0.5 in"), ("--case", "job-t")):
        assert call("new", "other", "--like", "ls-dual", *more).exit_code == 2
    with pytest.raises(InputError, match="did you mean ls-dual"):
        vt.Case.like("ls-dul")
