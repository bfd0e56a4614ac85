"""Unit: the folder of the results stands in one line however long it is, so that it can be copied
and searched for.
"""

from __future__ import annotations

import pytest

from unit.cli_parts import SMALL, call

STUDY = """
case = "small.toml"
spring_models = ["massless"]
vary = [{ key = "spring.wire_diameter", low = "3.7 mm", high = "3.9 mm" }]
points = { sampler = "latin-hypercube", count = 2, seed = 1 }
outputs = ["preload"]
"""
SEARCH = """
case = "small.toml"
vary = [{ key = "spring.wire_diameter", low = "3.7 mm", high = "3.9 mm" }]
objective = [{ quantity = "preload", direction = "minimise" }]
search = { trials = 2, per_round = 2 }
"""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "small.toml", "--spring", "massless"), ""),
        (("study", "study.toml"), ""),
        (("optimise", "search.toml"), ""),
        (("refine", "small.toml"), "/report.html"),
    ],
)
def test_the_folder_of_the_results_is_not_broken(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "40")
    for name, text in (("small.toml", SMALL), ("study.toml", STUDY), ("search.toml", SEARCH)):
        (tmp_path / name).write_text(text)
    folder = tmp_path / ("a folder with a long name " * 4).strip() / "out"
    result = call(*words, "--output", str(folder), "--workers", "1")
    assert result.exit_code == 0, result.stderr
    lines = [line for line in result.stdout.splitlines() if line.startswith("results")]
    assert [line.removeprefix("results").strip() for line in lines] == [f"{folder}{said}"]
