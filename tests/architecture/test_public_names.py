"""The names of ``import valvetrain`` all resolve on first use, a type checker sees them, and each
has an example.
"""

from __future__ import annotations

import doctest
import importlib
import inspect
import os
import re
import subprocess
import sys

import pytest
from api_pages import HOMES, object_of

import valvetrain
from architecture.layout import PACKAGE, ROOT

TOP = [path for path in HOMES if path.count(".") == 1]


def test_the_top_has_few_names():
    assert len(valvetrain.__all__) <= 45
    assert set(TOP) <= {f"valvetrain.{name}" for name in valvetrain.__all__}


@pytest.mark.parametrize("path", HOMES)
def test_a_public_name_is_the_object_of_its_module(path):
    module, _, name = path.rpartition(".")
    assert object_of(path) is getattr(importlib.import_module(HOMES[path]), name)
    assert name in dir(importlib.import_module(module))


@pytest.mark.parametrize(
    ("name", "near"), [("simulat", "simulate"), ("SpringDefintion", "parameters.SpringDefinition")]
)
def test_an_unknown_name_is_answered_with_the_nearest(name, near):
    with pytest.raises(AttributeError, match=f"no name '{name}'; did you mean {near}?"):
        getattr(valvetrain, name)


def test_a_type_checker_sees_every_public_name(tmp_path):
    """mypy knows the type of each name, and that a misspelt one does not exist."""
    names = list(HOMES)
    lines = [
        "import valvetrain as vt",
        *(f"import {name.rpartition('.')[0]}" for name in names),
        *(f"reveal_type({name})" for name in names),
        "vt.load_cse",
    ]
    (tmp_path / "snippet.py").write_text("\n".join(lines), encoding="utf-8")
    # from the root, as `make lint` runs it, whose cache then serves here
    command = [
        sys.executable,
        "-m",
        "mypy",
        "--config-file",
        "pyproject.toml",
        str(tmp_path / "snippet.py"),
    ]
    found = subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "MYPYPATH": str(PACKAGE.parent)},
    )
    types = re.findall(r'note: Revealed type is "(.*)"', found.stdout)
    assert len(types) == len(names), found.stdout + found.stderr
    assert not [
        name
        for name, seen in zip(names, types, strict=True)
        if seen in ("Any", "object", "builtins.object")
    ]
    assert 'Module has no attribute "load_cse"' in found.stdout
    assert found.stdout.count(" error: ") == 1, found.stdout


def examples() -> list[doctest.DocTest]:
    """The examples in the docstrings of all public names and their methods."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = []
    for name, home in HOMES.items():
        module = importlib.import_module(home)
        found += [
            test for test in finder.find(object_of(name), name, module=module) if test.examples
        ]
    return found


FUNCTIONS = [name for name in HOMES if inspect.isfunction(object_of(name))]


def test_public_names_carry_an_example():
    assert not set(HOMES) - {example.name for example in examples()}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_tells_its_arguments_its_errors_and_an_example(name):
    function = object_of(name)
    text = inspect.getdoc(function) or ""
    arguments, _, _ = text.partition("Parameters\n----------\n")[2].partition("\n\n")
    told = {
        word.strip()
        for line in arguments.splitlines()
        if not line.startswith(" ")
        for word in line.partition(" : ")[0].split(",")
    }
    assert told == set(inspect.signature(function).parameters), (
        "every argument stands on a line 'name : what it is, its unit and shape'"
    )
    assert "Raises\n------\n" in text or "Raises nothing" in text
    assert name in {example.name for example in examples()}, "an example is missing"
