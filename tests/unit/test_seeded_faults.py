"""The tool that seeds faults: what a kept trail depends on, which tests are asked, and a sample
that goes on where it was stopped.
"""

from __future__ import annotations

import json

import pytest
from mutants import choose, digests
from mutants.__main__ import Answers
from mutants.faults import Fault, faults, seeded

HERE = "mechanism/contour.py"
TEXT = '''"""A module."""
LIMIT = 3
MANY = 4001
OPTIONS = {"_nrt": False, "speed": True}


def one(x, factor=2.0):
    """Words."""
    return factor * x + LIMIT


class Part:
    size: float = 1.0

    def two(self):
        return [one(x) for x in range(self.size)]
'''


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.setattr(digests, "SOURCE", tmp_path)
    digests._of_file.cache_clear()
    yield tmp_path / "part.py"
    digests._of_file.cache_clear()


def digest(path, text: str, *places: str) -> str:
    path.write_text(text)
    digests._of_file.cache_clear()
    return digests.of_places([f"part.py:{place}" for place in places])


@pytest.mark.parametrize(
    ("old", "new", "changed"),
    [
        ("factor * x", "factor / x", ("one",)),
        ("factor=2.0", "factor=3.0", ("one",)),
        ("range(self.size)", "range(3)", ("Part.two",)),
        ("LIMIT = 3", "LIMIT = 4", ("<module>",)),
        ("size: float = 1.0", "size: float = 2.0", ("Part",)),
        ("A module", "The module", ("<module>",)),
    ],
)
def test_a_trail_is_old_where_code_that_it_entered_has_changed(source, old, new, changed):
    places = ("one", "Part.two", "Part.two.<locals>.<listcomp>", "Part", "<module>")
    for place in places:
        before, after = digest(source, TEXT, place), digest(source, TEXT.replace(old, new), place)
        assert (before != after) == (place.split(".<locals>")[0] in changed), place
    assert digest(source, TEXT, *places) == digest(
        source, f"{TEXT}\n\ndef three():\n    pass\n", *places
    )


def test_what_nobody_meets_is_no_fault(tmp_path):
    (tmp_path / "part.py").write_text(TEXT)
    found = [seeded(TEXT, fault) for fault in faults(tmp_path, "part.py")]
    assert (
        TEXT.replace("LIMIT = 3", "LIMIT = 4") in found
        and TEXT.replace('"speed": True', '"speed": False') in found
    )
    assert not any(
        "4001" not in text or '"_nrt": False' not in text or '"""Words."""' not in text
        for text in found
    )


def trails(**tests: tuple[float, list[str]]) -> dict[str, dict]:
    """Trails of test files by one test each: seconds and functions entered."""
    return {
        f"tests/unit/{file}.py": {
            "import": [],
            "tests": {f"tests/unit/{file}.py::test_it": {"seconds": seconds, "places": places}},
        }
        for file, (seconds, places) in tests.items()
    }


def test_tests_that_enter_the_function_are_asked_and_for_what_it_takes_those_of_tables_too(
    monkeypatch,
):
    whole = choose.Definitions(choose.SOURCE / HERE)
    monkeypatch.setattr(choose, "definitions", lambda: {HERE: whole})
    place = next(one for one in whole.found if one.name == "lift_table")
    known = trails(
        test_contour_tables=(2.0, [f"{HERE}:lift_table"]),
        test_units=(0.1, []),
        test_defaults_page=(0.2, []),
        test_gap_geometry=(500.0, [f"{HERE}:lift_table"]),
    )
    inside, head = (
        Fault(HERE, place.body + 1, 0, 1, "", "sign"),
        Fault(HERE, place.first, 0, 1, "", "constant"),
    )
    assert choose.tests_for(inside, known) == ["tests/unit/test_contour_tables.py::test_it"]
    assert set(choose.tests_for(head, known)) == {
        "tests/unit/test_contour_tables.py::test_it",
        "tests/unit/test_defaults_page.py::test_it",
    }


def test_a_sample_goes_on_where_it_was_stopped_and_on_nothing_else(tmp_path, monkeypatch):
    chosen = {number: Fault(HERE, number, 0, 1, "", "sign") for number in range(3)}
    first = Answers(tmp_path / "kept.json", chosen)
    with pytest.raises(SystemExit, match="nothing to resume"):
        first.read()
    first.keep(2, {"verdict": "noticed", "by": "a test", "seconds": 1.0})
    first.keep(0, {"verdict": "endless", "by": "", "seconds": 9.0})
    again = Answers(tmp_path / "kept.json", chosen)
    again.read()
    assert list(again) == [2] and again[2]["verdict"] == "noticed"
    assert json.loads((tmp_path / "kept.json").read_text())["tree"] == digests.of_tree()
    monkeypatch.setattr("mutants.__main__.of_tree", lambda: "another")
    with pytest.raises(SystemExit, match="another source or with other tests"):
        again.read()
