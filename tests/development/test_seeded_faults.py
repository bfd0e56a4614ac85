"""The tool that seeds faults: what is a fault, which tests are run about it, and a sample that
continues where it was stopped.
"""

from __future__ import annotations

import json
import subprocess

import pytest
from mutants import choose
from mutants.__main__ import Answers
from mutants.copies import tree_digest
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


def test_tests_that_enter_the_function_are_run_and_nothing_too_long():
    place = next(one for one in choose.definitions()[HERE].found if one.name == "lift_table")
    known = trails(
        test_contour_tables=(2.0, [f"{HERE}:lift_table"]),
        test_units=(0.1, []),
        test_gap_geometry=(500.0, [f"{HERE}:lift_table"]),
    )
    inside = Fault(HERE, place.body + 1, 0, 1, "", "sign")
    assert choose.tests_for(inside, known) == ["tests/unit/test_contour_tables.py::test_it"]


def test_a_sample_continues_where_it_was_stopped_and_on_nothing_else(tmp_path):
    chosen = {number: Fault(HERE, number, 0, 1, "", "sign") for number in range(3)}
    file = tmp_path / "sample.json"
    first = Answers(file, chosen)
    with pytest.raises(SystemExit, match="nothing to resume"):
        first.read()
    first.add(2, {"verdict": "noticed", "by": "a test", "seconds": 1.0})
    first.add(0, {"verdict": "endless", "by": "", "seconds": 9.0})
    again = Answers(file, chosen)
    again.read()
    assert list(again) == [2] and again[2]["verdict"] == "noticed"
    saved = json.loads(file.read_text())
    assert saved["tree"] == tree_digest()
    file.write_text(json.dumps(saved | {"tree": "another"}))
    with pytest.raises(SystemExit, match="another source or with other tests"):
        again.read()


def test_each_changed_line_gets_at_most_one_fault():
    """Against the empty tree every line of the package is changed."""
    empty = subprocess.run(
        ["git", "hash-object", "-t", "tree", "/dev/null"],
        cwd=choose.ROOT,
        capture_output=True,
        text=True,
    ).stdout.strip()
    found = choose.changed(empty, 20, 1, ["cam"])
    assert len(found) == 20 == len({(fault.file, fault.line) for fault in found}) and all(
        fault.file.startswith("cam/") for fault in found
    )
    assert choose.changed("HEAD", 20, 1, ["no folder"]) == []
