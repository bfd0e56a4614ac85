"""The example of every docstring of the package gives what it shows: of public names, and of
modules that only the package uses.
"""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

import valvetrain

PACKAGE = Path(valvetrain.__file__).parent


def examples() -> list[doctest.DocTest]:
    """All of them, those of methods and properties too."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        if ">>> " in path.read_text(encoding="utf-8"):
            parts = ["valvetrain", *path.relative_to(PACKAGE).with_suffix("").parts]
            name = ".".join(parts).removesuffix(".__init__")
            found += [
                one for one in finder.find(importlib.import_module(name), name) if one.examples
            ]
    return found


@pytest.mark.parametrize("example", examples(), ids=lambda example: example.name)
def test_an_example_gives_what_it_shows(example, tmp_path, monkeypatch):
    """In an empty folder, where examples may write."""
    monkeypatch.chdir(tmp_path)
    said: list[str] = []
    result = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(
        example, out=said.append
    )
    assert result.failed == 0, "".join(said)
